"""Codec of STS servos: recorded frames, both ways, and bytes that nobody sent."""

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.hardware.motors.sts import codec
from spiraltrunk.hardware.motors.turn_count import TurnCount

FEEDBACKS = st.builds(
    codec.Feedback,
    st.integers(0, 4095),
    st.integers(-12288, 12288),
    st.integers(-1000, 1000),
    st.integers(0, 255).map(lambda volts: 0.1 * volts),
    st.integers(0, 150).map(float),
)
PACKETS = st.builds(codec.Packet, st.integers(0, 253), st.integers(0, 0x7F), st.binary(max_size=20))


@pytest.mark.parametrize(("raw", "steps"), [("7002", 624), ("280a", 2600), ("ff06", 1791)])
def test_recorded_positions(raw, steps):
    assert codec.decode_feedback(bytes.fromhex(raw + "000000007a20")).position == steps


@pytest.mark.parametrize(("raw", "speed"), [("b20c", 3250), ("3280", -50), ("0000", 0)])
def test_recorded_speeds(raw, speed):
    assert codec.decode_feedback(bytes.fromhex("0000" + raw + "00007a20")).speed == speed


@pytest.mark.parametrize(("raw", "load"), [("a807", -936), ("1804", -24), ("6000", 96), ("2000", 32)])
def test_recorded_loads(raw, load):
    assert codec.decode_feedback(bytes.fromhex("00000000" + raw + "7a20")).load == load


def test_recorded_voltage():
    feedback = codec.decode_feedback(bytes([0, 0, 0, 0, 0, 0, 122, 32]))
    assert feedback.voltage == pytest.approx(12.2)
    assert feedback.temperature == 32.0


def test_one_turn_below_zero():
    """Recorded: raw 2600 after 10 is -1496 steps, -131.48 deg."""
    count = TurnCount(codec.STEPS, 0.5)
    count.update(0, 0.0)
    assert count.update(10, 0.01) == 10
    steps = count.update(2600, 0.4)
    assert steps == -1496
    assert math.degrees(steps * codec.STEP) == pytest.approx(-131.48, abs=0.005)


@given(FEEDBACKS)
def test_feedback_both_ways(feedback):
    found = codec.decode_feedback(codec.encode_feedback(feedback))
    assert found._replace(voltage=0.0) == feedback._replace(voltage=0.0)
    assert found.voltage == pytest.approx(feedback.voltage)


def test_position_with_a_stored_offset():
    """An offset makes the position negative or larger than a turn: the angle within the turn is the same."""
    for raw, steps in ((0x8000 | 100, 3996), (4096 + 7, 7)):
        assert codec.decode_feedback(struct.pack("<HHHBB", raw, 0, 0, 120, 30)).position == steps


@pytest.mark.parametrize(
    "data",
    [
        b"",
        bytes(7),
        bytes(9),
        struct.pack("<HHHBB", 0, 0, 1001, 120, 30),  # More than the full supply.
        struct.pack("<HHHBB", 0, 0, 1 << 11, 120, 30),  # A bit above the sign.
        struct.pack("<HHHBB", 0, 12289, 0, 120, 30),  # 180 rpm.
        struct.pack("<HHHBB", 0, 0, 0, 120, 151),
    ],
)
def test_feedback_that_is_none_of_a_servo(data):
    assert codec.decode_feedback(data) is None


def test_duty():
    assert codec.encode_duty(1.0) == [0xE8, 0x03]  # 1000
    assert codec.encode_duty(-1.0) == [0xE8, 0x07]
    assert codec.encode_duty(0.0) == [0, 0]
    assert codec.encode_duty(-0.0001) == [0, 0]


def test_ping_of_the_protocol_manual():
    """Feetech's protocol manual: ping of id 1 is FF FF 01 02 01 FB, its answer FF FF 01 02 00 FC."""
    assert codec.encode_packet(codec.Packet(1, 1, b"")) == bytes.fromhex("ffff010201fb")
    assert codec.take_packets(bytearray.fromhex("ffff010200fc")) == [codec.Packet(1, 0, b"")]


@given(st.lists(PACKETS, max_size=5), st.integers(1, 7))
def test_packets_arrive_in_any_pieces(packets, size):
    sent, received, found = b"".join(map(codec.encode_packet, packets)), bytearray(), []
    for start in range(0, len(sent), size):
        received += sent[start : start + size]
        found += codec.take_packets(received)
    assert found == packets
    assert not received


@given(st.binary(max_size=60))
def test_noise_never_crashes_and_hides_no_packet_for_long(noise):
    """Behind noise, a packet is found once the longest packet that the noise can claim to be is full."""
    received = bytearray(noise)
    codec.take_packets(received, longest=8)
    packet = codec.Packet(1, 0, bytes(8))
    found = []
    for _ in range(3):
        received += codec.encode_packet(packet)
        found += codec.take_packets(received, longest=8)
    assert packet in found
    assert len(received) < 14


@given(PACKETS, st.data())
def test_a_changed_byte_is_noticed(packet, data):
    sent = bytearray(codec.encode_packet(packet))
    place = data.draw(st.integers(4, len(sent) - 1))
    sent[place] ^= data.draw(st.integers(1, 255))
    assert packet not in codec.take_packets(sent)


def test_errors_in_words():
    assert codec.describe_errors(0) == ""
    assert codec.describe_errors(4 | 32) == "overheated, overload"
    assert codec.describe_errors(1 | 64) == "supply voltage, unknown fault 0x40"
