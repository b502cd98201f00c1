"""A group of motors, one per cable: the interface that winders are written against, whatever the motor's family."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from spiraltrunk.field_docs import explain_fields


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class MotorDataSheet:
    """Limits of a motor that no setting may raise; its module names the sources."""

    name: str
    """Name of the family, such as "gm6020"."""
    torque_max: float
    """Largest torque [N m]."""
    speed_max: float
    """Speed without load [rad/s]."""
    torque_step: float
    """Resolution of a commanded torque [N m]."""
    angle_step: float
    """Resolution of the measured angle [rad]."""
    period: float
    """Least period of control that its bus allows with one motor per cable [s]."""
    silence_max: float
    """Longest silence after which the count of turns is still known: half a turn at full speed [s]."""
    temperature_derate: float
    """Temperature from which the torque is reduced [degC]."""
    temperature_stop: float
    """Temperature at which the motor must stop [degC]."""
    rotor_inertia: float
    """Inertia of the rotor about its axis [kg m^2]."""
    rotor_friction: float
    """Dry friction of the bearings and the cogging [N m]."""
    feedback_period: float | None = None
    """Period at which a motor sends feedback by itself [s]; None where it is asked, once in a period of control."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class MotorState:
    """Latest feedback of one motor."""

    time: float
    """Arrival of the feedback, or the time of its request where a motor is asked, on the driver's clock [s]."""
    angle: float
    """Angle turned since the driver's start, turns counted, positive when the cable is wound in [rad]."""
    speed: float
    """Speed, positive when the cable is wound in [rad/s]."""
    torque: float
    """Torque by the motor's own estimate, positive when it winds in [N m]."""
    temperature: float
    """Temperature [degC]."""
    voltage: float | None = None
    """Supply voltage [V]; None where the motor does not measure it."""
    is_count_lost: bool = False
    """Whether turns may have been missed since the driver's start: a silence too long, or a jump of the angle."""
    problem: str = ""
    """Faults that the motor itself reports, in words; empty without one."""
    n_frame: int | None = None
    """Frames of feedback that have arrived since the driver's start [-]; None where they are not counted."""


class MotorPort(ABC):
    """One motor per cable, in the order of the design's cables. Torques are positive when they wind in."""

    data_sheet: MotorDataSheet
    """The motor's limits."""
    n_motor: int
    """Number of motors."""

    @abstractmethod
    def read(self) -> tuple[MotorState | None, ...]:
        """Latest feedback of each motor, None where none has arrived yet; never waits.

        Raises:
            DriveError: where the bus is off or its adapter gone.
        """

    @abstractmethod
    def send(self, torques: Sequence[float]) -> None:
        """Send one torque to each motor [N m], in one flush of the bus.

        Raises:
            DriveError: where a torque is not finite, their number is wrong, one is beyond the data sheet (nothing is
                sent then, and nothing is clamped), or the bus is off.
        """

    @abstractmethod
    def restart_count(self) -> None:
        """Count turns anew from here, after homing: clears `MotorState.is_count_lost`."""

    @abstractmethod
    def close(self) -> None:
        """Send zero torque where the bus still works, and release it; harmless when called again."""
