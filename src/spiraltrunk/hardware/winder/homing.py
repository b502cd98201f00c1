"""Homing by gentle tension: all cables are wound in until they are taut, and the trunk is straight between them.

The trunk hangs down, free of objects. Equal tensions hold it straight up to its weight and its friction; where it
is then is pull 0 of every winder. The motors cannot feel where the trunk is: a person looks whether it is so. Through
gears of 15 N no motor feels the 0.2 N that hold a trunk 3 mm aside, so that the drums are stirred at the end, see
`stirring`. Pure functions; nothing here was tried on a real motor.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import final

from spiraltrunk.checks import check_number
from spiraltrunk.errors import DriveError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.motors.motor_port import MotorState
from spiraltrunk.hardware.winder.feedback_check import check_feedback
from spiraltrunk.hardware.winder.stirring import Stirring, compute_torque, step_stirring
from spiraltrunk.hardware.winder.winder import Winder, WinderState, WinderTarget, step

FLOORS = 3.0
"""Tension of homing over the floor [-] (ours)."""

DITHER = 2.0
"""Amplitude of the dither over the dry friction while slack is taken in [-] (ours: the true one may be twice that)."""

STILL_TIME, STILL_LENGTH = 0.5, 1e-3
"""A cable is still that moved less than this length [m] for this time [s] (ours)."""

JAM_TIME, JAM_LENGTH = 3.0, 3e-5
"""A drum is jammed that moved less than this length [m] for this time under tension [s] (ours).

Three newtons stretch a cable of 2e4 N/m by five times that length, and an encoder of 8192 steps sees a quarter of it.
"""

SPARE_TIME = 5.0
"""Time limit of homing beyond twice the time that the whole travel takes at the speed of a slack cable [s] (ours)."""


@final
class HomingStatus(Enum):
    """Where homing is."""

    RUNNING = "running"
    HOMED = "homed"
    FAILED = "failed"


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class CableHoming:
    """Homing of one cable."""

    winder: WinderState
    """Control of its winder; until homed, counted from the end of the cable, when homed from the straight trunk."""
    start: float
    """Pull at the beginning [m]."""
    still_pull: float
    """Pull from which the cable did not move since `still_since` [m]."""
    still_since: float
    """Time of homing at which it came there [s]."""
    has_moved: bool = False
    """Whether it moved at all."""
    has_lost_count: bool = False
    """Whether turns had been lost before homing began."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class HomingState:
    """Homing of all cables."""

    cables: tuple[CableHoming, ...]
    """One a cable."""
    tension: float
    """Tension of homing [N]."""
    time: float = 0.0
    """Time since it began [s]."""
    stirring: Stirring | None = None
    """Stirring, from the time at which all cables were taut and at rest; None before."""
    status: HomingStatus = HomingStatus.RUNNING
    """Running, homed or failed."""
    cable: int | None = None
    """Cable that failed, counted from 0."""
    reason: str = ""
    """Why it failed, one line."""


def begin_homing(winders: Sequence[Winder], motors: Sequence[MotorState], tension: float | None = None) -> HomingState:
    """Begin homing from where the motors are; by default with `FLOORS` times the largest floor of the winders.

    Raises:
        DesignError: where the tension is below a floor or above a ceiling.
    """
    floor, ceiling = (max(w.limits.tension_floor for w in winders), min(w.limits.tension_ceiling for w in winders))
    tension = min(FLOORS * floor, ceiling) if tension is None else tension
    check_number("homing.tension", tension, least=floor, most=ceiling)
    cables = tuple(_begin(winder, motor) for winder, motor in zip(winders, motors, strict=True))
    return HomingState(cables=cables, tension=tension)


def step_homing(
    winders: Sequence[Winder], state: HomingState, motors: Sequence[MotorState], dt: float
) -> tuple[HomingState, tuple[float, ...]]:
    """Advance homing by ``dt`` [s], and return its state and the torques [N m].

    Homed are all cables that reached the tension, moved, stood still together for `STILL_TIME`, and were stirred. It
    fails, and the winders hold their floor, where a cable does not become taut within the drum's travel (it is off or
    broken), where a drum never moves (it is jammed, or its cable was taut before), where turns are lost, and where the
    cables are not taut after a time limit.

    Raises:
        DriveError: where homing is over, or feedback is not finite.
    """
    if state.status is not HomingStatus.RUNNING:
        raise DriveError(f"homing is over: {state.status.value}; allowed: to begin anew")
    state = replace(state, time=state.time + dt)
    if state.stirring is None:
        return _wind_in(winders, state, motors, dt)
    for motor in motors:
        check_feedback(motor, dt, None)
    pulls = [_read_pull(*each) for each in zip(winders, state.cables, motors, strict=True)]
    stirring = step_stirring(winders[0], state.stirring, pulls, dt)
    state = replace(state, stirring=stirring)
    torques = tuple(
        compute_torque(
            winder, stirring, winder.drum.radius(motor.angle - cable.winder.zero_angle), state.tension,
            2 * math.pi * number / len(winders),
        )
        for number, (winder, cable, motor) in enumerate(zip(winders, state.cables, motors, strict=True))
    )  # fmt: skip
    failed = _find_failed(winders, state, motors)
    if failed is None and stirring.is_over:
        homed = tuple(map(_set_zero, winders, state.cables, stirring.zeros))
        return replace(state, cables=homed, status=HomingStatus.HOMED), torques
    return failed or state, torques


def _wind_in(
    winders: Sequence[Winder], state: HomingState, motors: Sequence[MotorState], dt: float
) -> tuple[HomingState, tuple[float, ...]]:
    """One period of winding in until all cables are taut and at rest."""
    stepped = [
        _step_cable(winder, cable, motor, state, dt)
        for winder, cable, motor in zip(winders, state.cables, motors, strict=True)
    ]
    after = replace(state, cables=tuple(cable for cable, _ in stepped))
    torques = tuple(torque for _, torque in stepped)
    failed = _find_failed(winders, after, motors)
    if failed is None and all(_is_taut(cable, after) for cable in after.cables):
        return replace(after, stirring=Stirring()), torques
    return failed or after, torques


def _find_failed(winders: Sequence[Winder], state: HomingState, motors: Sequence[MotorState]) -> HomingState | None:
    """The state with the first cable that failed; None where none did."""
    for i, (winder, cable, motor) in enumerate(zip(winders, state.cables, motors, strict=True)):
        if reason := _find_fault(winder, cable, motor, state):
            return replace(state, status=HomingStatus.FAILED, cable=i, reason=reason)
    return None


def find_time_limit(winder: Winder) -> float:
    """Longest time until all cables are taut [s]."""
    return 2 * _find_travel(winder) / winder.gains.slack_speed + SPARE_TIME


def _begin(winder: Winder, motor: MotorState) -> CableHoming:
    """A cable of which nothing is known: it may be paid out all the way."""
    start = winder.limits.pull_min
    state = WinderState(zero_angle=motor.angle - winder.drum.angle(start))
    return CableHoming(winder=state, start=start, still_pull=start, still_since=0.0, has_lost_count=motor.is_count_lost)


def _step_cable(
    winder: Winder, cable: CableHoming, motor: MotorState, homing: HomingState, dt: float
) -> tuple[CableHoming, float]:
    state, reading, torque = step(winder, cable.winder, WinderTarget(tension=homing.tension), motor, dt, dither=DITHER)
    has_moved = cable.has_moved or abs(reading.pull - cable.start) > max(JAM_LENGTH, 4 * _find_step(winder))
    is_ramping = state.tension_limit < homing.tension
    if is_ramping or abs(reading.pull - cable.still_pull) > STILL_LENGTH:
        return replace(
            cable, winder=state, has_moved=has_moved, still_pull=reading.pull, still_since=homing.time
        ), torque
    return replace(cable, winder=state, has_moved=has_moved), torque


def _read_pull(winder: Winder, cable: CableHoming, motor: MotorState) -> float:
    """Cable wound in, as `CableHoming.start` counts it [m]."""
    return winder.drum.pull(motor.angle - cable.winder.zero_angle)


def _find_fault(winder: Winder, cable: CableHoming, motor: MotorState, state: HomingState) -> str:
    wound, travel = _read_pull(winder, cable, motor) - cable.start, _find_travel(winder)
    if motor.is_count_lost and not cable.has_lost_count:
        return "turns were lost during homing; look at the bus, and home again"
    if wound > travel:
        return (
            f"not taut after winding in {1e3 * wound:.0f} mm, the drum's travel is {1e3 * travel:.0f} mm: is its cable "
            "off the drum, or broken?"
        )
    if not cable.has_moved and state.time - cable.still_since > JAM_TIME:
        return (
            f"moved less than {1e3 * JAM_LENGTH:g} mm in {JAM_TIME:g} s under {state.tension:.1f} N: is its drum "
            "jammed, or was its cable taut before? Loosen it by hand"
        )
    if state.stirring is not None and state.stirring.is_unsettled:
        return "did not settle while the drums were stirred: does something move the trunk?"
    if state.stirring is None and state.time > (limit := find_time_limit(winder)):
        return f"did not come to rest in {limit:.0f} s: does something move the trunk?"
    return ""


def _is_taut(cable: CableHoming, state: HomingState) -> bool:
    return cable.has_moved and state.time - cable.still_since >= STILL_TIME


def _set_zero(winder: Winder, cable: CableHoming, zero: float) -> CableHoming:
    """The cable counted from this pull [m]."""
    angle = cable.winder.zero_angle + winder.drum.angle(zero)
    return replace(cable, winder=cable.winder._replace(zero_angle=angle), start=0.0, still_pull=0.0)


def _find_travel(winder: Winder) -> float:
    """Cable that the drum has to wind [m]."""
    return winder.drum.design.travel_in + winder.drum.design.travel_out


def _find_step(winder: Winder) -> float:
    """Cable of one step of the encoder [m]."""
    return winder.angle_step * winder.drum.design.winding_radius
