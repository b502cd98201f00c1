"""CAN adapter at 1 Mbit/s, on python-can. Never tried on a real adapter; python-can's virtual bus stands in for one.

SocketCAN's bit rate and queue are set outside: ``ip link set can0 up type can bitrate 1000000`` and
``ip link set can0 txqueuelen 4``. The kernel keeps what it could not send and sends it when the bus returns; a short
queue keeps that to the frames of a few ticks, and a driver whose feedback is stale only queues zeros.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, final

from spiraltrunk.errors import DriveError, MissingPackage, describe_reason
from spiraltrunk.hardware.bus.can_address import CanAddress, parse_can_address
from spiraltrunk.hardware.bus.can_reader import CanReader, is_gone
from spiraltrunk.hardware.bus.frame_bus import Frame, FrameBus
from spiraltrunk.hardware.bus.frame_queue import FrameQueue, is_standard
from spiraltrunk.hardware.clock import Clock

if TYPE_CHECKING:
    import can

BITRATE = 1_000_000
"""Bit rate of the motors [1/s] (GM6020 manual)."""

MOST_FRAMES = 256
"""Most messages that one `CanBus.receive` takes (ours), so that a flood cannot hold the loop [-]."""

SEND_TIMEOUT = 0.005
"""Longest wait for a driver that does not take a frame (ours) [s]."""

BUS_OFF = 0x40
"""Bit of an error frame: the controller went off the bus (Linux, can/error.h)."""

OPTIONS: dict[str, dict[str, Any]] = {
    "socketcan": {},
    "gs_usb": {"bitrate": BITRATE},
    "slcan": {"bitrate": BITRATE, "sleep_after_open": 0.2},
    "virtual": {},
    "udp_multicast": {"fd": False},
}
"""What each interface is opened with; USB adapters are ready 0.2 s after opening (ours)."""

EXTRAS = {"gs_usb": "python-can[gs-usb]", "udp_multicast": "python-can[multicast]"}
"""What must be installed, beside python-can itself, for an interface."""

IN_THREAD = ("gs_usb", "slcan")
"""Interfaces that wait about 1 ms when nothing has arrived, so that another thread must wait for them."""

KERNEL_STAMPED = ("socketcan", "udp_multicast")
"""Interfaces whose messages carry the time at which the kernel received them."""


@final
class CanBus(FrameBus):
    """A CAN adapter. `open_can_bus` makes one."""

    def __init__(self, bus: can.BusABC, address: CanAddress, clock: Clock) -> None:
        """Use an open bus of python-can; `close` closes it."""
        self._ignored = 0
        self._bus = bus
        self._name = ":".join(address)
        self._clock = clock
        self._is_stamped = address.interface in KERNEL_STAMPED
        self._has_echo = address.interface == "gs_usb"
        self._queue = FrameQueue()
        self._last = clock.now()
        self._is_off = False
        self._is_closed = False
        self._reader = CanReader(bus, clock) if address.interface in IN_THREAD else None

    @property
    def ignored(self) -> int:
        """Messages that were no standard data frame of up to 8 bytes, or that could not be read [-]."""
        return self._ignored + (self._reader.unreadable if self._reader is not None else 0)

    def send(self, frame: Frame) -> None:
        """See `FrameBus.send`."""
        self._queue.put(frame)

    def flush(self) -> None:
        """See `FrameBus.flush`. A bus that is off takes nothing until something arrives from it again."""
        import can

        frames = self._queue.take()
        self._check_on()
        for frame in frames:
            message = can.Message(arbitration_id=frame.id, data=frame.data, is_extended_id=False, check=True)
            try:
                self._bus.send(message, timeout=SEND_TIMEOUT)
            except (can.CanError, OSError) as error:
                self._discard()
                raise self._gone(error) from error

    def receive(self) -> list[Frame]:
        """See `FrameBus.receive`. Error, remote, extended and FD messages are never passed on."""
        if self._is_closed:
            raise DriveError(f"bus {self._name} is closed; open it anew")
        frames = []
        for message, arrival in self._poll() if self._reader is None else self._reader.take(MOST_FRAMES):
            if message.is_error_frame:
                self._ignored += 1
                self._is_off |= bool(message.arbitration_id & BUS_OFF)
            elif self._has_echo and not message.is_rx:
                continue  # What this adapter sent itself.
            elif _is_plain(message):
                frames.append(Frame(message.arbitration_id, bytes(message.data), arrival))
                self._is_off = False
            else:
                self._ignored += 1
        self._check_on()
        return frames

    def _poll(self) -> Iterable[tuple[can.Message, float]]:
        for _ in range(MOST_FRAMES):
            try:
                message = self._bus.recv(0)
            except Exception as error:
                if is_gone(error):
                    raise self._gone(error) from error
                self._ignored += 1
                continue
            if message is None:
                return
            yield message, self._date(message.timestamp)

    def _discard(self) -> None:
        """Drop what a serial adapter has not taken yet, so that it is not sent when the line is free again."""
        port = getattr(self._bus, "serialPortOrig", None)
        if port is not None:
            with contextlib.suppress(Exception):  # A line that is gone raises `termios.error`, which is no OSError.
                port.reset_output_buffer()

    def _date(self, stamp: float) -> float:
        """When a message arrived, on the driver's clock: not before the one before it, and not in the future [s]."""
        now = self._clock.now()
        arrival = now - (time.time() - stamp) if self._is_stamped else now
        self._last = min(max(arrival, self._last), now)
        return self._last

    def _check_on(self) -> None:
        if self._is_closed:
            raise DriveError(f"bus {self._name} is closed; open it anew")
        if self._is_off:
            raise DriveError(f"bus {self._name} is off after too many errors; check wiring and termination, restart it")
        if self._reader is not None and self._reader.error is not None:
            raise self._gone(self._reader.error) from self._reader.error

    def _gone(self, error: BaseException) -> DriveError:
        return DriveError(f"bus {self._name} does not work: {describe_reason(error)}; check adapter, power and wiring")

    def close(self) -> None:
        """See `FrameBus.close`."""
        import can

        if self._is_closed:
            return
        self._is_closed = True
        self._queue.take()
        if self._reader is not None:
            self._reader.stop()
        with contextlib.suppress(can.CanError, OSError):  # An adapter that is gone needs no closing.
            self._bus.shutdown()


def open_can_bus(text: str, clock: Clock, *, feedback_ids: Iterable[int] | None = None) -> CanBus:
    """Open the adapter that a text such as ``socketcan:can0`` names; no frame is sent.

    Args:
        text: ``INTERFACE:CHANNEL``, see `can_address.INTERFACES`.
        clock: the driver's clock.
        feedback_ids: identifiers that are to be received; None for all. The kernel's filter drops the others on
            SocketCAN; the other interfaces have none, and pass everything on.

    Raises:
        DriveError: where the text names no adapter, or it cannot be opened.
        MissingPackage: without python-can, or what it needs for the interface.
    """
    address = parse_can_address(text)
    try:
        import can
    except ImportError:
        raise MissingPackage("a CAN bus needs python-can: pip install 'spiraltrunk[hardware]'") from None
    options = dict(OPTIONS[address.interface])
    if address.interface == "socketcan" and feedback_ids is not None:
        options["can_filters"] = [{"can_id": i, "can_mask": 0x7FF, "extended": False} for i in feedback_ids]
    channel: Any = int(address.channel) if address.interface == "gs_usb" else address.channel
    try:
        bus = can.Bus(channel=channel, interface=address.interface, ignore_config=True, **options)
    except can.CanInterfaceNotImplementedError as error:
        advice = f"pip install '{EXTRAS[address.interface]}'" if address.interface in EXTRAS else "use another computer"
        raise MissingPackage(f"bus {text} cannot be opened: {describe_reason(error)}; {advice}") from error
    except (can.CanError, OSError, ValueError) as error:
        raise DriveError(
            f"bus {text} cannot be opened: {describe_reason(error)}; check adapter, driver and permissions"
        ) from error
    return CanBus(bus, address, clock)


def _is_plain(message: can.Message) -> bool:
    """Whether it is a standard data frame."""
    return (
        not (message.is_extended_id or message.is_remote_frame or message.is_fd)
        and message.dlc == len(message.data)
        and is_standard(message.arbitration_id, bytes(message.data))
    )
