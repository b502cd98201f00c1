"""The gripper's hobby servo behind the development board, and its pulses as measured at calibration.

No data sheet of the DS-929MG is at hand: 50 Hz and 1000 to 2000 us with the centre at 1500 us are what hobby servos
take (unconfirmed). Where the gripper is open, slack and closed is measured. Never tried on a real servo.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

from spiraltrunk.checks import check_number
from spiraltrunk.errors import DesignError, DriveError, Unquoted, describe
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.bus.board import BoardBus
from spiraltrunk.hardware.motors.servo_port import ServoPort

NARROWEST_US = 500.0
"""Narrowest pulse that a calibration may name (ours: beyond it a hobby servo runs into its stop) [us]."""

WIDEST_US = 2500.0
"""Widest pulse that a calibration may name (ours) [us]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class ServoCalibration:
    """Pulses of one gripper, measured with its cables on. Open may be wider than closed, or narrower."""

    least_us: float
    """Narrowest pulse at which nothing is forced, from 500 us [us]."""
    most_us: float
    """Widest pulse at which nothing is forced, up to 2500 us [us]."""
    open_us: float
    """Pulse of the open gripper: command -1 [us]."""
    slack_us: float
    """Pulse at which the gripper's cable is slack: command 0 [us]."""
    closed_us: float
    """Pulse of the closed gripper: command 1 [us]."""

    def __post_init__(self) -> None:
        check_number("servo.least_us", self.least_us, least=NARROWEST_US, most=WIDEST_US)
        check_number("servo.most_us", self.most_us, above=self.least_us, most=WIDEST_US)
        for name in ("open_us", "slack_us", "closed_us"):
            check_number(f"servo.{name}", getattr(self, name), least=self.least_us, most=self.most_us)
        if not min(self.open_us, self.closed_us) < self.slack_us < max(self.open_us, self.closed_us):
            got = Unquoted(f"{self.slack_us:g} us")
            allowed = f"between open_us {self.open_us:g} and closed_us {self.closed_us:g}"
            raise DesignError("servo.slack_us", got=got, allowed=allowed)


def compute_pulse(calibration: ServoCalibration, gripper: float) -> float:
    """Pulse of a gripper command, linear from -1 (open) to 0 (slack) and on to 1 (closed) [us].

    Raises:
        DriveError: where the command is not finite or outside -1 to 1; it is not clamped.
    """
    if not (_is_number(gripper) and -1.0 <= gripper <= 1.0):
        raise DriveError(f"gripper command is {describe(gripper)}; allowed: a finite number from -1 to 1")
    end = calibration.closed_us if gripper > 0.0 else calibration.open_us
    return calibration.slack_us + abs(float(gripper)) * (end - calibration.slack_us)


def check_pulse(calibration: ServoCalibration, pulse_us: float) -> None:
    """Refuse a pulse that is not finite or outside the limits measured at calibration.

    Raises:
        DriveError: with the pulse and the limits.
    """
    least, most = calibration.least_us, calibration.most_us
    if not (_is_number(pulse_us) and least <= pulse_us <= most):
        raise DriveError(f"servo pulse is {describe(pulse_us)}; allowed: a finite number from {least:g} to {most:g} us")


def _is_number(value: object) -> bool:
    return isinstance(value, (float, int)) and math.isfinite(value)


@final
class PwmServo(ServoPort):
    """A servo on the board's pulse output. What is set leaves with the board's next flush, and is repeated at 50 Hz."""

    def __init__(self, board: BoardBus, calibration: ServoCalibration) -> None:
        """Use the servo of an open board, which its motors' driver flushes and closes."""
        self.calibration = calibration
        self._board = board

    def set_pulse(self, pulse_us: float) -> None:
        """See `ServoPort.set_pulse`; rounded to 1 us."""
        check_pulse(self.calibration, pulse_us)
        self._board.set_servo_pulse(round(pulse_us))

    def release(self) -> None:
        """See `ServoPort.release`."""
        self._board.set_servo_pulse(0)
