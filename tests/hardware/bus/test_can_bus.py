"""The bus on python-can: names of adapters, messages that are never trusted, and adapters that go away."""

from __future__ import annotations

import os
import threading
import time
import uuid

import can
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.errors import DriveError, MissingPackage
from spiraltrunk.hardware.bus.can_address import CanAddress, parse_can_address
from spiraltrunk.hardware.bus.can_bus import BUS_OFF, MOST_FRAMES, CanBus, open_can_bus
from spiraltrunk.hardware.bus.frame_bus import Frame
from spiraltrunk.hardware.clock import SystemClock

CLOCK = SystemClock()
SOON = 30.0
"""Time that a computer under load may take [s]."""


class Adapter(can.BusABC):
    """An adapter of python-can that does as the test says."""

    def __init__(self, messages=()) -> None:
        self.messages = list(messages)
        self.failure: Exception | None = None
        self.sent: list[can.Message] = []
        self.shutdowns = 0
        super().__init__("fake")

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        if self.failure is not None:
            raise self.failure
        self.sent.append(msg)

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        message = self.messages.pop(0) if self.messages else None
        if isinstance(message, Exception):
            raise message
        if message is None:
            time.sleep(min(timeout or 0.0, 0.01))
        return message, True

    def shutdown(self) -> None:
        super().shutdown()
        self.shutdowns += 1


def open_fake(*messages, interface: str = "socketcan") -> tuple[Adapter, CanBus]:
    adapter = Adapter(messages)
    return adapter, CanBus(adapter, CanAddress(interface, "can0"), CLOCK)


def build_message(identifier: int = 0x205, data: bytes = bytes(8), **options) -> can.Message:
    given = {"arbitration_id": identifier, "data": data, "is_extended_id": False, "timestamp": time.time()}
    return can.Message(**(given | options))


def parse_failure() -> Exception:
    """What python-can raises where it cannot read what arrived."""
    failure = can.CanOperationError("could not unpack received message")
    failure.__cause__ = ValueError("not a frame")
    return failure


BUS_OFF_MESSAGE = build_message(BUS_OFF, is_error_frame=True)


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("socketcan:can0", ("socketcan", "can0")),
        ("gs_usb:0", ("gs_usb", "0")),
        ("slcan:/dev/ttyACM0", ("slcan", "/dev/ttyACM0")),
        ("slcan:socket://box:99", ("slcan", "socket://box:99")),
        ("virtual:twin", ("virtual", "twin")),
        ("udp_multicast:239.74.163.2", ("udp_multicast", "239.74.163.2")),
        ("udp_multicast:ff15:7079::1", ("udp_multicast", "ff15:7079::1")),
    ],
)
def test_names_of_adapters(text, address):
    assert parse_can_address(text) == address


@pytest.mark.parametrize(
    "text",
    [
        "", "can0", "socketcan", "socketcan:", "socketcan:a/b", "socketcan:a b", "socketcan:can0123456789012",
        "gs_usb:", "gs_usb:-1", "gs_usb:x", "gs_usb:100", "gs_usb:\u0665", "slcan:", "slcan: ", "slcan:a\nb",
        "virtual:", "udp_multicast:10.0.0.1", "udp_multicast:host", "kvaser:0", "SOCKETCAN:can0", None, 3,
    ],
)  # fmt: skip
def test_other_names_are_refused_in_one_line_that_tells_an_allowed_one(text):
    with pytest.raises(DriveError, match="allowed: ") as error:
        parse_can_address(text)
    assert "\n" not in str(error.value)


@given(st.text(max_size=60))
def test_any_text_is_an_address_or_refused(text):
    try:
        address = parse_can_address(text)
    except DriveError:
        return
    assert ":".join(address) == text


def test_an_adapter_that_is_absent_is_one_line():
    for text in ("socketcan:nocan9", "slcan:/dev/no-such-port"):
        with pytest.raises((DriveError, MissingPackage), match="cannot be opened") as error:
            open_can_bus(text, CLOCK)
        assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("text", "advice"),
    [("gs_usb:0", "pip install 'python-can[gs-usb]'"), ("socketcan:can0", "use another computer")],
)
def test_an_interface_that_lacks_something_says_what_helps(monkeypatch, text, advice):
    def refuse(**options):
        raise can.CanInterfaceNotImplementedError("no such module")

    monkeypatch.setattr(can, "Bus", refuse)
    with pytest.raises(MissingPackage) as error:
        open_can_bus(text, CLOCK)
    assert str(error.value) == f"bus {text} cannot be opened: no such module; {advice}"


def test_the_kernel_filters_what_is_not_feedback(monkeypatch):
    asked = {}
    monkeypatch.setattr(can, "Bus", lambda **options: asked.update(options) or Adapter())
    open_can_bus("socketcan:can0", CLOCK, feedback_ids=(0x205, 0x206))
    filters = [{"can_id": i, "can_mask": 0x7FF, "extended": False} for i in (0x205, 0x206)]
    assert asked == {"channel": "can0", "interface": "socketcan", "ignore_config": True, "can_filters": filters}


@pytest.mark.parametrize(("text", "channel"), [("gs_usb:1", 1), ("slcan:/dev/ttyACM0", "/dev/ttyACM0")])
def test_usb_adapters_are_set_to_the_motors_bit_rate(monkeypatch, text, channel):
    asked = {}
    monkeypatch.setattr(can, "Bus", lambda **options: asked.update(options) or Adapter())
    open_can_bus(text, CLOCK, feedback_ids=(0x205,)).close()
    assert (asked["bitrate"], asked["channel"], asked.get("can_filters")) == (1_000_000, channel, None)


@pytest.mark.parametrize(
    "message",
    [
        build_message(is_extended_id=True),
        build_message(data=b"", is_remote_frame=True, dlc=8),
        build_message(data=b"", is_remote_frame=True, dlc=0),
        build_message(is_error_frame=True, identifier=1),
        build_message(data=bytes(64), is_fd=True),
        build_message(0x800),
        build_message(dlc=8, data=bytes(3)),
        build_message(data=bytes(9)),
        parse_failure(),
        ValueError("invalid literal for int() with base 16"),
        IndexError("string index out of range"),
        AssertionError("only requested a single extra field"),
    ],
    ids=[
        "extended",
        "remote",
        "remote without length",
        "error",
        "fd",
        "id",
        "short",
        "long",
        "cause",
        "value",
        "index",
        "assertion",
    ],
)
@pytest.mark.parametrize("interface", ["socketcan", "slcan"])
def test_messages_that_are_never_trusted_are_counted_and_the_next_one_is_read(message, interface):
    _, bus = open_fake(message, build_message(0x206), interface=interface)
    frames, end = [], time.monotonic() + SOON
    while not frames and time.monotonic() < end:
        frames += bus.receive()
    bus.close()
    assert [frame.id for frame in frames] == [0x206]
    assert bus.ignored == 1


@pytest.mark.parametrize("interface", ["socketcan", "slcan"])
def test_an_adapter_that_is_gone_is_an_error(interface):
    failure = can.CanOperationError("Failed to receive: No such device")
    failure.__cause__ = OSError(19, "No such device")
    _, bus = open_fake(failure, interface=interface)
    with pytest.raises(DriveError, match=r"bus .*:can0 does not work: Failed to receive: No such device; check"):
        wait_until_refused(bus)
    bus.close()


def wait_until_refused(bus: CanBus) -> None:
    end = time.monotonic() + SOON
    while time.monotonic() < end:
        bus.receive()


def test_what_could_not_be_sent_is_never_sent_later():
    adapter, bus = open_fake()
    adapter.failure = can.CanOperationError("Transmit buffer full")
    bus.send(Frame(0x1FE, b"stale"))
    bus.send(Frame(0x2FE, b"stale"))
    with pytest.raises(DriveError, match="Transmit buffer full"):
        bus.flush()
    adapter.failure = None
    bus.flush()
    assert adapter.sent == []
    bus.send(Frame(0x1FE, b"fresh"))
    bus.flush()
    assert [bytes(message.data) for message in adapter.sent] == [b"fresh"]


def test_what_a_serial_adapter_has_not_taken_is_discarded():
    adapter, bus = open_fake()
    discarded = []
    adapter.serialPortOrig = type("Port", (), {"reset_output_buffer": lambda self: discarded.append(True)})()
    adapter.failure = can.CanOperationError("Could not write to serial device")
    bus.send(Frame(0x1FE, b"stale"))
    with pytest.raises(DriveError, match="Could not write"):
        bus.flush()
    assert discarded == [True]


def test_a_bus_that_went_off_takes_nothing_until_it_is_heard_again():
    adapter, bus = open_fake(BUS_OFF_MESSAGE)
    with pytest.raises(DriveError, match="is off after too many errors"):
        bus.receive()
    bus.send(Frame(0x1FE, b"stale"))
    with pytest.raises(DriveError, match="is off"):
        bus.flush()
    with pytest.raises(DriveError, match="is off"):
        bus.receive()
    adapter.messages.append(build_message())
    assert len(bus.receive()) == 1
    bus.flush()
    assert adapter.sent == []


def test_a_flood_does_not_hold_the_loop():
    adapter, bus = open_fake(*[build_message() for _ in range(3 * MOST_FRAMES)])
    assert len(bus.receive()) == MOST_FRAMES
    adapter.messages = [ValueError("noise")] * 3 * MOST_FRAMES
    assert bus.receive() == []
    assert len(adapter.messages) == 2 * MOST_FRAMES


def test_a_message_that_waited_in_the_kernel_is_as_old_as_it_is():
    now = time.time()
    stamps = [now - 2.0, now - 1.0, now - 3.0, now + 9.0]
    _, bus = open_fake()
    bus._bus.messages = [build_message(timestamp=stamp) for stamp in stamps]
    bus._last = CLOCK.now() - 60.0
    ages = [CLOCK.now() - frame.time for frame in bus.receive()]
    assert ages[:2] == pytest.approx([2.0, 1.0], abs=0.5)
    assert ages[2] == pytest.approx(ages[1], abs=0.1)
    assert ages[3] == pytest.approx(0.0, abs=0.5)


def test_nobody_waits_for_an_adapter_that_is_read_in_a_thread():
    """And its thread ends with the bus."""
    adapter, bus = open_fake(interface="gs_usb")
    thread = bus._reader._thread
    assert thread in threading.enumerate()
    assert bus.receive() == []
    bus.close()
    bus.close()
    thread.join(SOON)
    assert not thread.is_alive()
    assert adapter.shutdowns == 1


def test_the_echo_of_what_was_sent_is_no_frame():
    _, bus = open_fake(build_message(0x1FE, is_rx=False), build_message(0x206), interface="gs_usb")
    frames, end = [], time.monotonic() + SOON
    while not frames and time.monotonic() < end:
        frames += bus.receive()
    bus.close()
    assert [frame.id for frame in frames] == [0x206]


def test_a_serial_adapter_at_a_pseudo_terminal():
    """The slcan text both ways: ``t`` with id, length and bytes in hexadecimal; garbage is passed over."""
    pty = pytest.importorskip("pty", reason="a pseudo-terminal needs POSIX")
    device, host = pty.openpty()
    bus = open_can_bus(f"slcan:{os.ttyname(host)}", CLOCK)
    assert b"S8\r" in os.read(device, 1000)
    bus.send(Frame(0x1FE, bytes.fromhex("4000c00000010000")))
    bus.flush()
    assert os.read(device, 1000).endswith(b"t1FE84000C00000010000\r")
    os.write(device, b"\xff\xfe\rt2\rtxyz\rt2058zz\r\a\r")
    frames, end = [], time.monotonic() + SOON
    while not frames and time.monotonic() < end:
        os.write(device, b"t2053010203\r")
        time.sleep(0.01)
        frames += bus.receive()
    assert {(frame.id, frame.data) for frame in frames} == {(0x205, b"\1\2\3")}
    assert bus.ignored > 0
    os.close(device)
    os.close(host)
    with pytest.raises(DriveError, match="does not work"):
        wait_until_refused(bus)
    bus.close()


def test_two_ends_of_a_virtual_bus_in_one_process():
    name = f"virtual:{uuid.uuid4()}"
    one, other = open_can_bus(name, CLOCK), open_can_bus(name, CLOCK)
    one.send(Frame(0x1FE, b"x"))
    one.flush()
    assert [frame.id for frame in other.receive()] == [0x1FE]
    one.close()
    other.close()
