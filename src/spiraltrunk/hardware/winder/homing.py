"""Homing by gentle tension: all cables are wound in until they are taut, and the trunk is straight between them.

The trunk hangs down, free of objects. Equal tensions hold it straight up to its weight and its friction; where it
stands still is pull 0 of every winder. The motors cannot feel where the trunk is: a person looks whether it is so.

Dry friction at the drums is larger than the tensions that hold a hanging trunk straight. So the cables are stirred at
the end, as a magnet is demagnetised: to equal tensions an alternating part is added, shifted from cable to cable by a
turn over their number, which falls from above the friction to zero. The trunk circles by some millimetres, and settles
where the tensions are equal. The larger the friction, the slower: of a rotor that is driven to and fro with the speed
v, dry friction F brakes a slow motion u by F (2/pi) u / v, for it averages to a damping, and so does the back-EMF that
is not compensated. With the gears of STS servos `STIR_TIME` ends some millimetres away from the middle, on the side of
the cables that had less slack: all wind in alike until all are taut. A trunk that 0.2 N hold 3 mm aside cannot be felt
through gears of 15 N.
Pure functions; nothing here was tried on a real motor.
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
from spiraltrunk.hardware.winder.winder import Winder, WinderState, WinderTarget, step

FLOORS = 3.0
"""Tension of homing over the floor [-] (ours)."""

DITHER = 2.0
"""Amplitude of the dither over the dry friction while slack is taken in [-] (ours: the true one may be twice that)."""

STIR, STIR_TIME = 4.0, 5.0
"""Amplitude of the stirring over the dry friction at its start [-], and time in which it falls to zero [s] (ours)."""

STIR_LENGTH = 2.5e-3
"""Motion of each cable to and fro at the start of the stirring [m] (ours)."""

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
    taut_since: float = math.inf
    """Time of homing at which all cables were taut and at rest [s]; infinite before."""
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

    Homed are all cables that reached the tension, moved, and stood still together for `STILL_TIME`. It fails, and the
    winders hold their floor, where a cable does not become taut within the drum's travel (it is off or broken), where a
    drum never moves (it is jammed, or its cable was taut before), where turns are lost, and after a time limit.

    Raises:
        DriveError: where homing is over, or feedback is not finite.
    """
    if state.status is not HomingStatus.RUNNING:
        raise DriveError(f"homing is over: {state.status.value}; allowed: to begin anew")
    time = state.time + dt
    is_taut = state.taut_since < math.inf
    stepped = [
        _stir_cable(winder, cable, motor, state, 2 * math.pi * number / len(winders))
        if is_taut
        else _step_cable(winder, cable, motor, state, dt)
        for number, (winder, cable, motor) in enumerate(zip(winders, state.cables, motors, strict=True))
    ]
    after = replace(state, cables=tuple(cable for cable, _ in stepped), time=time)
    torques = tuple(torque for _, torque in stepped)
    for i, (winder, cable, motor) in enumerate(zip(winders, after.cables, motors, strict=True)):
        if reason := _find_fault(winder, cable, motor, after):
            return replace(after, status=HomingStatus.FAILED, cable=i, reason=reason), torques
    if not is_taut and all(_is_taut(cable, after) for cable in after.cables):
        return replace(after, taut_since=time), torques
    if time - state.taut_since >= STIR_TIME:
        homed = tuple(_set_zero(cable, motor) for cable, motor in zip(after.cables, motors, strict=True))
        return replace(after, cables=homed, status=HomingStatus.HOMED), torques
    return after, torques


def find_time_limit(winder: Winder) -> float:
    """Longest time that homing may take [s]."""
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
            cable, winder=state, has_moved=has_moved, still_pull=reading.pull, still_since=homing.time + dt
        ), torque
    return replace(cable, winder=state, has_moved=has_moved), torque


def _stir_cable(
    winder: Winder, cable: CableHoming, motor: MotorState, homing: HomingState, phase: float
) -> tuple[CableHoming, float]:
    """Torque of the tension, and of an alternating part with this phase [rad] that falls to zero; feedback is unused.

    A rotor that a torque A beyond its friction F drives to and fro moves by about (A - F) t^2 / (32 J) with the period
    t, which follows from `STIR_LENGTH`.
    """
    radius, elapsed = winder.drum.radius(motor.angle - cable.winder.zero_angle), homing.time - homing.taut_since
    amplitude = STIR * winder.friction * max(0.0, 1.0 - elapsed / STIR_TIME)
    excess = max((STIR - 1.0) * winder.friction * radius, 1e-9)
    period = math.sqrt(32.0 * STIR_LENGTH * winder.inertia / excess)
    torque = homing.tension * radius + amplitude * math.sin(2 * math.pi * elapsed / period + phase)
    return cable, min(max(torque, -winder.limits.torque_max), winder.limits.torque_max)


def _find_fault(winder: Winder, cable: CableHoming, motor: MotorState, state: HomingState) -> str:
    wound, travel = winder.drum.pull(motor.angle - cable.winder.zero_angle) - cable.start, _find_travel(winder)
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
    if state.time > (limit := find_time_limit(winder)):
        return f"did not come to rest in {limit:.0f} s: does something move the trunk?"
    return ""


def _is_taut(cable: CableHoming, state: HomingState) -> bool:
    return cable.has_moved and state.time - cable.still_since >= STILL_TIME


def _set_zero(cable: CableHoming, motor: MotorState) -> CableHoming:
    return replace(cable, winder=cable.winder._replace(zero_angle=motor.angle), start=0.0, still_pull=0.0)


def _find_travel(winder: Winder) -> float:
    """Cable that the drum has to wind [m]."""
    return winder.drum.design.travel_in + winder.drum.design.travel_out


def _find_step(winder: Winder) -> float:
    """Cable of one step of the encoder [m]."""
    return winder.angle_step * winder.drum.design.winding_radius
