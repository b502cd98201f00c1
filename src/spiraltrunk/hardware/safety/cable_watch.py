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

    elapsed: float = 0.0
    """That time [s]."""
    was_taut: bool = False
    """Whether it has carried the floor of tension since torque was switched on."""


def watch_slack(
    state: SlackState, reading: CableReading, dt: float, floor: float, limits: SafetyLimits
) -> tuple[SlackState, Finding | None]:
    """A cable without load that is not being paid out, slack or broken.

    A swing of the trunk slackens a cable until the winder has caught up, within less than `slack_time`; a broken cable
    stays without load. After arming the winder first takes up what became slack without torque, for `take_up_time`.
    """
    least = limits.slack_part * floor
    was_taut = state.was_taut or reading.tension >= floor
    if reading.tension >= least or (was_taut and reading.speed < -limits.slack_speed):
        elapsed = 0.0 if was_taut else state.elapsed + dt
    else:
        elapsed = state.elapsed + dt
    after = SlackState(elapsed=elapsed, was_taut=was_taut)
    allowed_time = limits.slack_time if was_taut else limits.take_up_time
    if elapsed < allowed_time:
        return after, None
    allowed = f"allowed: above {least:.2f} N within {1e3 * allowed_time:g} ms"
    return after, Finding(FaultKind.SLACK, f"the cable carries {reading.tension:.2f} N; {allowed}")


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class SlipState:
    """Tension and length before a dip."""

    tension: float = 0.0
    """Latest tension, falling no faster than `SafetyLimits.slip_rate` [N]."""
    pull: float | None = None
    """Cable wound in when the dip began [m]; None outside of a dip."""


def watch_slip(
    state: SlipState, reading: CableReading, dt: float, limits: SafetyLimits
) -> tuple[SlipState, Finding | None]:
    """A cable that slips on its drum or out of its knot: the tension dips while a burst of cable is wound in."""
    before = max(reading.tension, state.tension - limits.slip_rate * dt)
    is_dip = before - reading.tension >= max(limits.slip_tension, limits.slip_part * before)
    if not is_dip:
        return SlipState(tension=before), None
    start = reading.pull if state.pull is None else min(state.pull, reading.pull)
    after = SlipState(tension=before, pull=start)
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
