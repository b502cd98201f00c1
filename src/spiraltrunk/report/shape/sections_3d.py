"""Geometry of a shape for its figure: sections as solids of revolution, and cables, in the frame of `Shape`, in mm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.model.kinematics.frames import base_orientation, section_frames
from spiraltrunk.model.kinematics.shape import Shape
from spiraltrunk.model.statics.pull_sequences import find_shut

_FACETS = 24
"""Facets round a section."""


@final
@dataclass(frozen=True, kw_only=True)
class Solids:
    """Sections, cables and joints in space, in the frame of `Shape`."""

    outline: np.ndarray
    """Rings of each section base to tip: proximal joint centre, two rims, distal joint centre; shape (n_section, 4,
    n_facet, 3) [mm]."""
    cable: np.ndarray
    """Holes that each cable passes, base to tip, shape (n_cable, 2 n_section, 3) [mm]."""
    center: np.ndarray
    """Joint centres, shape (n_joint, 3) [mm]."""
    is_shut: np.ndarray
    """Whether each joint is at its limit, shape (n_joint,) [bool]."""
    axis: np.ndarray
    """Direction of the base axis, shape (3,) [-]."""

    @property
    def bands(self) -> np.ndarray:
        """Quadrilaterals of the proximal face, the outside and the distal face, shape (n_section, 3, n_facet, 4, 3)."""
        ring, beside = self.outline, np.roll(self.outline, -1, axis=2)
        return np.stack([ring[:, :-1], ring[:, 1:], beside[:, 1:], beside[:, :-1]], axis=3)

    @property
    def gaps(self) -> np.ndarray:
        """Cable segments across the gaps, shape (n_cable, n_joint, 2, 3) [mm]."""
        return np.stack([self.cable[:, 1:-1:2], self.cable[:, 2::2]], axis=2)


def build_solids(design: TrunkDesign, shape: Shape, theta_0: float) -> Solids:
    """Geometry of one shape with the base axis ``theta_0`` below the horizontal [rad]."""
    base = base_orientation(theta_0)
    frames = section_frames(design, shape.joint_rotation)
    turn = base @ frames[:, :3, :3]
    origin = frames[:, :3, 3] @ base.T
    outline = _place(turn, origin, _profile(design))
    holes = _place(turn, origin, _holes(design))
    return Solids(
        outline=1e3 * outline,
        cable=1e3 * np.moveaxis(holes, 2, 0).reshape(design.n_cable, -1, 3),
        center=1e3 * origin[1:],
        is_shut=find_shut(design, shape),
        axis=base[:, 0],
    )


def _place(turn: np.ndarray, origin: np.ndarray, local: np.ndarray) -> np.ndarray:
    """Transform points (n_section, a, b, 3) from the sections' frames to that of `Shape`."""
    placed: np.ndarray = np.einsum("nij,nabj->nabi", turn, local) + origin[:, None, None]
    return placed


def _profile(design: TrunkDesign) -> np.ndarray:
    """Rings of each section in its frame, shape (n_section, 4, n_facet, 3) [m]."""
    solid = design.solid
    axial = np.array([0.0, solid.rim_start, solid.rim_end, solid.length])
    radial = np.array([0.0, solid.radius, solid.radius, 0.0])
    angle = np.linspace(0.0, 2 * np.pi, _FACETS, endpoint=False)
    across = np.stack([np.zeros(_FACETS), np.cos(angle), np.sin(angle)], axis=-1)
    first = axial[:, None, None] * np.array([1.0, 0.0, 0.0]) + radial[:, None, None] * across
    return design.scale[:, None, None, None] * first


def _holes(design: TrunkDesign) -> np.ndarray:
    """Proximal and distal hole of each cable in each section's frame, shape (n_section, 2, n_cable, 3) [m]."""
    axial, ring = design.hole_position[..., 0, None, None], design.hole_position[..., 1, None, None]
    return axial * np.array([1.0, 0.0, 0.0]) + ring * design.cable_direction
