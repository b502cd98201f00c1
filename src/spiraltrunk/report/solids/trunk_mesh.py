"""Surfaces of a trunk for drawing: sections, joints, cables, gripper, neck and housing, as arrays of vertices.

All are in the frame of the base: x along the trunk, y dorsal. Vertices of the parts of a section stay the same in the
section's own frame, so that another shape only moves them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple, final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.model.kinematics.frames import bend_rotation, section_frames

_FACETS, _FEW_FACETS, _MANY = 36, 20, 60
"""Facets round a section, those of a trunk of many sections, and how many are many."""

_THIN_FACETS = 12
"""Facets round joints and phalanges."""


@final
class Surface(NamedTuple):
    """A surface of triangles."""

    vertices: np.ndarray
    """Vertices, shape (n, 3) [m]."""
    faces: np.ndarray
    """Indices of each triangle's vertices, counterclockwise from outside, shape (m, 3)."""


@final
class TrunkSurfaces(NamedTuple):
    """Surfaces of a trunk in one shape."""

    sections: tuple[Surface, Surface]
    """Sections 1, 3, 5 ... and 2, 4, 6 ..."""
    joints: Surface
    """Elastic joints."""
    gripper: Surface | None
    """Fingers; None where there is no gripper."""
    mount: Surface
    """Neck and housing."""
    cables: np.ndarray
    """Cables as lines through their holes, shape (n_cable, 2 n_section, 3) [m]."""


def curl_frames(design: TrunkDesign, share: float = 1.0) -> np.ndarray:
    """Frames of the sections with every joint bent ventral by a share of its limit, shape (n_section, 4, 4) [-, m]."""
    bend = np.tile([0.0, -share * design.joint_limit], (design.n_joint, 1))
    return section_frames(design, bend_rotation(bend))


def build_trunk_surfaces(design: TrunkDesign, frames: np.ndarray) -> TrunkSurfaces:
    """Surfaces of a trunk.

    Args:
        design: the trunk.
        frames: frames of its sections, as of `section_frames`, shape (n_section, 4, 4) [-, m].
    """
    solid, scale = design.solid, design.scale
    facets = _FEW_FACETS if design.n_section > _MANY else _FACETS
    section = revolve(
        [(0.0, 0.0), (solid.rim_start, solid.radius), (solid.rim_end, solid.radius), (solid.length, 0.0)], facets
    )
    odd, even = (_place(section, frames[first::2], scale[first::2]) for first in (0, 1))
    joint = revolve(_cylinder(-design.joint.length / 2, design.joint.length / 2, design.joint.radius), _THIN_FACETS)
    return TrunkSurfaces(
        sections=(odd, even), joints=_place(joint, _halve(frames), scale[:-1]),
        gripper=_build_gripper(design, frames[-1]),
        mount=_build_mount(design, facets), cables=_place_holes(design, frames),
    )  # fmt: skip


def build_rods(lines: Sequence[np.ndarray], radii: Sequence[float]) -> list[Surface]:
    """Thin square rods along lines, which any renderer draws fast; one surface for each line.

    Args:
        lines: ends of the straight pieces of each line, shape (n, 2, 3) [m]; pieces without a length are left out.
        radii: half the diagonal of each line's cross-section [m].
    """
    segments = np.concatenate(lines)
    radius = np.repeat(radii, [len(line) for line in lines])
    along = segments[:, 1] - segments[:, 0]
    length = np.linalg.norm(along, axis=1)
    is_long = length > 0.0
    along = along[is_long] / length[is_long, None]
    least = np.eye(3)[np.abs(along).argmin(axis=1)]
    first = np.cross(along, least)
    first /= np.linalg.norm(first, axis=1)[:, None]
    second = np.cross(along, first)
    corners = radius[is_long, None, None] * np.stack([first, second, -first, -second], axis=1)
    vertices = segments[is_long][:, :, None] + corners[:, None]
    here = np.arange(4)
    beside = (here + 1) % 4
    sides = np.concatenate([np.stack([here, beside, here + 4], -1), np.stack([beside, beside + 4, here + 4], -1)])
    faces = 8 * np.arange(len(vertices))[:, None, None] + sides
    ends = np.cumsum([len(line) for line in lines])
    counts = np.diff(np.concatenate([[0], np.cumsum(is_long)])[[0, *ends]])
    parts = np.split(vertices, np.cumsum(counts)[:-1])
    return [Surface(part.reshape(-1, 3), faces[: len(part)].reshape(-1, 3)) for part in parts]


def revolve(profile: list[tuple[float, float]], facets: int) -> Surface:
    """Surface of revolution about x of a profile of (axial, radial) points [m]; its edges stay sharp."""
    angle = 2 * math.pi * np.arange(facets) / facets
    around = np.stack([np.zeros(facets), np.cos(angle), np.sin(angle)], axis=-1)
    points = np.array(profile)
    rings = points[:, 0, None, None] * np.array([1.0, 0.0, 0.0]) + points[:, 1, None, None] * around
    bands = np.stack([rings[:-1], rings[1:]], axis=1).reshape(-1, 3)  # A band's rings are its own.
    here = np.arange(facets)
    beside = (here + 1) % facets
    near = np.stack([here, beside, here + facets], axis=-1)
    far = np.stack([beside, beside + facets, here + facets], axis=-1)
    faces = []
    for i, (first, second) in enumerate(pairwise(points[:, 1])):
        # A ring on the axis is one point: the triangles along it have no area.
        faces += [2 * facets * i + side for side, width in ((near, first), (far, second)) if width > 0.0]
    return Surface(bands, np.concatenate(faces))


def _cylinder(start: float, end: float, radius: float) -> list[tuple[float, float]]:
    return [(start, 0.0), (start, radius), (end, radius), (end, 0.0)]


def _place(part: Surface, frames: np.ndarray, scale: np.ndarray) -> Surface:
    """Copies of a part, scaled, in frames of shape (k, 4, 4)."""
    local = scale[:, None, None] * part.vertices
    placed = local @ np.swapaxes(frames[:, :3, :3], 1, 2) + frames[:, None, :3, 3]
    first = len(part.vertices) * np.arange(len(frames))
    return Surface(placed.reshape(-1, 3), (first[:, None, None] + part.faces).reshape(-1, 3))


def _halve(frames: np.ndarray) -> np.ndarray:
    """Frames in the joint centres, half-way between the sections on both sides, shape (n_joint, 4, 4)."""
    halves = frames[1:].copy()
    middle = frames[:-1, :3, :3] + frames[1:, :3, :3]
    u, _, vt = np.linalg.svd(middle)
    halves[:, :3, :3] = u @ vt
    return halves


def _build_gripper(design: TrunkDesign, tip: np.ndarray) -> Surface | None:
    gripper = design.gripper
    if gripper is None:
        return None
    begin = np.concatenate([[0.0], np.cumsum(gripper.phalanx_length)[:-1]])
    angle = 2 * math.pi * np.arange(gripper.n_finger) / gripper.n_finger
    aside = gripper.mount_radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    surfaces = []
    for start, length, width in zip(begin.tolist(), gripper.phalanx_length, gripper.phalanx_width, strict=True):
        bevel, radius = min(width, length) / 5, float(width) / 2
        phalanx = revolve(
            [(0.0, 0.0), (0.0, radius - bevel), (bevel, radius), (float(length) - bevel, radius),
             (float(length), radius - bevel), (float(length), 0.0)], _THIN_FACETS,
        )  # fmt: skip
        frames = np.tile(tip, (gripper.n_finger, 1, 1))
        local = np.insert(aside, 0, design.section_length[-1] + start, axis=1)
        frames[:, :3, 3] += local @ tip[:3, :3].T
        surfaces.append(_place(phalanx, frames, np.ones(gripper.n_finger)))
    return _join(surfaces)


def _build_mount(design: TrunkDesign, facets: int) -> Surface:
    housing, neck = design.housing, -design.housing.neck_length
    return _join([
        revolve(_cylinder(neck, 0.0, float(design.section_radius[0])), facets),
        revolve(_cylinder(neck - housing.length, neck, housing.radius), facets),
    ])  # fmt: skip


def _place_holes(design: TrunkDesign, frames: np.ndarray) -> np.ndarray:
    axial, radial = design.hole_position[..., 0], design.hole_position[..., 1]
    local = axial[..., None, None] * np.array([1.0, 0.0, 0.0]) + radial[..., None, None] * design.cable_direction
    placed = np.einsum("nij,nhcj->chni", frames[:, :3, :3], local) + frames[:, :3, 3]
    return np.swapaxes(placed, 1, 2).reshape(design.n_cable, -1, 3)


def _join(surfaces: list[Surface]) -> Surface:
    first = np.cumsum([0, *(len(one.vertices) for one in surfaces[:-1])])
    faces = [start + one.faces for start, one in zip(first, surfaces, strict=True)]
    return Surface(np.concatenate([one.vertices for one in surfaces]), np.concatenate(faces))
