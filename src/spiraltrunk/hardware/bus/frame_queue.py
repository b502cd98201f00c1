"""Frames that wait for the next flush of a bus."""

from __future__ import annotations

from typing import final

from spiraltrunk.errors import DriveError, describe
from spiraltrunk.hardware.bus.frame_bus import Frame

LARGEST_ID = 0x7FF
"""Largest standard identifier of CAN 2.0A (ISO 11898-1: 11 bits)."""

LARGEST_LENGTH = 8
"""Largest content of a classical CAN frame (ISO 11898-1) [bytes]."""


@final
class FrameQueue:
    """Frames by identifier, in the order in which they leave; of each identifier only the latest is kept."""

    def __init__(self) -> None:
        self._frames: dict[int, Frame] = {}

    def put(self, frame: Frame) -> None:
        """Queue a frame; it takes the place of one of the same id that still waits.

        Raises:
            DriveError: where it is not a standard data frame; the queue stays as it was.
        """
        if not is_standard(frame.id, frame.data):
            allowed = f"an id from 0 to 0x{LARGEST_ID:X} and a content of 0 to {LARGEST_LENGTH} bytes"
            raise DriveError(f"frame is {describe(frame.id)}, {describe(frame.data)}; allowed: {allowed}")
        self._frames[frame.id] = frame

    def take(self) -> list[Frame]:
        """Everything that waits; nothing waits afterwards, whatever becomes of the frames."""
        frames = list(self._frames.values())
        self._frames.clear()
        return frames

    def __len__(self) -> int:
        return len(self._frames)


def is_standard(identifier: int, data: bytes) -> bool:
    """Whether this is what a frame on the bus may be: a standard identifier with at most eight bytes."""
    return (
        type(identifier) is int
        and 0 <= identifier <= LARGEST_ID
        and isinstance(data, bytes)
        and len(data) <= LARGEST_LENGTH
    )
