"""Frames of the GM6020: bytes written by hand, laws both ways, identifiers, and limits."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.motors import gm6020
from spiraltrunk.hardware.motors.gm6020 import GM6020, CommandMode, Feedback

FEEDBACKS = st.builds(
    Feedback, st.integers(0, 8191), st.integers(-960, 960), st.integers(-32768, 32767), st.integers(0, 150)
)


@pytest.mark.parametrize(
    ("values", "mode", "frame"),
    [
        ((0, 0, 0, 0), CommandMode.CURRENT, "0000000000000000"),
        ((16384, -16384, 1, -1), CommandMode.CURRENT, "4000c0000001ffff"),
        ((258, 0, 0, -2), CommandMode.CURRENT, "010200000000fffe"),
        ((25000, -25000, 0, 0), CommandMode.VOLTAGE, "61a89e5800000000"),
    ],
)
def test_golden_commands(values, mode, frame):
    assert gm6020.encode_command(values, mode).hex() == frame
    assert gm6020.decode_command(bytes.fromhex(frame)) == values


@pytest.mark.parametrize(
    ("frame", "feedback"),
    [
        ("0000000000000000", Feedback(0, 0, 0, 0)),
        ("1fff0140400019ff", Feedback(8191, 320, 16384, 25)),
        ("1000fec0c0004100", Feedback(4096, -320, -16384, 65)),
    ],
)
def test_golden_feedback(frame, feedback):
    """The last byte is reserved: whatever it holds is ignored."""
    assert gm6020.decode_feedback(bytes.fromhex(frame)) == feedback
    assert gm6020.encode_feedback(feedback) == bytes.fromhex(frame)[:7] + b"\0"


@pytest.mark.parametrize(
    "frame", ["2000000000000000", "ffff000000000000", "000003c100000000", "0000fc3f00000000", "0000000000009700"]
)
def test_what_no_working_motor_tells_is_no_feedback(frame):
    """An angle of 8192 or more, 961 rpm in either sense, 151 degC."""
    assert gm6020.decode_feedback(bytes.fromhex(frame)) is None


@given(FEEDBACKS)
def test_feedback_is_read_as_it_was_sent(feedback):
    assert gm6020.decode_feedback(gm6020.encode_feedback(feedback)) == feedback


@given(st.binary(min_size=8, max_size=8))
def test_any_content_is_refused_or_sent_back_the_same(data):
    feedback = gm6020.decode_feedback(data)
    if feedback is not None:
        assert gm6020.encode_feedback(feedback)[:7] == data[:7]


@given(st.tuples(*[st.integers(-16384, 16384)] * 4), st.sampled_from(CommandMode))
def test_a_command_is_read_as_it_was_sent(values, mode):
    assert gm6020.decode_command(gm6020.encode_command(values, mode)) == values


@given(st.binary(max_size=12).filter(lambda data: len(data) != 8))
def test_a_command_of_another_length_is_none(data):
    assert gm6020.decode_command(data) is None


@pytest.mark.parametrize("values", [(16385, 0, 0, 0), (0, 0, 0, -16385), (0, 0, 0), (0.5, 0, 0, 0), (True, 0, 0, 0)])
def test_a_command_beyond_its_limit_is_refused_and_not_clamped(values):
    with pytest.raises(DriveError, match="allowed: 4 whole numbers from -16384 to 16384"):
        gm6020.encode_command(values, CommandMode.CURRENT)


def test_identifiers_of_every_motor():
    """Commands of motors 1 to 4 and 5 to 7 share a frame each; every motor answers under its own identifier."""
    ids = range(1, 8)
    assert [gm6020.compute_command_id(i, CommandMode.CURRENT) for i in ids] == [0x1FE] * 4 + [0x2FE] * 3
    assert [gm6020.compute_command_id(i, CommandMode.VOLTAGE) for i in ids] == [0x1FF] * 4 + [0x2FF] * 3
    assert [gm6020.compute_slot(i) for i in ids] == [0, 1, 2, 3, 0, 1, 2]
    assert [gm6020.compute_feedback_id(i) for i in ids] == [0x205, 0x206, 0x207, 0x208, 0x209, 0x20A, 0x20B]


@pytest.mark.parametrize("ids", [(), (0,), (8,), (-1, 1), (1, 1), (1, 2, 1), (1.0,), ("1",), (True,)])
def test_ids_out_of_range_or_alike_are_refused(ids):
    with pytest.raises(DriveError, match="allowed: "):
        gm6020.check_motor_ids(ids)


def test_the_data_sheet_is_what_its_sources_say():
    assert GM6020.torque_max == pytest.approx(2.223)
    assert GM6020.speed_max == pytest.approx(320 * 2 * math.pi / 60)
    assert GM6020.silence_max == pytest.approx(0.09375)
    assert GM6020.silence_max * GM6020.speed_max == pytest.approx(math.pi)
    assert round(GM6020.torque_max / GM6020.torque_step) == 16384
    assert 2 * math.pi / GM6020.angle_step == pytest.approx(8192)


def test_three_motors_take_half_of_the_bus():
    """A frame with 8 bytes takes 111 bits and at most 24 stuffed ones (ISO 11898-1); a tick has four frames."""
    assert 0.44 <= 4 * 111 / 1e6 / GM6020.period <= 4 * 135 / 1e6 / GM6020.period <= 0.54
