"""Settings of the driver."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

from spiraltrunk.checks import check_number
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.motors.pwm_servo import ServoCalibration
from spiraltrunk.hardware.safety.limits import SafetyLimits

HOBBY_SERVO = ServoCalibration(least_us=1000.0, most_us=2000.0, open_us=1000.0, slack_us=1500.0, closed_us=2000.0)
"""Pulses that hobby servos take (unconfirmed)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class DriverOptions:
    """How a trunk is driven."""

    period: float = 0.002
    """Period of control [s]; at least that of the motors' data sheet."""
    limits: SafetyLimits = field(default_factory=SafetyLimits)
    """When what is measured is a fault."""
    without_watchdog: bool = False
    """Whether torque may be switched on without a watchdog: a host that dies then leaves the last torque on."""
    arming_time: float = 1.0
    """Time after arming for which the floor of tension is held without a command [s] (ours)."""
    validity_most: float = 1.0
    """Longest validity of a command [s] (ours)."""
    gripper: ServoCalibration = HOBBY_SERVO
    """Pulses of the gripper's servo; measure them at calibration."""

    def __post_init__(self) -> None:
        check_number("driver.period", self.period, least=1e-4, most=0.1)
        check_number("driver.arming_time", self.arming_time, least=0.0, most=10.0)
        check_number("driver.validity_most", self.validity_most, least=0.0, most=10.0)
