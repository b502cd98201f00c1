"""Watches of the cable: slack, slip, tangle, tension, length."""

from __future__ import annotations

import math

import numpy as np
import pytest

from spiraltrunk.hardware.motors.motor_port import MotorState
from spiraltrunk.hardware.safety.cable_watch import (
    SlackState,
    SlipState,
    TangleState,
    compute_shape_weights,
    find_too_far,
    has_moved,
    watch_length,
    watch_slack,
    watch_slip,
    watch_tangle,
    watch_tension,
)
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.reading import CableRange, CableReading

LIMITS = SafetyLimits(slack_part_moved=0.1)
DT = 0.002
MOTOR = MotorState(time=0.0, angle=0.0, speed=0.0, torque=0.0, temperature=30.0)
Point = tuple[float, float, float]
"""Pull [m], tension [N], tension that is wanted [N]."""


def read(pull: float, speed: float, tension: float, wanted: float = 0.0) -> CableReading:
    return CableReading(motor=MOTOR, torque=0.0, pull=pull, speed=speed, tension=tension, tension_wanted=wanted)


# Slack.

RANGE = CableRange(tension_least=1.0, tension_ceiling=60.0, pull_least=-0.05, pull_most=0.2)


def run_slack(points: list[tuple[float, float, float]], *, state: SlackState | None = None) -> tuple[int, float] | None:
    """Pulls [m], lengths told by the others [m] and tensions [N]; period and excess of the fault."""
    state = state or SlackState(load=1.0)
    for number, (pull, told, tension) in enumerate(points):
        state, found = watch_slack(state, (read(pull, 0.0, tension), RANGE), told, DT, LIMITS)
        if found:
            assert found.kind is FaultKind.SLACK
            return number, pull - told
    return None


def wind(speed: float, periods: int, told: float = 0.0, tension: float = 0.0) -> list[tuple[float, float, float]]:
    return [(speed * DT * i, told, tension) for i in range(periods)]


def test_a_cable_that_broke_is_noticed_within_3_mm_and_200_ms():
    number, excess = run_slack(wind(0.028, 500))
    assert excess == pytest.approx(LIMITS.slack_length, abs=1e-4)
    assert number * DT < 0.2


def test_a_loaded_cable_is_not_slack_wherever_it_is():
    assert run_slack(wind(0.1, 2000, tension=0.51)) is None
    assert run_slack(wind(0.1, 2000, tension=0.49)) is not None


def test_a_cable_that_a_trunk_outruns_is_slack_and_no_fault():
    """80 mm at the speed of a slack cable: three seconds without load."""
    assert run_slack(wind(0.028, 1400, told=0.08)) is None
    assert run_slack(wind(-0.028, 1400)) is None


def test_the_allowance_grows_with_what_the_others_moved():
    moved = [(0.05, 0.042, 0.0)] * 200
    assert run_slack(moved, state=SlackState(load=1.0, told=-0.012)) is None
    assert run_slack(moved, state=SlackState(load=1.0, told=0.096)) is None
    assert run_slack(moved, state=SlackState(load=1.0, told=0.032)) is not None
    assert run_slack(moved, state=SlackState(load=1.0, told=0.032, offset=0.0045)) is None


def test_a_moment_without_load_is_no_fault():
    number, _ = run_slack([(0.05, 0.0, 0.0)] * 200)
    assert number * DT == pytest.approx(LIMITS.slack_time + LIMITS.slack_memory * math.log(2), abs=3 * DT)
    assert run_slack(([(0.05, 0.0, 0.0)] * 18 + [(0.05, 0.0, 5.0)] * 20) * 20) is None


def test_the_load_is_a_mean_over_its_memory():
    state, _ = watch_slack(SlackState(load=1.0), (read(0.0, 0.0, 2.0), RANGE), 0.0, DT, LIMITS)
    assert state.load == pytest.approx(1.0 + DT / LIMITS.slack_memory)
    state, _ = watch_slack(SlackState(load=1.0), (read(0.0, 0.0, 2.0), RANGE), 0.0, 1.0, LIMITS)
    assert state.load == 2.0


# Lengths of taut cables.


def run_length(points: list[tuple[float, float, float]]) -> tuple[int, float] | None:
    """Pulls [m], lengths told by the others [m], sums of tension [N], from where all agree; period and excess."""
    state = SlackState()
    for number, (pull, told, tension) in enumerate(points):
        state, found = watch_length(state, (pull, told), tension, DT, LIMITS)
        if found:
            assert found.kind is FaultKind.CABLE_SLIP
            return number, pull - told
    return None


def test_a_step_of_a_taut_cable_against_the_others_is_a_slip():
    assert run_length([(0.0, 0.0, 0.0)] * 100 + [(0.0037, 0.0, 0.0)] * 100) is None
    assert run_length([(0.0, 0.0, 0.0)] * 100 + [(0.0039, 0.0, 0.0)] * 100)[0] == 100
    assert run_length([(0.0, 0.0, 0.0)] * 100 + [(0.0, -0.0039, 0.0)] * 100) is None, "0.39 mm by bending"
    assert run_length([(0.0, 0.0, 0.0)] * 100 + [(0.0, -0.0043, 0.0)] * 100)[0] == 100
    assert run_length([(0.0, 0.0, 0.0)] * 100 + [(-0.01, 0.0, 0.0)] * 100) is None, "shorter is no slip"


def test_a_rise_of_tension_stretches_and_a_fall_excuses_nothing():
    assert run_length([(0.0, 0.0, 20.0)] * 5000 + [(0.0060, 0.0, 43.0)] * 2) is None
    assert run_length([(0.0, 0.0, 20.0)] * 5000 + [(0.0060, 0.0, 41.0)] * 2) is not None
    assert run_length([(0.0, 0.0, 20.0)] * 5000 + [(0.0039, 0.0, 5.0)] * 2) is not None


def test_a_slow_change_is_followed_with_its_time_constant():
    assert run_length([(0.006 * DT * i, 0.0, 0.0) for i in range(5000)]) is None
    assert run_length([(0.009 * DT * i, 0.0, 0.0) for i in range(5000)]) is not None
    state, _ = watch_length(SlackState(), (0.005, 0.002), 10.0, DT, LIMITS)
    share = DT / LIMITS.settle_time
    assert (state.told, state.offset, state.tension) == pytest.approx((0.002 * share, 0.003 * share, 10.0 * share))


def test_a_trunk_that_moves_is_followed_at_once():
    state, found = watch_length(SlackState(load=3.0), (0.02, 0.0061), 10.0, None, LIMITS)
    assert not found
    assert (state.load, state.told, state.offset, state.tension) == pytest.approx((3.0, 0.0061, 0.0139, 10.0))
    state, _ = watch_length(SlackState(), (0.02, 0.003), 10.0, 10.0, LIMITS)
    assert state.told == 0.003


def test_a_trunk_moves_when_one_cable_tells_so():
    states = [SlackState(), SlackState(told=0.01)]
    assert not has_moved(states, [0.0059, 0.0041], LIMITS)
    assert has_moved(states, [0.0061, 0.01], LIMITS)
    assert has_moved(states, [-0.0061, 0.01], LIMITS)
    assert has_moved(states, [0.0, 0.0039], LIMITS)


def test_the_text_of_a_step():
    _, found = watch_length(SlackState(), (0.02, 0.0), 10.0, DT, LIMITS)
    assert found.text == "20.0 mm more than the other cables tell came in under load; allowed: 4.8 mm"


def test_the_text_of_a_slack_cable():
    state = SlackState(load=0.0, elapsed=1.0)
    _, found = watch_slack(state, (read(0.05, 0.0, 0.0), RANGE), 0.04, DT, LIMITS)
    assert found.text == "10.0 mm more than the other cables tell came in with a load of 0.00 N; allowed: 7.0 mm"


def test_three_cables_tell_each_other_exactly_and_two_by_their_sum():
    angles = [0.0, 2 * math.pi / 3, 4 * math.pi / 3]
    weights = compute_shape_weights([(math.cos(a), math.sin(a)) for a in angles])
    assert np.allclose(weights, [[0, -1, -1], [-1, 0, -1], [-1, -1, 0]])
    assert np.allclose(compute_shape_weights([(1.0, 0.0), (-1.0, 0.0)]), [[0, -1], [-1, 0]])
    square = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)]
    for bend in ((0.01, 0.02), (-0.03, 0.01)):
        pulls = [y * bend[0] + z * bend[1] for y, z in square]
        told = [sum(w * pull for w, pull in zip(row, pulls, strict=True)) for row in compute_shape_weights(square)]
        assert told == pytest.approx(pulls)


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


def run_tangle(points: list[Point], drag: float = 0.0) -> int | None:
    state, before = TangleState(), points[0][0]
    for number, (pull, tension, wanted) in enumerate(points):
        state, found = watch_tangle(state, read(pull, (pull - before) / DT, tension, wanted), drag, LIMITS)
        before = pull
        if found:
            assert found.kind is FaultKind.TANGLED_DRUM
            return number
    return None


def pay_out(rise: float, length: float, wanted: float = 5.0) -> list[Point]:
    return [(0.1 - length * i / 100, 5.0 + rise * i / 100, wanted) for i in range(101)]


def test_a_drum_that_tightens_while_it_pays_out_is_tangled():
    number = run_tangle(pay_out(20.0, 0.02))
    assert number in {76, 77}, "15 N more than at the second point"
    assert run_tangle(pay_out(20.0, 0.02), drag=1.0 / 0.1) in {80, 81, 82}, "the drag of 0.1 m/s is 1 N"
    assert run_tangle(pay_out(20.0, 0.02, wanted=0.0)) == number


@pytest.mark.parametrize(
    ("rise", "length", "wanted"), [(15.1, 0.02, 5.0), (20.0, 0.0029, 5.0), (20.0, 0.02, 10.1), (-4.0, 0.02, 5.0)]
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
    _, found = watch_tangle(TangleState(pull=0.05, tension=5.0), read(0.04, -0.1, 31.0, 10.0), 10.0, LIMITS)
    assert found.text == "the tension rose by 20.0 N while 10.0 mm were paid out; allowed: 15 N"
