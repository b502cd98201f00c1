"""Watches of the cable: slack, slip, tangle, tension, length."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from spiraltrunk.hardware.motors.motor_port import MotorState
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.limits import SafetyLimits, adapt_to_slack_speed
from spiraltrunk.hardware.safety.reading import CableRange, CableReading
from spiraltrunk.hardware.safety.watches.cable_watch import (
    LengthState,
    LoadState,
    SlipState,
    TangleState,
    find_too_far,
    watch_length,
    watch_load,
    watch_slip,
    watch_tangle,
    watch_tension,
    watch_untaken,
)

LIMITS = SafetyLimits()
DT = 0.002
MOTOR = MotorState(time=0.0, angle=0.0, speed=0.0, torque=0.0, temperature=30.0)
Point = tuple[float, float, float]
"""Pull [m], tension [N], tension that is wanted [N]."""


def read(pull: float, speed: float, tension: float, wanted: float = 0.0) -> CableReading:
    return CableReading(motor=MOTOR, torque=0.0, pull=pull, speed=speed, tension=tension, tension_wanted=wanted)


# Load.

RANGE = CableRange(tension_least=1.0, tension_ceiling=60.0, pull_least=-0.05, pull_most=0.2)


def run_load(tensions: list[float], state: LoadState | None = None) -> LoadState:
    state = state or LoadState(load=1.0)
    for tension in tensions:
        state = watch_load(state, read(0.0, 0.0, tension), RANGE.tension_least, DT, LIMITS)
    return state


def test_the_load_is_a_mean_over_its_memory():
    assert run_load([2.0]).load == pytest.approx(1.0 + DT / LIMITS.slack_memory)
    assert watch_load(LoadState(load=1.0), read(0.0, 0.0, 2.0), 1.0, 1.0, LIMITS).load == 2.0


def test_half_of_the_least_tension_is_load():
    assert run_load([0.51] * 500).elapsed == 0.0
    assert run_load([0.5] * 500, LoadState(load=0.5)).elapsed == 0.0
    assert run_load([0.49] * 500).elapsed > 0.5


def test_what_is_load_is_a_part_of_the_least_nominal_one():
    for load, is_loaded in ((2.01, True), (1.99, False)):
        after = watch_load(LoadState(load=load), read(0.0, 0.0, load), 4.0, DT, LIMITS)
        assert (after.elapsed == 0.0) == is_loaded


def test_the_time_without_load_begins_when_the_mean_is_gone_and_ends_with_load():
    late = LIMITS.slack_memory * math.log(2)
    assert run_load([0.0] * 100).elapsed == pytest.approx(0.2 - late, abs=2 * DT)
    assert run_load([0.0] * 100 + [5.0] * 5).elapsed == 0.0
    assert run_load([0.0] * 2, LoadState(load=0.1, elapsed=1.0)).elapsed == pytest.approx(1.0 + 2 * DT)


# Lengths.


def run_length(points: list[tuple[float, float]], *, is_taut: bool = True, state: LengthState | None = None):
    """Excess [m] and sum of tensions [N] of each period; the period of the fault, or None."""
    state = state or LengthState()
    for number, (excess, tension) in enumerate(points):
        state, text = watch_length(state, excess, tension, DT, is_taut=is_taut, limits=LIMITS)
        if text:
            return number
    return None


@pytest.mark.parametrize("is_taut", [True, False])
def test_a_step_of_3_mm_is_a_fault(is_taut):
    still = [(0.0, 10.0)] * 3000
    state = LengthState(tension=10.0)
    assert run_length([*still, *[(0.0029, 10.0)] * 100], is_taut=is_taut, state=state) is None
    assert run_length([*still, *[(0.0031, 10.0)] * 100], is_taut=is_taut, state=state) == 3000
    assert run_length([*still, *[(-0.01, 10.0)] * 100], is_taut=is_taut, state=state) is None, "shorter is no slip"


def test_a_slip_that_is_wound_in_at_the_speed_of_a_slack_cable_is_noticed_in_time():
    slow = [(0.028 * DT * i, 10.0) for i in range(500)]
    for is_taut in (True, False):
        number = run_length(slow, is_taut=is_taut, state=LengthState(tension=10.0))
        assert number * DT < 0.2
        assert slow[number][0] < 0.0037


@pytest.mark.parametrize("change", [20.0, -20.0])
def test_a_change_of_tension_excuses_the_elastic_length_once_more(change):
    """5e-5 m/N over 20 N is 1 mm."""
    state = LengthState(tension=100.0)
    assert run_length([(0.0039, 100.0 + change)] * 2, state=state) is None
    assert run_length([(0.0041, 100.0 + change)] * 2, state=state) == 0


def test_a_slow_change_is_followed_with_its_time_constant():
    assert run_length([(0.0055 * DT * i, 0.0) for i in range(5000)]) is None
    assert run_length([(0.0065 * DT * i, 0.0) for i in range(5000)]) is not None
    state, _ = watch_length(LengthState(), 0.002, 10.0, DT, is_taut=True, limits=LIMITS)
    share = DT / LIMITS.settle_time
    assert (state.excess, state.tension) == pytest.approx((0.002 * share, 10.0 * share))
    state, _ = watch_length(LengthState(), 0.002, 10.0, 1.0, is_taut=True, limits=LIMITS)
    assert (state.excess, state.tension) == (0.002, 10.0)


def test_while_a_cable_is_slack_nothing_is_followed():
    state, _ = watch_length(LengthState(excess=0.002, tension=3.0), -0.03, 9.0, DT, is_taut=False, limits=LIMITS)
    assert state == LengthState(excess=0.002, tension=3.0)
    assert run_length([(0.0005 * DT * i, 0.0) for i in range(5000)], is_taut=False) == pytest.approx(3000, abs=2)


def test_lengths_below_those_of_an_even_bend_are_followed_by_1_mm():
    """A cable that is slack and does not look so must not become a slip when it is wound in."""
    slack = [(-0.02, 0.0)] * 5000
    assert run_length([*slack, (0.0019, 0.0)]) is None
    assert run_length([*slack, (0.0021, 0.0)]) == 5000
    state, _ = watch_length(LengthState(excess=0.005), -0.02, 0.0, 1.0, is_taut=True, limits=LIMITS)
    assert state.excess == -LIMITS.settle_least


@pytest.mark.parametrize("lag", [0.0, 0.012, 0.06])
@pytest.mark.parametrize("speed", [0.0005, 0.007, 0.02])
def test_slack_that_comes_in_slowly_is_noticed_at_3_mm(speed, lag):
    """Whatever the lag with which it is seen."""
    limits, state, length = adapt_to_slack_speed(LIMITS, speed, lag), LengthState(), 0.0
    text = ""
    while not text and length < 0.01:
        length += speed * DT
        seen = max(0.0, length - speed * lag)
        state, text = watch_length(state, seen, 0.0, DT, is_taut=True, limits=limits)
    assert length == pytest.approx(LIMITS.step_length, rel=0.01, abs=2 * speed * DT)


def test_limits_of_winders_that_take_in_slack_fast_stay():
    """A GM6020 takes it in at 28.4 mm/s on the paper's drum."""
    assert adapt_to_slack_speed(LIMITS, 0.0284) is LIMITS
    assert adapt_to_slack_speed(LIMITS, 0.007).settle_time > 3 * LIMITS.settle_time


def test_the_text_of_a_step():
    _, text = watch_length(LengthState(excess=0.001), 0.021, 20.0, DT, is_taut=True, limits=LIMITS)
    assert text == "20.0 mm of cable came in that no bend explains; allowed: 4.0 mm"


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


def test_a_dip_while_the_drum_is_stirred_is_no_slip():
    state = SlipState()
    for pull, tension, wanted in burst(30.0, 25.0, 0.008):
        state, found = watch_slip(state, replace(read(pull, 0.0, tension, wanted), is_stirred=True), DT, LIMITS)
        assert found is None
        assert state == SlipState(tension=tension)


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


def run_tangle(points: list[Point], drag: float = 0.0, friction: float = 0.0) -> int | None:
    state, before = TangleState(), points[0][0]
    allowed = replace(RANGE, drag=drag, friction=friction)
    for number, (pull, tension, wanted) in enumerate(points):
        state, found = watch_tangle(state, read(pull, (pull - before) / DT, tension, wanted), allowed, LIMITS)
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


def test_dry_friction_of_the_drum_is_no_tangle():
    assert run_tangle(pay_out(20.0, 0.02), friction=4.0) is not None
    assert run_tangle(pay_out(20.0, 0.02), friction=6.0) is None


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
    _, found = watch_tangle(
        TangleState(pull=0.05, tension=5.0), read(0.04, -0.1, 31.0, 10.0), replace(RANGE, drag=10.0), LIMITS
    )
    assert found.text == "the tension rose by 20.0 N while 10.0 mm were paid out; allowed: 15 N"


# Slack that no drum takes in.


def run_untaken(excess: float, speeds: list[float]) -> int | None:
    elapsed = 0.0
    for number, speed in enumerate(speeds):
        readings = (read(0.0, 0.0, 1.0), read(0.0, speed, 1.0), read(0.0, -0.05, 1.0))
        elapsed, found = watch_untaken(elapsed, excess, readings, DT, LIMITS)
        if found:
            assert found.kind is FaultKind.STALL
            return number
    return None


def test_slack_that_no_drum_takes_in_is_a_stall():
    number = run_untaken(-0.0101, [0.0] * 1000)
    assert number * DT == pytest.approx(LIMITS.stall_time, abs=2 * DT)
    assert run_untaken(-0.0099, [0.0] * 1000) is None
    assert run_untaken(0.02, [0.0] * 1000) is None, "more than a bend explains is another fault"


def test_the_text_of_slack_that_no_drum_takes_in():
    _, found = watch_untaken(0.499, -0.0123, (read(0.0, 0.0, 1.0),), DT, LIMITS)
    assert found.text == "12 mm of cable are slack, and no drum has wound in for 0.5 s; one is stuck"


def test_slack_that_a_drum_takes_in_now_and_then_is_none():
    assert run_untaken(-0.05, [0.0011] * 1000) is None
    assert run_untaken(-0.05, ([0.0] * 240 + [0.0011]) * 10) is None
    assert run_untaken(-0.05, [0.0009] * 1000) is not None
