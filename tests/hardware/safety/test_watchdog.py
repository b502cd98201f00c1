"""Watchdogs: heartbeat and answer, the board's side of it, and a relay."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.bus.frame_bus import Frame, FrameBus
from spiraltrunk.hardware.bus.frame_queue import FrameQueue
from spiraltrunk.hardware.clock import Clock
from spiraltrunk.hardware.safety.watchdog import (
    ANSWER_ID,
    END_COUNT,
    END_FLAG,
    HEARTBEAT_FORMAT,
    HEARTBEAT_ID,
    RELEASE,
    TIMEOUT,
    BoardMode,
    BoardWatchdog,
    NoWatchdog,
    RelayWatchdog,
    WatchedBus,
)
from spiraltrunk.hardware.safety.watches.board_watch import BoardWatch, advance, answer, hear, pass_share


class FakeClock(Clock):
    time = 0.0

    def now(self) -> float:
        return self.time

    def sleep_until(self, moment: float) -> None:
        self.time = max(self.time, moment)


class BoardBus(FrameBus):
    """A bus with a board on it."""

    def __init__(self, clock: Clock) -> None:
        self.clock, self.board, self.queue, self.inbox = clock, BoardWatch(), [], []
        self.is_closed = False

    def send(self, frame: Frame) -> None:
        self.queue.append(frame)

    def flush(self) -> None:
        now = self.clock.now()
        for frame in self.queue:
            if frame.id == HEARTBEAT_ID:
                self.board = hear(self.board, frame.data, now)
                self.inbox.append(Frame(ANSWER_ID, answer(self.board), now))
        self.queue = []

    def receive(self) -> list[Frame]:
        frames, self.inbox = self.inbox, []
        return frames

    def close(self) -> None:
        self.is_closed = True


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock()


@pytest.fixture
def bus(clock) -> BoardBus:
    return BoardBus(clock)


def beat(watchdog: BoardWatchdog, watched: WatchedBus) -> bool:
    watchdog.feed()
    watched.flush()
    watched.receive()
    return watchdog.is_present()


def test_a_board_that_answers_is_present(clock, bus):
    watched = WatchedBus(bus)
    watchdog = BoardWatchdog(watched, clock)
    assert not watchdog.is_present()
    assert watchdog.find_absence().startswith("its board has not answered")
    assert beat(watchdog, watched)
    assert watchdog.find_absence() == ""
    assert HEARTBEAT_FORMAT.unpack(watched.answer.data) == (1, BoardMode.WATCHING)
    clock.time = 0.049
    assert watchdog.is_present()
    clock.time = 0.051
    assert not watchdog.is_present()
    late = "its board answered 51 ms ago; allowed: below 50 ms; check its supply and the bus, and whether this computer"
    assert watchdog.find_absence() == f"{late} is too busy"


def test_a_board_that_has_tripped_is_present_again_when_a_person_cleared_it(clock, bus):
    watched = WatchedBus(bus)
    watchdog = BoardWatchdog(watched, clock)
    assert beat(watchdog, watched)
    clock.time = 0.1
    for _ in range(3):
        assert not beat(watchdog, watched)
    assert watchdog.find_absence().startswith("it has tripped, as no heartbeat came within 20 ms")
    watchdog.clear()
    assert beat(watchdog, watched)
    clock.time = 0.2
    assert not beat(watchdog, watched), "one clearing is good for one trip"


def test_a_host_that_ends_in_order_leaves_a_board_that_waits_for_the_next(clock, bus):
    watched = WatchedBus(bus)
    first = BoardWatchdog(watched, clock)
    assert beat(first, watched)
    first.end()
    watched.receive()
    assert first.find_absence() == "its board waits for a heartbeat"
    clock.time = 1.0
    second = BoardWatchdog(WatchedBus(bus), clock)
    assert beat(second, second._bus), "it did not trip in a second without heartbeats"


def test_the_end_of_a_host_is_told_three_times_on_a_bus_that_keeps_the_latest_frame_alone(clock, bus):
    told = []
    queue = FrameQueue()
    bus.send = queue.put
    bus.flush = lambda: told.extend(queue.take())
    BoardWatchdog(WatchedBus(bus), clock).end()
    beats = [HEARTBEAT_FORMAT.unpack(frame.data) for frame in told]
    assert [flags for _, flags in beats] == [END_FLAG] * END_COUNT
    assert len({counter for counter, _ in beats}) == END_COUNT == 3


def test_the_end_of_a_host_does_not_clear_a_board_that_has_tripped(clock, bus):
    watched = WatchedBus(bus)
    watchdog = BoardWatchdog(watched, clock)
    assert beat(watchdog, watched)
    clock.time = 0.1
    watchdog.end()
    watched.receive()
    assert "has tripped" in watchdog.find_absence()
    assert not beat(watchdog, watched)


def test_the_counter_goes_around(clock, bus):
    watchdog = BoardWatchdog(WatchedBus(bus), clock)
    counters = set()
    for _ in range(0x10001):
        watchdog.feed()
        counters.add(bus.queue.pop().data)
    assert len(counters) == 0x10000


def test_the_motors_see_every_other_frame(bus):
    watched = WatchedBus(bus)
    others = [Frame(0x205, b"12345678"), Frame(0x7A2, b"")]
    bus.inbox = [others[0], Frame(ANSWER_ID, b"\0\1\1"), others[1], Frame(ANSWER_ID, b"bad length")]
    assert watched.receive() == others
    assert watched.answer.data == b"\0\1\1"
    watched.send(others[0])
    assert bus.queue == [others[0]]
    watched.close()
    assert bus.is_closed


# The board's side.


def test_a_board_lets_nothing_through_before_the_first_heartbeat():
    assert pass_share(BoardWatch(), 1.0) == 0.0
    assert advance(BoardWatch(), 1e6).mode is BoardMode.WAITING


def test_a_board_ramps_to_zero_within_60_ms_of_the_last_heartbeat():
    watch = hear(BoardWatch(), HEARTBEAT_FORMAT.pack(1, 0), 10.0)
    for time, share in ((0.0, 1.0), (0.9 * TIMEOUT, 1.0), (TIMEOUT + RELEASE / 4, 0.75), (TIMEOUT + RELEASE, 0.0),
                        (1e3, 0.0)):  # fmt: skip
        assert pass_share(advance(watch, 10.0 + time), 10.0 + time) == pytest.approx(share, abs=1e-6)
    assert TIMEOUT + RELEASE <= 0.060
    assert advance(watch, 10.0 + 0.99 * TIMEOUT).mode is BoardMode.WATCHING
    assert advance(watch, 10.0 + 1.01 * TIMEOUT).mode is BoardMode.TRIPPED


def test_a_heartbeat_that_repeats_its_counter_or_has_another_length_is_none():
    watch = hear(BoardWatch(), HEARTBEAT_FORMAT.pack(1, 0), 0.0)
    assert hear(watch, HEARTBEAT_FORMAT.pack(1, 0), 0.015) == watch
    assert hear(watch, b"\0\2", 0.015) == watch
    assert hear(watch, HEARTBEAT_FORMAT.pack(2, 0), 0.015).heard == 0.015


def test_a_board_that_tripped_stays_so_until_the_clear_flag():
    watch = advance(hear(BoardWatch(), HEARTBEAT_FORMAT.pack(1, 0), 0.0), 0.021)
    later = hear(watch, HEARTBEAT_FORMAT.pack(2, 0), 0.022)
    assert later.mode is BoardMode.TRIPPED
    assert later.tripped == pytest.approx(TIMEOUT)
    assert later.counter == 2
    assert hear(watch, HEARTBEAT_FORMAT.pack(2, 2), 0.022).mode is BoardMode.TRIPPED
    assert hear(watch, HEARTBEAT_FORMAT.pack(2, 1), 0.022).mode is BoardMode.WATCHING
    assert hear(watch, HEARTBEAT_FORMAT.pack(2, 5), 0.022).mode is BoardMode.WATCHING
    assert hear(watch, HEARTBEAT_FORMAT.pack(2, 3), 0.022).mode is BoardMode.TRIPPED, "the last one of a host"


def test_a_late_heartbeat_does_not_hide_the_silence_before_it():
    watch = hear(BoardWatch(), HEARTBEAT_FORMAT.pack(1, 0), 0.0)
    assert hear(watch, HEARTBEAT_FORMAT.pack(2, 0), 0.5).mode is BoardMode.TRIPPED


def test_the_answer_holds_counter_and_mode():
    assert HEARTBEAT_FORMAT.unpack(answer(BoardWatch())) == (0, BoardMode.WAITING)
    watch = hear(BoardWatch(), HEARTBEAT_FORMAT.pack(77, 0), 0.0)
    assert HEARTBEAT_FORMAT.unpack(answer(watch)) == (77, BoardMode.WATCHING)


@given(st.lists(st.binary(max_size=8)))
def test_no_bytes_stop_the_board(frames):
    watch = BoardWatch()
    for i, data in enumerate(frames):
        watch = hear(watch, data, 0.001 * i)
        assert 0.0 <= pass_share(watch, 0.001 * i) <= 1.0


# The others.


def test_no_watchdog_is_never_present():
    watchdog = NoWatchdog()
    watchdog.feed()
    watchdog.clear()
    assert not watchdog.is_present()
    assert watchdog.find_absence() == "there is none; connect one, or say that there is none"


class FakePort:
    def __init__(self) -> None:
        self.written, self.is_gone, self.contact = b"", False, True

    def write(self, data: bytes) -> None:
        self._check()
        self.written += data

    @property
    def cts(self) -> bool:
        self._check()
        return self.contact

    def _check(self) -> None:
        if self.is_gone:
            raise OSError("gone")


def test_a_relay_is_fed_by_bytes_and_present_by_its_contact():
    port = FakePort()
    watchdog = RelayWatchdog(port)
    watchdog.feed()
    watchdog.feed()
    watchdog.clear()
    assert port.written == b"UU"
    assert watchdog.is_present()
    port.contact = False
    assert not watchdog.is_present()
    assert watchdog.find_absence().startswith("its relay is open")
    port.is_gone = True
    assert not watchdog.is_present()
    assert watchdog.find_absence().startswith("the relay's serial line is gone (gone)")
    with pytest.raises(DriveError, match=r"the relay's serial line is gone \(gone\)"):
        watchdog.feed()
