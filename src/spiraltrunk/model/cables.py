"""From a shape to the lengths of its cables, exact in three dimensions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ShapeError
from spiraltrunk.model.transforms import bend_rotation, section_ends, section_frames


@final
@dataclass(frozen=True, kw_only=True)
class CableLengths:
    """Where the trunk is and how long its cables are."""

    points: np.ndarray
    """Section ends, base to tip, in the base frame, shape (..., n_section, 3) [m]."""
    gap: np.ndarray
    """Length of each cable across each joint's gap, shape (..., n_joint, n_cable) [m]."""
    length: np.ndarray
    """Length of each cable from the first hole to the last, shape (..., n_cable) [m]."""
    change: np.ndarray
    """Straight length minus length, positive = pulled in, shape (..., n_cable) [m]."""


def lengths(design: TrunkDesign, joint_bend: ArrayLike) -> CableLengths:
    """Cables of a trunk whose joints bend without torsion.

    Args:
        design: the trunk.
        joint_bend: bends about y and z of each joint, shape (..., n_joint, 2) [rad].

    Raises:
        ShapeError: where the bends are not two finite numbers per joint.
    """
    bend = np.asarray(joint_bend, float)
    if bend.shape[-2:] != (design.n_joint, 2) or not np.isfinite(bend).all():
        raise ShapeError(f"joint_bend has shape {bend.shape}; allowed: finite, (..., {design.n_joint}, 2)")
    return lengths_from_rotations(design, bend_rotation(bend))


def lengths_from_rotations(design: TrunkDesign, joint_rotation: ArrayLike) -> CableLengths:
    """Cables of a trunk from the rotations of its joints, shape (..., n_joint, 3, 3) [-]."""
    rotation = np.asarray(joint_rotation, float)
    frames = section_frames(design, rotation)
    gap = np.linalg.norm(gap_vectors(design, rotation), axis=-1)
    inside = float(design.cable_in_section.sum())
    total = gap.sum(axis=-2)
    return CableLengths(
        points=section_ends(design, frames), gap=gap, length=inside + total, change=design.cable_stroke - total
    )


def gap_vectors(design: TrunkDesign, joint_rotation: np.ndarray) -> np.ndarray:
    """Cable across each gap from the proximal to the distal hole, in the proximal section's frame.

    Shape (..., n_joint, n_cable, 3) [m].
    """
    distal, proximal = _holes(design)
    return np.einsum("...jkl,jcl->...jck", joint_rotation, distal) - proximal


def planar_lever(design: TrunkDesign, bend: ArrayLike) -> np.ndarray:
    """Moment about z per tension of each cable at each joint, in a trunk that bends about z alone.

    A cable at height h above the joint spans the gap 2 (a cos(q / 2) - h sin(q / 2)), a being half its straight gap; the
    lever is minus its derivative by q, a sin(q / 2) + h cos(q / 2).

    Args:
        design: the trunk.
        bend: bend about z of each joint, shape (..., n_joint) [rad]; positive is dorsal.

    Returns:
        Levers, positive where the cable pulls the tip dorsal, shape (..., n_joint, n_cable) [m].
    """
    half = np.asarray(bend, float)[..., None] / 2
    return _half_gap(design)[:, None] * np.sin(half) + _hole_height(design) * np.cos(half)


def planar_gap(design: TrunkDesign, bend: ArrayLike) -> np.ndarray:
    """Length of each cable across each gap of a trunk that bends about z alone, shape (..., n_joint, n_cable) [m]."""
    half = np.asarray(bend, float)[..., None] / 2
    return 2 * np.abs(_half_gap(design)[:, None] * np.cos(half) - _hole_height(design) * np.sin(half))


def _half_gap(design: TrunkDesign) -> np.ndarray:
    return design.straight_gap / 2


def _hole_height(design: TrunkDesign) -> np.ndarray:
    """Height of the holes above the joint on the dorsal side, shape (n_joint, n_cable) [m]."""
    ring = design.hole_to_joint * np.cos(design.delta_theta / 2)
    return ring[:, None] * design.cable_direction[:, 1]


def _holes(design: TrunkDesign) -> tuple[np.ndarray, np.ndarray]:
    """Holes beyond and before each joint, from its centre, shapes (n_joint, n_cable, 3) [m]."""
    axial, ring = design.hole_position[..., 0], design.hole_position[..., 1]
    along = np.array([1.0, 0.0, 0.0])
    beyond = axial[1:, 0, None, None] * along + ring[1:, 0, None, None] * design.cable_direction
    back = axial[:-1, 1] - design.section_length[:-1]
    before = back[:, None, None] * along + ring[:-1, 1, None, None] * design.cable_direction
    return beyond, before
