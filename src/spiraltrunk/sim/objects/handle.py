"""Handle of an object that stands: what projects from its outline, seen from above, between two of three fingers."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from spiraltrunk.control.object_handle import Handle
from spiraltrunk.sim.objects.geoms import Solid
from spiraltrunk.sim.objects.profile import UPRIGHT
from spiraltrunk.sim.objects.spec import ObjectSpec
from spiraltrunk.sim.objects.tessellation import choose_corners, hull_of_geom

WEDGE = math.radians(60.0)
"""Angle about the body's middle in which a handle lies (ours): half of that between two of three fingers [rad]."""
SLENDER = 0.4
"""Largest extent of a handle across its direction over the body's width (ours) [-]: beside it fingers have room."""
SMALLER = 0.85
"""Largest diameter of the circle round the body over that round the whole, of what has a handle (ours) [-]."""
FULL = 0.8
"""Least area of the body's convex outline over that of its circle (ours) [-]: only a round body has
a handle. A flat box less a wedge would count as one otherwise."""
PLAIN = ("cylinder", "cone", "ring", "bottle", "sphere", "box")
"""Kinds of object without a handle."""

SETTLED = 1e-3
"""Largest last move of the circle's middle over the whole circle's radius [-]."""

_SIDES = 40
"""Points of an outline's edge of the length of the whole outline [-]."""
_PASSES = 6
"""Passes in which the body's circle is sought; it settles in three [-]."""


def find_handle(shape: ObjectSpec, yaw: float = 0.0) -> Handle | None:
    """Handle of an object that stands, its x axis up, turned by ``yaw`` [rad] about the vertical; None without one."""
    found = None if shape.kind in PLAIN else _find_handle(shape.solid)
    if found is None:
        return None
    angle, width, middle = found
    c, s = math.cos(yaw), math.sin(yaw)
    handle = Handle(
        direction=np.array([math.cos(angle + yaw), math.sin(angle + yaw), 0.0]),
        body_width=width,
        body_offset=np.array([c * middle[0] - s * middle[1], s * middle[0] + c * middle[1], 0.0]),
    )
    for array in (handle.direction, handle.body_offset):
        array.setflags(write=False)
    return handle


@lru_cache(maxsize=64)
def _find_handle(solid: Solid) -> tuple[float, float, tuple[float, float]] | None:
    """Angle of the handle [rad], width of the body and its middle [m]: the least circle round all but a wedge.

    The wedge opens from the body's middle to the point of the outline that is farthest from the centre of mass.
    """
    points = _outline(solid)
    try:
        middle, whole = _enclose(points)
    except QhullError:  # A plate so thin that it counts as a line.
        return None
    center = (UPRIGHT @ solid.centroid)[:2]
    tip, radius = points[np.linalg.norm(points - center, axis=1).argmax()], whole
    for _ in range(_PASSES):
        way = (tip - middle) / float(np.linalg.norm(tip - middle))
        along, across = (points - middle) @ way, np.abs((points - middle) @ [-way[1], way[0]])
        is_body = across >= math.tan(WEDGE / 2) * along
        if not _is_full(points[is_body]):
            return None
        before, (middle, radius) = middle, _enclose(points[is_body])
        if float(np.linalg.norm(middle - before)) < SETTLED * whole:
            break
    else:
        return None
    if radius > SMALLER * whole:
        return None
    out = points[np.linalg.norm(points - middle, axis=1) > 1.02 * radius] - middle
    way = out.mean(axis=0) / float(np.linalg.norm(out.mean(axis=0)))
    if float(np.ptp(out @ [-way[1], way[0]])) > SLENDER * 2 * radius:
        return None
    return math.atan2(way[1], way[0]), 2 * radius, (float(middle[0]), float(middle[1]))


def _outline(solid: Solid) -> np.ndarray:
    """Points on the outlines of an object's convex shapes, seen from above, shape (n, 2) [m]."""
    colliding = [geom for geom in solid.geoms if geom.collides]
    corners = choose_corners(len(colliding))
    found: list[np.ndarray] = []
    for geom in colliding:
        flat = (hull_of_geom(geom, corners)[0] @ UPRIGHT.T)[:, :2]
        try:
            edge = flat[ConvexHull(flat).vertices]
        except QhullError:  # All on one line.
            edge = flat
        found.append(edge)
    span = float(np.ptp(np.vstack(found), axis=0).max())
    return np.vstack([_divide(edge, span / _SIDES) for edge in found])


def _divide(edge: np.ndarray, longest: float) -> np.ndarray:
    """Corners of a closed polygon and points between them, no further apart than ``longest`` [m]."""
    following = np.roll(edge, -1, axis=0)
    parts: list[Any] = []
    for start, end in zip(edge, following, strict=True):
        count = max(1, math.ceil(float(np.linalg.norm(end - start)) / longest))
        parts.append(start + np.arange(count)[:, None] / count * (end - start))
    return np.vstack(parts)


def _is_full(points: np.ndarray) -> bool:
    """Whether the convex hull of points fills its circle by `FULL`."""
    try:
        area = float(ConvexHull(points).volume)
    except (QhullError, ValueError):  # Too few points, or all on one line.
        return False
    return area >= FULL * math.pi * _enclose(points)[1] ** 2


def _enclose(points: np.ndarray) -> tuple[np.ndarray, float]:
    """Middle, shape (2,), and radius of a circle round points of a plane [m]: the least where three bound it."""
    from trimesh.nsphere import minimum_nsphere

    middle, radius = minimum_nsphere(points)  # type: ignore[no-untyped-call]
    return np.asarray(middle), float(radius)
