"""What the bus in memory has beyond the contract: a time of its own, an end that goes off, and a bound."""

from __future__ import annotations

import sys
import threading
import time

import pytest

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.bus.frame_bus import Frame
from spiraltrunk.hardware.bus.memory_bus import CAPACITY, build_memory_pair
from spiraltrunk.hardware.clock import Clock


class StepClock(Clock):
    """Time that the test sets."""

    time = 0.0

    def now(self) -> float:
        return self.time

    def sleep_until(self, moment: float) -> None:
        self.time = moment


def test_frames_carry_the_time_of_their_flush():
    clock = StepClock()
    one, other = build_memory_pair(clock)
    one.send(Frame(1, b"a"))
    clock.time = 0.5
    one.flush()
    clock.time = 2.0
    assert other.receive() == [Frame(1, b"a", 0.5)]


def test_an_end_that_is_off_loses_what_waits_in_both_directions():
    one, other = build_memory_pair(StepClock())
    one.send(Frame(1, b"stale"))
    other.send(Frame(2, b"lost"))
    other.flush()
    one.set_off(True)
    for use in (one.flush, one.receive):
        with pytest.raises(DriveError, match="is off"):
            use()
    other.send(Frame(2, b"unheard"))
    other.flush()
    one.send(Frame(1, b"too"))
    with pytest.raises(DriveError):
        one.flush()
    one.set_off(False)
    one.flush()
    assert (one.receive(), other.receive()) == ([], [])


def test_nobody_who_receives_costs_no_memory():
    one, other = build_memory_pair(StepClock())
    for i in range(CAPACITY + 10):
        one.send(Frame(1, bytes([i % 256])))
        one.flush()
    frames = other.receive()
    assert len(frames) == CAPACITY
    assert frames[0].data == b"\0"


def test_no_frame_is_lost_between_two_threads():
    one, other = build_memory_pair(StepClock())
    count, received = 20_000, []

    def produce() -> None:
        for i in range(count):
            while len(other._inbox) >= CAPACITY // 2:
                time.sleep(0)
            one.send(Frame(1, i.to_bytes(4, "big")))
            one.flush()

    interval, thread = sys.getswitchinterval(), threading.Thread(target=produce, daemon=True)
    sys.setswitchinterval(1e-5)
    try:
        thread.start()
        while thread.is_alive():
            received += other.receive()
        received += other.receive()
    finally:
        sys.setswitchinterval(interval)
    assert [int.from_bytes(frame.data, "big") for frame in received] == list(range(count))
