"""Cable lengths of a shape, in three dimensions and in the plane."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.checks import Range, read_numbers
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ShapeError
from spiraltrunk.model.kinematics.frames import bend_rotation, section_ends, section_frames


@final
@dataclass(frozen=True, kw_only=True)
class CableLengths:
    """Section ends and cable lengths of a shape."""

    points: np.ndarray
    """Section ends, base to tip, in the base frame, shape (..., n_section, 3) [m]."""
    gap: np.ndarray
    """Length of each cable across each joint's gap, shape (..., n_joint, n_cable) [m]."""
    length: np.ndarray
    """Length of each cable from the first hole to the last, shape (..., n_cable) [m]."""
    change: np.ndarray
    """Straight length minus length, positive = pulled in, shape (..., n_cable) [m]."""


def lengths(design: TrunkDesign, joint_bend: ArrayLike) -> CableLengths:
    """Cable lengths of a trunk whose joints bend without torsion.

    Args:
        design: the trunk.
        joint_bend: bends about y and z of each joint, shape (..., n_joint, 2) [rad].

    Raises:
        ShapeError: where the bends are not two finite numbers per joint.
    """
    bend = read_numbers("joint_bend", joint_bend, shape=(..., design.n_joint, 2), error=ShapeError)
    return lengths_from_rotations(design, bend_rotation(bend))


def lengths_from_rotations(design: TrunkDesign, joint_rotation: ArrayLike) -> CableLengths:
    """Cable lengths from the rotations of the joints.

    Args:
        design: the trunk.
        joint_rotation: rotation of each joint, shape (..., n_joint, 3, 3) [-].

    Raises:
        ShapeError: where the rotations are not one finite 3 x 3 matrix per joint.
    """
    rotation = np.asarray(joint_rotation, float)
    points = section_ends(design, section_frames(design, rotation))
    gap = np.linalg.norm(gap_vectors(design, rotation), axis=-1)
    total = gap.sum(axis=-2)
    length = float(design.cable_in_section.sum()) + total
    return CableLengths(points=points, gap=gap, length=length, change=design.cable_stroke - total)


def gap_vectors(design: TrunkDesign, joint_rotation: np.ndarray) -> np.ndarray:
    """Vectors from proximal to distal hole in the proximal section's frame, shape (..., n_joint, n_cable, 3) [m]."""
    distal, proximal = hole_positions(design)
    return np.einsum("...jkl,jcl->...jck", joint_rotation, distal) - proximal


def planar_lever(design: TrunkDesign, bend: ArrayLike) -> np.ndarray:
    """Moment about z per tension of each cable at each joint, in a trunk that bends about z alone.

    Projected along z, the two holes at a joint are at distances r and s from it and subtend the angle p, which
    decreases as the joint bends; their offset along z is w. The cable's length across the gap is

        l = sqrt((r - s)^2 + w^2 + 4 r s sin(p / 2)^2),

    its lever is minus the derivative by the bend, r s sin(p) / l, which tends to r cos(p / 2) as the gap closes.

    Args:
        design: the trunk.
        bend: bend about z of each joint, shape (..., n_joint) [rad]; positive is dorsal.

    Returns:
        Levers, positive where the cable pulls the tip dorsal, shape (..., n_joint, n_cable) [m].
    """
    product, rest, half = _planar_holes(design, bend)
    is_open = rest > 0
    gap = np.sqrt(np.where(is_open, rest + 4 * product * np.sin(half) ** 2, 1.0))
    pull = np.where(is_open, product * np.sin(2 * half) / gap, np.sqrt(product) * np.cos(half))
    return _planar_side(design) * pull


def planar_gap(design: TrunkDesign, bend: ArrayLike) -> np.ndarray:
    """Length of each cable across each gap of a trunk that bends about z alone, shape (..., n_joint, n_cable) [m]."""
    product, rest, half = _planar_holes(design, bend)
    return np.sqrt(rest + 4 * product * np.sin(half) ** 2)


def _planar_holes(design: TrunkDesign, bend: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Product r s [m^2], (r - s)^2 + w^2 [m^2] and p / 2 [rad] of `planar_lever`, last axes (n_joint, n_cable)."""
    product, rest, angle = _straight_holes(design)
    return product, rest, (angle - _planar_side(design) * np.asarray(bend, float)[..., None]) / 2


@lru_cache(maxsize=16)
def _straight_holes(design: TrunkDesign) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """r s, (r - s)^2 + w^2 and p of `planar_lever` in the straight trunk, shapes (n_joint, n_cable); read-only."""
    beyond, before = hole_positions(design)
    r, s = np.hypot(beyond[..., 0], beyond[..., 1]), np.hypot(before[..., 0], before[..., 1])
    side = _planar_side(design)
    angle = np.arctan2(side * before[..., 1], before[..., 0]) - np.arctan2(side * beyond[..., 1], beyond[..., 0])
    rest = (r - s) ** 2 + (beyond[..., 2] - before[..., 2]) ** 2
    rest = np.where(rest > 1e-24 * r * s, rest, 0.0)  # In the plane r and s differ by rounding alone.
    return r * s, rest, angle


def _planar_side(design: TrunkDesign) -> np.ndarray:
    """Side of each cable, 1 dorsal, -1 ventral, shape (n_cable,) [-]."""
    return np.where(design.cable_direction[:, 1] < 0, -1.0, 1.0)


def hole_positions(design: TrunkDesign, set_back: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Positions of the holes distal and proximal to each joint, from its centre, in the axes of their sections.

    Args:
        design: the trunk.
        set_back: distance of the holes behind the face over the face's half-width [-].

    Returns:
        Two arrays of shape (n_joint, n_cable, 3) [m].
    """
    axial, ring = design.hole_position[..., 0], design.hole_position[..., 1]
    along = np.array([1.0, 0.0, 0.0])
    behind = set_back * design.face_half_width * design.scale
    beyond = (axial[1:, 0] + behind[1:])[:, None, None] * along + ring[1:, 0, None, None] * design.cable_direction
    back = axial[:-1, 1] - design.section_length[:-1] - behind[:-1]
    before = back[:, None, None] * along + ring[:-1, 1, None, None] * design.cable_direction
    return beyond, before


PULL_MARGIN = 1.01
"""Largest pull over the one that closes every gap [-]: the paper itself pulls 130 mm of 129.86."""


def pull_range(full: float) -> Range:
    """Accepted pulls where ``full`` closes every gap [m], with a margin for rounding."""
    return Range(least=0.0, most=PULL_MARGIN * full * (1 + 1e-12))
