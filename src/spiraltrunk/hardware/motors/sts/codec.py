"""Numbers of Feetech's STS servos: registers, signed values, packets, feedback and duty cycle. No I/O.

A packet is ``FF FF id length instruction|error parameters... checksum`` with ``length = parameters + 2`` and
``checksum = ~(sum of the bytes from id on) mod 256``; values are little endian. Addresses are those of Feetech's
library SMS_STS.h and of its memory table; the layout of the feedback was checked against recorded frames of public
robots.
"""

from __future__ import annotations

import math
import struct
from typing import NamedTuple, final

STEPS = 4096
"""Steps of the encoder in one turn of the output [-]."""
STEP = 2.0 * math.pi / STEPS
"""One step [rad]."""
SPEED_SIGN = 15
"""Bit of the sign in position and speed."""
LOAD_SIGN = 10
"""Bit of the sign in load and duty cycle."""
DUTY_MAX = 1000
"""Duty cycle of the full supply voltage [0.1 %]."""
SPEED_PLAUSIBLE = 3 * STEPS
"""Speed above which feedback is not believed [steps/s] (ours): four times that of an STS3215."""
TEMPERATURE_PLAUSIBLE = 150
"""Temperature above which feedback is not believed [degC] (ours)."""
BROADCAST = 0xFE
"""Id of every servo at once."""
ID_MAX = 252
"""Largest id of a servo in the SDK."""

MODE = 33
"""Register of the operating mode, 1 byte."""
MODE_PWM = 2
"""Mode in which the goal is a duty cycle: no loop runs in the servo."""
TORQUE_ENABLE = 40
"""Register that switches the motor on, 1 byte."""
GOAL_DUTY = 44
"""Register of the duty cycle in the mode of duty cycles, 2 bytes; in other modes it is a time."""
LOCK = 55
"""Register that keeps written settings from the permanent memory while it is 1, 1 byte."""
FEEDBACK = 56
"""First register of the feedback: position, speed, load (2 bytes each), voltage, temperature (1 byte each)."""
FEEDBACK_SIZE = 8
"""Size of the feedback [bytes]."""
FEEDBACK_SIZE_MOST = 15
"""Most bytes that are asked for from `FEEDBACK` on [bytes]: up to the current, as Feetech's library SMS_STS reads."""

ERRORS = {1: "supply voltage", 2: "angle sensor", 4: "overheated", 8: "over-current", 32: "overload"}
"""Faults that a servo reports with each answer, by bit."""

_FEEDBACK = struct.Struct("<HHHBB")
_HEADER = b"\xff\xff"


@final
class Packet(NamedTuple):
    """One packet."""

    servo_id: int
    """Id of the servo on the bus; not the index of the motor."""
    code: int
    """Instruction in a request, error bits in an answer."""
    data: bytes
    """Parameters."""


@final
class Feedback(NamedTuple):
    """Decoded feedback of one servo, in the servo's own direction."""

    position: int
    """Position within a turn, 0 to 4095 [steps]."""
    speed: int
    """Speed [steps/s]."""
    load: int
    """Duty cycle at which the servo drives its motor, by its own statement in 0.1 % of the stall torque."""
    voltage: float
    """Supply voltage [V]."""
    temperature: float
    """Temperature [degC]."""


def decode_signed(value: int, sign: int) -> int:
    """Number of which bit ``sign`` is the sign and the bits below it are the magnitude."""
    magnitude = value & ((1 << sign) - 1)
    return -magnitude if value >> sign & 1 else magnitude


def encode_signed(number: int, sign: int) -> int:
    """Inverse of `decode_signed`; the magnitude fits below the sign."""
    return -number | 1 << sign if number < 0 else number


def decode_feedback(data: bytes) -> Feedback | None:
    """Feedback in 8 bytes from register 56; None where they cannot come from a working servo.

    The position is taken modulo one turn: an offset stored in the servo makes it negative or larger than one turn.
    """
    if len(data) != FEEDBACK_SIZE:
        return None
    raw_position, raw_speed, raw_load, voltage, temperature = _FEEDBACK.unpack(data)
    speed, load = decode_signed(raw_speed, SPEED_SIGN), decode_signed(raw_load, LOAD_SIGN)
    if raw_load >> (LOAD_SIGN + 1) or abs(load) > DUTY_MAX:
        return None
    if abs(speed) > SPEED_PLAUSIBLE or temperature > TEMPERATURE_PLAUSIBLE:
        return None
    return Feedback(decode_signed(raw_position, SPEED_SIGN) % STEPS, speed, load, 0.1 * voltage, float(temperature))


def encode_feedback(feedback: Feedback) -> bytes:
    """Inverse of `decode_feedback`, as the twin answers it."""
    return _FEEDBACK.pack(
        encode_signed(feedback.position, SPEED_SIGN),
        encode_signed(feedback.speed, SPEED_SIGN),
        encode_signed(feedback.load, LOAD_SIGN),
        round(10.0 * feedback.voltage),
        round(feedback.temperature),
    )


def encode_duty(duty: float) -> list[int]:
    """Duty cycle from -1 to 1 as two bytes, rounded to 0.1 %."""
    return list(encode_signed(round(DUTY_MAX * duty), LOAD_SIGN).to_bytes(2, "little"))


def compute_checksum(body: bytes | bytearray) -> int:
    """Checksum of a packet's bytes from the id to the last parameter."""
    return ~sum(body) & 0xFF


def encode_packet(packet: Packet) -> bytes:
    """Bytes of a packet."""
    body = bytes([packet.servo_id, len(packet.data) + 2, packet.code]) + packet.data
    return _HEADER + body + bytes([compute_checksum(body)])


def take_packets(received: bytearray, longest: int = 250) -> list[Packet]:
    """Remove the whole packets from the front of what was received, and return them.

    Bytes that belong to none are dropped; a packet that is not whole yet stays. One whose checksum is wrong costs its
    first byte only, so that the packet behind it is found.

    Args:
        received: bytes in their order; changed.
        longest: largest number of parameters that is believed [bytes].
    """
    packets: list[Packet] = []
    while (start := received.find(_HEADER)) >= 0:
        del received[:start]
        if len(received) < 4:
            return packets
        servo_id, length = received[2], received[3]
        if servo_id > BROADCAST or not 2 <= length <= longest + 2:
            del received[0]
        elif len(received) < length + 4:
            return packets
        elif compute_checksum(received[2 : length + 3]) != received[length + 3]:
            del received[0]
        else:
            packets.append(Packet(servo_id, received[4], bytes(received[5 : length + 3])))
            del received[: length + 4]
    del received[: max(0, len(received) - 1)]  # The last byte may begin a header.
    return packets


def describe_errors(bits: int) -> str:
    """Faults of a servo in words, empty where there is none; bits that `ERRORS` does not list are told as a number."""
    unknown = bits & ~sum(ERRORS)
    texts = [text for bit, text in ERRORS.items() if bits & bit]
    return ", ".join([*texts, f"unknown fault {unknown:#04x}"] if unknown else texts)
