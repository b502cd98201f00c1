"""The simulated gripper's servo: a pulse becomes a share of the cables' tension, no faster than the servo turns."""

from __future__ import annotations

from typing import final

import numpy as np

from spiraltrunk.hardware.motors.pwm_servo import ServoCalibration, check_pulse
from spiraltrunk.hardware.motors.servo_port import ServoPort
from spiraltrunk.hardware.twin.device import TwinDevice
from spiraltrunk.sim.machine import GRIPPER_TIME, SimMachine

CALIBRATION = ServoCalibration(least_us=1000.0, most_us=2000.0, open_us=1000.0, slack_us=1500.0, closed_us=2000.0)
"""Pulses of the twin's gripper [us] (ours)."""


@final
class MachineServo(ServoPort, TwinDevice):
    """A servo that moves the gripper of a simulated machine; it is advanced with the motors."""

    def __init__(self, machine: SimMachine) -> None:
        self._machine = machine
        self._share, self._wanted = 0.0, 0.0

    def set_pulse(self, pulse_us: float) -> None:
        """See `ServoPort.set_pulse`."""
        check_pulse(CALIBRATION, pulse_us)
        ends = (CALIBRATION.open_us, CALIBRATION.slack_us, CALIBRATION.closed_us)
        self._wanted = float(np.interp(pulse_us, ends, (-1.0, 0.0, 1.0)))

    def release(self) -> None:
        """See `ServoPort.release`: the fingers open by their own elasticity."""
        self._wanted = 0.0

    def advance(self, dt: float) -> None:
        """See `TwinDevice.advance`."""
        step = dt / GRIPPER_TIME
        share = min(max(self._wanted, self._share - step), self._share + step)
        if share != self._share:
            self._share = share
            self._machine.set_gripper(share)
