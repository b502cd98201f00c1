"""A trunk wrapped round a circle: bends of joints whose sections touch it, and which joints wrap it."""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign

WRAP_TURN = math.radians(250.0)
"""Turning of the tip part that wraps an object [rad] (ours: short of a full turn, as the tip ends under the trunk)."""


def snug_bend(design: TrunkDesign, width: float) -> np.ndarray:
    """Bend of each joint of a trunk whose sections all touch a circle at their middles, at most the joint limit.

    bend_i = atan(l_i / (w + 2 r_i)) + atan(l_(i+1) / (w + 2 r_(i+1))), with section lengths l and radii r.

    Args:
        design: the trunk.
        width: diameter w of the circle [m].

    Returns:
        Bends, shape (n_joint,) [rad].
    """
    half = np.arctan(design.section_length / 2 / (width / 2 + design.section_radius))
    return np.minimum(half[:-1] + half[1:], design.joint_limit)


def first_wrapped(bend: np.ndarray) -> int:
    """Index of the first joint of the tip part that turns by at most `WRAP_TURN`, bends of shape (n_joint,) [rad]."""
    return int(np.count_nonzero(np.cumsum(bend[::-1])[::-1] > WRAP_TURN))
