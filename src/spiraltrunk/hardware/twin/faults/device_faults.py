"""Faults of motors, drums and cables."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

from spiraltrunk.checks import check_count, check_number
from spiraltrunk.errors import DesignError, DriveError
from spiraltrunk.hardware.twin.faults.device_fault import DeviceFault
from spiraltrunk.hardware.twin.motor import MotorTwin
from spiraltrunk.hardware.twin.motors import MotorTwins


@final
@dataclass(frozen=True, kw_only=True)
class IdSwap(DeviceFault):
    """Two motors have each other's id: commands and feedback of two cables are exchanged."""

    name: ClassVar[str] = "id_swap"
    cable: int = 0
    """One of them, counted from 0."""
    other: int = 1
    """The other one."""

    def __post_init__(self) -> None:
        _check_cable(self.cable)
        check_count("other", self.other, least=0, most=11)
        if self.other == self.cable:
            raise DesignError("other", got=self.other, allowed="another cable")

    def begin(self, motors: MotorTwins) -> None:
        """See `DeviceFault.begin`."""
        _find(motors, self.cable)
        _find(motors, self.other)
        motors.swap_ids(self.cable, self.other)

    def end(self, motors: MotorTwins) -> None:
        """See `DeviceFault.end`."""
        motors.swap_ids(self.cable, self.other)


@final
@dataclass(frozen=True, kw_only=True)
class EncoderWrap(DeviceFault):
    """The encoder starts next to its last count, so that it wraps at the first movement.

    No failure of the motor, but one of drivers. It must begin before the motors' first feedback.
    """

    name: ClassVar[str] = "encoder_wrap"
    cable: int = 0
    """Motor, counted from 0."""
    margin: int = 1
    """Counts left before the wrap [-]."""

    def __post_init__(self) -> None:
        _check_cable(self.cable)
        check_count("margin", self.margin, least=0, most=4096)

    def begin(self, motors: MotorTwins) -> None:
        """See `DeviceFault.begin`."""
        motor = _find(motors, self.cable)
        if motors.n_answered:
            raise DriveError("encoder_wrap after the motors' first feedback; allowed: before it, at 0 s")
        counts, reversed_ = motor.parameters.encoder_counts, motor.parameters.is_reversed
        motor.encoder_offset = float(self.margin if reversed_ else counts - 1 - self.margin) + 0.5

    def end(self, motors: MotorTwins) -> None:
        """See `DeviceFault.end`; the encoder stays where it is."""


@final
@dataclass(frozen=True, kw_only=True)
class PowerCycle(DeviceFault):
    """A motor loses its supply and boots: no torque and no feedback meanwhile, its command forgotten.

    The encoder tells the right angle within a turn afterwards; how many turns the rotor made meanwhile, nobody knows.
    """

    name: ClassVar[str] = "power_cycle"
    cable: int = 0
    """Motor, counted from 0."""
    duration: float = 0.3
    """Time without supply and for booting [s] (ours)."""

    def __post_init__(self) -> None:
        _check_cable(self.cable)
        check_number("duration", self.duration, least=0.0, most=3600.0)

    def begin(self, motors: MotorTwins) -> None:
        """See `DeviceFault.begin`."""
        _find(motors, self.cable).is_on = False

    def step(self, motors: MotorTwins, elapsed: float) -> bool:
        """See `DeviceFault.step`."""
        return elapsed >= self.duration

    def end(self, motors: MotorTwins) -> None:
        """See `DeviceFault.end`."""
        motors.forget(self.cable)
        _find(motors, self.cable).is_on = True


@final
@dataclass(frozen=True, kw_only=True)
class OverTemperature(DeviceFault):
    """Something heats a motor up to a temperature, and holds it there."""

    name: ClassVar[str] = "over_temperature"
    cable: int = 0
    """Motor, counted from 0."""
    temperature: float = 120.0
    """Temperature that is reached [degC]."""
    rate: float = 10.0
    """Heating besides that by the current [K/s]."""

    def __post_init__(self) -> None:
        _check_cable(self.cable)
        check_number("temperature", self.temperature, least=-40.0, most=500.0)
        check_number("rate", self.rate, above=0.0, most=1e6)

    def begin(self, motors: MotorTwins) -> None:
        """See `DeviceFault.begin`."""
        self.step(motors, 0.0)

    def step(self, motors: MotorTwins, elapsed: float) -> bool:
        """See `DeviceFault.step`."""
        motor = _find(motors, self.cable)
        motor.heating = self.rate if motor.temperature < self.temperature else 0.0
        return False

    def end(self, motors: MotorTwins) -> None:
        """See `DeviceFault.end`; the motor cools down by itself."""
        _find(motors, self.cable).heating = 0.0


@final
@dataclass(frozen=True, kw_only=True)
class Stall(DeviceFault):
    """Something holds a rotor."""

    name: ClassVar[str] = "stall"
    cable: int = 0
    """Motor, counted from 0."""

    def __post_init__(self) -> None:
        _check_cable(self.cable)

    def begin(self, motors: MotorTwins) -> None:
        """See `DeviceFault.begin`."""
        _find(motors, self.cable).is_blocked = True

    def end(self, motors: MotorTwins) -> None:
        """See `DeviceFault.end`."""
        _find(motors, self.cable).is_blocked = False


@final
@dataclass(frozen=True, kw_only=True)
class CableBreak(DeviceFault):
    """A cable breaks; at the end it is knotted again at its old length."""

    name: ClassVar[str] = "cable_break"
    cable: int = 0
    """Cable, counted from 0."""

    def __post_init__(self) -> None:
        _check_cable(self.cable)

    def begin(self, motors: MotorTwins) -> None:
        """See `DeviceFault.begin`."""
        _find(motors, self.cable).stiffness = 0.0

    def end(self, motors: MotorTwins) -> None:
        """See `DeviceFault.end`."""
        motor = _find(motors, self.cable)
        motor.stiffness = motor.parameters.cable_stiffness


@final
@dataclass(frozen=True, kw_only=True)
class CableSlip(DeviceFault):
    """A cable slips on its drum, once: there is less of it on the drum than by the motor's angle."""

    name: ClassVar[str] = "cable_slip"
    cable: int = 0
    """Cable, counted from 0."""
    length: float = 5e-3
    """Length by which it slips [m]."""

    def __post_init__(self) -> None:
        _check_cable(self.cable)
        check_number("length", self.length, least=-1.0, most=1.0)

    def begin(self, motors: MotorTwins) -> None:
        """See `DeviceFault.begin`."""
        _find(motors, self.cable).wound -= self.length

    def end(self, motors: MotorTwins) -> None:
        """See `DeviceFault.end`; homing alone finds where the cable is."""


@final
@dataclass(frozen=True, kw_only=True)
class TangledDrum(DeviceFault):
    """From now on a drum winds another length per angle: over a crossing layer, or the wrong way round."""

    name: ClassVar[str] = "tangled_drum"
    cable: int = 0
    """Cable, counted from 0."""
    factor: float = -1.0
    """Length per angle over the right one [-]: -1 winds the wrong way, 1.3 over a crossing layer."""

    def __post_init__(self) -> None:
        _check_cable(self.cable)
        check_number("factor", self.factor, least=-10.0, most=10.0)

    def begin(self, motors: MotorTwins) -> None:
        """See `DeviceFault.begin`."""
        motor = _find(motors, self.cable)
        motor.lever = self.factor * motor.parameters.drum_radius

    def end(self, motors: MotorTwins) -> None:
        """See `DeviceFault.end`."""
        motor = _find(motors, self.cable)
        motor.lever = motor.parameters.drum_radius


def _check_cable(cable: int) -> None:
    check_count("cable", cable, least=0, most=11)


def _find(motors: MotorTwins, cable: int) -> MotorTwin:
    """A motor of these.

    Raises:
        DriveError: where there are fewer.
    """
    if cable >= len(motors.motors):
        raise DriveError(f"fault of cable {cable}; allowed: 0 to {len(motors.motors) - 1}")
    return motors.motors[cable]
