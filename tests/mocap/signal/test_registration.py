"""Rigid motions, frames and deviations obey their laws."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from spiraltrunk.errors import ShapeError, TakeError
from spiraltrunk.mocap.signal.deviation import compute_deviation
from spiraltrunk.mocap.signal.registration import (
    Alignment,
    fit_motion,
    frame_from_markers,
    is_straight,
    mean_rotation,
    read_alignment,
)

seeds = st.integers(0, 2**32 - 1)


@given(seeds, st.integers(3, 20))
def test_a_rigid_motion_is_found_again(seed, count):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(count, 3))
    turn, shift = Rotation.random(random_state=np.random.RandomState(seed)).as_matrix(), rng.normal(size=3)
    found = fit_motion(points, points @ turn.T + shift)
    np.testing.assert_allclose(found.rotation, turn, atol=1e-7)
    np.testing.assert_allclose(found.shift, shift, atol=1e-7)


@given(seeds)
def test_with_noise_it_is_what_scipy_finds(seed):
    rng = np.random.default_rng(seed)
    points, target = rng.normal(size=(2, 8, 3))
    found = fit_motion(points, target)
    turn, _ = Rotation.align_vectors(target - target.mean(axis=0), points - points.mean(axis=0))
    np.testing.assert_allclose(found.rotation, turn.as_matrix(), atol=1e-6)
    assert np.linalg.det(found.rotation) == pytest.approx(1.0)
    best = ((found.move(points) - target) ** 2).sum()
    for _ in range(5):
        other = Rotation.from_rotvec(rng.normal(0, 0.05, 3)).as_matrix() @ found.rotation
        moved = points @ other.T
        moved += (target - moved).mean(axis=0)
        assert ((moved - target) ** 2).sum() >= best - 1e-12


def test_unseen_points_are_left_out_and_two_are_too_few():
    points = np.vstack([np.eye(3), [[np.nan] * 3, [1.0, 1.0, 1.0]]])
    target = np.vstack([np.eye(3) + 1.0, np.zeros((1, 3)), [[np.nan] * 3]])
    np.testing.assert_allclose(fit_motion(points, target).shift, 1.0)
    with pytest.raises(ShapeError, match="2 points seen"):
        fit_motion(points[1:], target[1:])


def test_points_on_a_line_are_straight():
    line = np.linspace(0, 1, 9)[:, None] * np.array([1.0, 2.0, -1.0])
    assert is_straight(line)
    line[4, 0] += 0.1
    assert not is_straight(line)
    found = fit_motion(line[:4], line[:4] + 1.0)
    np.testing.assert_allclose(found.move(line[:4]), line[:4] + 1.0, atol=1e-12)


@given(seeds)
def test_three_markers_give_the_sections_frame(seed):
    turn = Rotation.random(random_state=np.random.RandomState(seed)).as_matrix()
    angle = 2 * np.pi / 3 * np.arange(3)
    ring = 0.04 * np.stack([np.zeros(3), np.cos(angle), np.sin(angle)], axis=-1)
    np.testing.assert_allclose(frame_from_markers(ring @ turn.T + 1.0), turn, atol=1e-9)


def test_markers_on_a_line_or_unseen_give_no_frame():
    markers = np.array([[[0.0, 0, 0], [0, 1, 0], [0, 2, 0]], [[0.0, 0, 0], [0, 1, 0], [np.nan, 0, 0]]])
    assert np.isnan(frame_from_markers(markers)).all()


def test_the_mean_rotation_of_equal_turns_either_way_is_none():
    turns = Rotation.from_rotvec([[0, 0, 0.3], [0, 0, -0.3], [0.2, 0, 0], [-0.2, 0, 0]]).as_matrix()
    np.testing.assert_allclose(mean_rotation(turns), np.eye(3), atol=1e-12)
    assert np.isnan(mean_rotation(np.full((2, 3, 3), np.nan))).all()
    unseen = np.concatenate([turns[:1], np.full((1, 3, 3), np.nan)])
    np.testing.assert_allclose(mean_rotation(unseen), turns[0], atol=1e-12)


@pytest.mark.parametrize(("text", "expected"), [
    ("base", Alignment(kind="base")), ("Run", Alignment(kind="run")),
    ("shape:1-5", Alignment(kind="shape", sections=(1, 2, 3, 4, 5))),
    ("run:8,1-2,2", Alignment(kind="run", sections=(1, 2, 8))),
])  # fmt: skip
def test_alignments_are_read(text, expected):
    assert read_alignment(text) == expected
    assert read_alignment(str(expected)) == expected


@pytest.mark.parametrize(
    "text", ["", "tip", "base:1-5", "run:", "run:0-5", "run:5-1", "run:1-2", "run:1-9999", "run:a", "run:1-5:2"]
)
def test_other_alignments_are_refused(text):
    with pytest.raises(TakeError, match="alignment is"):
        read_alignment(text)


def test_deviations_are_root_mean_squares():
    predicted = np.zeros((2, 3, 3))
    points = predicted.copy()
    points[0, :, 0] = [3.0, 4.0, np.nan]
    points[1, :, 1] = [0.0, 12.0, 5.0]
    found = compute_deviation(points, predicted)
    np.testing.assert_allclose(found.per_shape, [np.sqrt(12.5), np.sqrt(169 / 3)])
    np.testing.assert_allclose(found.per_section, [np.sqrt(4.5), np.sqrt(80), 5.0])
    assert found.mean_rmse == pytest.approx((np.sqrt(12.5) + np.sqrt(169 / 3)) / 2)
    assert (found.max_rmse, found.max_deviation) == (pytest.approx(np.sqrt(169 / 3)), 12.0)
    assert found.sections == [1, 2, 3]
    assert np.isnan(found.mean_turn)


def test_turns_are_the_angles_between_axes():
    turn = Rotation.from_rotvec([[0, 0, 0.3], [0.4, 0, 0]]).as_matrix()[None]
    eye = np.broadcast_to(np.eye(3), turn.shape)
    found = compute_deviation(np.zeros((1, 2, 3)), np.zeros((1, 2, 3)), turn, eye)
    np.testing.assert_allclose(found.turn, [[0.3, 0.4]])
    assert found.mean_turn == pytest.approx(0.35)


def test_a_shape_without_points_is_refused():
    with pytest.raises(ShapeError, match="shape 2 has no section"):
        compute_deviation(np.stack([np.zeros((2, 3)), np.full((2, 3), np.nan)]), np.zeros((2, 2, 3)))
