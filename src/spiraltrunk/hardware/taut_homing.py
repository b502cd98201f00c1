"""Homing of all winders by gentle tension, as a routine of the driver."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

from spiraltrunk.hardware.driver_homing import HomingRoutine, HomingStep
from spiraltrunk.hardware.motors.motor_port import MotorState
from spiraltrunk.hardware.safety.fault import Fault, FaultKind
from spiraltrunk.hardware.winder.homing import HomingState, HomingStatus, begin_homing, step_homing
from spiraltrunk.hardware.winder.winder import Winder


@final
class TautHoming(HomingRoutine):
    """`winder.homing`: every cable is wound in until the trunk is straight between them."""

    def __init__(self, winders: Sequence[Winder]) -> None:
        self._winders = tuple(winders)
        self._state: HomingState | None = None

    def start(self, motors: tuple[MotorState, ...]) -> None:
        """Begin from where the motors are."""
        self._state = begin_homing(self._winders, motors)

    def step(self, motors: tuple[MotorState, ...], now: float, dt: float) -> HomingStep:
        """Advance by ``dt`` [s]."""
        assert self._state is not None
        self._state, torques = step_homing(self._winders, self._state, motors, dt)
        if self._state.status is HomingStatus.RUNNING:
            return HomingStep(torques)
        if self._state.status is HomingStatus.HOMED:
            return HomingStep(torques, tuple(cable.winder.zero_angle for cable in self._state.cables))
        fault = Fault(kind=FaultKind.STALL, time=now, cable=self._state.cable, text=self._state.reason)
        return HomingStep(torques, None, (fault,))
