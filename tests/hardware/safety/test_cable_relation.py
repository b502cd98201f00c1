"""The relation of the cables' lengths against their lengths in three dimensions."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from spiraltrunk.design.presets import PAPER, get
from spiraltrunk.hardware.safety.cable_relation import CableRelation
from spiraltrunk.model.kinematics import cables

RELATION = CableRelation.from_design(PAPER)
MOST = RELATION.compute_common(1.0)
"""Common length of shut gaps [m]."""

BENDS = arrays(float, (PAPER.n_joint, 2), elements=st.floats(-0.36, 0.36))
"""Bends within the joint limit in any direction: 0.36 sqrt(2) < 30 deg."""

LEAN = 0.35
"""Part of the common length by which a cable beside the plane of the bend takes in less, in three dimensions [-]."""


def find_lengths(bend: np.ndarray, design=PAPER) -> tuple[float, ...]:
    return tuple(cables.lengths(design, bend).change.tolist())


def bend_alike(angle: float, direction: float, design=PAPER) -> np.ndarray:
    """All joints bent by ``angle`` [rad] towards ``direction`` [rad]."""
    return np.tile([-angle * math.sin(direction), angle * math.cos(direction)], (design.n_joint, 1))


def test_the_common_length_of_a_straight_trunk_is_none_and_of_shut_gaps_4_mm():
    assert RELATION.compute_common(0.0) == 0.0
    assert pytest.approx(4.42e-3, abs=1e-5) == MOST
    size, half = 2.0 * PAPER.hole_to_joint.sum(), PAPER.delta_theta / 2
    assert pytest.approx(size * math.sin(half) * (1 - math.cos(half))) == MOST
    bend = size * math.cos(half) * math.sin(0.1)
    assert RELATION.compute_common(bend) == pytest.approx(size * math.sin(half) * (1 - math.cos(0.1)))


def evens(bend: float, direction: float) -> tuple[float, ...]:
    """Lengths of gaps whose faces lean alike, for joints bent alike [m]."""
    common, along = RELATION.compute_common(bend), bend * np.array([math.cos(direction), math.sin(direction)])
    return tuple(common + float(along @ across) for across in RELATION.directions)


@pytest.mark.parametrize("bend", [0.0, 0.03, 0.08, 0.125])
@pytest.mark.parametrize("direction", [0.0, 0.7, math.pi / 3, math.pi])
def test_bends_alike_have_no_excess(bend, direction):
    assert RELATION.compute_excess(evens(bend, direction)) == pytest.approx([0.0] * 3, abs=1e-4)


@pytest.mark.parametrize("angle", [0.1, 0.3, 0.5])
@pytest.mark.parametrize("direction", [0.0, 0.7, math.pi / 3, math.pi])
def test_in_three_dimensions_cables_beside_the_plane_take_in_less(angle, direction):
    lengths = find_lengths(bend_alike(angle, direction))
    common = RELATION.compute_common(RELATION.size * math.cos(RELATION.half_gap) * math.sin(angle / 2))
    assert -3.0 * LEAN * common < min(RELATION.compute_excess(lengths)) < 0.0


@given(BENDS)
def test_no_shape_of_taut_cables_is_far_below_bends_alike_or_beyond_shut_gaps(bend):
    excess = RELATION.compute_excess(find_lengths(bend))
    assert min(excess) > -3.0 * LEAN * MOST
    assert max(excess) < 3.0 * MOST


@given(BENDS, st.integers(0, 2), st.floats(-0.02, 0.02))
def test_a_slip_is_seen_by_its_length_in_every_shape(bend, cable, slip):
    lengths = list(find_lengths(bend))
    before = RELATION.compute_excess(tuple(lengths))[cable]
    lengths[cable] += slip
    assert RELATION.compute_excess(tuple(lengths))[cable] - before == pytest.approx(slip, abs=1e-9)


@given(BENDS, st.integers(0, 2))
def test_of_three_cables_all_see_the_slip_of_one(bend, cable):
    lengths = list(find_lengths(bend))
    before = RELATION.compute_excess(tuple(lengths))
    lengths[cable] += 0.005
    after = RELATION.compute_excess(tuple(lengths))
    assert np.subtract(after, before) == pytest.approx([0.005] * 3, abs=1.5e-3)


def test_a_trunk_of_two_cables():
    design = get("spirob-15")
    relation = CableRelation.from_design(design)
    lengths = list(find_lengths(bend_alike(0.5 * design.joint_limit, 0.0, design), design))
    assert relation.compute_excess(tuple(lengths)) == pytest.approx([0.0] * 2, abs=1e-4)
    lengths[-1] += 0.005
    assert relation.compute_excess(tuple(lengths))[-1] == pytest.approx(0.005, abs=1e-4)


def test_of_four_cables_the_one_that_slips_and_its_opposite_see_it():
    design = dataclasses.replace(PAPER, cable=dataclasses.replace(PAPER.cable, angles=(0.0, 1.5, 3.0, 4.5)))
    relation = CableRelation.from_design(design)
    lengths = list(find_lengths(bend_alike(0.2, 0.4, design), design))
    before = relation.compute_excess(tuple(lengths))
    lengths[2] += 0.005
    excess = np.subtract(relation.compute_excess(tuple(lengths)), before)
    assert excess == pytest.approx([0.005, 0.0, 0.005, 0.0], abs=7e-4)


def test_lengths_that_no_trunk_has_are_told_all_the_same():
    assert all(map(math.isfinite, RELATION.compute_excess((10.0, -3.0, 2.0))))
    assert RELATION.compute_excess((0.0, 0.0, -0.02)) == pytest.approx([-0.02] * 3, abs=1e-3)
