"""Watchdog: what takes the torque off the motors when the host dies, and how the host feeds it.

A heartbeat is a frame `HEARTBEAT_ID` with ``struct ">HB"``: a counter that changes with each one, and flags. The board
answers each with `ANSWER_ID`, ``struct ">HB"``: the counter it saw, and a `BoardMode`. Identifiers, format and timeout
are ours: no such board was tried.
"""

from __future__ import annotations

import struct
from abc import ABC, abstractmethod
from enum import IntEnum
from typing import Any, Final, final

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.bus.frame_bus import Frame, FrameBus
from spiraltrunk.hardware.clock import Clock

HEARTBEAT_ID: Final = 0x7A0
"""Identifier of the host's heartbeat (ours; no RoboMaster motor uses it)."""

ANSWER_ID: Final = 0x7A1
"""Identifier of the board's answer (ours)."""

HEARTBEAT_FORMAT: Final = struct.Struct(">HB")
"""Content of heartbeat and answer: counter of 16 bits, and flags or mode."""

CLEAR_FLAG: Final = 0x01
"""Flag of a heartbeat: a person has cleared the fault, so the board may let torques through again."""

END_FLAG: Final = 0x02
"""Flag of a heartbeat: the host ends in order, its torque is off; a watching board waits for the next host."""

TIMEOUT: Final = 0.020
"""Silence after which the board takes the torque off [s] (ours: ten periods of control)."""

RELEASE: Final = 0.040
"""Time in which the board ramps the torque from its last value to zero [s] (ours)."""

ANSWER_AGE: Final = 0.050
"""Largest age of the board's answer with which it counts as present [s] (ours: as for a motor's feedback)."""

END_COUNT: Final = 3
"""Heartbeats with the end flag, as a frame may be lost [-] (ours)."""

_TRIPPED: Final = (
    f"it has tripped, as no heartbeat came within {1e3 * TIMEOUT:g} ms: a program was killed, or this computer is too "
    "busy; find the cause, then clear it: spiraltrunk drive --bus robot --robot FILE DESIGN clear NAME, with your name"
)

PULSE: Final = b"\x55"
"""Byte that is written to keep a relay closed: its bits alternate, so that the line itself is the pulse."""


@final
class BoardMode(IntEnum):
    """What a board's watchdog does."""

    WAITING = 0
    """No heartbeat has come yet, or the last host ended in order; every torque is zero."""
    WATCHING = 1
    """Torques pass."""
    TRIPPED = 2
    """The heartbeat stopped: torques are ramped to zero and stay there until a heartbeat has the clear flag."""


class Watchdog(ABC):
    """What cuts the motors' torque when it is no longer fed."""

    @abstractmethod
    def feed(self) -> None:
        """Tell it that the host lives; never waits.

        Raises:
            DriveError: where the line to it is gone.
        """

    def is_present(self) -> bool:
        """Whether it is known to be there and to let torques through."""
        return not self.find_absence()

    @abstractmethod
    def find_absence(self) -> str:
        """Why it does not count as present, in words; empty where it does."""

    @abstractmethod
    def clear(self) -> None:
        """Let it pass torques again after it has tripped; a person decides that."""

    @abstractmethod
    def end(self) -> None:
        """Tell it that the host ends in order, with all torque off, so that it does not trip.

        Raises:
            DriveError: where the line to it is gone.
        """


@final
class NoWatchdog(Watchdog):
    """No watchdog: a host that dies leaves the motors with their last torque."""

    def feed(self) -> None:
        """Do nothing."""

    def find_absence(self) -> str:
        """It is never there."""
        return "there is none; connect one, or say that there is none"

    def clear(self) -> None:
        """Do nothing."""

    def end(self) -> None:
        """Do nothing."""


@final
class WatchedBus(FrameBus):
    """A bus that keeps the watchdog's answers back from the motors, which share it."""

    def __init__(self, bus: FrameBus) -> None:
        self._bus = bus
        self.answer: Frame | None = None
        """Latest answer of the board; None before the first."""

    def send(self, frame: Frame) -> None:
        """Queue a frame."""
        self._bus.send(frame)

    def flush(self) -> None:
        """Send what is queued."""
        self._bus.flush()

    def receive(self) -> list[Frame]:
        """Frames that are not the watchdog's."""
        frames = self._bus.receive()
        for frame in frames:
            if frame.id == ANSWER_ID and len(frame.data) == HEARTBEAT_FORMAT.size:
                self.answer = frame
        return [frame for frame in frames if frame.id != ANSWER_ID]

    def close(self) -> None:
        """Release the bus."""
        self._bus.close()


@final
class BoardWatchdog(Watchdog):
    """A board on the motors' bus that lets torques through as long as heartbeats come.

    The heartbeat is queued and leaves with the torques in one flush of the bus.
    """

    def __init__(self, bus: WatchedBus, clock: Clock) -> None:
        self._bus = bus
        self._clock = clock
        self._counter = 0
        self._is_clearing = False

    def feed(self) -> None:
        """Queue the next heartbeat."""
        self._queue(CLEAR_FLAG if self._is_clearing else 0)

    def _queue(self, flags: int) -> None:
        self._counter = (self._counter + 1) & 0xFFFF
        self._bus.send(Frame(HEARTBEAT_ID, HEARTBEAT_FORMAT.pack(self._counter, flags)))

    def find_absence(self) -> str:
        """Empty where a fresh answer says that the board is watching; that ends a clearing, too."""
        answer = self._bus.answer
        if answer is None:
            return "its board has not answered; check its supply and the bus, or say that there is none"
        age = self._clock.now() - answer.time
        if not age < ANSWER_AGE:
            late = f"its board answered {1e3 * age:.0f} ms ago; allowed: below {1e3 * ANSWER_AGE:g} ms"
            return f"{late}; check its supply and the bus, and whether this computer is too busy"
        mode = HEARTBEAT_FORMAT.unpack(answer.data)[1]
        if mode != BoardMode.WATCHING:
            return _TRIPPED if mode == BoardMode.TRIPPED else "its board waits for a heartbeat"
        self._is_clearing = False
        return ""

    def clear(self) -> None:
        """Set the clear flag until the board is watching."""
        self._is_clearing = True

    def end(self) -> None:
        """Send heartbeats with the end flag; if all are lost, the board trips."""
        for _ in range(END_COUNT):
            self._queue(END_FLAG)
            self._bus.flush()  # A bus keeps the latest frame of an identifier alone.


@final
class RelayWatchdog(Watchdog):
    """A relay in the motors' 24 V supply that a retriggerable timer keeps closed while bytes come on a serial line.

    The timer is triggered by the edges of the transmit line, and a second contact of the relay pulls "clear to send":
    so presence is measured, and not believed. Nothing of it was tried on a real relay.
    """

    def __init__(self, port: Any) -> None:
        self._port = port

    def feed(self) -> None:
        """Write one pulse."""
        try:
            self._port.write(PULSE)
        except OSError as error:  # SerialException is one.
            raise DriveError(
                f"the relay's serial line is gone ({error}); allowed: a port that is plugged in"
            ) from error

    def find_absence(self) -> str:
        """Empty where the relay's second contact is closed."""
        try:
            is_closed = bool(self._port.cts)
        except OSError as error:
            return f"the relay's serial line is gone ({error}); allowed: a port that is plugged in"
        return "" if is_closed else "its relay is open; check its supply, and that CTS is wired to its second contact"

    def clear(self) -> None:
        """Do nothing: the relay closes again when it is fed."""

    def end(self) -> None:
        """Do nothing: the relay opens."""
