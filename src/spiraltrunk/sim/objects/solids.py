"""Geometric solids with exact mass distributions, each with its axis along x."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from spiraltrunk.sim.objects.geoms import Geom, Solid

Size = tuple[float, float, float]

NECK_SHARE = 0.3
"""Share of the neck in the height of a bottle (ours) [-]."""

RING_PARTS = 24
"""Capsules of a ring (ours): between their ends they deviate by 0.9 % of the ring's radius."""

CONE_CORNERS = 48
"""Sides of the pyramid that approximates a cone (ours): they deviate by 0.2 % of the radius."""

_X_UP = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
"""Maps z, the axis of MuJoCo's cylinders, to x."""


def box(size: Size) -> Solid:
    """A box; wraps go around x."""
    x, y, z = size
    geom = Geom(form="box", size=(x / 2, y / 2, z / 2))
    return _solid(geom, (y**2 + z**2) / 12, (x**2 + z**2) / 12, (x**2 + y**2) / 12)


def sphere(size: Size) -> Solid:
    """A ball."""
    radius = size[0] / 2
    return _solid(Geom(form="sphere", size=(radius, 0.0, 0.0)), *(0.4 * radius**2,) * 3)


def cylinder(size: Size) -> Solid:
    """A cylinder, flat as a disc or long as a rod."""
    length, width, _ = size
    across = (3 * (width / 2) ** 2 + length**2) / 12
    return _solid(_rod(width, length, 0.0), (width / 2) ** 2 / 2, across, across)


def cone(size: Size) -> Solid:
    """A cone, apex towards +x, its centre of mass at a quarter of its height; collides as a pyramid of 48 sides."""
    height, width, _ = size
    radius = width / 2
    angle = 2 * math.pi * np.arange(CONE_CORNERS) / CONE_CORNERS
    rim = np.stack([np.full_like(angle, -height / 2), radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    vertices = np.vstack([rim, [[-height / 2, 0.0, 0.0], [height / 2, 0.0, 0.0]]])
    here = np.arange(CONE_CORNERS)
    after = (here + 1) % CONE_CORNERS
    foot, apex = np.full_like(here, CONE_CORNERS), np.full_like(here, CONE_CORNERS + 1)
    faces = np.vstack([np.stack([here, after, apex], axis=1), np.stack([after, here, foot], axis=1)])
    across = 3 / 80 * (4 * radius**2 + height**2)
    geom = Geom(form="mesh", vertices=vertices, faces=faces)
    return _solid(geom, 0.3 * radius**2, across, across, along=-height / 4)


def ring(size: Size) -> Solid:
    """A torus around x, as long as its tube is thick; collides as capsules along its circle."""
    tube, outer, _ = size
    radius, around = tube / 2, (outer - tube) / 2
    angle = 2 * math.pi * np.arange(RING_PARTS) / RING_PARTS
    points = around * np.stack([np.zeros_like(angle), np.cos(angle), np.sin(angle)], axis=1)
    geoms = tuple(_link(start, end, radius) for start, end in zip(points, np.roll(points, -1, axis=0), strict=True))
    across = around**2 / 2 + 5 / 8 * radius**2
    inertia = np.diag([around**2 + 3 / 4 * radius**2, across, across])
    return Solid(geoms=geoms, centroid=np.zeros(3), inertia=inertia)


def bottle(size: Size, neck: float) -> Solid:
    """Two cylinders on one axis, the neck towards +x.

    Args:
        size: height, diameter and diameter [m].
        neck: diameter of the neck, which takes the last `NECK_SHARE` of the height [m].
    """
    height, width, _ = size
    lengths = np.array([(1 - NECK_SHARE) * height, NECK_SHARE * height])
    radii = np.array([width, neck]) / 2
    middles = np.array([lengths[0] - height, height - lengths[1]]) / 2
    share = radii**2 * lengths / (radii**2 @ lengths)
    along = float(share @ middles)
    across = float(share @ ((3 * radii**2 + lengths**2) / 12 + (middles - along) ** 2))
    geoms = tuple(_rod(2 * r, length, middle) for r, length, middle in zip(radii, lengths, middles, strict=True))
    inertia = np.diag([float(share @ radii**2) / 2, across, across])
    return Solid(geoms=geoms, centroid=np.array([along, 0.0, 0.0]), inertia=inertia)


SOLIDS: dict[str, Callable[[Size], Solid]] = {
    "cylinder": cylinder,
    "sphere": sphere,
    "box": box,
    "cone": cone,
    "ring": ring,
}
"""Solids that are determined by their extents."""


def _solid(geom: Geom, about_x: float, about_y: float, about_z: float, *, along: float = 0.0) -> Solid:
    """A solid of one geom with its centre of mass on its axis."""
    return Solid(geoms=(geom,), centroid=np.array([along, 0.0, 0.0]), inertia=np.diag([about_x, about_y, about_z]))


def _rod(width: float, length: float, along: float) -> Geom:
    return Geom(
        form="cylinder", size=(width / 2, length / 2, 0.0), position=np.array([along, 0.0, 0.0]), rotation=_X_UP
    )


def _link(start: np.ndarray, end: np.ndarray, radius: float) -> Geom:
    """A capsule between two points of the plane across x."""
    step = end - start
    half = float(np.linalg.norm(step)) / 2
    z = step / (2 * half)
    x = np.array([1.0, 0.0, 0.0])
    rotation = np.stack([x, np.cross(z, x), z], axis=1)
    return Geom(form="capsule", size=(radius, half, 0.0), position=(start + end) / 2, rotation=rotation)
