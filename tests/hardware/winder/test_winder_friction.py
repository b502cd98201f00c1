"""Direction of the dry friction: what turns it, and that a last digit that flickers at rest does not."""

import math
import random
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.hardware.winder.friction import (
    FRICTION_STEPS,
    FRICTION_TIME,
    PLAY_STEPS,
    FrictionDirection,
    follow_motion,
    lead_at_rest,
)
from spiraltrunk.hardware.winder.winder import WinderTarget

STEP = 2 * math.pi / 8192


def _flicker(one, seed=0):
    """Let the encoder's last digit flicker as the twin's does: noise of 0.3 steps before rounding."""
    noise, exact = random.Random(seed), one.feedback

    def feedback():
        count = math.floor(one.angle / one.winder.angle_step + noise.gauss(0.0, 0.3))
        return replace(exact(), angle=count * one.winder.angle_step)

    one.feedback = feedback


def _follow(direction, counts):
    for count in counts:
        direction = follow_motion(direction, count * STEP, STEP)
    return direction


@pytest.mark.parametrize("stiffness", [2e4, 200.0])
@pytest.mark.parametrize("target", [WinderTarget(tension=20.0), WinderTarget(tension=60.0, pull=0.05)])
def test_compensation_does_not_flicker_at_rest_with_the_encoders_last_digit(rig, stiffness, target):
    """One direction of friction, where a count more or less would turn it by half, and an even torque."""
    one = rig.Rig(rig.build_rig_winder(), stiffness=stiffness, substeps=10)
    _flicker(one)
    one.run(target, 2.5)
    shares, torques = [], []
    for _ in range(100):
        torques += [torque for *_, torque in one.run(target, one.winder.gains.period)]
        shares.append(one.state.direction.share)
    assert max(shares) - min(shares) < 0.1
    assert abs(shares[-1]) > 0.9
    assert max(torques) - min(torques) < 0.25 * one.winder.friction


@given(st.lists(st.sampled_from([-1, 0, 1]), max_size=30), st.floats(-1.0, 1.0), st.integers(-(10**6), 10**6))
def test_three_neighbouring_counts_are_rest(flicker, share, count):
    seen = _follow(FrictionDirection(share, count * STEP), [count + one for one in flicker])
    assert seen.share == pytest.approx(share, abs=1e-6)


@pytest.mark.parametrize("sense", [-1, 1])
def test_motion_turns_the_direction_by_its_steps_beyond_the_play(sense):
    whole, play = 2 * FRICTION_STEPS, 2 * PLAY_STEPS
    before = _follow(FrictionDirection(), [-sense * n for n in range(20)])
    assert before.share == -sense
    start = -sense * 19
    assert _follow(before, [start + sense * n for n in range(round(play) + 1)]).share == pytest.approx(-sense)
    turned = _follow(before, [start + sense * n for n in range(round(play + whole) + 1)])
    assert turned.share == pytest.approx(sense)
    less = _follow(before, [start + sense * n for n in range(round(play + whole))])
    assert sense * less.share == pytest.approx(1.0 - 1.0 / FRICTION_STEPS)


@given(st.lists(st.floats(-1e4, 1e4), min_size=1, max_size=20))
def test_the_angle_behind_the_play_is_never_farther_than_that(angles):
    direction = FrictionDirection()
    for angle in angles:
        direction = follow_motion(direction, angle, STEP)
        assert abs(direction.angle - angle) <= PLAY_STEPS * STEP + 1e-9
        assert -1.0 <= direction.share <= 1.0


@pytest.mark.parametrize("is_let_down", [True, False])
def test_at_standstill_it_is_led_where_the_tension_goes(is_let_down):
    sense = -1.0 if is_let_down else 1.0
    half = lead_at_rest(FrictionDirection(-sense, 0.7), FRICTION_TIME, is_let_down=is_let_down)
    assert half == FrictionDirection(0.0, 0.7)
    assert lead_at_rest(half, 2 * FRICTION_TIME, is_let_down=is_let_down).share == sense
