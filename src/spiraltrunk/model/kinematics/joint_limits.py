"""Joint limit for arrays: neighbouring sections bend until their faces meet, by the same angle in any direction.

Where the limit is part of an equilibrium it is an active set, compiled: `model.statics.kernels.joint_limits` in space,
`model.reference.gravity_rest` in the plane. A test holds all of them together.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def clip_bend(bend: ArrayLike, limit: float) -> np.ndarray:
    """Planar bends within ``limit`` [rad] to either side, shape of ``bend`` [rad]."""
    return np.clip(np.asarray(bend, float), -limit, limit)


def joint_angle(joint_rotation: np.ndarray) -> np.ndarray:
    """Angle between the axes of neighbouring sections, which the limit bounds: shapes (..., 3, 3) -> (...) [rad]."""
    across = np.hypot(joint_rotation[..., 1, 0], joint_rotation[..., 2, 0])
    return np.arctan2(across, joint_rotation[..., 0, 0])
