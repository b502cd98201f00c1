"""Profile of an object in a pose: sections through its convex shapes, centre of mass, tilt at which it falls over."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from spiraltrunk.control.object_profile import ObjectProfile
from spiraltrunk.errors import DesignError, UnknownName
from spiraltrunk.sim.objects.geoms import Geom, Solid
from spiraltrunk.sim.objects.spec import ObjectSpec
from spiraltrunk.sim.objects.tessellation import choose_corners, hull_of_geom

N_SECTION = 61
"""Sections of a profile (ours)."""

INSET = 1e-4
"""Distance of the first and the last section from foot and top, over the height (ours) [-]."""

N_DIRECTION, N_TILT = 72, 360
"""Directions about the vertical, and tilts from 0 to 90 degrees, at which falling over is sought (ours)."""

FOOT = 2e-3
"""Height up to which points belong to the foot, over the object's height (ours) [-]."""

EDGE = 0.03
"""Least length of an edge of the foot whose direction is tried, over the foot's girth (ours) [-]."""

_EARLY = 4
"""Tilt, of `N_TILT`, at which the radius of the support is measured: 1 degree."""

BARRIER = 1e-3
"""Least rise of the centre of mass before it falls, over the object's height, that counts as standing (ours) [-]."""

UPRIGHT = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
"""Rotation that turns the object's x axis up, shape (3, 3) [-]."""

ROTATIONS = {"lying": np.eye(3), "upright": UPRIGHT}
"""Rotation of the object's frame into the world by the orientation of a scene, before the yaw."""


def compute_profile(shape: ObjectSpec, orientation: str | np.ndarray = "upright") -> ObjectProfile:
    """Profile of an object that rests on a plane.

    The sections are those of the convex shapes that collide; where there are several, of their union's convex hull.

    Args:
        shape: the object.
        orientation: "upright", its axis vertical; "lying", its axis horizontal and its z up; or a rotation of its frame
            into the world, shape (3, 3) [-].

    Raises:
        UnknownName: for another orientation.
        DesignError: for a matrix that is no rotation.
    """
    if isinstance(orientation, str):
        if orientation not in ROTATIONS:
            raise UnknownName("orientation", orientation, ROTATIONS)
        return _compute_cached(shape.solid, orientation)
    turn = np.asarray(orientation, float)
    if turn.shape != (3, 3) or not np.allclose(turn @ turn.T, np.eye(3), atol=1e-6) or np.linalg.det(turn) < 0:
        raise DesignError("orientation", got=orientation, allowed="a rotation matrix, shape (3, 3)")
    return _compute(shape.solid, turn)


@lru_cache(maxsize=64)
def _compute_cached(solid: Solid, orientation: str) -> ObjectProfile:
    return _compute(solid, ROTATIONS[orientation])


def _compute(solid: Solid, turn: np.ndarray) -> ObjectProfile:
    colliding = [geom for geom in solid.geoms if geom.collides]
    hulls = [hull_of_geom(geom, choose_corners(len(colliding))) for geom in colliding]
    pieces = [(points @ turn.T, edges) for points, edges in hulls]
    low = min(float(points[:, 2].min()) for points, _ in pieces)
    total = max(float(points[:, 2].max()) for points, _ in pieces) - low
    height = np.linspace(0.0, total, N_SECTION)
    inside = low + np.clip(height, INSET * total, (1 - INSET) * total)
    measures = np.array([measure_section(_cut(pieces, z)) for z in inside])
    center = float(turn[2] @ solid.centroid) - low
    topple, radius = compute_stability(solid, turn, _edge_directions(np.vstack([points for points, _ in pieces])))
    profile = ObjectProfile(
        height=height, width_least=measures[:, 0], width_most=measures[:, 1], girth=measures[:, 2],
        center_height=center, topple_angle=topple, support_radius=radius,
    )  # fmt: skip
    for array in (profile.height, profile.width_least, profile.width_most, profile.girth):
        array.setflags(write=False)
    return profile


def _cut(pieces: list[tuple[np.ndarray, np.ndarray]], z: float) -> np.ndarray:
    """Corners of the sections of convex hulls at a height, shape (n, 2) [m]."""
    found = []
    for points, edges in pieces:
        start, end = points[edges[:, 0]], points[edges[:, 1]]
        crosses = (start[:, 2] - z) * (end[:, 2] - z) <= 0
        start, end = start[crosses], end[crosses]
        rise = end[:, 2] - start[:, 2]
        level = np.abs(rise) < 1e-12
        share = np.where(level, 0.0, (z - start[:, 2]) / np.where(level, 1.0, rise))
        found.append((start + share[:, None] * (end - start))[:, :2])
    return np.vstack(found)


def measure_section(corners: np.ndarray) -> tuple[float, float, float]:
    """Least and largest caliper width and perimeter of the convex hull of points of a plane, shape (n, 2) [m].

    The least caliper width is normal to an edge of the hull (Houle and Toussaint, IEEE Trans. Pattern Anal. 1988); the
    largest is the distance of the farthest corners.
    """
    if len(corners) < 2:
        return 0.0, 0.0, 0.0
    try:
        hull = corners[ConvexHull(corners).vertices]
    except QhullError:  # All on one line.
        span = float(np.linalg.norm(np.ptp(corners, axis=0)))
        return 0.0, span, 2 * span
    edges = np.roll(hull, -1, axis=0) - hull
    lengths = np.linalg.norm(edges, axis=1)
    normals = np.stack([-edges[:, 1], edges[:, 0]], axis=1) / lengths[:, None]
    widths = np.ptp(normals @ hull.T, axis=1)
    apart = np.linalg.norm(hull[:, None] - hull[None], axis=2)
    return float(widths.min()), float(apart.max()), float(lengths.sum())


def foot_directions(solid: Solid, turn: np.ndarray) -> np.ndarray:
    """Horizontal directions normal to the long edges on which an object rests, shape (n,) [rad]."""
    colliding = [geom for geom in solid.geoms if geom.collides]
    corners = choose_corners(len(colliding))
    return _edge_directions(np.vstack([hull_of_geom(geom, corners)[0] for geom in colliding]) @ turn.T)


def _edge_directions(points: np.ndarray) -> np.ndarray:
    """Directions normal to the long edges of the convex hull of the lowest of the points, shape (n,) [rad]."""
    low, high = points[:, 2].min(), points[:, 2].max()
    foot = points[points[:, 2] < low + FOOT * (high - low), :2]
    try:
        hull = ConvexHull(foot)
    except (QhullError, ValueError):  # A point, or all on one line.
        return np.zeros(0)
    lengths = np.linalg.norm(np.diff(foot[hull.simplices], axis=1)[:, 0], axis=1)
    normals = hull.equations[lengths > EDGE * lengths.sum()]
    return np.arctan2(normals[:, 1], normals[:, 0])


def compute_stability(solid: Solid, turn: np.ndarray, edges: np.ndarray) -> tuple[float, float]:
    """Least tilt by which an object at rest falls over [rad], and the radius of its support [m], over all directions.

    On a plane of normal n the centre of mass c has the height h(n) = c . n + max over the object of -p . n. At a tilt t
    about an edge at the horizontal distance d, h = h(0) cos t + d sin t. The object falls where h passes its first
    maximum along the tilt; a maximum lower than `BARRIER` above the start does not count.

    Args:
        solid: the object.
        turn: rotation of its frame into the world, shape (3, 3) [-].
        edges: directions to try besides the evenly spaced ones, shape (n,) [rad].
    """
    tilt = np.linspace(0.0, math.pi / 2, N_TILT + 1)
    around = np.concatenate([np.linspace(0.0, 2 * math.pi, N_DIRECTION, endpoint=False), edges])
    normals = np.empty((len(around), len(tilt), 3))
    normals[..., 0] = np.cos(around)[:, None] * np.sin(tilt)
    normals[..., 1] = np.sin(around)[:, None] * np.sin(tilt)
    normals[..., 2] = np.cos(tilt)
    heights = _height_over(solid, normals @ turn)
    least = BARRIER * float(_height_over(solid, turn[2]) + _height_over(solid, -turn[2]))
    angle = min(_topple_angle(path, tilt, least) for path in heights)
    edge = (heights[:, _EARLY] - heights[:, 0] * math.cos(tilt[_EARLY])) / math.sin(tilt[_EARLY])
    return float(angle), max(0.0, float(edge.min())) if angle > 0 else 0.0


def _topple_angle(path: np.ndarray, tilt: np.ndarray, least: float) -> float:
    """Tilt of the first maximum of the centre of mass's height along a path [rad]."""
    falls = np.flatnonzero(path < np.maximum.accumulate(path) - least)
    top = int(np.argmax(path[: falls[0] if falls.size else len(path)]))
    return float(tilt[top]) if path[top] - path[0] > least else 0.0


def _height_over(solid: Solid, normals: np.ndarray) -> np.ndarray:
    """Height of the centre of mass over the plane that touches the object from below, of the shape before the last."""
    reach = np.max([reach_along(geom, -normals) for geom in solid.geoms if geom.collides], axis=0)
    return normals @ solid.centroid + reach


def reach_along(geom: Geom, directions: np.ndarray) -> np.ndarray:
    """`Geom.reach` of many unit directions, shape (..., 3) [m]."""
    own = directions @ geom.rotation
    a, b, c = geom.size
    if geom.vertices is not None:
        corners, _ = hull_of_geom(geom)
        rows = directions.reshape(-1, directions.shape[-2], 3) if directions.ndim > 1 else directions[None, None]
        return np.array([np.max(row @ corners.T, axis=-1) for row in rows]).reshape(directions.shape[:-1])
    if geom.form in {"capsule", "cylinder"}:
        bulge = 1.0 if geom.form == "capsule" else np.hypot(own[..., 0], own[..., 1])
        far = a * bulge + b * np.abs(own[..., 2])
    elif geom.form == "box":
        far = np.abs(own) @ np.array([a, b, c])
    else:
        far = np.linalg.norm(own * np.array([a, b, c] if geom.form == "ellipsoid" else [a, a, a]), axis=-1)
    return directions @ geom.position + far
