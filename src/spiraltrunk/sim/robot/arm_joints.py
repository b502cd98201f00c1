"""Joints of a simulated arm, with the ranges that actions span."""

from __future__ import annotations

import numpy as np

from spiraltrunk.control.encoding import ArmJoints
from spiraltrunk.sim.robot.arm_ik import ArmReach

RANGE = np.pi
"""Largest position of a joint without a range [rad] (ours)."""

RANGE_MARGIN = 0.02
"""Distance from the ends of a joint's range that actions keep [rad] (ours)."""


def build_arm_joints(reach: ArmReach) -> ArmJoints:
    """Joints of an arm: the ranges that actions span, in environments and in recordings alike."""
    shape, limits = reach.home.shape, reach.limits.position
    low, high = (np.full(shape, -RANGE), np.full(shape, RANGE)) if limits is None else limits
    low, high = np.where(np.isfinite(low), low, -RANGE), np.where(np.isfinite(high), high, RANGE)
    return ArmJoints(low=low + RANGE_MARGIN, high=high - RANGE_MARGIN, T_base=reach.T_base)
