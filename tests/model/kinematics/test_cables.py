"""Cable lengths against plane trigonometry, the trunk's symmetries and holes carried along by the frames."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from spiraltrunk.design import CableDesign, presets
from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.rules import design_from_rules
from spiraltrunk.errors import ShapeError
from spiraltrunk.model.kinematics import cables
from spiraltrunk.model.kinematics.frames import bend_rotation, section_ends, section_frames

SHAPES = arrays(float, (PAPER.n_joint, 2), elements=st.floats(-0.36, 0.36))
"""Bends within the joint limit in any direction: 0.36 sqrt(2) < 30 deg."""

PLANAR = presets.get("spirob-15")


def planar(bend):
    """Bends about z alone."""
    return np.stack([np.zeros_like(bend), bend], axis=-1)


def test_a_straight_trunk_has_straight_cables():
    cable = cables.lengths(PAPER, np.zeros((PAPER.n_joint, 2)))
    np.testing.assert_allclose(cable.gap, np.tile(PAPER.straight_gap[:, None], 3), rtol=1e-12)
    np.testing.assert_allclose(cable.length, PAPER.cable_in_section.sum() + PAPER.cable_stroke, rtol=1e-13)
    np.testing.assert_allclose(cable.change, 0.0, atol=1e-15)
    np.testing.assert_allclose(cable.points[:, 0], np.cumsum(PAPER.section_length), rtol=1e-14)


@given(st.floats(0.05, 0.4), st.sampled_from([3, 6, 8, 12]), st.floats(0.2, 0.9))
def test_full_dorsal_curl_pulls_in_exactly_the_stroke(b, parts, hole_fraction):
    design = design_from_rules(b=b, delta_theta=math.pi / parts)
    design = replace(design, cable=replace(design.cable, hole_fraction=hole_fraction))
    cable = cables.lengths(design, planar(np.full(design.n_joint, design.joint_limit)))
    np.testing.assert_allclose(cable.gap[:, 0], 0.0, atol=1e-12 * design.length)
    assert cable.change[0] == pytest.approx(design.cable_stroke, rel=1e-12)


def test_full_curl_towards_each_cable_pulls_that_cable_in():
    for i, angle in enumerate(PAPER.cable.angles):
        bend = PAPER.joint_limit * np.array([-math.sin(angle), math.cos(angle)])
        change = cables.lengths(PAPER, np.tile(bend, (PAPER.n_joint, 1))).change
        assert change[i] == pytest.approx(PAPER.cable_stroke, rel=1e-12)
        assert np.argmax(change) == i


@given(arrays(float, (PLANAR.n_joint,), elements=st.floats(-1.0, 1.0)))
def test_planar_gaps_are_chords_of_the_open_angle(share):
    """A gap between holes at R from the joint, open by limit -+ bend, spans 2 R sin(angle / 2)."""
    bend = share * PLANAR.joint_limit
    gap = cables.lengths(PLANAR, planar(bend)).gap
    opening = PLANAR.joint_limit + np.array([-1.0, 1.0]) * bend[:, None]
    expected = 2 * PLANAR.hole_to_joint[:, None] * np.sin(opening / 2)
    np.testing.assert_allclose(gap, expected, rtol=0, atol=1e-12 * PLANAR.length)


@given(SHAPES)
def test_gaps_are_distances_of_the_holes_in_space(bend):
    frames = section_frames(PAPER, bend_rotation(bend))
    axial, ring = PAPER.hole_position[..., 0], PAPER.hole_position[..., 1]
    local = axial[..., None, None] * np.array([1.0, 0.0, 0.0]) + ring[..., None, None] * PAPER.cable_direction
    world = np.einsum("nij,nhcj->nhci", frames[:, :3, :3], local) + frames[:, None, None, :3, 3]
    cable = cables.lengths(PAPER, bend)
    np.testing.assert_allclose(cable.gap, np.linalg.norm(world[1:, 0] - world[:-1, 1], axis=-1), rtol=0, atol=1e-13)
    inside = np.linalg.norm(world[:, 1] - world[:, 0], axis=-1).sum(axis=0)
    np.testing.assert_allclose(cable.length, inside + cable.gap.sum(axis=0), rtol=1e-12)
    assert (cable.points == section_ends(PAPER, frames)).all()


@given(SHAPES)
def test_change_is_what_the_length_lacks_to_straight(bend):
    cable = cables.lengths(PAPER, bend)
    straight = cables.lengths(PAPER, np.zeros_like(bend)).length
    np.testing.assert_allclose(cable.change, straight - cable.length, rtol=0, atol=1e-13)


@given(st.floats(-1.0, 0.999), st.floats(1e-6, 1.0))
def test_curling_up_pulls_the_dorsal_cable_in_monotonically(start, step):
    end = min(start + step, 1.0)
    ramp = planar(PAPER.joint_limit * np.outer([start, end], np.ones(PAPER.n_joint)))
    change = cables.lengths(PAPER, ramp).change
    assert change[1, 0] > change[0, 0]
    assert (change[1, 1:] < change[0, 1:]).all()


@given(SHAPES)
def test_mirror_symmetry_swaps_the_ventral_cables(bend):
    cable, mirror = cables.lengths(PAPER, bend), cables.lengths(PAPER, bend * [-1.0, 1.0])
    np.testing.assert_allclose(mirror.change, cable.change[[0, 2, 1]], rtol=0, atol=1e-14)
    np.testing.assert_allclose(mirror.points, cable.points * [1.0, 1.0, -1.0], rtol=0, atol=1e-13)


@given(SHAPES)
def test_turning_the_bend_from_cable_to_cable_permutes_them(bend):
    cos, sin = -0.5, math.sqrt(3) / 2
    turned = bend @ np.array([[cos, sin], [-sin, cos]])
    np.testing.assert_allclose(
        cables.lengths(PAPER, turned).change, cables.lengths(PAPER, bend).change[[2, 0, 1]], rtol=0, atol=1e-13
    )


@given(SHAPES, st.floats(0.1, 5.0))
def test_cables_scale_with_the_trunk(bend, factor):
    large = design_from_rules(b=0.16, arm_radius=0.044 * factor)
    np.testing.assert_allclose(
        cables.lengths(large, bend).length, factor * cables.lengths(PAPER, bend).length, rtol=1e-12
    )


def test_the_change_starts_with_the_slope_of_the_lever():
    """d(change)/d(bend) of one straight joint is its lever R cos(limit / 2) cos(angle of the cable)."""
    step, joint = 1e-6, 4
    bend = np.zeros((2, PAPER.n_joint, 2))
    bend[:, joint, 1] = -step, step
    before, after = cables.lengths(PAPER, bend).change
    lever = PAPER.hole_to_joint[joint] * math.cos(PAPER.joint_limit / 2) * np.cos(PAPER.cable.angles)
    np.testing.assert_allclose((after - before) / (2 * step), lever, rtol=1e-7)


def test_batches_equal_single_shapes():
    bend = np.random.default_rng(2).uniform(-0.36, 0.36, (2, 3, PAPER.n_joint, 2))
    batch = cables.lengths(PAPER, bend)
    assert batch.points.shape == (2, 3, 18, 3)
    assert batch.gap.shape == (2, 3, 17, 3)
    assert batch.length.shape == batch.change.shape == (2, 3, 3)
    for i, j in np.ndindex(2, 3):
        single = cables.lengths(PAPER, bend[i, j])
        for name in ("points", "gap", "length", "change"):
            np.testing.assert_allclose(getattr(batch, name)[i, j], getattr(single, name), rtol=0, atol=1e-15)


def test_rotations_with_torsion_are_taken_too():
    """Half a turn of every joint about the axis carries each cable's hole to the far side."""
    two = replace(PAPER, cable=CableDesign(angles=(0.0, math.pi)))
    twist = np.tile(np.diag([1.0, -1.0, -1.0]), (two.n_joint, 1, 1))
    gap = cables.lengths_from_rotations(two, twist).gap
    axial, ring = two.hole_position[..., 0], two.hole_position[..., 1]
    along = two.section_length[:-1] - axial[:-1, 1] + axial[1:, 0]
    np.testing.assert_allclose(gap, np.tile(np.hypot(along, ring[:-1, 1] + ring[1:, 0])[:, None], 2), rtol=1e-12)


@pytest.mark.parametrize("design", [PAPER, PLANAR], ids=["paper", "planar"])
def test_holes_set_back_lie_deeper_in_both_sections(design):
    """Away from the joint on both sides, along the section's axis, in proportion to the face."""
    back = 0.08 * design.face_half_width * design.scale
    face, deep = cables.hole_positions(design), cables.hole_positions(design, 0.08)
    distal, proximal = (deep[side] - face[side] for side in (0, 1))
    np.testing.assert_allclose(distal[..., 0], np.tile(back[1:, None], design.n_cable), rtol=1e-12)
    np.testing.assert_allclose(proximal[..., 0], -np.tile(back[:-1, None], design.n_cable), rtol=1e-12)
    np.testing.assert_allclose([distal[..., 1:], proximal[..., 1:]], 0.0, atol=1e-15)


@pytest.mark.parametrize(
    "bend",
    [0.0, np.zeros(2), np.zeros((16, 2)), np.zeros((17, 3)), np.full((17, 2), np.inf), np.full((17, 2), np.nan)],
)
def test_bends_that_do_not_fit_are_refused(bend):
    with pytest.raises(ShapeError, match=r"joint_bend (has shape .*\(\.\.\., 17, 2\)|is (inf|nan))"):
        cables.lengths(PAPER, bend)
