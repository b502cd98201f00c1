"""The plane formulas for gaps and levers against the cables in space and against differences."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from spiraltrunk.design import presets
from spiraltrunk.design.presets import PAPER
from spiraltrunk.model.kinematics import cables
from spiraltrunk.model.kinematics.cables import planar_gap, planar_lever

BENDS = arrays(float, (PAPER.n_joint,), elements=st.floats(-math.pi / 6, math.pi / 6))


def _in_space(design, bend):
    return cables.lengths(design, np.stack([0 * bend, bend], axis=-1)).gap


@given(BENDS)
def test_a_cable_in_the_plane_has_the_planes_gap(bend):
    """Cable 1 lies in the plane; of the others, the plane sees the height."""
    np.testing.assert_allclose(planar_gap(PAPER, bend), _in_space(PAPER, bend), rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", presets.NAMES)
def test_gaps_of_every_preset_agree_with_space(name):
    design = presets.get(name)
    bend = np.random.default_rng(1).uniform(-1, 1, design.n_joint) * design.joint_limit
    np.testing.assert_allclose(planar_gap(design, bend), _in_space(design, bend), rtol=0, atol=1e-12 * design.length)


@given(arrays(float, (PAPER.n_joint,), elements=st.floats(-0.5, 0.5)))
def test_the_lever_is_minus_the_derivative_of_the_gap(bend):
    step = 1e-6
    slope = (_in_space(PAPER, bend + step) - _in_space(PAPER, bend - step)) / (2 * step)
    np.testing.assert_allclose(planar_lever(PAPER, bend), -slope, rtol=0, atol=1e-9)


def test_levers_of_the_straight_trunk_are_the_holes_heights():
    lever = planar_lever(PAPER, np.zeros(PAPER.n_joint))
    ring = PAPER.hole_to_joint * math.cos(PAPER.delta_theta / 2)
    np.testing.assert_allclose(lever, np.outer(ring, np.cos(PAPER.cable.angles)), rtol=0, atol=1e-15)


def test_a_shut_gap_has_no_length():
    limit = np.full(PAPER.n_joint, PAPER.joint_limit)
    np.testing.assert_allclose(planar_gap(PAPER, limit)[:, 0], 0.0, atol=1e-15)
    opposite = replace(PAPER, cable=replace(PAPER.cable, angles=(0.0, math.pi)))
    np.testing.assert_allclose(planar_gap(opposite, -limit)[:, 1], 0.0, atol=1e-15)


def test_batches_equal_single_shapes():
    bend = np.random.default_rng(3).uniform(-0.5, 0.5, (4, PAPER.n_joint))
    for function in (planar_gap, planar_lever):
        batch = function(PAPER, bend)
        assert batch.shape == (4, PAPER.n_joint, 3)
        for i in range(4):
            np.testing.assert_allclose(batch[i], function(PAPER, bend[i]), rtol=0, atol=1e-16)
