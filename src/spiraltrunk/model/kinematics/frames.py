"""Rigid transforms along the trunk: rotations of the joints, frames of the sections."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.checks import read_numbers
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ShapeError


def bend_rotation(bend: ArrayLike) -> np.ndarray:
    """Rotation without torsion by the vector (0, b_y, b_z) in the section's frame (Rodrigues' formula).

    Args:
        bend: bends about y and z, shape (..., 2) [rad]; +b_z alone turns the tip dorsal, as in the paper's T.

    Returns:
        Matrices, shape (..., 3, 3) [-].
    """
    bend = np.asarray(bend, float)
    axis = np.concatenate([np.zeros((*bend.shape[:-1], 1)), bend], axis=-1)
    angle = np.linalg.norm(axis, axis=-1)[..., None, None]
    cross = np.zeros((*bend.shape[:-1], 3, 3))
    cross[..., 0, 1], cross[..., 0, 2] = -axis[..., 2], axis[..., 1]
    cross[..., 1, 0], cross[..., 1, 2] = axis[..., 2], -axis[..., 0]
    cross[..., 2, 0], cross[..., 2, 1] = -axis[..., 1], axis[..., 0]
    half = np.sinc(angle / (2 * np.pi))  # sin(angle / 2) / (angle / 2), exact at 0.
    return np.eye(3) + np.sinc(angle / np.pi) * cross + half**2 / 2 * cross @ cross


def section_frames(design: TrunkDesign, joint_rotation: ArrayLike) -> np.ndarray:
    """Frames of all sections in the base frame.

    Args:
        design: the trunk.
        joint_rotation: rotation of each joint, shape (..., n_joint, 3, 3) [-].

    Returns:
        Frames in the proximal joint centres, shape (..., n_section, 4, 4) [-, m].

    Raises:
        ShapeError: where the rotations are not one finite 3 x 3 matrix per joint.
    """
    rotation = read_numbers("joint_rotation", joint_rotation, shape=(..., design.n_joint, 3, 3), error=ShapeError)
    frames = np.zeros((*rotation.shape[:-3], design.n_section, 4, 4))
    frames[..., 3, 3] = 1.0
    frames[..., 0, :3, :3] = np.eye(3)
    for n in range(1, design.n_section):
        before = frames[..., n - 1, :, :]
        frames[..., n, :3, :3] = before[..., :3, :3] @ rotation[..., n - 1, :, :]
        frames[..., n, :3, 3] = before[..., :3, 3] + design.section_length[n - 1] * before[..., :3, 0]
    return frames


def section_ends(design: TrunkDesign, frames: np.ndarray) -> np.ndarray:
    """Distal ends of all sections, base to tip, shape (..., n_section, 3) [m]."""
    return frames[..., :3, 3] + design.section_length[:, None] * frames[..., :3, 0]


def base_orientation(theta_0: ArrayLike, roll: ArrayLike = 0.0) -> np.ndarray:
    """Axes of the base in the frame of `Shape`: rotation by -theta_0 about z, then by ``roll`` about its own x axis.

    Args:
        theta_0: angle of the base axis below the horizontal, shape (...) [rad].
        roll: rotation about the base axis, shape (...) [rad].

    Returns:
        Matrices, shape (..., 3, 3) [-].
    """
    if type(theta_0) is float and type(roll) is float:
        both = np.array((theta_0, roll))
        (c, cr), (s, sr) = np.cos(both).tolist(), np.sin(both).tolist()
        return np.array(((c, s * cr, -s * sr), (-s, c * cr, -c * sr), (0.0, sr, cr)))
    down, turn = np.asarray(theta_0, float), np.asarray(roll, float)
    if down.ndim == turn.ndim == 0:
        return base_orientation(float(down), float(turn))
    down, turn = np.broadcast_arrays(down, turn)
    c, s, cr, sr = np.cos(down), np.sin(down), np.cos(turn), np.sin(turn)
    rows = [[c, s * cr, -s * sr], [-s, c * cr, -c * sr], [np.zeros_like(c), sr, cr]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
