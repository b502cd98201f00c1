"""RoboMaster development board on a serial port: a bus of CAN frames, a servo channel and a watchdog.

Never tried on a real board; the messages are those of `board_messages`. At 115200 baud, 8N1, the line carries 11.5 kB/s
in each direction, which is enough for three motors at 200 Hz; 500 Hz need the board's USB port (CDC), where the baud
rate has no meaning.
"""

from __future__ import annotations

import contextlib
import math
from dataclasses import dataclass
from typing import Any, final

from spiraltrunk.checks import check_number
from spiraltrunk.errors import DriveError, MissingPackage, describe
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.bus.board_frame import BoardMessage, MessageParser, encode_message
from spiraltrunk.hardware.bus.board_messages import (
    Beat,
    BoardCommand,
    decode_beat,
    decode_frames,
    encode_beat,
    encode_frames,
    encode_pulse,
)
from spiraltrunk.hardware.bus.frame_bus import Frame, FrameBus
from spiraltrunk.hardware.bus.frame_queue import FrameQueue
from spiraltrunk.hardware.clock import Clock

BAUD_RATE = 115_200
"""Rate of the board's serial port (public RoboMaster firmware; unconfirmed) [1/s]."""

WRITE_TIMEOUT = 0.01
"""Longest wait for a line that does not take what is written (ours) [s]."""

HEARTBEAT_PERIOD = 0.01
"""Least time between two heartbeats (ours: a fifth of the default timeout) [s]."""

PULSE_PERIOD = 0.02
"""Time after which the servo's pulse is told again: that of its 50 Hz [s]."""

MOST_BYTES = 4096
"""Most bytes that one `BoardBus.receive` takes (ours), so that a flood cannot hold the loop."""

STATE_AGE = 0.25
"""Age up to which the watchdog's state counts: two that are missing (ours) [s]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class WatchdogSettings:
    """What the board does when the host falls silent; the sum is within the 100 ms to the safe state."""

    timeout: float = 0.05
    """Longest silence, from 20 ms (ours) [s]."""
    ramp: float = 0.03
    """Time in which the motors' currents are lowered to zero, so that no cable whips (ours) [s]."""

    def __post_init__(self) -> None:
        check_number("watchdog.timeout", self.timeout, least=0.02, most=0.1)
        check_number("watchdog.ramp", self.ramp, least=0.0, most=0.1 - self.timeout)


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class BoardCounts:
    """What was received from the board and not believed."""

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

    Each flush is one write: the queued CAN frames, a heartbeat when it is due, and the servo's pulse when it changed or
    is due. Only the loop of control may flush, because a heartbeat says that this loop is alive.
    """

    def __init__(self, port: Any, clock: Clock, watchdog: WatchdogSettings | None = None) -> None:
        """Use an open port of pyserial that does not wait for reading; `close` closes it."""
        self._port = port
        self._clock = clock
        self._settings = watchdog or WatchdogSettings()
        self._queue = FrameQueue()
        self._parser = MessageParser()
        self._unknown = self._malformed = self._missing = 0
        self._received: int | None = None
        self._sequence = 0
        self._beats = 0
        self._is_clearing = False
        self._pulse: int | None = None
        self._beat_time = self._pulse_time = -math.inf
        self._state: tuple[Beat, float] | None = None
        self._is_closed = False

    @property
    def counts(self) -> BoardCounts:
        """What was received so far and not believed."""
        parser = self._parser
        return BoardCounts(
            skipped_bytes=parser.skipped,
            broken=parser.broken,
            unknown=self._unknown,
            malformed=self._malformed,
            missing=self._missing,
        )

    @property
    def is_watched(self) -> bool:
        """Whether the board has just confirmed that its watchdog runs with these settings and has not tripped."""
        if self._state is None:
            return False
        beat, time = self._state
        is_same = (beat.timeout_ms, beat.ramp_ms) == self._limits()
        return is_same and not beat.is_flagged and self._clock.now() - time <= STATE_AGE

    @property
    def is_tripped(self) -> bool:
        """Whether the board's watchdog last told that it has stopped the motors."""
        return self._state is not None and self._state[0].is_flagged

    def clear_watchdog(self) -> None:
        """Let the next heartbeat release a watchdog that has tripped; for a person's re-arming alone."""
        self._is_clearing = True

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
        if now - self._beat_time >= HEARTBEAT_PERIOD or self._is_clearing:
            self._beats = (self._beats + 1) % 256
            beat = Beat(*self._limits(), self._is_clearing, self._beats)
            self._beat_time, self._is_clearing = now, False
            data += self._pack(BoardCommand.HEARTBEAT, encode_beat(beat))
        if self._pulse is not None and now - self._pulse_time >= PULSE_PERIOD:
            self._pulse_time = now
            data += self._pack(BoardCommand.SERVO_PULSE, encode_pulse(self._pulse))
        return data

    def _pack(self, command: BoardCommand, data: bytes) -> bytes:
        self._sequence = (self._sequence + 1) % 256
        return encode_message(BoardMessage(command, data, self._sequence))

    def _limits(self) -> tuple[int, int]:
        return round(1e3 * self._settings.timeout), round(1e3 * self._settings.ramp)

    def _forget(self) -> None:
        self._pulse = None
        self._is_clearing = False
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
        frames: list[Frame] | None = []
        if message.command == BoardCommand.RECEIVED_FRAMES:
            frames = decode_frames(message.data, now)
        elif message.command == BoardCommand.WATCHDOG_STATE:
            beat = decode_beat(message.data)
            self._state, frames = ((beat, now), []) if beat is not None else (self._state, None)
        else:
            self._unknown += 1
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


def open_board(port: str, clock: Clock, watchdog: WatchdogSettings | None = None) -> BoardBus:
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
            f"board {describe(port)} cannot be opened: {error}; check name, cable and permissions"
        ) from error
    return BoardBus(line, clock, watchdog)


def _gone(error: BaseException) -> DriveError:
    return DriveError(f"the board does not answer: {error}; check cable and power")
