"""Dither: what is left in a cable that was let down, and when it runs."""

import itertools
import math

import pytest

from spiraltrunk.hardware.motors.gm6020 import GM6020
from spiraltrunk.hardware.motors.sts.models import MODELS
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.setup.robot_limits import PERIOD
from spiraltrunk.hardware.winder.dither import (
    FADE_TIME,
    RESTART_LENGTH,
    STIR,
    Dither,
    can_stir,
    compute_sign,
    count_half,
    step_dither,
)
from spiraltrunk.hardware.winder.winder import WinderTarget, step

STS3215 = MODELS["sts3215-12v"].data_sheet
STEP = math.tau / 8192

FRICTION = 0.02 / 9.85e-3
"""Dry friction of the rig's motor over the radius [N]."""


@pytest.mark.parametrize("period", [1e-3, 2e-3])
@pytest.mark.parametrize("scale", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("target", [WinderTarget(tension=0.0), WinderTarget(tension=60.0, pull=0.0)])
def test_a_cable_that_is_let_down_keeps_the_floor_and_no_friction(rig, period, scale, target):
    """On a soft trunk, where without dither the floor and all of the friction, 1 + 2 to 4 N, would hold against it."""
    one = rig.Rig(rig.build_rig_winder(period), stiffness=200.0, friction_scale=scale, substeps=10)
    one.run(WinderTarget(tension=20.0), 1.0)
    kept = one.run(target, 4.0)[-1][0]
    overcompensated = max(0.8 - scale, 0.0) * FRICTION
    left = 1.0 if scale == 2.0 else 0.3
    assert 0.5 < kept < 1.0 + left * FRICTION + overcompensated


def test_it_fades_while_nothing_moves_and_starts_anew_where_cable_is_paid_out():
    dither, dt = step_dither(Dither(), 0.01, 1e-3, 8, is_let_down=True), 1e-3
    assert dither.share == 1.0
    for _ in range(round(FADE_TIME / dt) + 1):
        dither = step_dither(dither, 0.01, dt, 8, is_let_down=False)
    assert dither.share == 0.0
    inward = step_dither(dither, 0.02, dt, 8, is_let_down=False)
    assert inward.share == 0.0
    assert step_dither(inward, 0.02 - 0.9 * RESTART_LENGTH, dt, 8, is_let_down=False).share == 0.0
    assert step_dither(inward, 0.02 - 1.1 * RESTART_LENGTH, dt, 8, is_let_down=False).share == 1.0


@pytest.mark.parametrize(("period", "expected"), [(1e-3, 8), (2e-3, 4), (20e-3, 1)])
def test_halves_of_a_cycle_are_whole_periods_of_equal_number(period, expected):
    half = count_half(period)
    assert half == expected
    dither, signs = Dither(), []
    for _ in range(10 * 2 * half):
        dither = step_dither(dither, 0.0, period, half, is_let_down=False)
        signs.append(compute_sign(dither, half))
    assert sum(signs) == 0
    assert sum(a != b for a, b in itertools.pairwise(signs)) in (19, 20)


@pytest.mark.parametrize("scale", [0.5, 1.0, 2.0])
def test_the_encoder_sees_a_stir_whatever_the_friction(scale):
    """A free rotor under the square wave, exactly: it turns by more than what the watch of stalls takes for none."""
    half = PERIOD * count_half(PERIOD)
    turned = (STIR - scale) * GM6020.rotor_friction / GM6020.rotor_inertia * half**2 / 4.0
    assert turned > SafetyLimits().blocked_steps * GM6020.angle_step
    assert can_stir(PERIOD, GM6020.rotor_inertia, GM6020.rotor_friction, GM6020.angle_step)


def test_slow_motors_coarse_encoders_and_rotors_without_friction_are_not_stirred():
    assert not can_stir(STS3215.period, STS3215.rotor_inertia, STS3215.rotor_friction, STS3215.angle_step)
    assert not can_stir(PERIOD, GM6020.rotor_inertia, GM6020.rotor_friction, 4 * GM6020.angle_step)
    assert not can_stir(PERIOD, GM6020.rotor_inertia, 0.0, GM6020.angle_step)


@pytest.mark.parametrize("tension", [0.0, 30.0])
@pytest.mark.parametrize("scale", [0.5, 1.0, 2.0])
def test_a_stir_moves_a_free_drum_hardly_and_keeps_its_tension(rig, tension, scale):
    """By several steps of the encoder, which a jammed drum does not show."""
    turned, swing = {}, {}
    for is_jammed in (False, True):
        one = rig.Rig(rig.build_rig_winder(), friction_scale=scale)
        one.run(WinderTarget(tension=tension), 2.0)
        before, pulls, tensions = one.tension, [], []
        one.is_jammed = is_jammed
        for k in range(round(FADE_TIME / one.winder.gains.period)):
            one.state, reading, torque = step(
                one.winder, one.state, WinderTarget(tension=tension), one.feedback(), one.winder.gains.period,
                is_stirred=k == 0,
            )  # fmt: skip
            one.advance(torque)
            pulls.append(reading.pull)
            tensions.append(one.tension)
        turned[is_jammed] = max(pulls) - min(pulls)
        swing[is_jammed] = max(abs(now - before) for now in tensions)
    print(f"a stir changes the tension by {swing[False]:.2f} N")
    assert swing[False] < 3.0 + scale * FRICTION
    step_length = one.winder.angle_step * one.winder.drum.design.winding_radius
    assert turned[True] == 0.0
    assert 3.0 * step_length < turned[False] < 4e-4


def test_a_high_tension_is_held_without_dither(rig):
    one = rig.Rig(rig.build_rig_winder(), stiffness=2e3)
    one.run(WinderTarget(tension=30.0), 1.0)
    torques = [torque for *_, torque in one.run(WinderTarget(tension=20.0), 1.0)][-250:]
    assert max(torques) - min(torques) < 0.1 * one.winder.friction
    assert math.isfinite(one.state.dither.pull)
