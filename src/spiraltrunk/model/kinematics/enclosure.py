"""The trunk round an object: joint bends of sections that touch a circle, and how far round they go."""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign

WRAP_TURN = math.radians(250.0)
"""Turning of the part that follows the object [rad]: short of a full turn, since the tip tucks in under the trunk."""


def snug_bend(design: TrunkDesign, width: float) -> np.ndarray:
    """Bend of each joint where all sections' middles touch a circle, up to the limit, shape (n_joint,) [rad]."""
    half = np.arctan(design.section_length / 2 / (width / 2 + design.section_radius))
    return np.minimum(half[:-1] + half[1:], design.joint_limit)
