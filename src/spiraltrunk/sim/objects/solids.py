"""Geometric solids with their axis along x: geoms and exact mass distributions."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from spiraltrunk.sim.objects.geoms import Geom, Solid

Size = tuple[float, float, float]

NECK_SHARE = 0.3
"""Height of a bottle's neck over the bottle's height [-] (ours)."""

RING_PARTS = 24
"""Capsules that represent a ring (ours); their middles lie inside the circle by 0.9 % of the ring's radius."""

CONE_CORNERS = 48
"""Corners of the polygon that represents a cone's circle (ours); its sides lie inside by 0.2 % of the radius."""

_X_UP = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
"""Rotation of z, the axis of MuJoCo's cylinders, onto x."""


def box(size: Size) -> Solid:
    """A box of the given extents; x is its axis."""
    x, y, z = size
    geom = Geom(form="box", size=(x / 2, y / 2, z / 2))
    return _solid(geom, (y**2 + z**2) / 12, (x**2 + z**2) / 12, (x**2 + y**2) / 12)


def sphere(size: Size) -> Solid:
    """A sphere of the given extents."""
    radius = size[0] / 2
    return _solid(Geom(form="sphere", size=(radius, 0.0, 0.0)), *(0.4 * radius**2,) * 3)


def cylinder(size: Size) -> Solid:
    """A cylinder; ``size`` is length, diameter and diameter [m]."""
    length, width, _ = size
    across = (3 * (width / 2) ** 2 + length**2) / 12
    return _solid(_rod(width, length, 0.0), (width / 2) ** 2 / 2, across, across)


def cone(size: Size) -> Solid:
    """A cone with its apex towards +x and its centre of mass at a quarter of its height; collides as a pyramid.

    Args:
        size: height, diameter and diameter [m].
    """
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
    about_x, volume = 0.3 * radius**2, math.pi * radius**2 * height / 3
    return replace(_solid(geom, about_x, across, across, along=-height / 4), volume=volume)


def ring(size: Size) -> Solid:
    """A torus about x; collides as `RING_PARTS` capsules along its circle.

    Args:
        size: diameter of the tube, outer diameter and outer diameter [m].
    """
    tube, outer, _ = size
    radius, around = tube / 2, (outer - tube) / 2
    angle = 2 * math.pi * np.arange(RING_PARTS) / RING_PARTS
    points = around * np.stack([np.zeros_like(angle), np.cos(angle), np.sin(angle)], axis=1)
    geoms = tuple(_link(start, end, radius) for start, end in zip(points, np.roll(points, -1, axis=0), strict=True))
    across = around**2 / 2 + 5 / 8 * radius**2
    inertia = np.diag([around**2 + 3 / 4 * radius**2, across, across])
    volume = 2 * math.pi**2 * around * radius**2
    return Solid(geoms=geoms, centroid=np.zeros(3), inertia=inertia, volume=volume)


def bottle(size: Size, neck: float) -> Solid:
    """Two coaxial cylinders, the neck towards +x.

    Args:
        size: height, diameter and diameter [m].
        neck: diameter of the neck, whose height is `NECK_SHARE` of the bottle's [m].
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
    """A solid of one geom, its centre of mass at ``along`` [m] on its axis."""
    return Solid(geoms=(geom,), centroid=np.array([along, 0.0, 0.0]), inertia=np.diag([about_x, about_y, about_z]))


def _rod(width: float, length: float, along: float) -> Geom:
    return Geom(
        form="cylinder", size=(width / 2, length / 2, 0.0), position=np.array([along, 0.0, 0.0]), rotation=_X_UP
    )


def _link(start: np.ndarray, end: np.ndarray, radius: float) -> Geom:
    """A capsule between two points of a plane perpendicular to x."""
    step = end - start
    half = float(np.linalg.norm(step)) / 2
    z = step / (2 * half)
    x = np.array([1.0, 0.0, 0.0])
    rotation = np.stack([x, np.cross(z, x), z], axis=1)
    return Geom(form="capsule", size=(radius, half, 0.0), position=(start + end) / 2, rotation=rotation)
