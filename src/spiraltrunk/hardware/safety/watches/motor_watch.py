"""Watches of the motor: temperature, supply voltage, faults of its own, stall."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import final

from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.motors.motor_port import MotorDataSheet, MotorState
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.reading import CableReading, Finding


def derate(temperature: float, sheet: MotorDataSheet) -> float:
    """Part of the tension above the floor that a motor may still take, 1 to 0 [-].

    1 up to `temperature_derate`, falling linearly to 0 at `temperature_stop`.
    """
    span = sheet.temperature_stop - sheet.temperature_derate
    return min(1.0, max(0.0, (sheet.temperature_stop - temperature) / span))


def find_hot(motor: MotorState, sheet: MotorDataSheet) -> Finding | None:
    """A temperature at which the motor must stop."""
    if motor.temperature < sheet.temperature_stop:
        return None
    text = f"the motor has {motor.temperature:g} degC; allowed: below {sheet.temperature_stop:g} degC"
    return Finding(FaultKind.OVER_TEMPERATURE, text)


def find_reported(motor: MotorState) -> Finding | None:
    """A fault that the motor itself reports: it may have taken off its torque."""
    if not motor.problem:
        return None
    return Finding(FaultKind.MOTOR, f"the motor reports a fault: {motor.problem}; switch it off and on")


def watch_voltage(elapsed: float, motor: MotorState, dt: float, limits: SafetyLimits) -> tuple[float, Finding | None]:
    """A supply voltage outside its range for too long; the state is the time that it is outside [s]."""
    if motor.voltage is None or limits.voltage_least <= motor.voltage <= limits.voltage_most:
        return 0.0, None
    elapsed += dt
    if elapsed < limits.voltage_time:
        return elapsed, None
    allowed = f"allowed: {limits.voltage_least:g} to {limits.voltage_most:g} V"
    return elapsed, Finding(FaultKind.VOLTAGE, f"the supply has {motor.voltage:.1f} V; {allowed}")


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class StallState:
    """For how long a motor does not turn although it should."""

    saturated: float = 0.0
    """Time for which the torque is at its largest without motion [s]."""
    angle: float = math.nan
    """Angle at which the drum stands [rad]."""
    stood: float = 0.0
    """Time for which it stands there [s]."""
    pull: float = math.nan
    """Cable wound in, followed with the time constant `blocked_memory` [m]; NaN before the first."""
    least: float = 0.0
    """Least torque commanded since it stands there, less what is explained [N m]."""
    most: float = 0.0
    """Largest torque commanded since it stands there, likewise [N m]."""
    blocked: float = 0.0
    """Time since the commanded torque has changed enough to turn it [s]."""

    def compute_motion(self, pull: float) -> float:
        """Cable wound in lately, within about `blocked_memory` [m]."""
        return 0.0 if math.isnan(self.pull) else pull - self.pull


def watch_stall(
    state: StallState,
    reading: CableReading,
    dt: float,
    sheet: MotorDataSheet,
    limits: SafetyLimits,
    *,
    others: float = 0.0,
) -> tuple[StallState, Finding | None]:
    """A motor that does not turn: at its largest torque, or through a change of torque that stretches every cable.

    A drum that stands at a high tension is nominal. One that does not turn by `blocked_steps` of the encoder while the
    torque changes by `blocked_torque` plus twice the dry friction, or `blocked_frictions` times it, is blocked, for no
    cable is that stiff. What other drums explain does not count: while they wind in, they tighten this cable through
    the trunk, so that lower torques of before are forgotten with the time constant `blocked_memory`, and larger ones
    while they pay out.

    Args:
        state: state after the period before.
        reading: cable and motor.
        dt: period [s].
        sheet: the motor's limits.
        limits: when it is a fault.
        others: cable that the other drums together wound in lately, negative where they paid out [m].

    Returns:
        The next state, and what was found.
    """
    is_saturated = abs(reading.torque) >= limits.stall_part * sheet.torque_max
    is_still = abs(reading.motor.speed) < limits.stall_speed
    saturated = state.saturated + dt if is_saturated and is_still else 0.0
    after = _stand(state, reading, dt, sheet, limits, others=others)
    span = after.most - after.least
    friction = sheet.rotor_friction
    needed = max(limits.blocked_torque + 2.0 * friction, limits.blocked_frictions * friction)
    after = replace(after, saturated=saturated, blocked=state.blocked + dt if span >= needed else 0.0)
    if saturated >= limits.stall_time:
        text = f"the motor stands at {reading.torque:.2f} N m for {saturated:.1f} s; allowed: {limits.stall_time:g} s"
        return after, Finding(FaultKind.STALL, text)
    if after.blocked >= limits.blocked_time:
        return after, Finding(FaultKind.STALL, f"the drum does not turn while its torque changes by {span:.2f} N m")
    return after, None


def _stand(
    state: StallState, reading: CableReading, dt: float, sheet: MotorDataSheet, limits: SafetyLimits, *, others: float
) -> StallState:
    """Where the drum stands, and the torques commanded since then that nothing explains."""
    angle, torque, share = reading.motor.angle, reading.torque, min(1.0, dt / limits.blocked_memory)
    pull = reading.pull if math.isnan(state.pull) else state.pull + share * (reading.pull - state.pull)
    if not abs(angle - state.angle) <= limits.blocked_steps * sheet.angle_step:
        return StallState(angle=angle, pull=pull, least=torque, most=torque)
    rise = share if others > limits.blocked_motion else 0.0
    fall = share if others < -limits.blocked_motion else 0.0
    least = min(state.least + rise * (torque - state.least), torque)
    most = max(state.most + fall * (torque - state.most), torque)
    return StallState(angle=state.angle, stood=state.stood + dt, pull=pull, least=least, most=most)
