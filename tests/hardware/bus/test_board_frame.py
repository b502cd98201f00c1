"""Serial frames of the board: bytes written by hand, and messages that are found again after garbage."""

from __future__ import annotations

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.bus import board_messages
from spiraltrunk.hardware.bus.board_frame import AROUND_DATA, LONGEST, BoardMessage, MessageParser, encode_message
from spiraltrunk.hardware.bus.board_messages import BoardCommand
from spiraltrunk.hardware.bus.crc import CRC8_POLYNOMIAL, CRC16_POLYNOMIAL, _build_table, compute_crc8, compute_crc16
from spiraltrunk.hardware.bus.frame_bus import Frame

MESSAGES = st.builds(BoardMessage, st.integers(0, 0xFFFF), st.binary(max_size=LONGEST), st.integers(0, 255))


def test_checksums_are_those_of_public_tables():
    """First and last entries of the tables in public RoboMaster firmware, and published check values."""
    crc8, crc16 = _build_table(CRC8_POLYNOMIAL), _build_table(CRC16_POLYNOMIAL)
    assert (crc8[:4], crc8[-4:]) == ((0x00, 0x5E, 0xBC, 0xE2), (0xD7, 0x89, 0x6B, 0x35))
    assert (crc16[:3], crc16[-4:]) == ((0x0000, 0x1189, 0x2312), (0x3DE3, 0x2C6A, 0x1EF1, 0x0F78))
    assert compute_crc16(b"123456789") == 0x6F91  # CRC-16/MCRF4XX.
    assert compute_crc8(bytes([0xFF])) == 0x00  # Its register is emptied by its own start.


@pytest.mark.parametrize(
    ("message", "frame"),
    [
        (BoardMessage(0x0A03, b"\xdc\x05", 7), "a50200070f030adc052d85"),
        (BoardMessage(0x0A04, bytes.fromhex("32001e000101"), 1), "a50600014c040a32001e0001011488"),
        (
            BoardMessage(0x0A01, bytes.fromhex("fe01084000c00000010000"), 255),
            "a50b00ff37010afe01084000c000000100006605",
        ),
    ],
)
def test_golden_frames(message, frame):
    """Checksums by another, bitwise implementation. Their parameters are unconfirmed: these frames change with them."""
    assert encode_message(message).hex() == frame
    assert MessageParser().feed(bytes.fromhex(frame)) == [message]


def test_golden_contents():
    frames = [Frame(0x1FE, bytes.fromhex("4000c00000010000")), Frame(0x205, b"\x01")]
    data = bytes.fromhex("fe01084000c000000100000502010100000000000000")
    assert board_messages.encode_frames(frames) == data
    assert board_messages.decode_frames(data, 0.0) == frames
    assert board_messages.encode_pulse(1500) == bytes.fromhex("dc05")
    assert board_messages.decode_pulse(bytes.fromhex("dc05")) == 1500


@pytest.mark.parametrize("data", ["00", "000800" * 5, "000800" + "00" * 8, "050209" + "00" * 8])
def test_records_that_are_no_standard_frames_are_refused_together(data):
    sound = board_messages.encode_frames([Frame(0x205, bytes(8))])
    assert board_messages.decode_frames(sound + bytes.fromhex(data), 0.0) is None


@pytest.mark.parametrize("data", [b"", b"\0", bytes(3)])
def test_a_pulse_of_another_length_is_none(data):
    assert board_messages.decode_pulse(data) is None


@given(st.lists(MESSAGES, max_size=5), st.integers(1, 40))
def test_messages_are_found_however_the_stream_is_cut(messages, size):
    stream = b"".join(map(encode_message, messages))
    parser = MessageParser()
    found = [message for i in range(0, len(stream), size) for message in parser.feed(stream[i : i + size])]
    assert found == messages
    assert (parser.skipped, parser.broken) == (0, 0)


@given(st.lists(st.sampled_from([0xA5, 0, 2, 255]) | st.integers(0, 255), max_size=100).map(bytes), MESSAGES)
@example(b"\xa5", BoardMessage(0x0A03, b"\xdc\x05", 7))
@example(b"\0\xa5\xa5\xa5", BoardMessage(0x0A03, b"\xdc\x05", 7))
def test_after_garbage_the_next_messages_are_found(garbage, message):
    """Garbage may begin as a frame, and then hides what follows until the longest frame would have ended."""
    stream = garbage + encode_message(message) * 3 + bytes(LONGEST + AROUND_DATA)
    assert MessageParser().feed(stream).count(message) == 3


def test_a_header_with_a_wrong_checksum_is_not_believed_though_the_frames_own_is_right():
    frame = bytearray(encode_message(BoardMessage(0x0A03, b"\xdc\x05", 7))[:-2])
    frame[4] ^= 1
    frame += compute_crc16(frame).to_bytes(2, "little")
    assert MessageParser().feed(bytes(frame)) == []


def test_a_length_that_no_message_has_is_not_waited_for():
    header = b"\xa5" + (LONGEST + 1).to_bytes(2, "little") + b"\0"
    message = BoardMessage(0x0A03, b"\xdc\x05", 7)
    assert MessageParser().feed(header + bytes([compute_crc8(header)]) + encode_message(message)) == [message]


@given(MESSAGES, st.integers(0), st.integers(1, 255))
def test_a_changed_byte_is_noticed(message, place, change):
    frame = bytearray(encode_message(message))
    frame[place % len(frame)] ^= change
    found = MessageParser().feed(bytes(frame) + bytes(LONGEST + AROUND_DATA))
    assert message not in found


@given(st.lists(st.binary(max_size=400), max_size=10))
def test_any_stream_is_read_and_little_of_it_is_kept(pieces):
    parser = MessageParser()
    for piece in pieces:
        parser.feed(piece)
        assert len(parser._buffer) <= LONGEST + AROUND_DATA


def test_a_message_that_is_too_long_is_refused():
    with pytest.raises(DriveError, match="257 bytes; allowed: up to 256"):
        encode_message(BoardMessage(BoardCommand.SEND_FRAMES, bytes(257)))
