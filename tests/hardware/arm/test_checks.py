"""Limits of two arms, thresholds that only fall, and targets that are never clamped."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from arm_bench import HIGH, LIMITS, LOW, SETTINGS, SPEED
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.control.arm_limits import ArmLimits, standstill_margin, velocity_bounds
from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.arm.checks import (
    COLLISION_FORCE,
    COLLISION_TORQUE,
    ArmSettings,
    CollisionThresholds,
    check_lead,
    check_pace,
    compute_travel_time,
    intersect_limits,
    position_range,
    read_target,
)
from spiraltrunk.sim.robot.fr3 import FR3
from spiraltrunk.sim.robot.panda import PANDA

FR3_SETTINGS = ArmSettings(limits=FR3.limits, payload=FR3.payload)
UNKNOWN = ArmLimits(position=None, velocity=None, acceleration=None, jerk=None, torque=None)


def test_intersection_keeps_both():
    panda, fr3 = PANDA.limits, FR3.limits
    both = intersect_limits(panda, fr3)
    for limits in (panda, fr3):
        assert (both.position[0] >= limits.position[0]).all()
        assert (both.position[1] <= limits.position[1]).all()
        for name in ("velocity", "acceleration", "jerk", "torque"):
            assert (getattr(both, name) <= getattr(limits, name)).all()
    assert both.position[0][5] == 0.4398  # Of joint 6 the FR3's lower end and the Panda's upper one.
    assert both.position[1][5] == 3.7525
    assert both.braking is fr3.braking
    assert intersect_limits(UNKNOWN, panda).velocity is panda.velocity


def test_limits_of_another_arm_are_refused():
    six = dataclasses.replace(UNKNOWN, position=(LOW[:6], HIGH[:6]), velocity=SPEED[:6])
    with pytest.raises(DriveError, match="6 and 7 joints"):
        intersect_limits(six, LIMITS)


@pytest.mark.parametrize(
    "limits",
    [
        UNKNOWN,
        dataclasses.replace(LIMITS, velocity=None),
        dataclasses.replace(LIMITS, position=None),
        dataclasses.replace(LIMITS, velocity=0 * SPEED),
        dataclasses.replace(LIMITS, velocity=SPEED * np.inf),
        dataclasses.replace(LIMITS, position=(HIGH, LOW)),
        dataclasses.replace(LIMITS, position=(LOW[:6], HIGH[:6])),
    ],
)
def test_settings_without_limits_to_check_against_are_refused(limits):
    with pytest.raises(DriveError):
        ArmSettings(limits=limits, payload=3.0)


@pytest.mark.parametrize("name", ["period", "position_margin", "lead_time", "feedback_age"])
@pytest.mark.parametrize("value", [math.nan, math.inf, -0.1, 10.0, "0.02", None])
def test_settings_out_of_range_are_refused(name, value):
    with pytest.raises(DriveError, match=f"arm {name} is"):
        ArmSettings(limits=LIMITS, payload=None, **{name: value})


def test_thresholds_are_libfrankas_examples():
    assert CollisionThresholds().torque == (20.0, 20.0, 18.0, 18.0, 16.0, 14.0, 12.0)
    assert CollisionThresholds().force == (20.0, 20.0, 20.0, 25.0, 25.0, 25.0)
    CollisionThresholds(torque=(5.0,) * 7, force=(5.0,) * 6)


@pytest.mark.parametrize(
    "change",
    [
        {"torque": (100.0,) * 7, "force": (100.0,) * 6},
        {"torque": (*COLLISION_TORQUE[:6], 12.001)},
        {"force": (20.001, *COLLISION_FORCE[1:])},
        {"torque": (0.0, *COLLISION_TORQUE[1:])},
        {"torque": (-1.0, *COLLISION_TORQUE[1:])},
        {"torque": (math.nan, *COLLISION_TORQUE[1:])},
        {"force": (math.inf, *COLLISION_FORCE[1:])},
        {"torque": COLLISION_TORQUE[:6]},
    ],
)
def test_thresholds_only_fall(change):
    with pytest.raises(DriveError, match="collision"):
        CollisionThresholds(**change)


@given(st.lists(st.floats(allow_nan=True, allow_infinity=True), min_size=7, max_size=7))
def test_a_target_passes_unchanged_or_not_at_all(numbers):
    target = np.array(numbers)
    low, high = position_range(SETTINGS)
    if (np.isfinite(target) & (low <= target) & (target <= high)).all():
        np.testing.assert_array_equal(read_target(SETTINGS, target), target)
    else:
        with pytest.raises(DriveError, match="arm target"):
            read_target(SETTINGS, target)


def test_margin_is_kept_and_grows_to_the_distance_of_standstill():
    low, high = position_range(SETTINGS)
    np.testing.assert_allclose(low - LOW, 0.01)
    np.testing.assert_allclose(HIGH - high, 0.01)
    low, _ = position_range(FR3_SETTINGS)
    distance = standstill_margin(FR3.limits)
    assert distance.max() > 0.01
    np.testing.assert_allclose(low - FR3.limits.position[0], np.maximum(distance, 0.01))


def test_travel_time_is_that_of_the_slowest_joint():
    step = np.array([0.02, 0, 0, -0.05, 0, 0, 0])
    assert compute_travel_time(SETTINGS, np.zeros(7), step) == pytest.approx(0.05 / 2.175)
    assert compute_travel_time(SETTINGS, step, step) == 0.0


@given(st.integers(0, 6), st.floats(0.01, 0.99), st.floats(-0.02, 0.02))
def test_travel_time_keeps_the_fr3s_position_dependent_speed(joint, share, step):
    low, high = position_range(FR3_SETTINGS)
    target = low + share * (high - low)
    before = target.copy()
    before[joint] -= step
    slowest, fastest = velocity_bounds(FR3.limits, target)
    bound = fastest[joint] if step > 0 else -slowest[joint]
    time = compute_travel_time(FR3_SETTINGS, before, target)
    assert time == pytest.approx(abs(target[joint] - before[joint]) / bound)


def test_an_fr3_near_its_end_may_only_creep_towards_it():
    _, high = position_range(FR3_SETTINGS)
    near, middle = high - 0.001, (FR3.limits.position[0] + FR3.limits.position[1]) / 2
    assert compute_travel_time(FR3_SETTINGS, near - 0.01, near) > 5 * compute_travel_time(
        FR3_SETTINGS, middle - 0.01, middle
    )
    end = FR3.limits.position[1]
    assert compute_travel_time(FR3_SETTINGS, end - 0.01, end) == math.inf


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_broken_measurement_allows_nothing(bad):
    with pytest.raises(DriveError, match="measured"):
        compute_travel_time(SETTINGS, np.full(7, bad), np.zeros(7))
    with pytest.raises(DriveError, match="joint 1"):
        check_lead(SETTINGS, np.zeros(7), np.full(7, bad))
    with pytest.raises(DriveError, match="periods"):
        check_pace(SETTINGS, math.nan, 0.02)


def test_lead_has_a_bound():
    measured = np.zeros(7)
    allowed = 0.15 * SPEED
    check_lead(SETTINGS, allowed, measured)
    over = measured.copy()
    over[6] = allowed[6] * 1.001
    with pytest.raises(DriveError, match=r"joint 7 .* blocks the arm"):
        check_lead(SETTINGS, over, measured)
