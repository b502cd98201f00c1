"""Servo that moves nothing and records its pulses, for the twin and for tests."""

from __future__ import annotations

from typing import final

from spiraltrunk.hardware.clock import Clock
from spiraltrunk.hardware.motors.pwm_servo import ServoCalibration, check_pulse
from spiraltrunk.hardware.motors.servo_port import ServoPort


@final
class RecordingServo(ServoPort):
    """A servo without hardware; it refuses what a real one refuses."""

    def __init__(self, clock: Clock, calibration: ServoCalibration) -> None:
        self.calibration = calibration
        self.pulse_us: float | None = None
        """Pulse in force [us]; None while the servo is limp."""
        self.changes: list[tuple[float, float | None]] = []
        """Time [s] and pulse [us] of each change."""
        self._clock = clock

    def set_pulse(self, pulse_us: float) -> None:
        """See `ServoPort.set_pulse`."""
        check_pulse(self.calibration, pulse_us)
        self._change(float(pulse_us))

    def release(self) -> None:
        """See `ServoPort.release`."""
        self._change(None)

    def _change(self, pulse_us: float | None) -> None:
        if pulse_us != self.pulse_us:
            self.pulse_us = pulse_us
            self.changes.append((self._clock.now(), pulse_us))
