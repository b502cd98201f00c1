"""What feedback a winder takes."""

from __future__ import annotations

import math

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.motors.motor_port import MotorState

_ANGLE_MOST, _SPEED_MOST, _FORCE_MOST = 1e6, 1e4, 1e4
"""Largest feedback [rad, rad/s, N m or N] (ours); anything else is no measurement."""


def check_feedback(motor: MotorState, dt: float, measured_tension: float | None) -> None:
    """Refuse feedback that is no measurement.

    Raises:
        DriveError: where feedback, ``dt`` [s] or the measured tension [N] is not finite or out of its range.
    """
    load = measured_tension or 0.0
    is_sane = -_ANGLE_MOST <= motor.angle <= _ANGLE_MOST and -_SPEED_MOST <= motor.speed <= _SPEED_MOST
    is_sane = is_sane and -_FORCE_MOST <= motor.torque <= _FORCE_MOST and -_FORCE_MOST <= load <= _FORCE_MOST
    if not (is_sane and math.isfinite(motor.time)):
        raise DriveError(
            f"feedback of a winder: {motor.angle:g} rad, {motor.speed:g} rad/s, {motor.torque:g} N m at {motor.time:g} "
            f"s, load cell {load:g} N; allowed: finite, at most {_ANGLE_MOST:g} rad, {_SPEED_MOST:g} rad/s and "
            f"{_FORCE_MOST:g} N m or N"
        )
    if not 0.0 < dt < math.inf:
        raise DriveError(f"time between two steps of a winder is {dt:g} s; allowed: finite and above 0")
