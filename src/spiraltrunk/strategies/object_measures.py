"""Measures of an announced object as it stands: extents over the height, centre of mass, force that topples it.

They are read from the target's profile. A target without one counts as a prism of its width and length.
"""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.control.messages import Target
from spiraltrunk.design.rules import GRAVITY

UPRIGHT = 0.7
"""Least vertical part of the axis of an object that stands, and least cosine of the angle by which the axis of one that
has not fallen over has turned [-] (ours): about 45 deg."""

TOPPLED = math.radians(45.0)
"""Tilt from which a standing object has toppled [rad] (ours): halfway between standing and lying."""


def is_upright(target: Target) -> bool:
    """Whether the object's axis is nearer to the vertical than to the horizontal."""
    return abs(float(target.axis[2])) > UPRIGHT


def height_of(target: Target) -> float:
    """Extent upwards [m]."""
    profile = target.profile
    if profile is not None:
        return profile.total_height
    return target.length if is_upright(target) else target.width


def cone_slope(target: Target) -> float:
    """Angle from its axis by which the wall of a standing cone narrows upwards [rad]; 0 for another object.

    A finger that presses on it with N lifts by N (mu cos a - sin a): by nothing where tan a is the friction or more.
    """
    return math.atan2(target.width / 2, target.length) if target.kind == "cone" and is_upright(target) else 0.0


def narrowing(target: Target, low: float, high: float) -> float:
    """Angle by which the sides of an object narrow upwards everywhere from ``low`` to ``high`` above the ground [rad].

    It is the least one of the circle of the object's girth: 0 where a part of it is straight, as of a bottle.
    """
    profile = target.profile
    if profile is None:
        return cone_slope(target)
    heights = np.linspace(low, high, 9)
    radii = np.interp(heights, profile.height, profile.girth) / (2.0 * math.pi)
    return max(0.0, math.atan(float((-np.diff(radii)).min()) / float(heights[1] - heights[0])))


def widths_between(target: Target, low: float, high: float) -> tuple[float, float]:
    """Least and largest horizontal width of the part from ``low`` to ``high`` above the ground [m].

    The least is that in the direction across which the part is narrowest; both are of its widest section.
    """
    profile = target.profile
    if profile is None:
        most = target.width if is_upright(target) or target.kind == "sphere" else target.length
        return target.width, most
    heights = np.clip(np.linspace(low, high, 9), profile.height[0], profile.height[-1])
    least, most = (np.interp(heights, profile.height, width) for width in (profile.width_least, profile.width_most))
    return float(least.max()), float(most.max())


def girth_width_between(target: Target, low: float, high: float) -> float:
    """Width of the cylinder that has the largest girth from ``low`` to ``high`` above the ground [m]."""
    if target.profile is None:
        return sum(widths_between(target, low, high)) / 2
    heights = np.linspace(low, high, 9)
    return float(np.interp(heights, target.profile.height, target.profile.girth).max()) / math.pi


def center_height_of(target: Target) -> float:
    """Height of the centre of mass above the ground [m]."""
    profile = target.profile
    return height_of(target) / 2 if profile is None else float(profile.center_height)


def topple_angle_of(target: Target) -> float:
    """Least angle by which the object must tilt to fall over [rad]; 0 for one that rolls."""
    profile = target.profile
    if profile is not None:
        return float(profile.topple_angle)
    rolls = target.kind == "sphere" or (target.kind != "box" and not is_upright(target))
    return 0.0 if rolls else math.atan2(target.width, height_of(target))


def topple_force(target: Target, height: float) -> float:
    """Least horizontal force at ``height`` above the ground [m] that topples the object [N].

    F = m g d / h, with the horizontal distance d of the centre of mass from the edge over which the object tilts.
    """
    lever = center_height_of(target) * math.tan(topple_angle_of(target))
    if target.profile is not None:
        lever = target.profile.support_radius
    return target.mass * GRAVITY * lever / max(height, 1e-6)
