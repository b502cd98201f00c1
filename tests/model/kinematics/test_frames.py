"""Rotations of joints against SciPy's, frames against the chain written out, the curled trunk against the spiral."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.rules import design_from_rules
from spiraltrunk.design.spiral import points
from spiraltrunk.errors import ShapeError
from spiraltrunk.model.kinematics.frames import bend_rotation, section_ends, section_frames

BENDS = arrays(float, (2,), elements=st.floats(-3.0, 3.0))
SHAPES = arrays(float, (PAPER.n_joint, 2), elements=st.floats(-0.5, 0.5))


@given(BENDS)
def test_bend_rotation_is_the_exponential_of_its_vector(bend):
    expected = Rotation.from_rotvec([0.0, *bend]).as_matrix()
    np.testing.assert_allclose(bend_rotation(bend), expected, rtol=0, atol=1e-14)


@given(BENDS)
def test_bend_rotation_is_a_rotation(bend):
    rotation = bend_rotation(bend)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), rtol=0, atol=1e-14)
    assert np.linalg.det(rotation) == pytest.approx(1.0, abs=1e-14)


@given(BENDS)
def test_bend_rotation_has_no_torsion(bend):
    """Its axis has no part along x, so that the matrix is symmetric in y and z."""
    rotation = bend_rotation(bend)
    assert rotation[1, 2] == pytest.approx(rotation[2, 1], abs=1e-15)


@given(BENDS)
def test_bending_back_undoes_the_bend(bend):
    np.testing.assert_allclose(bend_rotation(-bend), bend_rotation(bend).T, rtol=0, atol=1e-15)


@given(arrays(float, (2,), elements=st.floats(-1e-9, 1e-9)))
def test_a_tiny_bend_keeps_its_digits(bend):
    b_y, b_z = bend
    np.testing.assert_allclose(bend_rotation(bend)[:, 0], [1.0, b_z, -b_y], rtol=1e-15, atol=1e-18)


def test_no_bend_is_no_rotation():
    assert (bend_rotation(np.zeros((4, 2))) == np.eye(3)).all()


def test_a_bend_about_z_turns_the_tip_dorsal():
    tip = bend_rotation([0.0, math.pi / 6])[:, 0]
    np.testing.assert_allclose(tip, [math.cos(math.pi / 6), 0.5, 0.0], atol=1e-15)


@given(SHAPES)
def test_frames_chain_translation_and_rotation(bend):
    rotation = bend_rotation(bend)
    frames = section_frames(PAPER, rotation)
    T_base_section = np.eye(4)
    for n in range(PAPER.n_section):
        np.testing.assert_allclose(frames[n], T_base_section, rtol=0, atol=1e-13)
        step = np.eye(4)
        step[0, 3] = PAPER.section_length[n]
        if n < PAPER.n_joint:
            step[:3, :3] = rotation[n]
        T_base_section = T_base_section @ step
    np.testing.assert_allclose(section_ends(PAPER, frames)[-1], T_base_section[:3, 3], rtol=0, atol=1e-13)


@given(SHAPES)
def test_sections_keep_their_lengths(bend):
    ends = section_ends(PAPER, section_frames(PAPER, bend_rotation(bend)))
    steps = np.diff(ends, axis=0, prepend=np.zeros((1, 3)))
    np.testing.assert_allclose(np.linalg.norm(steps, axis=-1), PAPER.section_length, rtol=1e-12)


@given(SHAPES)
def test_a_mirrored_bend_gives_the_mirrored_trunk(bend):
    ends = section_ends(PAPER, section_frames(PAPER, bend_rotation(bend)))
    mirror = section_ends(PAPER, section_frames(PAPER, bend_rotation(bend * [-1.0, 1.0])))
    np.testing.assert_allclose(mirror, ends * [1.0, 1.0, -1.0], rtol=0, atol=1e-13)


@given(SHAPES, st.floats(-math.pi, math.pi))
def test_turning_the_bends_about_x_turns_the_trunk(bend, angle):
    turn = Rotation.from_rotvec([angle, 0.0, 0.0])
    turned = turn.apply(np.column_stack([np.zeros(len(bend)), bend]))[:, 1:]
    ends = section_ends(PAPER, section_frames(PAPER, bend_rotation(bend)))
    np.testing.assert_allclose(
        section_ends(PAPER, section_frames(PAPER, bend_rotation(turned))), turn.apply(ends), rtol=0, atol=1e-13
    )


@given(st.floats(0.05, 0.4), st.sampled_from([4, 6, 8, 12]))
def test_the_fully_curled_trunk_is_the_spiral_that_it_was_cut_from(b, parts):
    """Every joint at its limit: the backbone's corners lie on the spiral again, up to a rigid motion."""
    design = design_from_rules(b=b, delta_theta=math.pi / parts)
    curl = np.tile([0.0, design.joint_limit], (design.n_joint, 1))
    ends = section_ends(design, section_frames(design, bend_rotation(curl)))
    corners = np.vstack([np.zeros(3), ends])
    spiral = points(design.backbone, design.theta_base - design.delta_theta * np.arange(design.n_section + 1))

    def distances(place):
        return np.linalg.norm(place[:, None] - place[None], axis=-1)

    np.testing.assert_allclose(distances(corners), distances(spiral), rtol=0, atol=1e-11 * design.length)


def test_batches_equal_single_shapes():
    bend = np.random.default_rng(1).uniform(-0.5, 0.5, (2, 3, PAPER.n_joint, 2))
    rotation = bend_rotation(bend)
    frames = section_frames(PAPER, rotation)
    assert frames.shape == (2, 3, PAPER.n_section, 4, 4)
    for i, j in np.ndindex(2, 3):
        assert (rotation[i, j] == bend_rotation(bend[i, j])).all()
        np.testing.assert_allclose(frames[i, j], section_frames(PAPER, rotation[i, j]), rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    "rotation",
    [np.eye(3), np.zeros((16, 3, 3)), np.zeros((18, 3, 3)), np.zeros((17, 3)), np.full((17, 3, 3), np.nan), 1.0],
)
def test_rotations_that_do_not_fit_are_refused(rotation):
    with pytest.raises(ShapeError, match=r"joint_rotation (has shape .*; allowed: \(\.\.\., 17, 3, 3\)|is nan)"):
        section_frames(PAPER, rotation)
