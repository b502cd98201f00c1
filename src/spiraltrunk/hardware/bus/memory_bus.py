"""Bus inside one process, for lock-step with a twin: what one end flushes, the other receives."""

from __future__ import annotations

import contextlib
from collections import deque
from typing import final

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.bus.frame_bus import Frame, FrameBus
from spiraltrunk.hardware.bus.frame_queue import FrameQueue
from spiraltrunk.hardware.clock import Clock

CAPACITY = 512
"""Frames that an end keeps until they are received (ours, about an adapter's buffer); further ones are lost."""


@final
class MemoryBus(FrameBus):
    """One end of a pair that `build_memory_pair` makes.

    It is deterministic: frames arrive in the order in which they were flushed, at the time of the clock at the flush,
    and nothing is lost but what exceeds `CAPACITY`. It holds no thread and never waits; each end may be used by a
    thread of its own.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._queue = FrameQueue()
        self._inbox: deque[Frame] = deque()
        self._peer: MemoryBus | None = None
        self._is_off = False
        self._is_closed = False

    def connect(self, peer: MemoryBus) -> None:
        """Deliver to ``peer`` from now on what this end flushes."""
        self._peer = peer

    def set_off(self, is_off: bool) -> None:
        """Take this end off the bus, as its controller does after too many errors, or bring it back.

        What waits at this end, in either direction, is lost.
        """
        self._is_off = is_off
        self._queue.take()
        self._inbox.clear()

    def send(self, frame: Frame) -> None:
        """See `FrameBus.send`."""
        self._queue.put(frame)

    def flush(self) -> None:
        """See `FrameBus.flush`."""
        frames = self._queue.take()
        self._check_on()
        peer = self._peer
        if peer is None:
            return
        now, inbox = self._clock.now(), peer._inbox
        for frame in frames:
            if len(inbox) < CAPACITY:
                inbox.append(Frame(frame.id, frame.data, now))

    def receive(self) -> list[Frame]:
        """See `FrameBus.receive`."""
        self._check_on()
        frames: list[Frame] = []
        with contextlib.suppress(IndexError):  # Empty. Whatever another thread puts in meanwhile stays for later.
            while len(frames) < CAPACITY:
                frames.append(self._inbox.popleft())
        return frames

    def close(self) -> None:
        """See `FrameBus.close`."""
        self._is_closed = True
        self._queue.take()
        self._inbox.clear()

    def _check_on(self) -> None:
        if self._is_closed:
            raise DriveError("the bus in memory is closed; open a new one")
        if self._is_off:
            raise DriveError("the bus in memory is off; wait until it is back, then arm again")


def build_memory_pair(clock: Clock) -> tuple[MemoryBus, MemoryBus]:
    """Both ends of a new bus, each with the time of ``clock``: one for the driver, one for the twin."""
    one, other = MemoryBus(clock), MemoryBus(clock)
    one.connect(other)
    other.connect(one)
    return one, other
