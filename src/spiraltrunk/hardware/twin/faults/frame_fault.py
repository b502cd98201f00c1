"""A fault of the bus: what it does to the frames of one direction."""

from __future__ import annotations

import random
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from enum import Enum
from typing import ClassVar, final

from spiraltrunk.errors import DesignError
from spiraltrunk.hardware.bus.frame_bus import Frame


@final
class Direction(Enum):
    """Which frames a fault concerns."""

    COMMANDS = "commands"
    """Those from the driver to the motors."""
    FEEDBACK = "feedback"
    """Those from the motors to the driver."""
    BOTH = "both"
    """All."""

    def includes(self, direction: Direction) -> bool:
        """Whether frames of this direction are concerned."""
        return self is Direction.BOTH or self is direction


@final
@dataclass(kw_only=True)
class FrameMemory:
    """What a fault remembers of one direction."""

    random: random.Random
    """Its own random numbers."""
    held: list[tuple[float, Frame]] = field(default_factory=list)
    """Frames that it holds back, with the time until which [s]."""
    contents: dict[int, bytes] = field(default_factory=dict)
    """First content of each identifier."""

    def release(self, now: float) -> list[Frame]:
        """Frames that are due, the earliest first; those that had arrived at this end arrive now."""
        due = sorted((entry for entry in self.held if entry[0] <= now + 1e-9), key=lambda entry: entry[0])
        if due:
            self.held = [entry for entry in self.held if entry[0] > now + 1e-9]
        return [frame._replace(time=now) if frame.time else frame for _, frame in due]


class FrameFault(ABC):
    """Settings of a fault of the bus; what it remembers is in a `FrameMemory`."""

    name: ClassVar[str]
    """Name in the catalogue."""
    loses_frames: ClassVar[bool] = False
    """Whether frames that wait at the wrapped end are lost when it ends."""
    direction: Direction
    """Frames that it concerns."""

    @abstractmethod
    def change(self, frames: list[Frame], memory: FrameMemory, now: float) -> list[Frame]:
        """Frames that get through at ``now`` [s], those that were held back before among them.

        Raises:
            DriveError: where the bus is off.
        """


def read_direction(value: Direction | str) -> Direction:
    """A direction, or the one with this name.

    Raises:
        DesignError: where there is none.
    """
    try:
        return Direction(value)
    except ValueError as error:
        raise DesignError("direction", got=value, allowed="commands, feedback or both") from error
