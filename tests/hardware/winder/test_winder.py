"""Control of one winder on a simulated rotor and cable: tension, pull, limits, and what is refused."""

import itertools
import math
from dataclasses import replace
from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spiraltrunk.control.plant import TENSION_SLEW
from spiraltrunk.design import presets
from spiraltrunk.errors import DesignError, DriveError
from spiraltrunk.hardware.motors.motor_port import MotorState
from spiraltrunk.hardware.winder.winder import WinderState, WinderTarget, build_winder, step

PERIODS = pytest.mark.parametrize("period", [1e-3, 2e-3])
STIFFNESSES = pytest.mark.parametrize(
    "stiffness",
    [2e4, pytest.param(5e3, marks=pytest.mark.slow), 2e3, pytest.param(500.0, marks=pytest.mark.slow), 200.0],
)
"""From a stop at the drum to the paper's trunk, which gives way by about 5 mm a newton."""

SPREAD = 2 * 0.02 / 9.85e-3
"""Twice the dry friction over the radius: what the tension may differ by while the rotor stands [N]."""


def _tensions(seen):
    return [tension for tension, *_ in seen]


def _swing(values):
    """Largest fall after a rise, or rise after a fall, whichever is smaller: 0 of what creeps one way."""
    low = high = values[0]
    fall = rise = 0.0
    for value in values:
        low, high = min(low, value), max(high, value)
        fall, rise = max(fall, high - value), max(rise, value - low)
    return min(fall, rise)


@PERIODS
@STIFFNESSES
def test_a_step_of_tension_settles_without_overshoot_beyond_friction(rig, period, stiffness):
    one = rig.Rig(rig.build_rig_winder(period), stiffness=stiffness)
    for wanted in (10.0, 20.0):
        seen = one.run(WinderTarget(tension=wanted), 1.5)
        assert max(_tensions(seen)) < wanted * 1.05 + SPREAD
        assert _tensions(seen)[-1] == pytest.approx(wanted, abs=SPREAD)
        assert _swing(_tensions(seen)[-round(0.5 / period) :]) < 0.05  # No limit cycle.


@PERIODS
@STIFFNESSES
def test_the_floor_is_kept_when_no_tension_is_asked_for(rig, period, stiffness):
    one = rig.Rig(rig.build_rig_winder(period), stiffness=stiffness)
    one.run(WinderTarget(tension=20.0), 1.5)
    seen = _tensions(one.run(WinderTarget(tension=0.0), 2.0))
    assert min(seen) > 0.5
    assert seen[-1] == pytest.approx(1.0, abs=SPREAD)


@PERIODS
def test_the_set_tension_keeps_the_slew_limit_both_ways(rig, period):
    one = rig.Rig(rig.build_rig_winder(period), stiffness=2e3)
    sets, limits = [0.0], [0.0]
    for wanted, pull in ((60.0, math.inf), (0.0, math.inf), (60.0, 0.001), (30.0, -0.05)):
        for _ in range(round(0.3 / period)):
            one.run(WinderTarget(tension=wanted, pull=pull), period)
            sets.append(one.state.tension_set)
            limits.append(one.state.tension_limit)
    for values in (sets, limits):
        rates = [abs(b - a) / period for a, b in itertools.pairwise(values)]
        assert max(rates) <= TENSION_SLEW * (1 + 1e-9)
    assert max(rates) == pytest.approx(TENSION_SLEW)


@PERIODS
@pytest.mark.parametrize("stiffness", [2e3, pytest.param(500.0, marks=pytest.mark.slow), 200.0])
def test_the_pull_comes_to_its_limit_and_stops(rig, period, stiffness):
    """Under the largest tension: the limit of pull holds, up to a tenth and 1 mm on the way."""
    one = rig.Rig(rig.build_rig_winder(period), stiffness=stiffness)
    limit = 10.0 / stiffness
    seen = one.run(WinderTarget(tension=60.0, pull=limit), 4.0)
    assert max(pull for _, pull, *_ in seen) < 1.1 * limit + 1e-3
    assert seen[-1][1] == pytest.approx(limit, abs=1e-3)
    back = one.run(WinderTarget(tension=60.0, pull=limit / 2), 4.0)
    assert back[-1][1] == pytest.approx(limit / 2, abs=1e-3)


@PERIODS
def test_slack_is_taken_in_gently(rig, period):
    winder = rig.build_rig_winder(period)
    for wanted in (0.0, 10.0):
        seen = rig.Rig(winder, slack=0.02).run(WinderTarget(tension=wanted), 2.0)
        assert seen[-1][1] == pytest.approx(0.02, abs=1e-3)
        assert max(_tensions(seen)) < max(wanted, 1.0) + 5.0 + SPREAD
        assert max(reading.speed for *_, reading, _ in seen) < 1.5 * winder.gains.slack_speed


@PERIODS
@pytest.mark.parametrize("tension", [0.0, 5.0, 60.0])
def test_a_broken_cable_does_not_run_away_and_ends_at_the_soft_limit(rig, period, tension):
    winder = rig.build_rig_winder(period)
    seen = rig.Rig(winder, stiffness=0.0, substeps=10).run(WinderTarget(tension=tension), 6.0)
    assert max(reading.speed for *_, reading, _ in seen) < 1.5 * winder.gains.slack_speed
    pulls = [pull for _, pull, *_ in seen]
    assert max(pulls) <= winder.limits.pull_max + 1e-3
    assert pulls[-1] == pytest.approx(winder.limits.pull_max, abs=2e-3)


@settings(max_examples=15)
@given(
    st.lists(st.tuples(st.floats(0.0, 60.0), st.just(math.inf) | st.floats(-1.0, 1.0)), min_size=1, max_size=5),
    st.sampled_from([0.0, 50.0, 500.0, 2e4]),
)
def test_soft_limits_hold_under_hostile_targets(rig, targets, stiffness):
    winder = rig.build_rig_winder(2e-3)
    one = rig.Rig(winder, stiffness=stiffness, substeps=10, angle=winder.drum.angle(0.05), slack=0.049)
    for tension, pull in targets:
        for _, now, _, torque in one.run(WinderTarget(tension=tension, pull=pull), 0.4):
            assert winder.limits.pull_min - 2e-3 <= now <= winder.limits.pull_max + 2e-3
            assert abs(torque) <= winder.limits.torque_max


def test_a_trunk_that_pulls_the_cable_out_is_stopped_at_the_soft_limit(rig):
    """A spring whose far end is 60 mm beyond the end of the travel pays the cable out, against the floor."""
    winder = rig.build_rig_winder(2e-3)
    one = rig.Rig(winder, stiffness=200.0, slack=winder.limits.pull_min - 0.06, angle=winder.drum.angle(-0.1))
    seen = one.run(WinderTarget(tension=0.0), 3.0)
    assert min(pull for _, pull, *_ in seen) > winder.limits.pull_min - 3e-3
    assert seen[-1][1] == pytest.approx(winder.limits.pull_min, abs=3e-3)


HOSTILE = st.fixed_dictionaries(
    {
        "tension": st.floats(0.0, 60.0), "pull": st.floats(-99.0, 1e300) | st.just(math.inf),
        "angle": st.floats(-1e6, 1e6), "speed": st.floats(-1e4, 1e4), "torque": st.floats(-1e4, 1e4),
        "time": st.floats(-1e3, 1e6), "dt": st.floats(1e-6, 1e3), "load": st.none() | st.floats(-1e4, 1e4),
    }
)  # fmt: skip


@settings(max_examples=200)
@given(st.lists(HOSTILE, min_size=1, max_size=4))
def test_torque_and_state_are_finite_whatever_was_measured(rig, inputs):
    for winder in (rig.build_rig_winder(), rig.build_rig_winder(10e-3, rig.GEARED)):
        state = WinderState(zero_angle=0.0)
        for one in inputs:
            motor = MotorState(**{name: one[name] for name in ("time", "angle", "speed", "torque")}, temperature=30.0)
            target = WinderTarget(tension=one["tension"], pull=one["pull"])
            state, reading, torque = step(winder, state, target, motor, one["dt"], measured_tension=one["load"])
            assert abs(torque) <= winder.limits.torque_max
            assert all(
                map(math.isfinite, [*state[:-4], *state.direction, state.force, state.loss, *state.dither, *reading])
            )
            assert 0.0 <= state.tension_set <= winder.limits.tension_ceiling


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, -1.0, 60.1])
def test_a_tension_that_is_none_is_refused(rig, bad):
    one = rig.Rig(rig.build_rig_winder())
    with pytest.raises(DriveError, match=r"tension of a winder is .* N; allowed: 0 to 60 N, the design's largest"):
        one.run(WinderTarget(tension=bad), 2e-3)


@pytest.mark.parametrize("bad", [math.nan, -math.inf, -100.0])
def test_a_pull_that_is_none_is_refused(rig, bad):
    one = rig.Rig(rig.build_rig_winder())
    with pytest.raises(DriveError, match=r"pull of a winder is .* m; allowed: metres above -100, or infinity"):
        one.run(WinderTarget(tension=1.0, pull=bad), 2e-3)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("name", ["angle", "speed", "torque", "time"])
def test_feedback_that_is_not_finite_is_refused(rig, name, bad):
    one = rig.Rig(rig.build_rig_winder())
    motor = replace(one.feedback(), **{name: bad})
    with pytest.raises(DriveError, match="feedback of a winder"):
        step(one.winder, one.state, WinderTarget(tension=1.0), motor, 2e-3)
    with pytest.raises(DriveError, match="load cell"):
        step(one.winder, one.state, WinderTarget(tension=1.0), one.feedback(), 2e-3, measured_tension=bad)
    with pytest.raises(DriveError, match="time between two steps"):
        step(one.winder, one.state, WinderTarget(tension=1.0), one.feedback(), bad)


@PERIODS
@pytest.mark.parametrize("wanted", [5.0, 20.0, 50.0])
def test_the_estimate_is_the_tension_up_to_friction_while_winding(rig, period, wanted):
    """On a soft trunk, in motion: the observer knows the friction's direction."""
    one = rig.Rig(rig.build_rig_winder(period), stiffness=200.0, substeps=10)
    seen = one.run(WinderTarget(tension=wanted, pull=0.1), 0.6)
    moving = [(true, reading) for true, _, reading, _ in seen if reading.speed > 0.02]
    assert len(moving) > 20
    late = moving[len(moving) // 2 :]
    assert sum(abs(true - reading.tension) for true, reading in late) / len(late) < 1.0


FAST = {(2e4, 2.0, 1e-3), (2e4, 0.5, 2e-3), (200.0, 2.0, 2e-3)}
"""The stiffest and the softest cable, with the least and the most friction."""


@pytest.mark.parametrize(
    ("stiffness", "scale", "period"),
    [
        pytest.param(*case, marks=[] if case in FAST else [pytest.mark.slow])
        for case in product((2e4, 2e3, 200.0), (0.5, 1.0, 2.0), (1e-3, 2e-3))
    ],
)
def test_a_load_cell_removes_the_error_of_friction(rig, period, scale, stiffness):
    """Whatever the friction is: the true tension is the set one, and it does not swing."""
    winder = rig.build_rig_winder(period)
    one = rig.Rig(winder, stiffness=stiffness, friction_scale=scale, substeps=10)
    for wanted in (5.0, 20.0, 5.0):
        seen = one.run(WinderTarget(tension=wanted), 6.0, load_cell=True)
        last = _tensions(seen[-round(0.5 / period) :])
        print(f"{wanted:g} N: {last[-1]:.2f} N, swing {_swing(last):.2f} N, loss {one.state.loss:.2f} N")
        assert last[-1] == pytest.approx(wanted, abs=0.25)
        assert _swing(last) < 0.25
        assert seen[-1][2].tension == pytest.approx(seen[-1][0], abs=0.05)
        assert abs(one.state.loss) <= winder.friction / 9.8e-3 + 0.2 * winder.limits.tension_ceiling


@pytest.mark.parametrize(
    ("stiffness", "scale"),
    [(300.0, 1.5)]
    + [
        pytest.param(*case, marks=pytest.mark.slow)
        for case in ((2e3, 0.5), (2e3, 1.0), (2e3, 1.5), (300.0, 0.5), (300.0, 1.0))
    ],
)
def test_a_load_cell_removes_the_error_of_a_gear(rig, scale, stiffness):
    """Friction of 27 N behind a gear: the motor alone leaves the tension uncertain by that."""
    one = rig.Rig(rig.build_rig_winder(10e-3, rig.GEARED), stiffness=stiffness, friction_scale=scale, substeps=100)
    for wanted in (30.0, 15.0):
        seen = _tensions(one.run(WinderTarget(tension=wanted), 20.0, load_cell=True))
        print(f"{wanted:g} N: {seen[-1]:.2f} N, swing {_swing(seen[-300:]):.2f} N")
        assert sum(seen[-300:]) / 300 == pytest.approx(wanted, abs=1.0)


def test_a_load_cell_of_a_slack_cable_winds_it_in(rig):
    one = rig.Rig(rig.build_rig_winder(), stiffness=2e3, slack=0.01)
    seen = one.run(WinderTarget(tension=10.0), 4.0, load_cell=True)
    assert seen[-1][0] == pytest.approx(10.0, abs=0.25)
    assert min(pull for _, pull, *_ in seen) > -1e-4


@PERIODS
@pytest.mark.parametrize("scale", [0.5, 0.75, 1.5, 2.0])
@pytest.mark.parametrize("stiffness", [2e4, 2e3, 200.0])
def test_friction_that_is_not_as_assumed_makes_no_oscillation(rig, period, scale, stiffness):
    one = rig.Rig(rig.build_rig_winder(period), stiffness=stiffness, friction_scale=scale, substeps=10)
    for wanted in (20.0, 0.0):
        seen = _tensions(one.run(WinderTarget(tension=wanted), 1.5))
        assert _swing(seen[-round(0.5 / period) :]) < 0.05
    assert min(seen) > 0.5


def test_friction_as_measured_replaces_the_data_sheets(rig):
    drum = rig.build_rig_winder().drum
    winder = build_winder(presets.PAPER, rig.DIRECT, drum, 2e-3, friction=0.05)
    assert winder.friction == 0.05
    assert winder.limits.tension_floor == pytest.approx(1.5 * 0.2 * 0.05 / 9.85e-3)
    with pytest.raises(DesignError, match=r"winder.friction is -0.1"):
        build_winder(presets.PAPER, rig.DIRECT, drum, 2e-3, friction=-0.1)


def test_repeated_feedback_changes_no_estimate(rig):
    one = rig.Rig(rig.build_rig_winder(), stiffness=2e3)
    one.run(WinderTarget(tension=10.0), 0.03)
    motor = one.feedback()
    state, *_ = step(one.winder, one.state, WinderTarget(tension=10.0), motor, 2e-3)
    again, *_ = step(one.winder, state, WinderTarget(tension=10.0), motor, 2e-3)
    assert (again.tension, again.resistance, again.speed) == (state.tension, state.resistance, state.speed)


def test_the_same_steps_give_the_same_torques(rig):
    runs = [rig.Rig(rig.build_rig_winder(), stiffness=2e3).run(WinderTarget(tension=10.0), 0.2) for _ in range(2)]
    assert runs[0] == runs[1]


@pytest.mark.parametrize("period", [10e-3, 20e-3])
@pytest.mark.parametrize("stiffness", [2e4, 2e3, 300.0])
def test_a_geared_motor_on_a_slow_bus_settles(rig, period, stiffness):
    """Behind a gear, friction over the radius is 27 N: the tension is known to that, and it must not oscillate."""
    winder = rig.build_rig_winder(period, rig.GEARED)
    one = rig.Rig(winder, stiffness=stiffness, substeps=100)
    still = _tensions(one.run(WinderTarget(tension=30.0), 15.0))
    assert _swing(still[-round(3.0 / period) :]) < 0.1
    assert still[-1] == pytest.approx(30.0, abs=2 * 0.2 * winder.friction / winder.drum.radius_max + 3.0)
