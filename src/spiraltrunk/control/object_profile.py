"""Geometry of an object in the pose in which it is presented: sections by height, centre of mass, stability."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from spiraltrunk.field_docs import explain_fields

GRIP_SLOPE = 0.25
"""Largest slope of opposite walls, half the change of the width over that of the height, at which fingers hold them
with a margin by friction alone (ours: half the least coefficient of friction that trials draw) [-]."""

GRIP_INSET = 0.1
"""Share of the height at the foot and at the top that is no place for fingers (ours) [-]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, eq=False)
class StablePose:
    """A pose in which the object rests on a plane."""

    rotation: np.ndarray
    """Rotation of the object's frame into the world, z up, shape (3, 3) [-]."""
    probability: float
    """Probability of coming to rest so after a throw without spin, quasi-static (Goldberg et al., Part pose statistics,
    IEEE Trans. Robot. Autom. 1999) [-]."""
    height: float
    """Height of the object [m]."""
    center_height: float
    """Height of the centre of mass [m]."""
    topple_angle: float
    """Least tilt by which it falls over; 0 where it rolls [rad]."""

    @property
    def rotation_wxyz(self) -> np.ndarray:
        """The rotation as a unit quaternion, w first and not negative, shape (4,) [-]."""
        from scipy.spatial.transform import Rotation

        x, y, z, w = Rotation.from_matrix(self.rotation).as_quat(canonical=True)
        return np.array([w, x, y, z]) + 0.0  # No -0.


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ObjectProfile:
    """Horizontal sections of an object at rest, from its lowest point up, by what it collides with."""

    height: np.ndarray
    """Heights of the sections from 0 to the object's height, ascending, shape (n,) [m]."""
    width_least: np.ndarray
    """Least caliper width of each section: the least distance of two parallel lines that enclose it, shape (n,) [m]."""
    width_most: np.ndarray
    """Largest caliper width of each section, its diameter, shape (n,) [m]."""
    girth: np.ndarray
    """Perimeter of each section's convex hull, shape (n,) [m]."""
    center_height: float
    """Height of the centre of mass [m]."""
    topple_angle: float
    """Least tilt by which it falls over, over all directions; 0 where it rolls or does not stand [rad]."""
    support_radius: float
    """Least horizontal distance of the centre of mass from the edge about which it tilts: its weight times this is the
    moment that tilts it; 0 where it rolls or does not stand [m]."""
    stable_poses: tuple[StablePose, ...] = ()
    """Poses in which it rests on a plane, the most probable first; empty where they were not computed."""

    @property
    def total_height(self) -> float:
        """Height of the object [m]."""
        return float(self.height[-1])

    @cached_property
    def grip_index(self) -> int:
        """Section of the least width among those that fingers hold: `GRIP_SLOPE`, `GRIP_INSET`.

        Where there is none, of those of the least slope the nearest to the centre of mass; of a prism, whose widths are
        all equal, too.
        """
        slope = np.abs(np.gradient(self.width_least, self.height)) / 2
        share = self.height / self.total_height
        inner = (share >= GRIP_INSET) & (share <= 1 - GRIP_INSET)
        fit = inner & (slope <= GRIP_SLOPE)
        cost = np.where(fit, self.width_least, np.inf) if fit.any() else np.where(inner, slope, np.inf)
        equal = np.flatnonzero(cost <= cost.min() * (1 + 1e-3) + 1e-9)
        return int(equal[np.argmin(np.abs(self.height[equal] - self.center_height))])

    @property
    def grip_width(self) -> float:
        """Least width that fingers can hold [m]."""
        return float(self.width_least[self.grip_index])

    @property
    def grip_height(self) -> float:
        """Height of the least width that fingers can hold [m]."""
        return float(self.height[self.grip_index])

    def at(self, height: float) -> tuple[float, float, float]:
        """Least width, largest width and girth at a height, by linear interpolation [m]."""
        least, most, girth = (
            float(np.interp(height, self.height, values)) for values in (self.width_least, self.width_most, self.girth)
        )
        return least, most, girth
