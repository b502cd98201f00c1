"""Faults of load cells."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

from spiraltrunk.checks import check_count, check_number
from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.twin.faults.device_fault import DeviceFault
from spiraltrunk.hardware.twin.load_cells import LoadCellTwin
from spiraltrunk.hardware.twin.motors import MotorTwins


@final
@dataclass(frozen=True, kw_only=True)
class CellSilent(DeviceFault):
    """The board of the load cells sends no more."""

    name: ClassVar[str] = "cell_silent"

    def begin(self, motors: MotorTwins) -> None:
        """See `DeviceFault.begin`."""
        _find(motors).is_silent = True

    def end(self, motors: MotorTwins) -> None:
        """See `DeviceFault.end`."""
        _find(motors).is_silent = False


@final
@dataclass(frozen=True, kw_only=True)
class CellUnplugged(DeviceFault):
    """The plug of the load cells' board is pulled."""

    name: ClassVar[str] = "cell_unplugged"

    def begin(self, motors: MotorTwins) -> None:
        """See `DeviceFault.begin`."""
        _find(motors).is_gone = True

    def end(self, motors: MotorTwins) -> None:
        """See `DeviceFault.end`."""
        _find(motors).is_gone = False


@final
@dataclass(frozen=True, kw_only=True)
class CellStuck(DeviceFault):
    """A load cell's amplifier repeats its last reading in new frames."""

    name: ClassVar[str] = "cell_stuck"
    cable: int = 0
    """Cable, counted from 0."""

    def __post_init__(self) -> None:
        check_count("cable", self.cable, least=0, most=11)

    def begin(self, motors: MotorTwins) -> None:
        """See `DeviceFault.begin`."""
        _find(motors, self.cable).stuck.add(self.cable)

    def end(self, motors: MotorTwins) -> None:
        """See `DeviceFault.end`."""
        _find(motors, self.cable).stuck.discard(self.cable)


@final
@dataclass(frozen=True, kw_only=True)
class CellWireOff(DeviceFault):
    """A wire of a load cell breaks: its amplifier reads noise about a number that has nothing to do with the cable."""

    name: ClassVar[str] = "cell_wire_off"
    cable: int = 0
    """Cable, counted from 0."""
    reading: float = 0.0
    """That number [N]: about 0 without excitation, the amplifier's largest without one of the signals."""

    def __post_init__(self) -> None:
        check_count("cable", self.cable, least=0, most=11)
        check_number("reading", self.reading, least=-1e6, most=1e6)

    def begin(self, motors: MotorTwins) -> None:
        """See `DeviceFault.begin`."""
        _find(motors, self.cable).wire_off[self.cable] = self.reading

    def end(self, motors: MotorTwins) -> None:
        """See `DeviceFault.end`."""
        _find(motors, self.cable).wire_off.pop(self.cable, None)


def _find(motors: MotorTwins, cable: int | None = None) -> LoadCellTwin:
    """The load cells at these motors' cables.

    Raises:
        DriveError: where there are none, or none at this cable.
    """
    cells = motors.cells
    if cells is None:
        raise DriveError("fault of a load cell on a twin without load cells; allowed: with [load_cells] in its file")
    if cable is not None and cable not in cells.cables:
        allowed = ", ".join(map(str, cells.cables))
        raise DriveError(f"fault of the load cell of cable {cable}; allowed: {allowed}")
    return cells
