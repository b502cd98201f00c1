"""Convex polyhedra of geoms: corners and edges."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.spatial import ConvexHull

from spiraltrunk.sim.objects.geoms import Geom

CORNERS = 128
"""Corners of a polygon that represents a circle (ours); its sides lie inside by 3e-4 of the radius."""


HULL_MOST = 2000
"""Largest number of corners of a mesh's hull, which is thinned out to the farthest of as many directions (ours)."""


def choose_corners(count: int) -> int:
    """Corners of a circle of an object of so many shapes, at least 24 (ours)."""
    return min(CORNERS, max(24, 4 * CORNERS // max(1, count) // 8 * 8))


def hull_faces(points: np.ndarray) -> np.ndarray:
    """Triangles of the convex hull of points as places among them, counter-clockwise from outside, shape (n, 3)."""
    hull = ConvexHull(points)
    faces = hull.simplices
    corners = points[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.einsum("ij,ij->i", normal, hull.equations[:, :3]) < 0
    faces[inward] = faces[inward][:, ::-1]
    return np.asarray(faces)


def hull_of_geom(geom: Geom, corners: int = CORNERS) -> tuple[np.ndarray, np.ndarray]:
    """Convex hull of a geom in the object's frame: corners, shape (n, 3) [m], and edges between them, shape (m, 2)."""
    return _hull_cached(geom, corners if geom.vertices is None else 0)


@lru_cache(maxsize=256)
def _hull_cached(geom: Geom, corners: int) -> tuple[np.ndarray, np.ndarray]:
    own = _thin_out(geom.vertices) if geom.vertices is not None else _points(geom, corners)
    hull = ConvexHull(own)
    kept = np.unique(hull.simplices)
    place = np.full(len(own), -1)
    place[kept] = np.arange(len(kept))
    faces = place[hull.simplices]
    edges = np.unique(np.sort(np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [0, 2]]]), axis=1), axis=0)
    return own[kept] @ geom.rotation.T + geom.position, edges


def _thin_out(vertices: np.ndarray) -> np.ndarray:
    """The vertices, or of a hull with more than `HULL_MOST` those that are farthest in evenly spread directions."""
    if len(vertices) <= HULL_MOST:
        return vertices
    kept = vertices[ConvexHull(vertices).vertices]
    if len(kept) <= HULL_MOST:
        return kept
    place = np.arange(HULL_MOST) + 0.5  # Points of a Fibonacci lattice on the sphere.
    up, turn = 1 - 2 * place / HULL_MOST, np.pi * (1 + np.sqrt(5.0)) * place
    level = np.sqrt(1 - up**2)
    directions = np.vstack([np.stack([level * np.cos(turn), level * np.sin(turn), up], axis=1), np.eye(3), -np.eye(3)])
    return np.asarray(kept[np.unique([int(np.argmax(kept @ direction)) for direction in directions])])


def _points(geom: Geom, corners: int) -> np.ndarray:
    """Points whose convex hull represents an analytic form, in the geom's frame, shape (n, 3) [m]."""
    a, b, c = geom.size
    if geom.form == "box":
        return np.array(np.meshgrid([-a, a], [-b, b], [-c, c])).reshape(3, -1).T
    angle = 2 * np.pi * np.arange(corners) / corners
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    if geom.form == "cylinder":
        return np.vstack([np.column_stack([a * circle, np.full(corners, z)]) for z in (-b, b)])
    latitude = np.linspace(-np.pi / 2, np.pi / 2, corners // 4 + 1)[1:-1]
    rings = [np.column_stack([np.cos(up) * circle, np.full(corners, np.sin(up))]) for up in latitude]
    ball = np.vstack([*rings, [[0, 0, -1.0], [0, 0, 1.0]]])
    if geom.form == "capsule":
        return np.vstack([a * ball + [0, 0, z] for z in (-b, b)])
    return ball * (np.array([a, b, c]) if geom.form == "ellipsoid" else a)
