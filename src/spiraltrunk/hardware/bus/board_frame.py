"""Serial frame of a RoboMaster development board.

``0xA5 | length u16 | sequence u8 | crc8 | command u16 | data | crc16``, little endian; the length counts the data, crc8
covers the 4 bytes before it, crc16 everything before it (public RoboMaster firmware; unconfirmed by DJI).
"""

from __future__ import annotations

import struct
from typing import NamedTuple, final

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.bus.crc import compute_crc8, compute_crc16

START = 0xA5
"""First byte of a frame."""

LONGEST = 256
"""Most data bytes of a frame (ours): a longer one is rejected [bytes]."""

_HEADER = struct.Struct("<BHB")
_NUMBER = struct.Struct("<H")

BEFORE_DATA = _HEADER.size + 1 + _NUMBER.size
"""Bytes before the data."""

AROUND_DATA = BEFORE_DATA + _NUMBER.size
"""Bytes of a frame without data."""


@final
class BoardMessage(NamedTuple):
    """Content of one frame."""

    command: int
    """What it is about, 0 to 0xFFFF."""
    data: bytes
    """Content, up to `LONGEST` bytes."""
    sequence: int = 0
    """Number of the frame modulo 256."""


def encode_message(message: BoardMessage) -> bytes:
    """The frame of a message.

    Raises:
        DriveError: where the data are too long.
    """
    if len(message.data) > LONGEST:
        raise DriveError(f"board message has {len(message.data)} bytes; allowed: up to {LONGEST}")
    header = _HEADER.pack(START, len(message.data), message.sequence)
    frame = header + bytes([compute_crc8(header)]) + _NUMBER.pack(message.command) + message.data
    return frame + _NUMBER.pack(compute_crc16(frame))


@final
class MessageParser:
    """Finds messages in a stream of bytes; resynchronises after bytes that are no message."""

    def __init__(self) -> None:
        self.skipped = 0
        """Bytes that belonged to no message [-]."""
        self.broken = 0
        """Beginnings of a frame whose checksum or length was wrong [-]."""
        self._buffer = bytearray()

    def feed(self, data: bytes) -> list[BoardMessage]:
        """Messages that are complete with these further bytes, oldest first; never raises."""
        self._buffer += data
        messages: list[BoardMessage] = []
        start = 0
        while (begin := self._buffer.find(START, start)) >= 0:
            self.skipped += begin - start
            start, message = self._read(begin)
            if start == begin:  # The frame is not complete yet.
                break
            if message is not None:
                messages.append(message)
        else:
            self.skipped += len(self._buffer) - start
            start = len(self._buffer)
        del self._buffer[:start]
        return messages

    def _read(self, begin: int) -> tuple[int, BoardMessage | None]:
        """Where to go on, and the message that begins here; the same place where it is not complete."""
        buffer = self._buffer
        if len(buffer) - begin < _HEADER.size + 1:
            return begin, None
        _, length, sequence = _HEADER.unpack_from(buffer, begin)
        end = begin + AROUND_DATA + length
        is_header = length <= LONGEST and compute_crc8(buffer[begin : begin + 4]) == buffer[begin + 4]
        if is_header and len(buffer) < end:
            return begin, None
        if not is_header or compute_crc16(buffer[begin : end - 2]) != _NUMBER.unpack_from(buffer, end - 2)[0]:
            self.broken += 1
            self.skipped += 1
            return begin + 1, None
        command = _NUMBER.unpack_from(buffer, begin + 5)[0]
        return end, BoardMessage(command, bytes(buffer[begin + BEFORE_DATA : end - 2]), sequence)
