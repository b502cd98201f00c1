"""Dither: what is left in a cable that was let down, and when it runs."""

import math

import pytest

from spiraltrunk.hardware.winder.dither import FADE_TIME, RESTART_LENGTH, Dither, count_half, step_dither
from spiraltrunk.hardware.winder.winder import WinderTarget

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
        signs.append(dither.phase < half)
    assert sum(signs) == len(signs) // 2


def test_a_high_tension_is_held_without_dither(rig):
    one = rig.Rig(rig.build_rig_winder(), stiffness=2e3)
    one.run(WinderTarget(tension=30.0), 1.0)
    torques = [torque for *_, torque in one.run(WinderTarget(tension=20.0), 1.0)][-250:]
    assert max(torques) - min(torques) < 0.1 * one.winder.friction
    assert math.isfinite(one.state.dither.pull)
