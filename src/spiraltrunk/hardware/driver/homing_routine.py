"""Homing as the driver runs it: the probe of each motor first, then the routine that finds the zero of each drum."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import NamedTuple, final

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.motors.motor_port import MotorState
from spiraltrunk.hardware.safety.fault import Fault, FaultKind
from spiraltrunk.hardware.safety.probe import ProbeState, probe_torques, step_probe
from spiraltrunk.hardware.winder.homing import HomingState, HomingStatus, begin_homing, step_homing
from spiraltrunk.hardware.winder.winder import Winder


@final
class HomingStep(NamedTuple):
    """What a routine does in one period."""

    torques: tuple[float, ...]
    """Torques of this period [N m]."""
    zero_angles: tuple[float, ...] | None = None
    """Angle of each motor at the straight, just taut trunk [rad]; None until they are found."""
    faults: tuple[Fault, ...] = ()
    """What kept it from finding them."""


class HomingRoutine(ABC):
    """Finds the angle of each drum at the straight, just taut trunk, by gentle tension."""

    @abstractmethod
    def start(self, motors: tuple[MotorState, ...]) -> None:
        """Begin anew with this feedback."""

    @abstractmethod
    def step(self, motors: tuple[MotorState, ...], now: float, dt: float) -> HomingStep:
        """Advance by ``dt`` [s]."""


@final
class ProbedHoming(HomingRoutine):
    """A probe of each motor, then another routine."""

    def __init__(self, routine: HomingRoutine) -> None:
        self._routine = routine
        self._probe: ProbeState | None = None

    def start(self, motors: tuple[MotorState, ...]) -> None:
        """Begin with the probe of the first motor."""
        self._probe = ProbeState()

    def step(self, motors: tuple[MotorState, ...], now: float, dt: float) -> HomingStep:
        """Probe, and afterwards advance the other routine."""
        if self._probe is None:
            return self._routine.step(motors, now, dt)
        self._probe, found = step_probe(self._probe, [motor.torque for motor in motors], dt)
        if found:
            number, finding = found
            fault = Fault(kind=finding.kind, time=now, cable=number, text=finding.text)
            return HomingStep((0.0,) * len(motors), None, (fault,))
        if self._probe.motor < len(motors):
            return HomingStep(probe_torques(self._probe, len(motors)))
        self._probe = None
        self._routine.start(motors)
        return HomingStep((0.0,) * len(motors))


@final
class WinderHoming(HomingRoutine):
    """Homing by the winders: all cables taut, the trunk straight between them, see `winder.homing`."""

    def __init__(self, winders: Sequence[Winder]) -> None:
        self._winders = tuple(winders)
        self._state: HomingState | None = None

    def start(self, motors: tuple[MotorState, ...]) -> None:
        """Begin anew with this feedback."""
        self._state = begin_homing(self._winders, motors)

    def step(self, motors: tuple[MotorState, ...], now: float, dt: float) -> HomingStep:
        """Advance by ``dt`` [s]; a cable that does not become taut is slack or broken, a drum that stays is stalled."""
        state = self._state or begin_homing(self._winders, motors)
        try:
            self._state, torques = step_homing(self._winders, state, motors, dt)
        except DriveError as error:
            fault = Fault(kind=FaultKind.IMPLAUSIBLE_FEEDBACK, time=now, cable=None, text=str(error))
            return HomingStep((0.0,) * len(motors), None, (fault,))
        if self._state.status is HomingStatus.FAILED:
            fault = Fault(kind=FaultKind.HOMING, time=now, cable=self._state.cable, text=self._state.reason)
            return HomingStep((0.0,) * len(motors), None, (fault,))
        is_homed = self._state.status is HomingStatus.HOMED
        return HomingStep(torques, tuple(one.winder.zero_angle for one in self._state.cables) if is_homed else None)
