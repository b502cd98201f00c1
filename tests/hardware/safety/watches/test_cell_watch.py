"""Watches of the load cells: stuck, against the motor, pushing, and a zero that is none."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.hardware.motors.motor_port import MotorState
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.reading import CableRange, CableReading
from spiraltrunk.hardware.safety.watches.cell_watch import (
    CellState,
    ClaimState,
    StillState,
    find_silent_cell,
    find_untrue_zero,
    watch_cell,
    watch_claim,
    watch_still,
)

LIMITS = SafetyLimits()
DT, FRICTION = 0.01, 2.0
MOTOR = MotorState(time=0.0, angle=0.0, speed=0.0, torque=0.0, temperature=30.0)


def follow(felt, resistance, seconds=1.0, *, is_homed=True, is_loss_most=False):
    """Time until something is found [s], and what; infinity for nothing."""
    reading = CableReading(
        motor=MOTOR, torque=0.0, tension=felt or 0.0, felt=felt, resistance=resistance, is_loss_most=is_loss_most
    )
    state, elapsed = CellState(), 0.0
    while elapsed < seconds - 1e-9:
        elapsed += DT
        state, found = watch_cell(state, reading, FRICTION, DT, LIMITS, is_homed=is_homed)
        if found is not None:
            assert found.kind is FaultKind.LOAD_CELL
            return elapsed, found.text
    return math.inf, ""


@pytest.mark.parametrize(("felt", "apart"), [(0.0, 8.0), (40.0, 16.0), (40.0, -16.0), (0.0, -8.0)])
def test_what_friction_explains_is_no_fault_and_more_is(felt, apart):
    """1.5 times 2 N of friction, 3 N, and a quarter of the larger one: 6 N + 0.25 * max(|T|, |R|)."""
    bound = 6.0 + 0.25 * max(felt, abs(felt + apart))
    sign = math.copysign(1.0, apart)
    assert abs(apart) <= bound or felt == 0.0
    edge = 6.0 + 0.25 * felt if sign < 0 and felt > 0 else (6.0 + 0.25 * felt) / 0.75
    assert follow(felt, felt + sign * 0.99 * edge)[0] == math.inf
    time, text = follow(felt, felt + sign * 1.01 * edge)
    assert time == pytest.approx(LIMITS.cell_time, abs=DT)
    assert f"its load cell tells {felt:.1f} N, its motor {felt + sign * 1.01 * edge:.1f} N with friction" in text


def test_a_cable_that_pushes_is_a_fault_while_homing_too():
    for is_homed in (True, False):
        assert follow(-2.9, 0.0, is_homed=is_homed)[0] == math.inf
        time, text = follow(-3.1, 0.0, is_homed=is_homed)
        assert time == pytest.approx(LIMITS.cell_time, abs=DT)
        assert text == "its load cell tells -3.1 N; allowed: at least -3 N"
    assert follow(0.0, 50.0, is_homed=False)[0] == math.inf


def test_a_loss_that_no_friction_explains_is_a_fault():
    time, text = follow(0.0, 5.0, is_loss_most=True)
    assert time == pytest.approx(LIMITS.cell_beyond, abs=DT)
    assert "friction explains no such difference; allowed: for 0.5 s" in text
    assert follow(0.0, 5.0)[0] == math.inf


def test_the_time_begins_anew_when_they_agree():
    state = CellState()
    for i in range(100):
        apart = CableReading(motor=MOTOR, torque=0.0, felt=0.0, resistance=0.0 if i % 15 == 0 else 50.0)
        state, found = watch_cell(state, apart, FRICTION, DT, LIMITS)
        assert found is None


def test_a_cable_without_a_cell_is_left_alone():
    assert follow(None, 1e3) == (math.inf, "")


def test_a_silent_cell_is_told_with_its_limit():
    assert find_silent_cell(0.05).text == "no plausible reading of its load cell for 50 ms"


def test_a_reading_that_does_not_change_is_stuck():
    state, found_at = StillState(), None
    for i in range(100):
        state, found = watch_still(state, 12.34, 3.0 + 0.01 * i, LIMITS)
        if found is not None and found_at is None:
            found_at = 0.01 * i
            assert found.text == "its load cell has told 12.34 N without any change for 0.5 s; allowed: 0.5 s"
    assert found_at == pytest.approx(LIMITS.cell_still, abs=0.0101)
    assert watch_still(state, 12.35, 4.0, LIMITS)[1] is None


@given(st.lists(st.floats(-50.0, 50.0), min_size=2, max_size=50))
def test_a_reading_that_changes_within_the_time_is_not_stuck(tensions):
    state = StillState()
    for i, tension in enumerate(tensions):
        for j in range(2):
            value = tension + 1e-3 * ((2 * i + j) % 2)
            state, found = watch_still(state, value, 0.4 * (2 * i + j), LIMITS)
            assert found is None or value == state.tension
        assert state.since >= 0.4 * 2 * i - 0.8


def test_without_torque_friction_alone_holds_a_cable():
    assert find_untrue_zero(None, FRICTION, LIMITS) == ""
    assert find_untrue_zero(7.9, FRICTION, LIMITS) == ""
    assert find_untrue_zero(-3.0, FRICTION, LIMITS) == ""
    for felt in (8.1, -3.1, 60.0):
        text = find_untrue_zero(felt, FRICTION, LIMITS)
        assert text.startswith(f"its load cell tells {felt:.1f} N without torque; allowed: -3 to ")
        assert text.endswith("measure its zero and its sense")


RANGE = CableRange(tension_least=1.0, tension_ceiling=60.0, pull_least=-0.1, pull_most=0.2, friction=FRICTION)


def claim(slack, *, speed=0.01, felt=0.0, resistance=6.0, is_judged=True, starts_taut=True):
    """When a cell that tells of a slack cable is found [s], and the text; ``slack`` is a function of time [m].

    The drum winds in with ``speed`` [m/s], and the lengths tell of the slack.
    """
    state = ClaimState()
    for number in range(100):
        t = number * DT
        motor = MotorState(time=t, angle=0.0, speed=0.0, torque=0.0, temperature=30.0)
        reading = CableReading(motor=motor, torque=0.0, felt=felt, pull=0.02 + speed * t, resistance=resistance)
        state, found = watch_claim(
            state, reading, RANGE, DT, LIMITS, excess=0.004 - slack(t), is_judged=is_judged,
            is_slack=number > 0 or not starts_taut,
        )  # fmt: skip
        if found is not None:
            assert found.kind is FaultKind.LOAD_CELL
            return t, found.text
    return math.inf, ""


def taut(t):
    return 0.0


def test_a_cell_that_tells_of_slack_while_its_cable_bends_the_trunk_is_a_fault():
    """1 mm at 10 mm/s from the last load on takes 0.1 s; the lengths must tell of no slack for 0.5 s."""
    time, text = claim(taut)
    assert time == pytest.approx(LIMITS.cell_beyond, abs=1.5 * DT)
    assert text == "its load cell tells 0.0 N while 5.0 mm of its cable bent the trunk; allowed: 1 mm"
    assert claim(taut, speed=0.0013)[0] == pytest.approx(LIMITS.cell_bent / 0.0013, abs=1.5 * DT)
    assert claim(taut, speed=9e-4)[0] == math.inf


@pytest.mark.parametrize(
    "options",
    [
        {"felt": None}, {"is_judged": False}, {"starts_taut": False}, {"speed": -0.01},
        {"resistance": FRICTION + LIMITS.cell_error},
    ],
    ids=str,
)  # fmt: skip
def test_what_is_no_claim_is_no_fault(options):
    """No cell, another slack cable, lengths of a taut cable unknown, paid out, or no more force than friction."""
    assert claim(taut, **options)[0] == math.inf
    assert claim(taut, resistance=FRICTION + LIMITS.cell_error + 0.01)[0] < 0.6


def test_slack_that_is_taken_in_is_no_fault_until_the_lengths_tell_of_none():
    """Slack appears at once, and its end is seen 0.25 mm early: from there on 1 mm and 0.5 s count."""
    assert claim(lambda t: max(0.0, 0.004 - 0.01 * t) if t else 0.0)[0] == pytest.approx(0.375 + 0.5, abs=1.5 * DT)
    assert claim(lambda t: 0.0003 if t else 0.0)[0] == math.inf
    assert claim(lambda t: 0.0002 if t else 0.0)[0] < 0.6


@given(
    speed=st.floats(1e-4, 0.2), growths=st.lists(st.floats(0.0, 0.2), min_size=1, max_size=100),
)  # fmt: skip
def test_a_cable_that_a_trunk_loosens_as_fast_as_it_is_wound_in_is_the_only_honest_claim_that_is_told(speed, growths):
    """Honest slack: it grows as the trunk loosens the cable, and shrinks as that is wound in; taut, the cell tells."""
    state, slack, pull, loosened = ClaimState(), 0.0, 0.0, 0.0
    for number, growth in enumerate(growths):
        pull += speed * DT
        slack = max(0.0, slack + (growth - speed) * DT)
        loosened = loosened + growth * DT if 0.0 < slack <= LIMITS.cell_loosened else 0.0
        motor = MotorState(time=number * DT, angle=0.0, speed=0.0, torque=0.0, temperature=30.0)
        reading = CableReading(motor=motor, torque=0.0, felt=0.0, pull=pull, resistance=1e3)
        state, found = watch_claim(
            state, reading, RANGE, DT, LIMITS, excess=-slack, is_slack=slack > 0.0, is_judged=True
        )
        assert found is None or loosened >= LIMITS.cell_bent - LIMITS.cell_loosened - 2 * speed * DT
