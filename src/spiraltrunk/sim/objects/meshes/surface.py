"""Surfaces of triangles: faults, winding numbers and the volume that they enclose."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from trimesh import Trimesh

SAMPLES_MOST = 200
"""Largest number of triangles at which the winding number is computed."""

POINTS_MOST, TERMS_MOST = 2048, 20_000_000
"""Largest number of points at which a union of bodies is sampled, and of points times triangles (ours)."""

BODIES_MOST = 200
"""Largest number of bodies that are taken one by one (ours)."""

VOLUME_LEAST = 1e-6
"""Least volume of a solid over that of the box round it [-]."""


def find_fault(mesh: Trimesh) -> str:
    """Why a surface does not enclose one solid with outward triangles; empty where it does.

    Self-intersection is tested at up to `SAMPLES_MOST` triangles; a small one can be missed.
    """
    if not mesh.is_watertight:
        _, count = np.unique(mesh.edges_sorted, axis=0, return_counts=True)
        return f"open or cut at {np.count_nonzero(count != 2)} edges"
    if not mesh.is_winding_consistent:
        return "partly inside out"
    if abs(mesh.volume) < VOLUME_LEAST * np.prod(mesh.extents):
        return "without volume"
    if mesh.volume < 0:
        return "inside out"
    if _intersects_itself(mesh):
        return "cutting or overlapping itself"
    pieces = sum(part.volume > 0 for part in mesh.split(only_watertight=False))
    return "" if pieces == 1 else f"in {pieces} pieces that do not touch"


def _intersects_itself(mesh: Trimesh) -> bool:
    """Whether the winding number is other than 1 just inside a triangle, or other than 0 just outside."""
    corners = np.array(mesh.triangles)
    girth = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).sum(axis=1)
    depth = 2e-3 * mesh.area_faces / girth
    usable = np.flatnonzero(depth > 1e-9)
    if not usable.size:
        return True
    chosen = usable[np.linspace(0, usable.size - 1, min(usable.size, SAMPLES_MOST)).astype(int)]
    step, middle = mesh.face_normals[chosen] * depth[chosen, None], mesh.triangles_center[chosen]
    inside, outside = winding_numbers(middle - step, corners), winding_numbers(middle + step, corners)
    return bool(np.abs(inside - 1).max() > 0.1 or np.abs(outside).max() > 0.1)


def winding_numbers(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Winding number of a surface about each point: 1 inside a valid solid, 0 outside, -1 inside an inverted one.

    The sum of the triangles' solid angles over 4 pi (van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 1983).

    Args:
        points: shape (n, 3) [m].
        corners: corners of the triangles, counter-clockwise from outside, shape (m, 3, 3) [m].
    """

    def dot(one: np.ndarray, other: np.ndarray) -> np.ndarray:
        return np.asarray(np.einsum("ij,ij->j", one, other))

    turns = np.empty(len(points))
    sides = np.ascontiguousarray(corners.transpose(1, 2, 0))  # Contiguous coordinates are ten times as fast.
    for i, point in enumerate(points):
        a, b, c = sides - point[:, None]
        la, lb, lc = (np.sqrt(dot(side, side)) for side in (a, b, c))
        volume = dot(a, np.cross(b, c, axis=0))
        turns[i] = 2 * np.arctan2(volume, la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb).sum()
    return turns / (4 * np.pi)


def signed_volume(mesh: Trimesh) -> float:
    """Signed volume between a surface and the middle of its extents, its own volume where it is closed [m^3].

    Of an open surface it is an estimate: each hole counts as closed by a cone to the middle.
    """
    corners = np.asarray(mesh.triangles) - mesh.bounds.mean(axis=0)
    return float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6)


def count_bodies(mesh: Trimesh) -> int:
    """Number of bodies of triangles that are joined by edges."""
    return int(label_bodies(mesh.face_adjacency, len(mesh.faces)).max(initial=-1)) + 1


def label_bodies(neighbours: np.ndarray, n_face: int) -> np.ndarray:
    """Number of the body to which each of ``n_face`` triangles belongs, by pairs of neighbours, shape (n, 2)."""
    import trimesh

    graph: Any = trimesh.graph  # Untyped.
    return np.asarray(graph.connected_component_labels(neighbours, node_count=n_face)) if n_face else np.empty(0, int)


def estimate_volume(mesh: Trimesh) -> float:
    """Volume that a surface with faults encloses [m^3], an estimate.

    Of one body its signed volume. Of several, which may overlap, that of their union: the share of quasi-random points
    of the box round them at which the winding number of one is at least one half (Jacobson et al., ACM Trans. Graph.
    2013).
    """
    from scipy.stats import qmc

    if count_bodies(mesh) <= 1:
        return abs(signed_volume(mesh))
    bodies = mesh.split(only_watertight=False)
    count = int(np.clip(TERMS_MOST // max(1, len(mesh.faces)), 100, POINTS_MOST))
    low, high = mesh.bounds
    points = low + qmc.Halton(3, scramble=False).random(count) * (high - low)
    is_inside = np.zeros(count, bool)
    for body in bodies:
        near = ~is_inside & (points >= body.bounds[0]).all(axis=1) & (points <= body.bounds[1]).all(axis=1)
        is_inside[near] |= np.abs(winding_numbers(points[near], np.asarray(body.triangles))) >= 0.5
    return float(np.prod(high - low) * is_inside.mean())
