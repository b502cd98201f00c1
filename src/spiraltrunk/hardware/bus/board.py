"""RoboMaster development board on a serial port: a bus of CAN frames that its firmware's watchdog guards, and a servo.

Never tried on a real board; the messages are those of `board_messages`. At 115200 baud, 8N1, the line carries 11.5 kB/s
in each direction, which is enough for three motors at 200 Hz; 500 Hz need the board's USB port (CDC), where the baud
rate has no meaning.
"""

from __future__ import annotations

import contextlib
import math
from dataclasses import dataclass
from typing import Any, final

from spiraltrunk.errors import DriveError, MissingPackage, describe, describe_reason
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.bus.board_frame import BoardMessage, MessageParser, encode_message
from spiraltrunk.hardware.bus.board_messages import BoardCommand, decode_frames, encode_frames, encode_pulse
from spiraltrunk.hardware.bus.frame_bus import Frame, FrameBus
from spiraltrunk.hardware.bus.frame_queue import FrameQueue
from spiraltrunk.hardware.clock import Clock

BAUD_RATE = 115_200
"""Rate of the board's serial port (public RoboMaster firmware; unconfirmed) [1/s]."""

WRITE_TIMEOUT = 0.01
"""Longest wait for a line that does not take what is written (ours) [s]."""

PULSE_PERIOD = 0.02
"""Period at which the servo's pulse is sent again: that of its 50 Hz [s]."""

MOST_BYTES = 4096
"""Most bytes that one `BoardBus.receive` takes (ours), so that a flood cannot hold the loop."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class BoardCounts:
    """Received data that were discarded."""

    skipped_bytes: int
    """Bytes that belonged to no message [-]."""
    broken: int
    """Beginnings of a frame with a wrong checksum or length [-]."""
    unknown: int
    """Messages with another command than the board's [-]."""
    malformed: int
    """Messages whose content has no allowed layout [-]."""
    missing: int
    """Messages that the sequence number shows to be lost [-]."""


@final
class BoardBus(FrameBus):
    """The board. `open_board` makes one.

    Each flush is one write: the queued CAN frames, and the servo's pulse when it changed or is due.
    """

    def __init__(self, port: Any, clock: Clock) -> None:
        """Use an open port of pyserial that does not wait for reading; `close` closes it."""
        self._port = port
        self._clock = clock
        self._queue = FrameQueue()
        self._parser = MessageParser()
        self._unknown = self._malformed = self._missing = 0
        self._received: int | None = None
        self._sequence = 0
        self._pulse: int | None = None
        self._pulse_time = 0.0
        self._is_closed = False

    @property
    def counts(self) -> BoardCounts:
        """Received data that were discarded so far."""
        parser = self._parser
        return BoardCounts(
            skipped_bytes=parser.skipped,
            broken=parser.broken,
            unknown=self._unknown,
            malformed=self._malformed,
            missing=self._missing,
        )

    def set_servo_pulse(self, pulse_us: int) -> None:
        """Queue the width of the servo's pulse [us] for the next flush; 0 ends the pulses.

        Raises:
            DriveError: where it is no whole number that a message carries.
        """
        if not (type(pulse_us) is int and 0 <= pulse_us <= 0xFFFF):
            raise DriveError(f"servo pulse is {describe(pulse_us)}; allowed: a whole number from 0 to 65535 us")
        self._pulse, self._pulse_time = pulse_us, -math.inf

    def send(self, frame: Frame) -> None:
        """See `FrameBus.send`."""
        self._queue.put(frame)

    def flush(self) -> None:
        """See `FrameBus.flush`. Where it fails, the servo's pulse is forgotten too, until it is set anew."""
        try:
            data = self._take()
            self._check_open()
            if data and self._port.write(data) != len(data):
                raise DriveError("the board's line takes no more; check cable and baud rate")
        except (OSError, DriveError) as error:  # pyserial's errors are OSErrors.
            self._forget()
            raise error if isinstance(error, DriveError) else _gone(error) from error

    def _take(self) -> bytes:
        """What is to be written now; nothing of it waits afterwards."""
        now, data = self._clock.now(), b""
        if frames := self._queue.take():
            data += self._pack(BoardCommand.SEND_FRAMES, encode_frames(frames))
        if self._pulse is not None and now - self._pulse_time >= PULSE_PERIOD:
            self._pulse_time = now
            data += self._pack(BoardCommand.SERVO_PULSE, encode_pulse(self._pulse))
        return data

    def _pack(self, command: BoardCommand, data: bytes) -> bytes:
        self._sequence = (self._sequence + 1) % 256
        return encode_message(BoardMessage(command, data, self._sequence))

    def _forget(self) -> None:
        self._pulse = None
        with contextlib.suppress(Exception):  # A line that is gone raises `termios.error`, which is no OSError.
            self._port.reset_output_buffer()

    def receive(self) -> list[Frame]:
        """See `FrameBus.receive`."""
        self._check_open()
        try:
            data = self._port.read(min(self._port.in_waiting, MOST_BYTES))
        except OSError as error:
            raise _gone(error) from error
        now = self._clock.now()
        return [frame for message in self._parser.feed(data) for frame in self._take_in(message, now)]

    def _take_in(self, message: BoardMessage, now: float) -> list[Frame]:
        if self._received is not None:
            self._missing += (message.sequence - self._received - 1) % 256
        self._received = message.sequence
        if message.command != BoardCommand.RECEIVED_FRAMES:
            self._unknown += 1
            return []
        frames = decode_frames(message.data, now)
        self._malformed += frames is None
        return frames or []

    def _check_open(self) -> None:
        if self._is_closed:
            raise DriveError("the board is closed; open it anew")

    def close(self) -> None:
        """See `FrameBus.close`."""
        if not self._is_closed:
            self._is_closed = True
            self._queue.take()
            with contextlib.suppress(OSError):
                self._port.close()


def open_board(port: str, clock: Clock) -> BoardBus:
    """Open the serial port of a board, such as ``/dev/ttyACM0``, for this program alone; nothing is sent.

    Raises:
        DriveError: where it cannot be opened.
        MissingPackage: without pyserial.
    """
    try:
        import serial
    except ImportError:
        raise MissingPackage("a board needs pyserial: pip install 'spiraltrunk[hardware]'") from None
    try:
        line = serial.serial_for_url(port, baudrate=BAUD_RATE, timeout=0, write_timeout=WRITE_TIMEOUT, exclusive=True)
    except (OSError, ValueError, LookupError, AttributeError) as error:
        raise DriveError(
            f"board {describe(port)} cannot be opened: {describe_reason(error)}; check name, cable and permissions"
        ) from error
    return BoardBus(line, clock)


def _gone(error: BaseException) -> DriveError:
    return DriveError(f"the board does not answer: {describe_reason(error)}; check cable and power")
