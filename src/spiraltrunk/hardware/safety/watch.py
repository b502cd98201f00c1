"""All watches together: one state for the group of motors and cables, advanced once in a period of control."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple, final

from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.motors.motor_port import MotorDataSheet, MotorState
from spiraltrunk.hardware.safety.cable_relation import CableRelation
from spiraltrunk.hardware.safety.fault import Fault, FaultKind
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.reading import CableRange, CableReading, Finding
from spiraltrunk.hardware.safety.watches.cable_watch import (
    LengthState,
    LoadState,
    SlipState,
    TangleState,
    find_too_far,
    watch_length,
    watch_load,
    watch_slip,
    watch_tangle,
    watch_tension,
    watch_untaken,
)
from spiraltrunk.hardware.safety.watches.cell_watch import CellState, ClaimState, watch_cell, watch_claim
from spiraltrunk.hardware.safety.watches.feedback_watch import (
    FrozenState,
    MotionState,
    Noise,
    find_impossible,
    find_stale,
    watch_frozen,
    watch_motion,
    watch_swap,
)
from spiraltrunk.hardware.safety.watches.loss_watch import LossState, watch_loss
from spiraltrunk.hardware.safety.watches.motor_watch import (
    StallState,
    derate,
    find_hot,
    find_reported,
    watch_stall,
    watch_voltage,
)


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class MotorWatch:
    """States of the watches of one motor."""

    frozen: FrozenState = field(default_factory=FrozenState)
    """Frozen feedback."""
    motion: MotionState = field(default_factory=MotionState)
    """Angle against speed."""
    voltage: float = 0.0
    """Time outside of the voltage's range [s]."""
    stall: StallState = field(default_factory=StallState)
    """Stall."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class CableWatch:
    """States of the watches of one cable."""

    load: LoadState = field(default_factory=LoadState)
    """Load."""
    slip: SlipState = field(default_factory=SlipState)
    """Slip."""
    tangle: TangleState = field(default_factory=TangleState)
    """Tangled drum."""
    tension: float = 0.0
    """Time beyond the ceiling [s]."""
    cell: CellState = field(default_factory=CellState)
    """Load cell."""
    claim: ClaimState = field(default_factory=ClaimState)
    """A load cell's claim that its cable is slack."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class WatchState:
    """States of all watches."""

    motors: tuple[MotorWatch, ...]
    """Those of each motor."""
    cables: tuple[CableWatch, ...]
    """Those of each cable."""
    length: LengthState = field(default_factory=LengthState)
    """Lengths of all cables."""
    untaken: float = 0.0
    """Time for which a slack cable is not taken in [s]."""
    loss: LossState = field(default_factory=LossState)
    """Lost feedback."""
    swap: tuple[float, ...] = ()
    """Exchanged feedback, for each pair of motors [N m s]."""


@final
class Seen(NamedTuple):
    """What the watches found in one period."""

    state: WatchState
    """The next state."""
    faults: tuple[Fault, ...]
    """Faults, each as soon as it is there, again in each period while it lasts."""
    warnings: tuple[str, ...]
    """What is not yet a fault, one line each."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Watches:
    """What the watches compare with."""

    sheet: MotorDataSheet
    """Limits of the motors."""
    limits: SafetyLimits
    """When something is a fault."""
    ranges: tuple[CableRange, ...]
    """What each cable may do."""
    relation: CableRelation
    """Relation between the lengths of the cables."""
    is_homed: bool = True
    """Whether pull and load of the cables are known; False while the drums are homed."""

    def start(self, before: WatchState | None = None) -> WatchState:
        """State to begin with whenever torque is switched on; what is kept of ``before`` is the noise alone."""
        n_cable = len(self.ranges)
        noises = [Noise()] * n_cable if before is None else [motor.frozen.noise for motor in before.motors]
        motors = tuple(MotorWatch(frozen=FrozenState(noise=noise)) for noise in noises)
        return WatchState(motors=motors, cables=(CableWatch(),) * n_cable)


def find_silent(
    motors: tuple[MotorState | None, ...], now: float, sheet: MotorDataSheet, limits: SafetyLimits
) -> tuple[Fault, ...]:
    """Motors whose feedback is missing, too old or impossible: nothing can be computed from it."""
    found = []
    for cable, motor in enumerate(motors):
        finding = find_stale(motor, now, limits) or (motor and find_impossible(motor, sheet, limits))
        if finding:
            found.append(Fault(kind=finding.kind, time=now, cable=cable, text=finding.text))
    return tuple(found)


def watch(watches: Watches, state: WatchState, readings: tuple[CableReading, ...], now: float, dt: float) -> Seen:
    """Advance all watches by one period ``dt`` [s] with torque on; every feedback must have passed `find_silent`.

    While drums are homed neither pull nor load is known, and the watches of the cables rest but for the ceiling.
    """
    sheet, limits = watches.sheet, watches.limits
    loss, lost = watch_loss(state.loss, tuple(one.motor for one in readings), dt, sheet.feedback_period, limits)
    swap, swapped = watch_swap(state.swap, readings, dt, limits)
    found: list[tuple[int | None, Finding]] = [*lost, *([swapped] if swapped else [])]
    motors, cables = [], []
    motions = [one.stall.compute_motion(reading.pull) for one, reading in zip(state.motors, readings, strict=True)]
    excesses = _compute_excesses(watches, readings)
    for number, (reading, excess) in enumerate(zip(readings, excesses, strict=True)):
        others = _find_others(motions, number, limits)
        motor, findings = _watch_motor(watches, state.motors[number], reading, dt, others)
        cable, more = _watch_cable(watches, state.cables, number, reading, dt, excess=excess)
        motors.append(motor)
        cables.append(cable)
        found.extend((number, finding) for finding in (*findings, *more) if finding)
    length, text = _watch_lengths(watches, state.length, cables, readings, dt, excess=max(excesses))
    untaken, stuck = watch_untaken(state.untaken, min(excesses), readings, dt, limits)
    found += [(None, stuck)] if stuck else []
    if text:
        silent = [one.missed for one in loss.heard]
        found.extend(_explain_lengths(text, silent, motors, cables, readings=readings, limits=limits))
    faults = tuple(Fault(kind=one.kind, time=now, cable=number, text=one.text) for number, one in found)
    after = WatchState(motors=tuple(motors), cables=tuple(cables), length=length, untaken=untaken, loss=loss, swap=swap)
    return Seen(after, faults, tuple(_warn(watches, after, readings)))


def _compute_excesses(watches: Watches, readings: tuple[CableReading, ...]) -> tuple[float, ...]:
    """Length of each cable beyond an even bend, without the elastic part; none where pulls are not known [m].

    Pull and tension are of the same time: when cables become taut at once the estimate of the tension lags behind by
    tens of newtons, and what they stretch meanwhile would look like a slip.
    """
    if not watches.is_homed:
        return (0.0,) * len(readings)
    return watches.relation.compute_excess(tuple(_remove_stretch(reading, watches.limits) for reading in readings))


def _remove_stretch(reading: CableReading, limits: SafetyLimits) -> float:
    """Cable wound in without its elastic part, at the time that the tension tells of [m]."""
    pull = reading.pull if reading.pull_at_tension is None else reading.pull_at_tension
    return pull - limits.compliance * reading.tension


def _watch_lengths(
    watches: Watches,
    state: LengthState,
    cables: list[CableWatch],
    readings: tuple[CableReading, ...],
    dt: float,
    *,
    excess: float,
) -> tuple[LengthState, str]:
    """The lengths of all cables, and what is wrong with them or ""."""
    if not watches.is_homed:
        return state, ""
    is_taut = all(cable.load.elapsed == 0.0 for cable in cables)
    tension = sum(reading.tension for reading in readings)
    return watch_length(state, excess, tension, dt, is_taut=is_taut, limits=watches.limits)


_SILENT = 3
"""Periods in a row without feedback that explain a length [-] (ours): a part of `SafetyLimits.missed_cycles`, for its
motor is no longer where it was heard last."""


_ALIKE = "a cable slipped or broke, or a drum is tangled"


def _explain_lengths(
    text: str,
    silent: list[int],
    motors: list[MotorWatch],
    cables: list[CableWatch],
    *,
    readings: tuple[CableReading, ...],
    limits: SafetyLimits,
) -> list[tuple[int | None, Finding]]:
    """Why lengths do not fit, by what is known of each motor and cable at that time.

    A motor that is silent, a drum that stands while its torque changes, one that its cable drives in, a cable without
    load; else the lengths alone are known. No cable pulls a drum in unless it is wound the wrong way round; where such
    a cable carries little load, and where a drum winds another length, a slip, a break and a tangled drum look alike.
    """
    found: list[tuple[int | None, Finding]] = []
    for number, (missed, motor, cable, reading) in enumerate(zip(silent, motors, cables, readings, strict=True)):
        if missed >= _SILENT:
            why = Finding(FaultKind.STALE_FEEDBACK, f"{missed} periods without feedback, and {text}")
        elif motor.stall.blocked > 0.0:
            stands = "the drum does not turn though its torque changes"
            why = Finding(FaultKind.STALL, f"{stands}, and {text}; if it is not stuck, {_ALIKE}")
        elif reading.speed > limits.tangle_speed and reading.resistance < -limits.tangle_drive:
            force = f"the cable drives its drum in with {-reading.resistance:.1f} N"
            why = Finding(FaultKind.TANGLED_DRUM, f"{force}, and {text}")
        elif cable.load.elapsed >= limits.slack_time:
            load = f"its load is {cable.load.load:.2f} N"
            why = Finding(FaultKind.SLACK, f"{text}; {load}: it is slack or broken, or its drum is tangled")
        else:
            continue
        found.append((number, why))
    return found or [(None, Finding(FaultKind.CABLE_LENGTHS, f"{text}; {_ALIKE}"))]


_Findings = tuple[Finding | None, ...]


def _find_others(motions: list[float], number: int, limits: SafetyLimits) -> float:
    """Motion of the other drums that explains a change of this cable's tension; 0 where it is too large [m]."""
    others = motions[:number] + motions[number + 1 :]
    return sum(others) if max(map(abs, others), default=0.0) <= limits.blocked_motion_most else 0.0


def _watch_motor(
    watches: Watches, state: MotorWatch, reading: CableReading, dt: float, others: float
) -> tuple[MotorWatch, _Findings]:
    """The watches of one motor; ``others`` is what the other drums wound in lately [m]."""
    sheet, limits = watches.sheet, watches.limits
    motion, found_motion = watch_motion(state.motion, reading.motor, sheet, limits)
    frozen, found_frozen = watch_frozen(state.frozen, reading, limits)
    voltage, found_voltage = watch_voltage(state.voltage, reading.motor, dt, limits)
    stall, found_stall = watch_stall(state.stall, reading, dt, sheet, limits, others=others)
    after = MotorWatch(frozen=frozen, motion=motion, voltage=voltage, stall=stall)
    found_own = find_hot(reading.motor, sheet), found_voltage, find_reported(reading.motor)
    return after, (found_motion, found_frozen, *found_own, found_stall)


def _watch_cable(
    watches: Watches, states: tuple[CableWatch, ...], number: int, reading: CableReading, dt: float, *, excess: float
) -> tuple[CableWatch, _Findings]:
    """The watches of one cable; ``states`` are those of all."""
    limits, state, allowed, is_homed = watches.limits, states[number], watches.ranges[number], watches.is_homed
    tension, found_tension = watch_tension(state.tension, reading, dt, allowed.tension_ceiling, limits)
    cell, found_cell = watch_cell(state.cell, reading, allowed.friction, dt, limits, is_homed=is_homed)
    if not is_homed:
        return CableWatch(tension=tension, cell=cell), (found_tension, found_cell)
    load = watch_load(state.load, reading, allowed.tension_least, dt, limits)
    is_judged = all(other.load.elapsed == 0.0 for other in states[:number] + states[number + 1 :])
    is_slack = load.elapsed > 0.0
    claim, found_claim = watch_claim(
        state.claim, reading, allowed, dt, limits, excess=excess, is_slack=is_slack, is_judged=is_judged
    )
    slip, found_slip = watch_slip(state.slip, reading, dt, limits)
    tangle, found_tangle = watch_tangle(state.tangle, reading, allowed, limits)
    after = CableWatch(load=load, slip=slip, tangle=tangle, tension=tension, cell=cell, claim=claim)
    found_far = find_too_far(reading, allowed, limits)
    return after, (found_slip, found_tangle, found_tension, found_far, found_cell or found_claim)


def _warn(watches: Watches, state: WatchState, readings: tuple[CableReading, ...]) -> Iterator[str]:
    """What a person should know although it is no fault."""
    if state.loss.loss >= 0.8 * watches.limits.loss_warned:
        yield f"{state.loss.loss:.0%} of the feedback is lost"
    for number, reading in enumerate(readings, start=1):
        share = derate(reading.motor.temperature, watches.sheet)
        if share < 1.0:
            yield f"motor {number} has {reading.motor.temperature:g} degC: its tension is limited to {share:.0%}"
