"""The twin's end of a board's serial line: a pseudo-terminal, a serial port for any program. Not on Windows."""

from __future__ import annotations

import contextlib
import os
from typing import final

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.bus.board_frame import BoardMessage, MessageParser, encode_message
from spiraltrunk.hardware.bus.board_messages import BoardCommand, decode_frames, decode_pulse, encode_frames
from spiraltrunk.hardware.bus.frame_bus import Frame, FrameBus
from spiraltrunk.hardware.bus.frame_queue import FrameQueue
from spiraltrunk.hardware.clock import Clock

_MOST_BYTES = 65536


@final
class BoardLine(FrameBus):
    """A board whose bus is the twin's: what the host has it send is received here, and what is flushed is passed on.

    Bytes for which the host leaves no room are lost, as on a wire.
    """

    def __init__(self, clock: Clock) -> None:
        """Open a pseudo-terminal.

        Raises:
            DriveError: where the operating system has none.
        """
        try:
            import tty

            self._master, self._slave = os.openpty()
        except (ImportError, AttributeError, OSError) as error:
            raise DriveError(f"no pseudo-terminal: {error}; use the bus in memory") from error
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.port = os.ttyname(self._slave)
        """Name of the serial port."""
        self.pulse: int | None = None
        """Last width of the servo's pulse [us]; None before the first."""
        self._clock, self._queue, self._parser = clock, FrameQueue(), MessageParser()
        self._sequence = 0
        self._is_closed = False

    def send(self, frame: Frame) -> None:
        """See `FrameBus.send`."""
        self._queue.put(frame)

    def flush(self) -> None:
        """See `FrameBus.flush`: one message of all frames."""
        frames = self._queue.take()
        if not frames or self._is_closed:
            return
        self._sequence = (self._sequence + 1) % 256
        message = BoardMessage(BoardCommand.RECEIVED_FRAMES, encode_frames(frames), self._sequence)
        with contextlib.suppress(OSError):  # The host reads too slowly.
            os.write(self._master, encode_message(message))

    def receive(self) -> list[Frame]:
        """See `FrameBus.receive`."""
        try:
            data = b"" if self._is_closed else os.read(self._master, _MOST_BYTES)
        except OSError:  # Nothing has arrived.
            return []
        now, frames = self._clock.now(), list[Frame]()
        for message in self._parser.feed(data):
            if message.command == BoardCommand.SERVO_PULSE:
                self.pulse = decode_pulse(message.data)
            elif message.command == BoardCommand.SEND_FRAMES:
                frames += decode_frames(message.data, now) or []
        return frames

    def close(self) -> None:
        """See `FrameBus.close`."""
        if not self._is_closed:
            self._is_closed = True
            os.close(self._master)
            os.close(self._slave)
