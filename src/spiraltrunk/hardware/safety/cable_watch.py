"""Watches of the cable: slack or broken, slipping, tangled, too tight, too long or too short."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.reading import CableRange, CableReading, Finding


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class SlackState:
    """For how long a cable carries no load."""

    load: float = 0.0
    """Mean tension [N]."""
    elapsed: float = 0.0
    """That time, shortened while the trunk moves [s]."""
    wound: float = 0.0
    """Cable wound in during it [m]."""
    was_taut: bool = False
    """Whether it has carried a load since torque was switched on."""


def watch_slack(
    state: SlackState, reading: CableReading, dt: float, least: float, limits: SafetyLimits, *, is_moving: bool = False
) -> tuple[SlackState, Finding | None]:
    """A cable that is wound in without load, slack or broken.

    Without load the floor of tension winds a drum in. A broken cable stays without load, whereas a trunk that uncurls
    or swings slackens it until the winder has caught up: therefore time counts less while other cables move. After
    arming the winder first takes up what became slack without torque, for `take_up_time`.

    Args:
        state: state after the period before.
        reading: of this cable.
        dt: period [s].
        least: least load while it is wound in [N], see `CableRange`.
        limits: when it is a fault.
        is_moving: whether another cable moves.
    """
    load = state.load + min(1.0, dt / limits.slack_memory) * (reading.tension - state.load)
    was_taut = state.was_taut or load >= least
    if was_taut and (load >= limits.slack_part * least or reading.speed < 0.0):
        return SlackState(load=load, was_taut=was_taut), None
    elapsed = state.elapsed + dt * (limits.slack_time / limits.slack_time_moving if is_moving else 1.0)
    wound = state.wound + dt * reading.speed
    after = SlackState(load=load, elapsed=elapsed, wound=wound, was_taut=was_taut)
    is_long = elapsed >= limits.slack_time and wound >= limits.slack_length
    if not (is_long if was_taut else elapsed >= limits.take_up_time):
        return after, None
    text = f"{1e3 * wound:.1f} mm came in with a load of {load:.2f} N"
    allowed = f"allowed: above {limits.slack_part * least:.2f} N"
    return after, Finding(FaultKind.SLACK, f"{text}; {allowed}")


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class SlipState:
    """Tension and length before a dip."""

    tension: float = 0.0
    """Latest tension, falling no faster than `SafetyLimits.slip_rate`; in a dip that before it [N]."""
    pull: float | None = None
    """Least cable wound in since the dip began [m]; None outside of a dip."""
    elapsed: float = 0.0
    """Time since the dip began [s]."""


def watch_slip(
    state: SlipState, reading: CableReading, dt: float, limits: SafetyLimits
) -> tuple[SlipState, Finding | None]:
    """A cable that slips on its drum, out of its knot, or breaks: the tension dips and a burst of it is wound in.

    Up to then a slip and a break look alike. A dip is faster than `slip_rate` and deeper than `slip_tension` and
    `slip_part`; it ends when the tension comes back, or after `slip_time`.
    """
    before = state.tension if state.pull is not None else state.tension - limits.slip_rate * dt
    before = max(reading.tension, before)
    is_dip = before - reading.tension >= max(limits.slip_tension, limits.slip_part * before)
    if not is_dip or state.elapsed >= limits.slip_time:
        return SlipState(tension=before if state.pull is None else reading.tension), None
    start = reading.pull if state.pull is None else min(state.pull, reading.pull)
    after = SlipState(tension=before, pull=start, elapsed=state.elapsed + dt)
    if reading.pull - start < limits.slip_length:
        return after, None
    text = f"{1e3 * (reading.pull - start):.1f} mm came in while the tension fell to {reading.tension:.1f} N"
    allowed = f"allowed: {1e3 * limits.slip_length:g} mm"
    return after, Finding(FaultKind.CABLE_SLIP, f"{text}; {allowed}")


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class TangleState:
    """Tension and length when paying out began."""

    pull: float | None = None
    """Cable wound in then [m]; None while nothing is paid out."""
    tension: float = 0.0
    """Tension then [N]."""


def watch_tangle(state: TangleState, reading: CableReading, limits: SafetyLimits) -> tuple[TangleState, Finding | None]:
    """A drum that pays out and tightens: the cable is caught between layers, or winds on the wrong way.

    A trunk that pulls cable out raises the tension to its command and no further, because the winder yields.
    """
    if reading.speed >= 0.0:
        return TangleState(), None
    if state.pull is None:
        return TangleState(pull=reading.pull, tension=reading.tension), None
    rise = reading.tension - max(state.tension, reading.tension_wanted)
    out = state.pull - reading.pull
    if out < limits.tangle_length or rise < limits.tangle_tension:
        return state, None
    text = f"the tension rose by {rise:.1f} N while {1e3 * out:.1f} mm were paid out"
    return state, Finding(FaultKind.TANGLED_DRUM, f"{text}; allowed: {limits.tangle_tension:g} N")


def watch_tension(
    elapsed: float, reading: CableReading, dt: float, ceiling: float, limits: SafetyLimits
) -> tuple[float, Finding | None]:
    """A tension beyond its ceiling, for too long or by far; the state is for how long [s]."""
    if reading.tension <= (1.0 + limits.over_part) * ceiling:
        return 0.0, None
    elapsed += dt
    if elapsed < limits.over_time and reading.tension < (1.0 + limits.over_part_at_once) * ceiling:
        return elapsed, None
    return elapsed, Finding(FaultKind.OVER_TENSION, f"the tension is {reading.tension:.1f} N; allowed: {ceiling:g} N")


def find_too_far(reading: CableReading, allowed: CableRange, limits: SafetyLimits) -> Finding | None:
    """A length beyond what the design allows."""
    least, most = allowed.pull_least - limits.length_margin, allowed.pull_most + limits.length_margin
    if least <= reading.pull <= most:
        return None
    span = f"{1e3 * allowed.pull_least:.0f} to {1e3 * allowed.pull_most:.0f} mm"
    return Finding(FaultKind.LENGTH_LIMIT, f"{1e3 * reading.pull:.1f} mm of cable are wound in; allowed: {span}")
