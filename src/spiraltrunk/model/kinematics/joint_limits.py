"""Joint limit for arrays: neighbouring sections bend until their faces touch, by the same angle in any direction.

In an equilibrium the limit is an active set: `model.statics.kernels.laws.joint_limits` in space and
`model.reference.gravity_rest` in the plane. `tests/laws/test_joint_limit.py` compares them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def clip_bend(bend: ArrayLike, limit: float) -> np.ndarray:
    """Planar bends within ``limit`` [rad] to either side, shape of ``bend`` [rad]."""
    return np.clip(np.asarray(bend, float), -limit, limit)


def joint_angle(joint_rotation: np.ndarray) -> np.ndarray:
    """Angle between the axes of neighbouring sections, from rotations of shape (..., 3, 3), shape (...) [rad]."""
    across = np.hypot(joint_rotation[..., 1, 0], joint_rotation[..., 2, 0])
    return np.arctan2(across, joint_rotation[..., 0, 0])
