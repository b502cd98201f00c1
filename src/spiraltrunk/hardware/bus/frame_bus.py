"""A bus of frames with an id and up to 8 bytes: the interface that motors are written against."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple, final


@final
class Frame(NamedTuple):
    """One frame."""

    id: int
    """Standard identifier, 0 to 0x7FF."""
    data: bytes
    """Content, 0 to 8 bytes."""
    time: float = 0.0
    """Time of its arrival on the driver's clock [s]; 0 in a frame to be sent."""


class FrameBus(ABC):
    """A bus. Frames are queued by `send` and leave together at `flush`, once in a period of control.

    That a frame was sent is no proof that it arrived: only the age of an answer is.
    """

    @abstractmethod
    def send(self, frame: Frame) -> None:
        """Queue a frame; one of the same id that still waits is replaced, so that no stale command is ever sent."""

    @abstractmethod
    def flush(self) -> None:
        """Send what is queued.

        Raises:
            DriveError: where the bus is off or its adapter gone; the queue is empty then.
        """

    @abstractmethod
    def receive(self) -> list[Frame]:
        """Frames that arrived since the last call, oldest first, without waiting.

        Raises:
            DriveError: where the bus is off or its adapter gone.
        """

    @abstractmethod
    def close(self) -> None:
        """Release the adapter; harmless when called again."""
