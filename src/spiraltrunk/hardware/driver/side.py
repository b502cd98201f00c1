"""What a driver commands beside the winders: the arm and the gripper's servo."""

from __future__ import annotations

from typing import final

import numpy as np

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.arm.arm_port import ArmPort, ArmState
from spiraltrunk.hardware.driver.targets import Targets
from spiraltrunk.hardware.motors.pwm_servo import ServoCalibration, compute_pulse
from spiraltrunk.hardware.motors.servo_port import ServoPort
from spiraltrunk.hardware.safety.fault import Fault, FaultKind
from spiraltrunk.hardware.safety.limits import SafetyLimits


@final
class ArmSide:
    """The arm: gets each new position once, is watched, and is held on a fault."""

    def __init__(self, arm: ArmPort | None, limits: SafetyLimits) -> None:
        self._arm, self._limits = arm, limits
        self.state: ArmState | None = None
        """Latest measured state; None without an arm."""

    def watch(self, now: float) -> tuple[Fault, ...]:
        """Read the arm, and return the faults that were found."""
        if self._arm is None:
            return ()
        try:
            state = self.state = self._arm.read()
        except DriveError as error:
            return (_build_fault(str(error), now),)
        if state.error is not None:
            return (_build_fault(f"the arm's controller reports {state.error}", now),)
        if not np.isfinite(state.position).all():
            return (_build_fault("the arm's measured position is not finite", now),)
        if not now - state.time < self._limits.feedback_age:
            allowed = f"allowed: below {1e3 * self._limits.feedback_age:g} ms"
            return (_build_fault(f"the arm's state is {1e3 * (now - state.time):.1f} ms old; {allowed}", now),)
        return ()

    def send(self, position: np.ndarray, now: float) -> tuple[Fault, ...]:
        """Command a position; a refusal is a fault."""
        if self._arm is None:
            return ()
        try:
            self._arm.send(position)
        except DriveError as error:
            return (_build_fault(str(error), now),)
        return ()

    def hold(self, now: float) -> tuple[Fault, ...]:
        """Stop the arm where it is."""
        if self._arm is None:
            return ()
        try:
            self._arm.hold()
        except DriveError as error:
            return (_build_fault(str(error), now),)
        return ()

    def close(self) -> None:
        """Hold the arm and release it."""
        if self._arm is not None:
            self._arm.close()


def _build_fault(text: str, now: float) -> Fault:
    return Fault(kind=FaultKind.ARM, time=now, cable=None, text=text)


@final
class GripperSide:
    """The servo: gets each new pulse once, and goes limp while the torque is off."""

    def __init__(self, servo: ServoPort | None, calibration: ServoCalibration) -> None:
        self._servo, self._calibration = servo, calibration
        self._sent: float | None = None

    def send(self, targets: Targets, now: float) -> tuple[Fault, ...]:
        """Command the gripper; a refusal is a fault."""
        if self._servo is None or targets.gripper == self._sent:
            return ()
        try:
            self._servo.set_pulse(compute_pulse(self._calibration, targets.gripper))
        except DriveError as error:
            return (Fault(kind=FaultKind.SERVO, time=now, cable=None, text=str(error)),)
        self._sent = targets.gripper
        return ()

    def release(self) -> None:
        """Let the servo go limp; once, until it is commanded again."""
        if self._servo is None or self._sent is None:
            return
        self._sent = None
        self._servo.release()
