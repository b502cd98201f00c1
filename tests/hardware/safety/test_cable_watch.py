"""Watches of the cable: slack, slip, tangle, tension, length."""

from __future__ import annotations

import math

import pytest

from spiraltrunk.hardware.motors.motor_port import MotorState
from spiraltrunk.hardware.safety.cable_watch import (
    SlackState,
    SlipState,
    TangleState,
    find_too_far,
    watch_slack,
    watch_slip,
    watch_tangle,
    watch_tension,
)
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.reading import CableRange, CableReading

LIMITS = SafetyLimits()
DT = 0.002
MOTOR = MotorState(time=0.0, angle=0.0, speed=0.0, torque=0.0, temperature=30.0)
Point = tuple[float, float, float]
"""Pull [m], tension [N], tension that is wanted [N]."""


def read(pull: float, speed: float, tension: float, wanted: float = 0.0) -> CableReading:
    return CableReading(motor=MOTOR, torque=0.0, pull=pull, speed=speed, tension=tension, tension_wanted=wanted)


# Slack.


def run_slack(points: list[tuple[float, float]], *, is_moving: bool = False, was_taut: bool = True) -> int | None:
    """Speeds [m/s] and tensions [N] at a least load of 1 N."""
    state, pull = SlackState(load=1.0, was_taut=was_taut), 0.0
    for number, (speed, tension) in enumerate(points):
        pull += speed * DT
        state, found = watch_slack(state, read(pull, speed, tension), DT, 1.0, LIMITS, is_moving=is_moving)
        if found:
            assert found.kind is FaultKind.SLACK
            return number
    return None


@pytest.mark.parametrize("speed", [-0.2, 0.0, 0.2])
def test_a_loaded_cable_is_not_slack(speed):
    assert run_slack([(speed, 0.6)] * 5000) is None


def test_a_cable_that_comes_in_without_load_is_slack_within_200_ms():
    number = run_slack([(0.02, 0.0)] * 1000)
    assert LIMITS.slack_time <= number * DT < 0.2


def test_a_standing_cable_is_slack_only_once_it_comes_in():
    assert run_slack([(0.0, 0.0)] * 5000) is None
    assert run_slack([(0.0005, 0.0)] * 1400) is None
    assert run_slack([(0.0005, 0.0)] * 1600) is not None


def test_a_cable_that_is_paid_out_is_not_slack():
    assert run_slack([(-0.02, 0.0)] * 5000) is None
    assert run_slack(([(0.02, 0.0)] * 50 + [(-0.001, 0.0)]) * 20) is None


def test_a_moment_without_load_is_no_fault():
    assert run_slack(([(0.02, 0.0)] * 60 + [(0.02, 5.0)] * 20) * 20) is None


def test_a_cable_that_a_moving_trunk_outruns_is_slack_only_after_long():
    number = run_slack([(0.02, 0.0)] * 2000, is_moving=True)
    assert number * DT == pytest.approx(LIMITS.slack_time_moving, abs=0.05)


def test_after_arming_the_slack_is_taken_up_first():
    state, number, found = SlackState(), 0, None
    while not found:
        state, found = watch_slack(state, read(0.0, 0.02, 0.0), DT, 1.0, LIMITS)
        number += 1
    assert number * DT == pytest.approx(LIMITS.take_up_time, abs=0.01)
    state = SlackState()
    for number in range(3000):
        state, found = watch_slack(state, read(0.0, 0.02, 0.0 if number < 1000 else 2.0), DT, 1.0, LIMITS)
        assert not found
    assert state.was_taut


def test_a_cable_that_is_paid_out_before_it_was_taut_goes_on_counting():
    state = SlackState()
    for _ in range(3000):
        state, found = watch_slack(state, read(0.0, -0.02, 0.0), DT, 1.0, LIMITS)
        if found:
            break
    assert found


def test_the_load_is_a_mean_over_its_memory():
    state, _ = watch_slack(SlackState(load=1.0), read(0.0, 0.0, 2.0), DT, 1.0, LIMITS)
    assert state.load == pytest.approx(1.0 + DT / LIMITS.slack_memory)
    state, _ = watch_slack(SlackState(load=1.0), read(0.0, 0.0, 2.0), 1.0, 1.0, LIMITS)
    assert state.load == 2.0


def test_the_length_that_came_in_is_told():
    state = SlackState(was_taut=True)
    for _ in range(200):
        state, found = watch_slack(state, read(0.0, 0.02, 0.0), DT, 1.0, LIMITS)
        if found:
            break
    assert found.text == "2.4 mm came in with a load of 0.00 N; allowed: above 0.50 N"


# Slip.


def run_slip(points: list[Point]) -> int | None:
    state = SlipState()
    for number, (pull, tension, wanted) in enumerate(points):
        state, found = watch_slip(state, read(pull, 0.0, tension, wanted), DT, LIMITS)
        if found:
            assert found.kind is FaultKind.CABLE_SLIP
            return number
    return None


def burst(tension: float, depth: float, length: float, speed: float = 0.1) -> list[Point]:
    """100 periods taut, then a dip by ``depth`` in 10 ms while ``length`` comes in, then taut again."""
    points: list[Point] = [(0.05, tension, tension)] * 100
    periods = max(1, round(length / (speed * DT)))
    for i in range(periods):
        points.append((0.05 + length * (i + 1) / periods, tension - depth * min(1.0, (i + 1) / 5), tension))
    return points + [(0.05 + length, tension, tension)] * 100


def test_a_burst_of_cable_with_a_dip_of_tension_is_a_slip():
    number = run_slip(burst(30.0, 25.0, 0.008))
    assert number is not None
    came_in = burst(30.0, 25.0, 0.008)[number][0] - 0.05
    assert came_in < 0.0045
    assert (number - 100) * DT < 0.2


@pytest.mark.parametrize(
    ("tension", "depth", "length"), [(30.0, 25.0, 0.0028), (30.0, 14.0, 0.008), (5.0, 2.9, 0.008), (30.0, 0.0, 0.008)]
)
def test_too_short_or_too_shallow_a_burst_is_no_slip(tension, depth, length):
    assert run_slip(burst(tension, depth, length)) is None


def test_a_break_is_noticed_like_a_slip():
    points = [(0.05, 30.0, 30.0)] * 100 + [(0.05 + 0.06 * DT * i, 30.0 * math.exp(-i * DT / 0.012), 30.0)
              for i in range(200)]  # fmt: skip
    number = run_slip(points)
    assert (number - 100) * DT < 0.1


def test_a_tension_that_is_let_down_at_the_largest_rate_is_no_slip():
    points = [(0.05 + 0.2 * DT * i, max(1.0, 60.0 - 240.0 * DT * i), max(1.0, 60.0 - 240.0 * DT * i))
              for i in range(500)]  # fmt: skip
    assert run_slip(points) is None


def test_a_swing_of_the_tension_at_2_hz_is_no_slip():
    times = [DT * i for i in range(5000)]
    assert run_slip([(0.05 + 0.01 * math.sin(12 * t), 20 - 18 * math.sin(12 * t), 20.0) for t in times]) is None


def test_a_dip_without_a_burst_ends_after_its_time():
    """Cable that comes in long after the tension fell is no slip."""
    dip = [(0.05, 30.0, 30.0)] * 100 + [(0.05, 2.0, 30.0)] * 100
    assert run_slip(dip + [(0.05 + 0.2 * DT * i, 2.0, 30.0) for i in range(100)]) is None
    dip = [(0.05, 30.0, 30.0)] * 100 + [(0.05, 2.0, 30.0)] * 50
    assert run_slip(dip + [(0.05 + 0.2 * DT * i, 2.0, 30.0) for i in range(100)]) is not None


def test_after_a_dip_the_next_one_is_noticed():
    quiet = [(0.05, 30.0, 30.0)] * 100 + [(0.05, 10.0, 30.0)] * 200 + [(0.05, 30.0, 30.0)] * 20
    assert run_slip(quiet) is None
    assert run_slip(quiet + burst(30.0, 25.0, 0.008)) is not None


def test_cable_that_first_went_out_counts_from_its_least():
    points = [(0.05, 30.0, 30.0)] * 100 + [(0.05 - 0.1 * DT * i, 2.0, 30.0) for i in range(20)]
    assert run_slip([*points, *[(0.046 + 0.1 * DT * i, 2.0, 30.0) for i in range(14)]]) is None
    assert run_slip([*points, *[(0.046 + 0.1 * DT * i, 2.0, 30.0) for i in range(18)]]) is not None


# Tangle.


def run_tangle(points: list[Point]) -> int | None:
    state, before = TangleState(), points[0][0]
    for number, (pull, tension, wanted) in enumerate(points):
        state, found = watch_tangle(state, read(pull, (pull - before) / DT, tension, wanted), LIMITS)
        before = pull
        if found:
            assert found.kind is FaultKind.TANGLED_DRUM
            return number
    return None


def pay_out(rise: float, length: float, wanted: float = 5.0) -> list[Point]:
    return [(0.1 - length * i / 100, 5.0 + rise * i / 100, wanted) for i in range(101)]


def test_a_drum_that_tightens_while_it_pays_out_is_tangled():
    number = run_tangle(pay_out(20.0, 0.02))
    assert number is not None
    assert number <= 53
    assert run_tangle(pay_out(20.0, 0.02, wanted=0.0)) == number


@pytest.mark.parametrize(
    ("rise", "length", "wanted"), [(9.9, 0.02, 5.0), (20.0, 0.0029, 5.0), (20.0, 0.02, 15.1), (-4.0, 0.02, 5.0)]
)
def test_a_drum_that_yields_is_not_tangled(rise, length, wanted):
    assert run_tangle(pay_out(rise, length, wanted)) is None


def test_a_drum_that_winds_in_is_not_tangled():
    assert run_tangle([(0.02 * i / 100, 5.0 + 0.5 * i, 5.0) for i in range(100)]) is None


def test_each_time_of_paying_out_counts_for_itself():
    points: list[Point] = []
    for start in range(10):
        points += [(0.1 - 0.002 * i / 10, 5.0 + 2.0 * start + i * 0.2, 5.0) for i in range(10)]
        points += [(0.1, 5.0 + 2.0 * start, 5.0)]
    assert run_tangle(points) is None


# Tension and length.


def run_tension(tensions: list[float]) -> int | None:
    elapsed = 0.0
    for number, tension in enumerate(tensions):
        elapsed, found = watch_tension(elapsed, read(0.0, 0.0, tension), DT, 60.0, LIMITS)
        if found:
            assert found.kind is FaultKind.OVER_TENSION
            return number
    return None


def test_a_tension_over_its_ceiling_is_a_fault_after_30_ms_or_at_once():
    assert run_tension([69.0] * 1000) is None
    assert run_tension([69.1] * 1000) == pytest.approx(0.03 / DT, abs=1)
    assert run_tension([89.9] * 1000) == pytest.approx(0.03 / DT, abs=1)
    assert run_tension([90.0]) == 0
    assert run_tension([*[80.0] * 13, 60.0] * 20) is None


RANGE = CableRange(tension_least=1.0, tension_ceiling=60.0, pull_least=-0.05, pull_most=0.2)


@pytest.mark.parametrize("pull", [-0.0549, 0.0, 0.2049])
def test_a_length_within_its_range_is_fine(pull):
    assert find_too_far(read(pull, 0.0, 0.0), RANGE, LIMITS) is None


@pytest.mark.parametrize("pull", [-0.0551, 0.2051, math.nan, math.inf])
def test_a_length_beyond_its_range_is_a_fault(pull):
    assert find_too_far(read(pull, 0.0, 0.0), RANGE, LIMITS).kind is FaultKind.LENGTH_LIMIT


def test_texts_say_what_was_measured_in_millimetres():
    found = find_too_far(read(0.25, 0.0, 0.0), RANGE, LIMITS)
    assert found.text == "250.0 mm of cable are wound in; allowed: -50 to 200 mm"
    assert watch_tension(0.0, read(0.0, 0.0, 95.0), DT, 60.0, LIMITS)[1].text == (
        "the tension is 95.0 N; allowed: 60 N"
    )
    _, found = watch_slip(SlipState(tension=30.0, pull=0.05, elapsed=0.01), read(0.054, 0.0, 3.0), DT, LIMITS)
    assert found.text == "4.0 mm came in while the tension fell to 3.0 N; allowed: 3 mm"
    _, found = watch_tangle(TangleState(pull=0.05, tension=5.0), read(0.04, -0.1, 25.0, 10.0), LIMITS)
    assert found.text == "the tension rose by 15.0 N while 10.0 mm were paid out; allowed: 10 N"
