"""One contract for every bus: each is opened with a device at its other end that injects and collects frames."""

from __future__ import annotations

import itertools
import os
import time
import uuid
from collections.abc import Callable, Iterator

import pytest

from spiraltrunk.errors import DriveError, MissingPackage
from spiraltrunk.hardware.bus.board import open_board
from spiraltrunk.hardware.bus.board_frame import BoardMessage, MessageParser, encode_message
from spiraltrunk.hardware.bus.board_messages import BoardCommand, decode_frames, encode_frames
from spiraltrunk.hardware.bus.can_bus import open_can_bus
from spiraltrunk.hardware.bus.frame_bus import Frame, FrameBus
from spiraltrunk.hardware.bus.memory_bus import build_memory_pair
from spiraltrunk.hardware.clock import SystemClock

CLOCK = SystemClock()
SOON = 30.0
"""Time that a computer under load may take to deliver a frame [s]."""


class Device:
    """What is at the other end of a bus."""

    def __init__(self, inject: Callable[[list[Frame]], None], collect: Callable[[], list[Frame]]) -> None:
        self.inject = inject
        self.collect = collect


def build_peer(peer: FrameBus) -> Device:
    def inject(frames: list[Frame]) -> None:
        for frame in frames:
            peer.send(frame)
            peer.flush()

    return Device(inject, peer.receive)


def open_memory() -> tuple[FrameBus, Device, Callable[[], None]]:
    bus, peer = build_memory_pair(CLOCK)
    return bus, build_peer(peer), peer.close


def open_can(text: str) -> tuple[FrameBus, Device, Callable[[], None]]:
    try:
        bus, peer = open_can_bus(text, CLOCK), open_can_bus(text, CLOCK)
    except (DriveError, MissingPackage) as error:
        pytest.skip(f"this computer has no such bus: {error}")
    return bus, build_peer(peer), peer.close


def open_pseudo_terminal() -> tuple[FrameBus, Device, Callable[[], None]]:
    pty = pytest.importorskip("pty", reason="a pseudo-terminal needs POSIX")
    device, host = pty.openpty()
    bus = open_board(os.ttyname(host), CLOCK)
    os.set_blocking(device, False)
    parser, numbers = MessageParser(), itertools.count()

    def inject(frames: list[Frame]) -> None:
        for frame in frames:
            data = encode_frames([frame])
            os.write(device, encode_message(BoardMessage(BoardCommand.RECEIVED_FRAMES, data, next(numbers) % 256)))

    def collect() -> list[Frame]:
        try:
            messages = parser.feed(os.read(device, 65536))
        except BlockingIOError:
            return []
        found = [
            decode_frames(message.data, 0.0) for message in messages if message.command == BoardCommand.SEND_FRAMES
        ]
        return list(itertools.chain.from_iterable(found))

    def close() -> None:
        os.close(device)
        os.close(host)

    return bus, Device(inject, collect), close


BUSES = {
    "memory": open_memory,
    "virtual": lambda: open_can(f"virtual:{uuid.uuid4()}"),
    "udp_multicast": lambda: open_can("udp_multicast:239.74.163.2"),
    "vcan": lambda: open_can("socketcan:vcan0"),
    "board": open_pseudo_terminal,
}


@pytest.fixture(params=BUSES)
def pair(request: pytest.FixtureRequest) -> Iterator[tuple[FrameBus, Device]]:
    bus, device, close = BUSES[request.param]()
    yield bus, device
    bus.close()
    close()


def wait_for(receive: Callable[[], list[Frame]], count: int) -> list[Frame]:
    """So many frames, or fewer after `SOON`."""
    frames, end = receive(), time.monotonic() + SOON
    while len(frames) < count and time.monotonic() < end:
        time.sleep(0.001)
        frames += receive()
    return frames


def strip(frames: list[Frame]) -> list[tuple[int, bytes]]:
    return [(frame.id, frame.data) for frame in frames]


def test_what_is_flushed_arrives_whole_and_in_order(pair):
    bus, device = pair
    sent = [(0x1FE, bytes(8)), (0, b""), (0x7FF, b"\x01\xa5\xff"), (0x205, bytes(range(8)))]
    for identifier, data in sent:
        bus.send(Frame(identifier, data))
    assert strip(device.collect()) == []
    bus.flush()
    assert strip(wait_for(device.collect, 4)) == sent


def test_what_the_device_sends_arrives_in_order_with_its_time(pair):
    bus, device = pair
    began = CLOCK.now()
    sent = [(0x205, bytes([i]) * 8) for i in range(20)]
    device.inject([Frame(*each) for each in sent])
    frames = wait_for(bus.receive, 20)
    assert strip(frames) == sent
    times = [frame.time for frame in frames]
    assert times == sorted(times)
    assert began - 0.05 <= times[0] <= times[-1] <= CLOCK.now()


def test_receiving_nothing_is_an_empty_list(pair):
    assert pair[0].receive() == []


def test_of_two_frames_with_the_same_id_only_the_later_is_sent(pair):
    bus, device = pair
    for data in (b"old", b"new"):
        bus.send(Frame(0x1FE, data))
    bus.flush()
    bus.send(Frame(0x2FE, b"end"))
    bus.flush()
    assert strip(wait_for(device.collect, 2)) == [(0x1FE, b"new"), (0x2FE, b"end")]


def test_nothing_is_sent_twice(pair):
    bus, device = pair
    bus.send(Frame(0x1FE, b"once"))
    bus.flush()
    bus.flush()
    bus.send(Frame(0x2FE, b"end"))
    bus.flush()
    assert strip(wait_for(device.collect, 2)) == [(0x1FE, b"once"), (0x2FE, b"end")]


@pytest.mark.parametrize(
    "frame", [Frame(-1, b""), Frame(0x800, b""), Frame(1, bytes(9)), Frame(True, b""), Frame(1, [0])]
)
def test_what_is_no_standard_frame_is_refused_and_nothing_waits(pair, frame):
    bus, device = pair
    with pytest.raises(DriveError, match=r"allowed: an id from 0 to 0x7FF and a content of 0 to 8 bytes"):
        bus.send(frame)
    bus.send(Frame(0x2FE, b"end"))
    bus.flush()
    assert strip(wait_for(device.collect, 1)) == [(0x2FE, b"end")]


def test_a_closed_bus_refuses_and_closing_again_is_harmless(pair):
    bus, device = pair
    bus.send(Frame(0x1FE, b"late"))
    bus.close()
    bus.close()
    with pytest.raises(DriveError, match="closed"):
        bus.flush()
    with pytest.raises(DriveError, match="closed"):
        bus.receive()
    assert strip(device.collect()) == []
