"""States of a driver: safe, homing, armed, fault; pure functions from a state and an event to the next state.

Torque is on in `Mode.HOMING` and `Mode.ARMED` alone. In `Mode.FAULT` there is the ramp to zero and nothing else. A
fault stays until a person clears it by name, and leads back to `Mode.SAFE`, never to a state with torque.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import Enum
from typing import final

from spiraltrunk.errors import DriveError, describe
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.motors.motor_port import MotorDataSheet, MotorState
from spiraltrunk.hardware.safety.fault import Fault
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.watches.feedback_watch import find_impossible, find_stale
from spiraltrunk.hardware.safety.watches.motor_watch import find_reported


@final
class Mode(Enum):
    """What a driver does; its value is what logs and messages call it."""

    SAFE = "safe"
    HOMING = "homing"
    ARMED = "armed"
    FAULT = "fault"


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class SafetyState:
    """Mode of a driver, and what led to it."""

    mode: Mode = Mode.SAFE
    """What the driver does."""
    faults: tuple[Fault, ...] = ()
    """Latched faults, the first cause first; empty outside of `Mode.FAULT`."""
    is_homed: bool = False
    """Whether the drums are homed, and no turn was missed and no fault left their zeros in doubt since."""
    cleared_by: str = ""
    """Person who cleared the last faults; empty before."""

    @property
    def has_torque(self) -> bool:
        """Whether motors may be commanded to pull."""
        return self.mode in {Mode.HOMING, Mode.ARMED}


def find_obstacles(
    motors: Iterable[MotorState | None],
    now: float,
    sheet: MotorDataSheet,
    limits: SafetyLimits,
    *,
    absence: str,
) -> tuple[str, ...]:
    """Why torque must not be switched on now, one line each; empty if it may be.

    Args:
        motors: latest feedback of each motor.
        now: time on the driver's clock [s].
        sheet: limits of the motors.
        limits: largest age of the feedback.
        absence: why the watchdog does not count as present; empty where it does, or was done without explicitly.
    """
    obstacles = [f"no watchdog is present: {absence}"] if absence else []
    for number, motor in enumerate(motors, start=1):
        finding = find_stale(motor, now, limits) or (motor and find_impossible(motor, sheet, limits))
        if finding:
            obstacles.append(f"motor {number}: {finding.text}")
        elif motor and not motor.temperature < sheet.temperature_derate:
            allowed = f"allowed: below {sheet.temperature_derate:g} degC"
            obstacles.append(f"motor {number} has {motor.temperature:g} degC; {allowed}")
        elif motor and (reported := find_reported(motor)):
            obstacles.append(f"motor {number}: {reported.text}")
    return tuple(obstacles)


def start_homing(state: SafetyState, obstacles: tuple[str, ...]) -> SafetyState:
    """From safe to homing; the drums count as not homed until it ends.

    Raises:
        DriveError: from another mode, or with an obstacle.
    """
    _require(state, Mode.SAFE, "home", obstacles)
    return replace(state, mode=Mode.HOMING, is_homed=False)


def finish_homing(state: SafetyState) -> SafetyState:
    """From homing to safe, homed.

    Raises:
        DriveError: from another mode.
    """
    _require(state, Mode.HOMING, "finish homing", ())
    return replace(state, mode=Mode.SAFE, is_homed=True)


def arm(state: SafetyState, obstacles: tuple[str, ...]) -> SafetyState:
    """From safe to armed.

    Raises:
        DriveError: from another mode, where the drums are not homed, or with an obstacle.
    """
    unhomed = () if state.is_homed else ("the drums are not homed; home them first",)
    _require(state, Mode.SAFE, "arm", (*unhomed, *obstacles))
    return replace(state, mode=Mode.ARMED)


def disarm(state: SafetyState) -> SafetyState:
    """From armed to safe.

    Raises:
        DriveError: from another mode.
    """
    _require(state, Mode.ARMED, "disarm", ())
    return replace(state, mode=Mode.SAFE)


def latch(state: SafetyState, faults: Iterable[Fault]) -> SafetyState:
    """Into fault from any mode; the first cause stays the first, and each cause of each cable is kept once.

    The drums count as not homed after a fault that `FaultKind.needs_homing`.
    """
    known = {(fault.kind, fault.cable) for fault in state.faults}
    kept = list(state.faults)
    for fault in faults:
        if (fault.kind, fault.cable) not in known:
            known.add((fault.kind, fault.cable))
            kept.append(fault)
    if not kept:
        return state
    is_homed = state.is_homed and not any(fault.kind.needs_homing for fault in kept)
    return replace(state, mode=Mode.FAULT, faults=tuple(kept), is_homed=is_homed)


def lose_count(state: SafetyState) -> SafetyState:
    """The same mode, not homed: turns were missed while no torque was on."""
    return replace(state, is_homed=False) if state.is_homed else state


def clear(state: SafetyState, person: str, *, is_released: bool) -> SafetyState:
    """From fault to safe, by a person.

    Args:
        state: state in fault.
        person: who clears, for the log.
        is_released: whether the ramp to zero torque has ended.

    Raises:
        DriveError: from another mode, without a name, or before the torque is off.
    """
    check_person(person)
    _require(state, Mode.FAULT, "clear a fault", () if is_released else ("the torque is not off yet; wait for it",))
    return replace(state, mode=Mode.SAFE, faults=(), cleared_by=person.strip())


def check_person(person: str) -> None:
    """Refuse what is no name of a person.

    Raises:
        DriveError: with what was given.
    """
    if not (isinstance(person, str) and person.strip() and person.isprintable()):
        raise DriveError(f"a fault is cleared by {describe(person)}; allowed: the name of a person")


def _require(state: SafetyState, mode: Mode, action: str, obstacles: tuple[str, ...]) -> None:
    """Refuse an event from another mode than ``mode``, or with an obstacle; a fault is named."""
    if state.mode is not mode:
        cause = f" ({state.faults[0].kind.value}: {state.faults[0].text})" if state.faults else ""
        raise DriveError(f"cannot {action}: the driver is in {state.mode.value}{cause}; allowed: in {mode.value}")
    if obstacles:
        raise DriveError(f"cannot {action}: {'; '.join(obstacles)}")
