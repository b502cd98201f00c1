"""Convex polyhedra of geoms: corners and edges."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull

from spiraltrunk.sim.objects.geoms import Geom

CORNERS = 128
"""Corners of a polygon that represents a circle (ours); its sides lie inside by 3e-4 of the radius."""


def choose_corners(count: int) -> int:
    """Corners of a circle of an object of so many shapes, at least 24 (ours)."""
    return min(CORNERS, max(24, 4 * CORNERS // max(1, count) // 8 * 8))


def hull_of_geom(geom: Geom, corners: int = CORNERS) -> tuple[np.ndarray, np.ndarray]:
    """Convex hull of a geom in the object's frame: corners, shape (n, 3) [m], and edges between them, shape (m, 2)."""
    own = geom.vertices if geom.vertices is not None else _points(geom, corners)
    hull = ConvexHull(own)
    kept = np.unique(hull.simplices)
    place = np.full(len(own), -1)
    place[kept] = np.arange(len(kept))
    faces = place[hull.simplices]
    edges = np.unique(np.sort(np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [0, 2]]]), axis=1), axis=0)
    return own[kept] @ geom.rotation.T + geom.position, edges


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
