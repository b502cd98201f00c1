"""A bus with faults, around any end of any bus."""

from __future__ import annotations

import random
from contextlib import suppress
from typing import final

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.bus.frame_bus import Frame, FrameBus
from spiraltrunk.hardware.bus.frame_queue import FrameQueue
from spiraltrunk.hardware.clock import Clock
from spiraltrunk.hardware.twin.faults.frame_fault import Direction, FrameFault, FrameMemory


@final
class FaultyBus(FrameBus):
    """An end of a bus whose frames pass through faults, in the order in which those began.

    A frame that a fault holds back leaves at the next `flush` or `receive` after its time. Without faults the bus
    behaves as the one that it wraps.
    """

    def __init__(self, bus: FrameBus, clock: Clock, *, is_driver: bool, seed: int = 0) -> None:
        """A bus without faults.

        Args:
            bus: the end that is wrapped.
            clock: time of the frames.
            is_driver: whether it is the driver's end, so that what it sends are commands; else the motors'.
            seed: same seed, same faults.
        """
        self._bus, self._clock, self._seed = bus, clock, seed
        ways = (Direction.COMMANDS, Direction.FEEDBACK)
        self._outward, self._inward = ways if is_driver else ways[::-1]
        self._queue = FrameQueue()
        self._faults: list[tuple[FrameFault, dict[Direction, FrameMemory]]] = []
        self._n_begun = 0

    def begin(self, fault: FrameFault) -> None:
        """Let a fault begin."""
        self._n_begun += 1
        text = f"{self._seed} {self._n_begun} {fault.name}"
        memory = {
            way: FrameMemory(random=random.Random(f"{text} {way.value}")) for way in (self._outward, self._inward)
        }
        self._faults.append((fault, memory))

    def end(self, fault: FrameFault) -> None:
        """Let it end; frames that it holds back are lost. Harmless where it has not begun."""
        self._faults = [entry for entry in self._faults if entry[0] is not fault]
        if fault.loses_frames:
            self._queue.take()
            with suppress(DriveError):
                self._bus.receive()

    def send(self, frame: Frame) -> None:
        """See `FrameBus.send`."""
        if self._faults:
            self._queue.put(frame)
        else:
            self._bus.send(frame)

    def flush(self) -> None:
        """See `FrameBus.flush`."""
        if self._faults or len(self._queue):
            self._deliver(self._change(self._queue.take(), self._outward))
        else:
            self._bus.flush()

    def receive(self) -> list[Frame]:
        """See `FrameBus.receive`."""
        frames = self._bus.receive()
        if not self._faults:
            return frames
        if any(memory[self._outward].held for _, memory in self._faults):
            self._deliver(self._change([], self._outward))
        return self._change(frames, self._inward)

    def close(self) -> None:
        """See `FrameBus.close`."""
        self._queue.take()
        self._bus.close()

    def _change(self, frames: list[Frame], way: Direction) -> list[Frame]:
        """What the faults leave of frames of this direction."""
        now = self._clock.now()
        for fault, memory in self._faults:
            if fault.direction.includes(way):
                frames = fault.change(frames, memory[way], now)
        return frames

    def _deliver(self, frames: list[Frame]) -> None:
        """Send frames in this order; of one id, the bus would keep the latest alone in one flush."""
        waiting: set[int] = set()
        for frame in frames:
            if frame.id in waiting:
                self._bus.flush()
                waiting.clear()
            self._bus.send(frame)
            waiting.add(frame.id)
        self._bus.flush()


def check_wrapped(bus: FaultyBus | None) -> FaultyBus:
    """The bus that takes faults of frames.

    Raises:
        DriveError: where there is none.
    """
    if bus is None:
        raise DriveError("a fault of the bus without a bus for faults; allowed: an injector that was given one")
    return bus
