"""The rolled-up trunk: against the equilibrium, its closed forms, and similarity."""

import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.model import statics
from spiraltrunk.strategies.moves import tilted_base
from spiraltrunk.strategies.push.rolled_model import predict_rolled_trunk


@pytest.mark.parametrize("tilt", [30.0, 60.0, 75.0])
def test_the_front_is_where_the_equilibrium_puts_it(tilt):
    """All cables pulled ventral as far as they go, the trunk is rolled up whatever the model."""
    shape = statics.solve(PAPER, tension=[0.0, 60.0, 60.0])
    assert np.degrees(shape.joint_angle).min() > 29.0
    ends = np.vstack([np.zeros(3), shape.points])
    middle = (ends[1:] + ends[:-1]) / 2
    down, aside = -middle[:, 1], -middle[:, 0]
    angle, radius = math.radians(tilt), PAPER.section_radius
    ahead = down * math.sin(angle) + radius
    rolled = predict_rolled_trunk(PAPER, angle)
    assert rolled.forward == pytest.approx(ahead.max(), abs=2e-3)
    assert rolled.lateral == pytest.approx(aside[np.argmax(ahead)], abs=2e-3)
    assert rolled.bottom == pytest.approx((down * math.cos(angle) + radius).max(), abs=2e-3)
    assert rolled.radius == radius[np.argmax(ahead)]
    assert rolled.below + rolled.radius == pytest.approx(rolled.bottom, abs=0.002)


def test_hanging_the_front_is_the_first_section():
    rolled = predict_rolled_trunk(PAPER, 0.0)
    assert rolled.forward == pytest.approx(PAPER.section_radius[0])
    assert rolled.lateral == pytest.approx(0.0, abs=1e-12)
    assert rolled.below == pytest.approx(PAPER.section_length[0] / 2)


def test_a_trunk_twice_as_large_has_a_roll_twice_as_large():
    twice = replace(PAPER, spiral=replace(PAPER.spiral, a=2 * PAPER.spiral.a))
    small, large = predict_rolled_trunk(PAPER, 1.0), predict_rolled_trunk(twice, 1.0)
    for name in ("forward", "lateral", "below", "bottom", "radius", "curve"):
        assert getattr(large, name) == pytest.approx(2 * getattr(small, name))


@pytest.mark.parametrize("heading", [0.0, 1.0, 2.5, -0.7])
def test_the_base_points_down_and_ahead_and_curls_to_the_right(heading):
    way, tilt = np.array([math.cos(heading), math.sin(heading), 0.0]), 1.1
    R = tilted_base(way, tilt)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0)
    np.testing.assert_allclose(R[:, 0], math.sin(tilt) * way - [0, 0, math.cos(tilt)], atol=1e-12)
    np.testing.assert_allclose(-R[:, 1], np.cross(way, [0.0, 0.0, 1.0]), atol=1e-12)
