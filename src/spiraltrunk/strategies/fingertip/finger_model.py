"""Planning model of a finger of the tip gripper, bent by its cables alone.

A strand passes each joint at the same part of its phalanx's width: one tension gives torques in proportion to the
width. Stiffness falls with the width's cube, so that the last phalanx bends first, as in the trunk.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.design.gripper import STRAND_LEVER, GripperDesign
from spiraltrunk.model.kinematics.joint_limits import clip_bend

_TENSIONS, _SAMPLES = 81, 20
"""Number of tensions tried, and of points along a phalanx."""


def finger_bend(gripper: GripperDesign, tension: ArrayLike) -> np.ndarray:
    """Bend of a free finger's joints: torque over stiffness, up to the limit, inwards positive, (..., n_phalanx) [rad].

    ``tension``, of any shape [N], is that of the closing cables where positive, of the opening ones where negative.
    """
    torque = STRAND_LEVER * gripper.phalanx_width * np.asarray(tension)[..., None]
    return clip_bend(torque / gripper.joint_stiffness, gripper.delta_theta)


def finger_points(gripper: GripperDesign, bend: np.ndarray) -> np.ndarray:
    """Joints and tip of a finger: distance from the trunk's axis, and depth beyond the trunk's end.

    Bends of shape (..., n_phalanx) [rad] give points of shape (..., n_phalanx + 1, 2) [m].
    """
    angle = np.cumsum(bend, axis=-1)
    steps = gripper.phalanx_length[:, None] * np.stack([-np.sin(angle), np.cos(angle)], axis=-1)
    start = np.broadcast_to([gripper.mount_radius, 0.0], (*angle.shape[:-1], 1, 2))
    return np.concatenate([start, start + np.cumsum(steps, axis=-2)], axis=-2)


def opening_tension(gripper: GripperDesign, outline: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> float | None:
    """Least tension of the opening cables at which the fingers clear a body of revolution [N]; None where they cannot.

    ``outline`` gives the least distance from the axis that a ball may have, from its depth beyond the trunk's end and
    its radius [m].
    """
    tensions = np.linspace(0.0, gripper.tension_max, _TENSIONS)
    points = finger_points(gripper, finger_bend(gripper, -tensions))
    share = np.linspace(0.0, 1.0, _SAMPLES)[:, None, None, None]
    along = points[:, :-1] + share * np.diff(points, axis=1)
    is_clear = (along[..., 0] >= outline(along[..., 1], gripper.phalanx_width / 2)).all(axis=(0, 2))
    return float(tensions[is_clear.argmax()]) if is_clear.any() else None


def closing_tension(gripper: GripperDesign, radius: float, force: float) -> float:
    """Tension of the closing cables with which each tip presses with ``force`` [N] on a circle of ``radius`` [m] [N].

    Joint 1 carries the force at a straight finger's length, and its own stiffness at the bend that brings the tip
    there; joint 2 and beyond need less.
    """
    reach = float(np.clip((gripper.mount_radius - radius) / gripper.finger_length, -1.0, 1.0))
    torque = force * gripper.finger_length + float(gripper.joint_stiffness[0]) * float(np.arcsin(reach))
    return float(np.clip(torque / (STRAND_LEVER * gripper.phalanx_width[0]), 0.0, gripper.tension_max))
