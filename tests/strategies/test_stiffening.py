"""Opposing cables leave moments as they were, and held lengths are those that the cables have."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.design import presets
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DesignError, ModelError
from spiraltrunk.model import statics
from spiraltrunk.model.kinematics.cables import planar_lever
from spiraltrunk.strategies.stiffening import co_contraction, hold_lengths


@given(st.floats(0.0, 30.0), st.floats(0.0, 20.0), st.floats(0.0, PAPER.joint_limit))
def test_joints_of_that_bend_feel_no_difference(ventral: float, dorsal: float, bend: float) -> None:
    tension = co_contraction(PAPER, ventral, dorsal, bend)
    lever = planar_lever(PAPER, np.full(PAPER.n_joint, -bend))
    np.testing.assert_allclose(lever @ tension, lever @ (0.0, ventral, ventral), rtol=1e-9, atol=1e-12)
    assert tension[0] == dorsal
    assert tension[1] == tension[2] >= ventral


def test_straight_they_are_all_alike() -> None:
    """Three cables 120 deg apart at one distance: the dorsal one balances two ventral ones of its own tension."""
    np.testing.assert_allclose(co_contraction(PAPER, 0.0, 5.0), [5.0, 5.0, 5.0], rtol=1e-12)
    two = presets.get("spirob-15")
    np.testing.assert_allclose(co_contraction(two, 1.0, 0.5), [0.5, 1.5], rtol=1e-12)


@pytest.mark.parametrize("joint", [0, 5, 16])
def test_without_weight_that_joint_stays_where_it_was(joint: int) -> None:
    """Joints then balance cables and elasticity each for itself, in the equilibrium that knows nothing of levers."""
    light = replace(PAPER, gripper=None, mass=replace(PAPER.mass, sections=(1e-9,) * PAPER.n_section))
    alone = statics.solve(light, tension=(0.0, 1.5, 1.5))
    bend = float(alone.joint_angle[joint])
    assert 0.01 < bend < PAPER.joint_limit
    braced = statics.solve(light, tension=co_contraction(light, 1.5, 3.0, bend))
    assert braced.joint_angle[joint] == pytest.approx(bend, abs=1e-6)
    opposed = statics.solve(light, tension=(1.0, 1.5, 1.5))
    assert opposed.joint_angle[joint] < 0.7 * bend


def test_held_lengths_are_those_that_the_cables_have() -> None:
    pull, tension = np.array([-0.09, 0.05, 0.048]), np.array([0.0, 20.0, 22.0])
    longest, ceiling = hold_lengths(PAPER, pull, tension, dorsal=2.0)
    np.testing.assert_allclose(longest, [math.inf, 0.051, 0.0491], rtol=1e-12)
    np.testing.assert_allclose(ceiling, [2.0, 57.0, 57.0], rtol=1e-12)


@pytest.mark.parametrize(
    ("values", "error", "message"),
    [
        ((-1.0, 0.0, 0.0), DesignError, "ventral"),
        ((1.0, math.nan, 0.0), DesignError, "dorsal"),
        ((1.0, 1.0, 0.6), DesignError, "bend"),
        ((50.0, 20.0, 0.0), ModelError, r"with 20 N against it is 70 N; allowed: 60 N, the motors' largest"),
    ],
)
def test_impossible_tensions_are_refused(
    values: tuple[float, float, float], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        co_contraction(PAPER, *values)


def test_cables_on_one_side_are_refused() -> None:
    class OneSided:
        cable_direction = np.array([[0.0, -1.0, 0.0]])
        joint_limit = PAPER.joint_limit

    with pytest.raises(ModelError, match="cables pull to one side alone"):
        co_contraction(OneSided(), 1.0, 1.0)  # type: ignore[arg-type]
