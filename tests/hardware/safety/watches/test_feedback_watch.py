"""Watches of the feedback: each notices its fault in time, and says nothing of a motor that works."""

from __future__ import annotations

import math
import random

import pytest

from spiraltrunk.hardware.motors.motor_port import MotorDataSheet, MotorState
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.reading import CableReading
from spiraltrunk.hardware.safety.watches.feedback_watch import (
    FrozenState,
    MotionState,
    find_impossible,
    find_stale,
    watch_frozen,
    watch_motion,
    watch_swap,
)

SHEET = MotorDataSheet(
    name="test", torque_max=2.0, speed_max=30.0, torque_step=1e-4, angle_step=1e-3, period=1e-3, silence_max=0.1,
    temperature_derate=70.0, temperature_stop=90.0, rotor_inertia=1e-4, rotor_friction=0.02,
)  # fmt: skip
LIMITS = SafetyLimits()
DT = 0.002


def build(time: float = 0.0, angle: float = 0.0, speed: float = 0.0, torque: float = 0.0, **others) -> MotorState:
    return MotorState(time=time, angle=angle, speed=speed, torque=torque, **{"temperature": 30.0, **others})


def read(motor: MotorState, torque: float = 0.0) -> CableReading:
    return CableReading(motor=motor, torque=torque)


# Stale and impossible.


def test_feedback_is_stale_from_its_age_on():
    assert find_stale(None, 0.0, LIMITS).kind is FaultKind.STALE_FEEDBACK
    assert find_stale(build(time=1.0), 1.049, LIMITS) is None
    found = find_stale(build(time=1.0), 1.0501, LIMITS)
    assert found.kind is FaultKind.STALE_FEEDBACK
    assert found.text == "the feedback is 50.1 ms old; allowed: below 50 ms"
    assert find_stale(build(time=math.nan), 1.0, LIMITS) is not None


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("name", ["time", "angle", "speed", "torque", "temperature", "voltage"])
def test_feedback_that_is_not_finite_is_impossible(name, bad):
    found = find_impossible(build(**{name: bad}), SHEET, LIMITS)
    assert found.kind is FaultKind.IMPLAUSIBLE_FEEDBACK
    assert "not finite" in found.text


@pytest.mark.parametrize(
    ("name", "good", "bad"),
    [("speed", 60.0, 60.1), ("speed", -60.0, -60.1), ("torque", 4.0, 4.01), ("temperature", -40.0, -40.1),
     ("temperature", 150.0, 150.1)],
)  # fmt: skip
def test_feedback_far_beyond_the_data_sheet_is_impossible(name, good, bad):
    assert find_impossible(build(**{name: good}), SHEET, LIMITS) is None
    found = find_impossible(build(**{name: bad}), SHEET, LIMITS)
    assert found.kind is FaultKind.IMPLAUSIBLE_FEEDBACK
    assert name in found.text


def test_a_voltage_may_be_unknown():
    assert find_impossible(build(voltage=None), SHEET, LIMITS) is None
    assert find_impossible(build(voltage=24.0), SHEET, LIMITS) is None


# Frozen.


def freeze(torques: list[float], motors: list[MotorState]) -> int | None:
    state = FrozenState()
    for number, (torque, motor) in enumerate(zip(torques, motors, strict=True)):
        state, found = watch_frozen(state, read(motor, torque), LIMITS)
        if found:
            assert found.kind is FaultKind.FROZEN_FEEDBACK
            return number
    return None


def test_equal_frames_under_a_constant_torque_are_a_motor_that_stands():
    motors = [build(time=i * DT, angle=1.0, torque=0.1) for i in range(5000)]
    assert freeze([0.1 + 0.01 * (i % 2) for i in range(5000)], motors) is None


def test_equal_frames_while_the_torque_changes_are_frozen():
    motors = [build(time=i * DT, angle=1.0, torque=0.1) for i in range(100)]
    assert freeze([0.1] * 50 + [0.131] * 50, motors) == 50 + LIMITS.frozen_frames - 1
    assert freeze([0.131] * 50 + [0.1] * 50, motors) == 50 + LIMITS.frozen_frames - 1
    assert freeze([0.1] * 50 + [0.129] * 50, motors) is None
    assert freeze([0.131] + [0.1] * 99, motors) == LIMITS.frozen_frames, "the torque of the first frame counts"


def test_equal_frames_that_say_that_the_motor_turns_are_frozen():
    motors = [build(time=i * DT, angle=1.0, speed=-0.2) for i in range(100)]
    assert freeze([0.1] * 100, motors) == LIMITS.frozen_frames
    motors = [build(time=i * DT, angle=1.0, speed=0.19) for i in range(100)]
    assert freeze([0.1] * 100, motors) is None


@pytest.mark.parametrize("name", ["angle", "speed", "torque"])
def test_one_changing_value_is_a_live_motor(name):
    motors = [build(time=i * DT, **{name: 0.01 * (i % 2)}) for i in range(200)]
    assert freeze([0.05 * (i // 5 % 2) for i in range(200)], motors) is None


def test_a_motor_that_answers_its_torque_after_a_few_periods_is_alive():
    torques = [0.1 * (i // 50 % 2) for i in range(1000)]
    motors = [build(time=i * DT, torque=torques[max(0, i - 5)]) for i in range(1000)]
    assert freeze(torques, motors) is None


def test_the_same_frame_read_twice_is_not_counted_twice():
    motors = [build(time=0.0, angle=1.0, speed=1.0)] * 100
    assert freeze([0.05 * i for i in range(100)], motors) is None


def listen(n_changed: int, n_frame: int = 80) -> FrozenState:
    """State after a rest without torque, in which so many frames differed from the one before."""
    state = FrozenState()
    for i in range(11 + n_frame):
        motor = build(time=i * DT, angle=1.0, torque=1e-4 * (max(0, min(i, 10 + n_changed) - 10) % 2))
        state, found = watch_frozen(state, read(motor), LIMITS)
        assert found is None
    return state


def hold(state: FrozenState, n_frame: int = 1000) -> int | None:
    """Equal frames of a constant torque up to the fault; None without one."""
    for i in range(n_frame):
        motor = build(time=10.0 + i * DT, angle=1.0, torque=0.3)
        state, found = watch_frozen(state, read(motor, 0.3), LIMITS)
        if found:
            assert found.kind is FaultKind.FROZEN_FEEDBACK
            return i
    return None


def test_equal_frames_of_a_motor_that_fluctuates_at_rest_are_frozen():
    assert hold(listen(n_changed=64)) == LIMITS.frozen_still
    assert hold(listen(n_changed=40)) == LIMITS.frozen_still


def test_equal_frames_of_a_motor_that_is_still_at_rest_are_none():
    assert hold(listen(n_changed=0)) is None
    assert hold(listen(n_changed=39)) is None
    assert hold(listen(n_changed=39, n_frame=39)) is None, "too few to tell"


def test_the_noise_is_counted_only_without_torque_and_after_settling():
    state = listen(n_changed=5)
    assert state.noise[1:] == (80, 5)
    state, _ = watch_frozen(state, read(build(time=9.0, torque=0.2), 0.1), LIMITS)
    assert state.noise == (0, 80, 5)
    for i in range(10):
        state, _ = watch_frozen(state, read(build(time=10.0 + i, torque=0.01 * i)), LIMITS)
    assert state.noise == (10, 80, 5)
    state, _ = watch_frozen(state, read(build(time=30.0, torque=0.5)), LIMITS)
    assert state.noise == (11, 81, 6)


# Motion.


def move(motors: list[MotorState]) -> tuple[int, FaultKind] | None:
    state = MotionState()
    for number, motor in enumerate(motors):
        state, found = watch_motion(state, motor, SHEET, LIMITS)
        if found:
            return number, found.kind
    return None


@pytest.mark.parametrize("speed", [0.0, 0.5, -5.0, 30.0, -30.0])
def test_an_angle_that_follows_the_speed_is_fine(speed):
    assert move([build(time=i * DT, angle=7.0 + speed * i * DT, speed=speed) for i in range(2000)]) is None


def test_a_swing_is_fine():
    times = [i * DT for i in range(5000)]
    motors = [build(time=t, angle=3 * math.sin(9 * t), speed=27 * math.cos(9 * t)) for t in times]
    assert move(motors) is None


def test_a_lost_frame_or_a_frame_read_twice_is_fine():
    motors = [build(time=i * DT, angle=20.0 * i * DT, speed=20.0) for i in range(500)]
    assert move([motors[i - i % 7] for i in range(500)]) is None


def test_an_angle_that_jumps_has_lost_its_count():
    allowed = 0.1 + 1.5 * 30.0 * DT
    for jump, is_lost in ((allowed - 1e-6, False), (allowed + 1e-6, True), (-allowed - 1e-6, True), (math.nan, True)):
        found = move([build(), build(time=DT, angle=jump)])
        assert (found == (1, FaultKind.COUNT_LOST)) == is_lost
    _, found = watch_motion(MotionState(time=0.0), build(time=DT, angle=1.0), SHEET, LIMITS)
    assert found.text == "the angle jumped by 1.00 rad in 2.0 ms; possible: 0.19 rad"
    assert move([build(angle=1.0, is_count_lost=True)]) == (0, FaultKind.COUNT_LOST)


@pytest.mark.parametrize(("turned", "speed"), [(0.0, 20.0), (20.0, 0.0), (10.0, -10.0), (-10.0, 10.0), (0.0, -20.0)])
def test_an_angle_that_does_not_follow_the_speed_is_implausible(turned, speed):
    number, kind = move([build(time=i * DT, angle=turned * i * DT, speed=speed) for i in range(100)])
    assert kind is FaultKind.IMPLAUSIBLE_FEEDBACK
    assert number * DT == pytest.approx(LIMITS.speed_window, abs=1.5 * DT)


def test_the_speed_may_be_filtered_and_offset_by_a_little():
    assert move([build(time=i * DT, angle=14.0 * i * DT, speed=20.0) for i in range(500)]) is None
    assert move([build(time=i * DT, angle=0.0, speed=5.0) for i in range(500)]) is None
    assert move([build(time=i * DT, angle=0.0, speed=13.0) for i in range(500)]) is not None


def test_the_comparison_begins_anew_in_each_window():
    """A difference of 0.2 rad in each of many windows is never a fault."""
    assert move([build(time=i * DT, angle=0.0, speed=4.0) for i in range(5000)]) is None


# Swap.


def swap(reported: list[list[float]], commanded: list[list[float]]) -> tuple[int, int] | None:
    state: tuple[float, ...] = ()
    for number, (m, c) in enumerate(zip(reported, commanded, strict=True)):
        readings = tuple(read(build(torque=a), b) for a, b in zip(m, c, strict=True))
        state, found = watch_swap(state, readings, DT, LIMITS)
        if found:
            assert found[1].kind is FaultKind.IMPLAUSIBLE_FEEDBACK
            assert found[1].text.startswith(f"motors {found[0] + 1} and ")
            return number, found[0]
    return None


@pytest.mark.parametrize("scale", [0.3, 1.0, 3.0])
def test_torques_of_the_right_motors_are_never_swapped(scale):
    random.seed(0)
    commanded = [[random.uniform(-1, 1) for _ in range(3)] for _ in range(2000)]
    assert swap([[scale * one for one in row] for row in commanded], commanded) is None


def test_torques_that_lag_are_not_swapped():
    commanded = [[0.3 + 0.3 * math.sin(5 * DT * i + k) for k in range(3)] for i in range(5000)]
    reported = [commanded[max(0, i - 2)] for i in range(5000)]
    assert swap(reported, commanded) is None


@pytest.mark.parametrize("order", [(1, 0, 2), (0, 2, 1), (2, 1, 0), (1, 2, 0), (2, 0, 1)])
def test_exchanged_feedback_is_noticed(order):
    commanded = [[0.1, 0.3, 0.5]] * 500
    number, motor = swap([[row[i] for i in order] for row in commanded], commanded)
    assert number * DT < 0.1
    assert order[motor] != motor


def test_equal_torques_cannot_tell_and_short_misfits_are_forgotten():
    assert swap([[0.3, 0.3]] * 500, [[0.3, 0.3]] * 500) is None
    right, wrong = [0.1, 0.3], [0.3, 0.1]
    assert swap([wrong if i % 50 < 5 else right for i in range(5000)], [right] * 5000) is None


def test_a_lone_motor_cannot_be_exchanged():
    assert swap([[0.5]] * 100, [[0.1]] * 100) is None
