"""The ramp to zero torque: bounded in rate, never larger, never of the other sign, over in time."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.hardware.safety.reaction import LET_GO_TIME, RAMP_TIME, Ramp, is_over, ramp_torques

torques = st.floats(-3.0, 3.0)


@given(torques, st.floats(0.0, 0.1), st.floats(0.0, 0.06), st.floats(0.0, 0.06))
def test_a_ramp_falls_in_size_and_keeps_its_sign(torque, floor, earlier, more):
    ramp = Ramp(start=5.0, torques=(torque,), floors=(floor,))
    (first,), (then,) = ramp_torques(ramp, 5.0 + earlier), ramp_torques(ramp, 5.0 + earlier + more)
    assert abs(then) <= abs(first) <= abs(torque)
    assert first * torque >= 0.0


def test_a_ramp_goes_from_the_last_torque_to_the_floor_and_then_to_zero():
    ramp = Ramp(start=5.0, torques=(0.6, 0.01, -0.2, 0.0), floors=(0.02,) * 4)
    assert ramp_torques(ramp, 5.0) == pytest.approx((0.6, 0.01, -0.2, 0.0))
    assert ramp_torques(ramp, 5.0 + RAMP_TIME / 4) == pytest.approx((0.455, 0.01, -0.15, 0.0))
    assert ramp_torques(ramp, 5.0 + 0.999 * RAMP_TIME) == pytest.approx((0.02, 0.01, 0.0, 0.0), abs=1e-3)
    assert ramp_torques(ramp, 5.0 + RAMP_TIME + 1e-9) == (0.0,) * 4
    assert ramp_torques(ramp, 1e6) == (0.0,) * 4


def test_a_time_before_the_start_does_not_raise_the_torque():
    ramp = Ramp(start=5.0, torques=(0.6,), floors=(0.02,))
    assert ramp_torques(ramp, 4.0) == pytest.approx((0.6,))


def test_a_ramp_is_over_after_its_time_and_within_60_ms():
    ramp = Ramp(start=5.0, torques=(0.6,), floors=(0.02,))
    assert not is_over(ramp, 5.0)
    assert not is_over(ramp, 5.0 + 0.999 * RAMP_TIME)
    assert is_over(ramp, 5.0 + RAMP_TIME + 1e-9)
    assert RAMP_TIME <= 0.060
    assert not is_over(Ramp(start=5.0, duration=LET_GO_TIME, torques=(), floors=()), 5.0 + 0.9 * LET_GO_TIME)


def test_the_rate_is_what_the_documentation_says():
    """From 60 N to 2 N on a drum of 10 mm."""
    ramp = Ramp(start=0.0, torques=(0.6,), floors=(0.02,))
    (early,), (late,) = ramp_torques(ramp, 0.010), ramp_torques(ramp, 0.011)
    assert (early - late) / 0.001 / 0.010 == pytest.approx(1450.0)
