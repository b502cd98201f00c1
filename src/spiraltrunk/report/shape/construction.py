"""Construction of a trunk from its spiral, as lines in the plane of the curled trunk (paper, figure 4a).

Coordinates are the paper's: the pole is the origin, x = -r cos(theta), y = r sin(theta) [m].
"""

from __future__ import annotations

import math
from typing import NamedTuple, final

import numpy as np

from spiraltrunk.design.rules import graspable_range
from spiraltrunk.design.spiral import points
from spiraltrunk.design.trunk import TrunkDesign

_STEP = math.radians(5.0)
"""Angle between points of a drawn spiral [rad]."""


@final
class Construction(NamedTuple):
    """Lines of the construction."""

    outer: np.ndarray
    """Outer contour r = a exp(b theta), from the tip to the base, shape (n, 2) [m]."""
    backbone: np.ndarray
    """Backbone k r(theta), through the joint centres, shape (n, 2) [m]."""
    inner: np.ndarray
    """Inner contour, the outer one a turn further in, shape (n, 2) [m]."""
    rays: np.ndarray
    """Rays from the pole through the faces of the sections to the outer contour, shape (n_section + 1, 2, 2) [m]."""
    sections: np.ndarray
    """Quadrilaterals between backbone and inner contour, which are revolved, shape (n_section, 4, 2) [m]."""
    tangent: np.ndarray
    """Tangent of the outer contour at the base; its angle to the ray is atan(1 / b) everywhere, shape (2, 2) [m]."""
    smallest: np.ndarray
    """Circle as wide as the smallest object, beside the inner contour at the tip, shape (n, 2) [m]."""


def build_construction(design: TrunkDesign) -> Construction:
    """Lines of the construction of a design."""
    count = max(2, math.ceil((design.theta_base - design.theta_tip) / _STEP) + 1)
    theta = np.linspace(design.theta_tip, design.theta_base, count)
    faces = design.theta_base - design.delta_theta * np.arange(design.n_section + 1)
    outer, turn = design.spiral, 2 * math.pi
    backbone, inner = points(design.backbone, faces), points(outer, faces - turn)
    rim = points(outer, faces)
    return Construction(
        outer=points(outer, theta), backbone=points(design.backbone, theta), inner=points(outer, theta - turn),
        rays=np.stack([np.zeros_like(rim), rim], axis=1),
        sections=np.stack([backbone[:-1], backbone[1:], inner[1:], inner[:-1]], axis=1),
        tangent=_build_tangent(design), smallest=_build_smallest(design),
    )  # fmt: skip


def curled_pose(design: TrunkDesign) -> np.ndarray:
    """Frame of the base in which the trunk curled to its limits lies on the construction, shape (4, 4) [-, m].

    Its joint centres are points of the backbone's spiral. Coordinates are the paper's x and y, and z perpendicular to
    both.
    """
    ends = points(design.backbone, design.theta_base - design.delta_theta * np.arange(2))
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    pose = np.eye(4)
    pose[:2, 0] = along
    pose[:2, 1] = along[1], -along[0]  # Dorsal points away from the pole, as the trunk curls ventral.
    pose[2, 2] = -1.0
    pose[:2, 3] = ends[0]
    return pose


def _build_tangent(design: TrunkDesign) -> np.ndarray:
    theta = design.theta_base
    at = points(design.spiral, theta)
    slope = points(design.spiral, theta + 1e-6) - points(design.spiral, theta - 1e-6)
    half = design.face_half_width * slope / np.linalg.norm(slope)
    return np.stack([at - half, at + half])


def _build_smallest(design: TrunkDesign) -> np.ndarray:
    """The circle across the inner turn of the tip: HJ reaches from the tip to the contour half a turn outwards."""
    width = graspable_range(design).minimum
    start = points(design.spiral, design.theta_tip - 2 * math.pi)
    end = points(design.spiral, design.theta_tip - math.pi)
    middle = start + (end - start) / np.linalg.norm(end - start) * width / 2
    angle = np.linspace(0.0, 2 * math.pi, 61)
    return np.asarray(middle + width / 2 * np.stack([np.cos(angle), np.sin(angle)], axis=-1))
