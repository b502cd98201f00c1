"""What host and board say to each other in the board's serial frame. The commands and their layout are ours.

The board's firmware is written to this page; its twin is, too. All numbers are little endian.

- ``SEND_FRAMES`` (host): records of 11 bytes, ``id u16 | length u8 | 8 bytes``, each a CAN frame that the board sends
  on its bus at once, in their order.
- ``RECEIVED_FRAMES`` (board): such records, of what arrived on the bus since the last message, oldest first.
- ``SERVO_PULSE`` (host): ``width u16`` [us] of the servo's pulse at 50 Hz; 0 ends the pulses.
- ``HEARTBEAT`` (host): ``timeout u16 [ms] | ramp u16 [ms] | flags u8 | number u8``. The first one starts the board's
  watchdog. After ``timeout`` without a heartbeat that is whole, the board lowers the last current command of every
  motor linearly to zero within ``ramp``, goes on sending zeros, and ignores ``SEND_FRAMES`` until a heartbeat has flag
  1 set ("clear"), which only a person's re-arming sets. The servo keeps its last pulse.
- ``WATCHDOG_STATE`` (board): the same layout, at least every 100 ms: timeout and ramp in force, flag 1 where the
  watchdog has tripped, number of the last heartbeat.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from enum import IntEnum
from typing import NamedTuple, final

from spiraltrunk.hardware.bus.frame_bus import Frame
from spiraltrunk.hardware.bus.frame_queue import LARGEST_ID, LARGEST_LENGTH

_RECORD = struct.Struct("<HB8s")
_PULSE = struct.Struct("<H")
_BEAT = struct.Struct("<HHBB")


@final
class BoardCommand(IntEnum):
    """Command of each message."""

    SEND_FRAMES = 0x0A01
    RECEIVED_FRAMES = 0x0A02
    SERVO_PULSE = 0x0A03
    HEARTBEAT = 0x0A04
    WATCHDOG_STATE = 0x0A05


@final
class Beat(NamedTuple):
    """Content of a heartbeat, and of the watchdog's state."""

    timeout_ms: int
    """Longest silence of the host [ms]."""
    ramp_ms: int
    """Time in which the motors' currents are lowered to zero [ms]."""
    is_flagged: bool
    """In a heartbeat: clear the watchdog. In its state: it has tripped."""
    number: int
    """Number of the heartbeat modulo 256."""


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


def encode_beat(beat: Beat) -> bytes:
    """Content of a heartbeat or of the watchdog's state."""
    return _BEAT.pack(beat.timeout_ms, beat.ramp_ms, beat.is_flagged, beat.number)


def decode_beat(data: bytes) -> Beat | None:
    """Heartbeat or state of the watchdog; None where the length is another or an unknown flag is set."""
    if len(data) != _BEAT.size:
        return None
    timeout_ms, ramp_ms, flags, number = _BEAT.unpack(data)
    return Beat(timeout_ms, ramp_ms, bool(flags), number) if flags <= 1 else None
