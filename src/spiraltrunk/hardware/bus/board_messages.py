"""Messages between host and board in the board's serial frame. The commands and their layout are ours.

The board's firmware is written to this page; its twin is, too. All numbers are little endian.

- ``SEND_FRAMES`` (host): records of 11 bytes, ``id u16 | length u8 | 8 bytes``, each a CAN frame that the board sends
  on its bus at once, in their order.
- ``RECEIVED_FRAMES`` (board): such records, of what arrived on the bus since the last message, oldest first.
- ``SERVO_PULSE`` (host): ``width u16`` [us] of the servo's pulse at 50 Hz; 0 ends the pulses.

Frames with identifiers from 0x7A0 to 0x7AF are for the board itself, which neither passes them on nor takes them from
its bus: the host's heartbeat 0x7A0 and the board's answer 0x7A1. `spiraltrunk.hardware.safety.watchdog` tells what the
board does when heartbeats stop: it lowers the motors' currents to zero, and takes no command until a person clears it.
The servo keeps its last pulse then.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from enum import IntEnum
from typing import final

from spiraltrunk.hardware.bus.frame_bus import Frame
from spiraltrunk.hardware.bus.frame_queue import LARGEST_ID, LARGEST_LENGTH

_RECORD = struct.Struct("<HB8s")
_PULSE = struct.Struct("<H")


@final
class BoardCommand(IntEnum):
    """Command of each message."""

    SEND_FRAMES = 0x0A01
    RECEIVED_FRAMES = 0x0A02
    SERVO_PULSE = 0x0A03


def encode_frames(frames: Iterable[Frame]) -> bytes:
    """Records of CAN frames."""
    return b"".join(_RECORD.pack(frame.id, len(frame.data), frame.data) for frame in frames)


def decode_frames(data: bytes, time: float) -> list[Frame] | None:
    """CAN frames of records, with the time of their arrival [s]; None where one is no standard frame."""
    if len(data) % _RECORD.size:
        return None
    records = list(_RECORD.iter_unpack(data))
    if any(identifier > LARGEST_ID or length > LARGEST_LENGTH for identifier, length, _ in records):
        return None
    return [Frame(identifier, content[:length], time) for identifier, length, content in records]


def encode_pulse(pulse_us: int) -> bytes:
    """Width of the servo's pulse [us]; 0 for no pulses."""
    return _PULSE.pack(pulse_us)


def decode_pulse(data: bytes) -> int | None:
    """Width of the servo's pulse [us]; None of a message of another length."""
    return _PULSE.unpack(data)[0] if len(data) == _PULSE.size else None
