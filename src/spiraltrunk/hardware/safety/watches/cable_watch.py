"""Watches of the cables: lengths that do not fit, slipping, tangled, too tight, too long or too short."""

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
class LoadState:
    """Load of a cable."""

    load: float = 0.0
    """Mean tension [N]."""
    elapsed: float = 0.0
    """Time without load [s]."""


def watch_load(
    state: LoadState, reading: CableReading, tension_least: float, dt: float, limits: SafetyLimits
) -> LoadState:
    """Whether a cable carries load: a mean over `slack_memory` of at least `slack_part` of ``tension_least`` [N].

    When a trunk uncurls or swings faster than the floor of tension winds a drum in, cables are slack for seconds.
    """
    load = state.load + min(1.0, dt / limits.slack_memory) * (reading.tension - state.load)
    is_loaded = load >= limits.slack_part * tension_least
    return LoadState(load=load, elapsed=0.0 if is_loaded else state.elapsed + dt)


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class LengthState:
    """What the lengths of the cables are compared with."""

    excess: float = 0.0
    """Length by which they differ from those of an even bend, followed slowly [m]."""
    tension: float = 0.0
    """Sum of the tensions, followed in the same way [N]."""


def watch_length(
    state: LengthState, excess: float, tension: float, dt: float, *, is_taut: bool, limits: SafetyLimits
) -> tuple[LengthState, str]:
    """Lengths that no bend explains: a cable has slipped, or it is broken and is wound in without end.

    `CableRelation` tells the ``excess`` of the lengths. It changes slowly where cables are taut, for shapes with
    several bends and contacts alone change it; a slack cable lowers it, and it comes back when that is wound in. So it
    is followed with the time constant `settle_time`, not below -`settle_least`, and only while all cables carry load.
    A step beyond that is a fault, where a change of tension does not explain it. Of a step while another cable is
    slack, what remains beyond its slack is seen; of slips that are shorter than `step_length`, nothing.

    Args:
        state: state after the period before.
        excess: largest excess of a cable, of lengths without their elastic part [m].
        tension: sum of the tensions of all cables [N].
        dt: period [s].
        is_taut: whether all cables carry load.
        limits: when it is a fault.

    Returns:
        The next state, and what is wrong or "".
    """
    rise = excess - state.excess
    allowed = limits.step_length + limits.compliance * abs(tension - state.tension)
    if is_taut:
        share = min(1.0, dt / limits.settle_time)
        followed = max(state.excess + share * rise, -limits.settle_least)
        state = LengthState(excess=followed, tension=state.tension + share * (tension - state.tension))
    if rise < allowed:
        return state, ""
    return state, f"{1e3 * rise:.1f} mm of cable came in that no bend explains; allowed: {1e3 * allowed:.1f} mm"


def watch_untaken(
    elapsed: float, excess: float, readings: tuple[CableReading, ...], dt: float, limits: SafetyLimits
) -> tuple[float, Finding | None]:
    """A slack cable that no drum takes in: winders wind in at the floor of tension whatever is slack.

    Lengths that are `untaken_length` below those of an even bend are slack, for other shapes take in more; of three
    cables they do not tell which one it is. The state is the time for which that lasts and no drum winds in [s].
    """
    is_taken = any(reading.speed > limits.untaken_speed for reading in readings)
    if is_taken or excess > -limits.untaken_length:
        return 0.0, None
    elapsed += dt
    if elapsed < limits.stall_time:
        return elapsed, None
    text = f"{-1e3 * excess:.0f} mm of cable are slack, and no drum has wound in for {elapsed:.1f} s; one is stuck"
    return elapsed, Finding(FaultKind.STALL, text)


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

    Up to then a slip, a break and a drum that winds the wrong way look alike. A dip is faster than `slip_rate` and
    deeper than `slip_tension` and `slip_part`; it ends when the tension comes back, or after `slip_time`. While the
    drum is stirred, the estimate dips by itself, and the lengths alone tell a slip.
    """
    if reading.is_stirred:
        return SlipState(tension=reading.by_motor), None
    before = state.tension if state.pull is not None else state.tension - limits.slip_rate * dt
    before = max(reading.by_motor, before)
    is_dip = before - reading.by_motor >= max(limits.slip_tension, limits.slip_part * before)
    if not is_dip or state.elapsed >= limits.slip_time:
        return SlipState(tension=before if state.pull is None else reading.by_motor), None
    start = reading.pull if state.pull is None else min(state.pull, reading.pull)
    after = SlipState(tension=before, pull=start, elapsed=state.elapsed + dt)
    if reading.pull - start < limits.slip_length:
        return after, None
    text = f"{1e3 * (reading.pull - start):.1f} mm came in while the tension fell to {reading.by_motor:.1f} N"
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


def watch_tangle(
    state: TangleState, reading: CableReading, allowed: CableRange, limits: SafetyLimits
) -> tuple[TangleState, Finding | None]:
    """A drum that pays out and tightens: the cable is caught between layers, or winds on the wrong way.

    A trunk that pulls cable out raises the tension to its command, the winder's drag times the speed and the rotor's
    dry friction, by which the tension of a drum at rest is uncertain, and no further, because the winder yields.
    """
    if reading.speed >= 0.0:
        return TangleState(), None
    if state.pull is None:
        return TangleState(pull=reading.pull, tension=reading.by_motor), None
    yielding = allowed.drag * abs(reading.speed) + allowed.friction
    rise = reading.by_motor - max(state.tension, reading.tension_wanted) - yielding
    out = state.pull - reading.pull
    if out < limits.tangle_length or rise < limits.tangle_tension:
        return state, None
    text = f"the tension rose by {rise:.1f} N while {1e3 * out:.1f} mm were paid out"
    return state, Finding(FaultKind.TANGLED_DRUM, f"{text}; allowed: {limits.tangle_tension:g} N")


def watch_tension(
    elapsed: float, reading: CableReading, dt: float, ceiling: float, limits: SafetyLimits
) -> tuple[float, Finding | None]:
    """A tension beyond its ceiling, for too long or by far, whatever tells it; the state is for how long [s]."""
    tension = max(reading.tension, reading.by_motor)
    if tension <= (1.0 + limits.over_part) * ceiling:
        return 0.0, None
    elapsed += dt
    if elapsed < limits.over_time and tension < (1.0 + limits.over_part_at_once) * ceiling:
        return elapsed, None
    return elapsed, Finding(FaultKind.OVER_TENSION, f"the tension is {tension:.1f} N; allowed: {ceiling:g} N")


def find_too_far(reading: CableReading, allowed: CableRange, limits: SafetyLimits) -> Finding | None:
    """A length beyond what the design allows."""
    least, most = allowed.pull_least - limits.length_margin, allowed.pull_most + limits.length_margin
    if least <= reading.pull <= most:
        return None
    span = f"{1e3 * allowed.pull_least:.0f} to {1e3 * allowed.pull_most:.0f} mm"
    return Finding(FaultKind.LENGTH_LIMIT, f"{1e3 * reading.pull:.1f} mm of cable are wound in; allowed: {span}")
