"""Pulses of the gripper's servo: the map from commands, and limits that nothing exceeds."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.errors import DesignError, DriveError
from spiraltrunk.hardware.clock import SystemClock
from spiraltrunk.hardware.motors.pwm_servo import ServoCalibration, check_pulse, compute_pulse
from spiraltrunk.hardware.twin.servo import RecordingServo

OPEN_WIDE = ServoCalibration(least_us=900, most_us=2100, open_us=1900, slack_us=1500, closed_us=1000)
OPEN_NARROW = ServoCalibration(least_us=900, most_us=2100, open_us=1000, slack_us=1300, closed_us=2000)


@pytest.mark.parametrize(
    ("calibration", "pulses"),
    [(OPEN_WIDE, [1900, 1700, 1500, 1250, 1000]), (OPEN_NARROW, [1000, 1150, 1300, 1650, 2000])],
)
def test_the_map_passes_through_what_was_measured(calibration, pulses):
    assert [compute_pulse(calibration, gripper) for gripper in (-1, -0.5, 0, 0.5, 1)] == pulses


@given(st.sampled_from([OPEN_WIDE, OPEN_NARROW]), st.floats(-1, 1), st.floats(-1, 1))
def test_the_map_is_monotone_and_within_the_limits(calibration, one, other):
    closing = 1 if calibration.closed_us > calibration.open_us else -1
    first, second = (compute_pulse(calibration, gripper) for gripper in sorted((one, other)))
    assert closing * first <= closing * second
    for pulse in (first, second):
        check_pulse(calibration, pulse)


@pytest.mark.parametrize("gripper", [1.01, -1.01, float("nan"), float("inf"), "0", None])
def test_a_command_out_of_range_is_refused(gripper):
    with pytest.raises(DriveError, match="allowed: a finite number from -1 to 1"):
        compute_pulse(OPEN_WIDE, gripper)


@pytest.mark.parametrize(
    "changes",
    [
        {"least_us": 499}, {"most_us": 2501}, {"most_us": 900}, {"open_us": 2101}, {"closed_us": 899},
        {"slack_us": 1900}, {"slack_us": 1000}, {"slack_us": 950}, {"open_us": float("nan")}, {"slack_us": "1500"},
    ],
)  # fmt: skip
def test_a_calibration_beyond_what_a_servo_takes_is_refused(changes):
    values = {"least_us": 900, "most_us": 2100, "open_us": 1900, "slack_us": 1500, "closed_us": 1000} | changes
    with pytest.raises(DesignError, match=r"servo\."):
        ServoCalibration(**values)


def test_a_recording_servo_remembers_changes_alone():
    servo = RecordingServo(SystemClock(), OPEN_WIDE)
    for pulse in (1500, 1500.0, 1800):
        servo.set_pulse(pulse)
    servo.release()
    assert [pulse for _, pulse in servo.changes] == [1500, 1800, None]
    assert servo.pulse_us is None
