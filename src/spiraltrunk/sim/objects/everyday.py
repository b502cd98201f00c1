"""Everyday shapes drawn from a seed: cylinders, boxes, superquadrics, surfaces of revolution, handles."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import final

import numpy as np

from spiraltrunk.checks import Range, check_range
from spiraltrunk.errors import DesignError, UnknownName
from spiraltrunk.sim.objects.geoms import HIDDEN, Geom, Solid, compute_bounds
from spiraltrunk.sim.objects.solids import SOLIDS
from spiraltrunk.sim.objects.spec import EXTENTS, MASSES, ObjectSpec
from spiraltrunk.sim.objects.tessellation import hull_faces

WIDTHS, HEIGHTS, GRAMS = (0.025, 0.120), (0.030, 0.240), (0.020, 1.000)
"""Ranges of width [m], height [m] and mass [kg] of everyday things."""

DENSITIES = (60.0, 1400.0)
"""Least and largest density: of a carton of cereals, and of a filled glass (ours) [kg/m^3]."""

SLENDER = 5.0
"""Largest height over width (ours) [-]."""

SECTORS = 32
"""Sides of a polygon that represents a circle (ours)."""

SHARES = np.linspace(0.0, 1.0, 9)
"""Heights of the rings of a surface of revolution over its height [-]."""

OUTLINES = {
    "bottle": (0.92, 1.0, 1.0, 1.0, 0.98, 0.72, 0.42, 0.36, 0.36),
    "cup": (0.72, 0.76, 0.80, 0.84, 0.88, 0.91, 0.94, 0.97, 1.0),
    "cone": (1.0, 0.89, 0.78, 0.67, 0.56, 0.45, 0.34, 0.23, 0.12),
    "barrel": (0.78, 0.88, 0.95, 0.99, 1.0, 0.99, 0.95, 0.88, 0.78),
    "vase": (0.70, 0.86, 0.97, 1.0, 0.92, 0.76, 0.62, 0.60, 0.68),
    "can": (0.94, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.94),
}
"""Radii of surfaces of revolution at `SHARES`, from the foot up, over the largest radius (ours) [-]."""

Draw = Callable[[np.random.Generator, float, float], tuple[str, Solid]]


@final
@dataclass(frozen=True, kw_only=True)
class Everyday:
    """An everyday thing that was drawn."""

    name: str
    """Its shape, such as bottle or superquadric."""
    family: str
    """Class of the shape, one of `FAMILIES`."""
    shape: ObjectSpec
    """The object, which stands with its axis up."""


def draw_object(
    rng: np.random.Generator,
    *,
    kind: str | None = None,
    width: tuple[float, float] = WIDTHS,
    height: tuple[float, float] = HEIGHTS,
    mass: tuple[float, float] = GRAMS,
) -> ObjectSpec:
    """An object of everyday size, shape and density (`draw_everyday` gives its name, too)."""
    return draw_everyday(rng, kind=kind, width=width, height=height, mass=mass).shape


def draw_everyday(
    rng: np.random.Generator,
    *,
    kind: str | None = None,
    width: tuple[float, float] = WIDTHS,
    height: tuple[float, float] = HEIGHTS,
    mass: tuple[float, float] = GRAMS,
) -> Everyday:
    """An object of everyday size, shape and density, with its name and class.

    Width and height are uniform in their ranges, the height at most `SLENDER` widths. The density is log-uniform in
    `DENSITIES`, as far as the mass stays in its range; the mass bounds win where no density fits.

    Args:
        rng: source of randomness; the same state gives the same object.
        kind: class of shape, one of `FAMILIES`; None draws one.
        width: least and largest extent across the axis, without a handle [m].
        height: least and largest extent along the axis [m].
        mass: least and largest mass [kg].

    Raises:
        UnknownName: for a class that does not exist.
        DesignError: for a range that is none.
    """
    for name, bounds, allowed in (("width", width, EXTENTS), ("height", height, EXTENTS), ("mass", mass, MASSES)):
        _check_bounds(f"everyday.{name}", bounds, allowed)
    if kind is not None and kind not in FAMILIES:
        raise UnknownName("class of everyday shapes", kind, FAMILIES)
    family = kind if kind is not None else str(rng.choice(list(FAMILIES)))
    wide = float(rng.uniform(*width))
    tall = float(rng.uniform(height[0], max(height[0], min(height[1], SLENDER * wide))))
    name, solid = FAMILIES[family](rng, wide, tall)
    volume = _volume(solid)
    density = math.exp(rng.uniform(*np.log(_density_bounds(volume, mass))))
    weight = float(np.clip(density * volume, *mass))
    own = name if name in {"cylinder", "box"} else "solid"
    shape = ObjectSpec(kind=own, size=solid.extents(), mass=weight, loaded=solid if own == "solid" else None)
    return Everyday(name=name, family=family, shape=shape)


def parse_everyday(seed: int, kind: str | None = None) -> ObjectSpec:
    """The object of a seed, as ``everyday:seed=7`` says."""
    drawn = draw_everyday(np.random.default_rng(seed), kind=kind)
    x, y, z = (1e3 * extent for extent in drawn.shape.size)
    note = f"drawn: a {drawn.name} of {y:.0f} x {z:.0f} x {x:.0f} mm, {1e3 * drawn.shape.mass:.0f} g"
    return replace(drawn.shape, notes=(note,))


def _check_bounds(name: str, bounds: tuple[float, float], allowed: Range) -> None:
    if not (isinstance(bounds, tuple) and len(bounds) == 2):
        raise DesignError(name, got=bounds, allowed="the least and the largest, a tuple of two numbers")
    for value in bounds:
        check_range(name, value, allowed)
    if bounds[0] > bounds[1]:
        raise DesignError(name, got=bounds, allowed="the smaller number first")


def _density_bounds(volume: float, mass: tuple[float, float]) -> tuple[float, float]:
    low, high = max(DENSITIES[0], mass[0] / volume), min(DENSITIES[1], mass[1] / volume)
    return (low, high) if low <= high else (min(max(DENSITIES[0], high), DENSITIES[1]),) * 2


def _draw_cylinder(rng: np.random.Generator, wide: float, tall: float) -> tuple[str, Solid]:
    return "cylinder", SOLIDS["cylinder"]((tall, wide, wide))


def _draw_box(rng: np.random.Generator, wide: float, tall: float) -> tuple[str, Solid]:
    deep = max(WIDTHS[0], wide * float(rng.uniform(0.35, 1.0)))
    return "box", SOLIDS["box"]((tall, min(wide, deep), wide))


def _draw_superquadric(rng: np.random.Generator, wide: float, tall: float) -> tuple[str, Solid]:
    """A convex superellipsoid (Barr, IEEE Comput. Graph. Appl. 1981), cut flat at 0.9 of its height."""
    along, around = (float(rng.uniform(0.2, 1.0)) for _ in range(2))
    deep = max(WIDTHS[0], wide * float(rng.uniform(0.5, 1.0)))
    up, turn = np.linspace(-math.pi / 2, math.pi / 2, 25), 2 * math.pi * np.arange(SECTORS) / SECTORS

    def power(value: np.ndarray, exponent: float) -> np.ndarray:
        return np.asarray(np.sign(value) * np.abs(value) ** exponent)

    height = np.clip(power(np.sin(up), along), -0.9, 0.9) / 0.9
    radius = power(np.cos(up), along)
    ring = np.stack([min(wide, deep) * power(np.cos(turn), around), wide * power(np.sin(turn), around)], axis=1) / 2
    points = [np.column_stack([np.full(SECTORS, h * tall / 2), r * ring]) for h, r in zip(height, radius, strict=True)]
    return "superquadric", _convex(np.vstack(points))


def _draw_revolution(rng: np.random.Generator, wide: float, tall: float) -> tuple[str, Solid]:
    name = str(rng.choice(list(OUTLINES)))
    return name, _revolve(np.array(OUTLINES[name]) * wide / 2, tall)


def _draw_handled(rng: np.random.Generator, wide: float, tall: float) -> tuple[str, Solid]:
    """A mug, or a jug that widens: a body with a handle of three bars to one side."""
    name = str(rng.choice(["mug", "jug"]))
    body = _revolve(wide / 2 * (np.ones(9) if name == "mug" else np.array(OUTLINES["barrel"])), tall)
    thick, out = max(0.006, 0.10 * wide), float(rng.uniform(0.3, 0.45)) * wide
    reach, span = 0.35 * wide, 0.5 * tall
    bars = [
        ((thick / 2, thick / 2, (out + wide / 2 - reach) / 2), (sign * span / 2, 0.0, (out + wide / 2 + reach) / 2))
        for sign in (-1, 1)
    ]
    bars.append(((span / 2 + thick / 2, thick / 2, thick / 2), (0.0, 0.0, wide / 2 + out)))
    handle = tuple(Geom(form="box", size=size, position=np.array(place)) for size, place in bars)
    return name, _unite((*body.geoms, *handle))


FAMILIES: dict[str, Draw] = {
    "cylinder": _draw_cylinder, "box": _draw_box, "superquadric": _draw_superquadric,
    "revolution": _draw_revolution, "handled": _draw_handled,
}  # fmt: skip
"""Classes of everyday shapes."""


def _revolve(radii: np.ndarray, tall: float) -> Solid:
    """A surface of revolution about x, as convex parts: frustums where its outline is concave."""
    angle = 2 * math.pi * np.arange(SECTORS) / SECTORS
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    heights = tall * (SHARES - 0.5)
    rings = [np.column_stack([np.full(SECTORS, h), r * circle]) for h, r in zip(heights, radii, strict=True)]
    slopes = np.diff(radii)
    cuts = [0, *(i for i in range(1, len(slopes)) if slopes[i] > slopes[i - 1] + 1e-9), len(slopes)]
    parts = [np.vstack(rings[a : b + 1]) for a, b in pairwise(cuts)]
    if len(parts) == 1:
        return _convex(parts[0])
    return _unite(tuple(_hull_geom(part) for part in parts))


def _hull_geom(points: np.ndarray) -> Geom:
    """A mesh geom of the convex hull of points, its triangles counter-clockwise from outside."""
    kept, faces = np.unique(hull_faces(points), return_inverse=True)
    return Geom(form="mesh", vertices=points[kept], faces=faces.reshape(-1, 3))


def _convex(points: np.ndarray) -> Solid:
    return _unite((_hull_geom(points),))


def _unite(geoms: tuple[Geom, ...]) -> Solid:
    """A solid of convex geoms of equal density, which hardly overlap: centre of mass and inertia are sums of theirs."""
    masses = [_moments(geom) for geom in geoms]
    volume = sum(part for part, _, _ in masses)
    centroid = sum((part * middle for part, middle, _ in masses), np.zeros(3)) / volume
    inertia = np.zeros((3, 3))
    for part, middle, own in masses:
        arm = middle - centroid
        inertia += part / volume * (own + arm @ arm * np.eye(3) - np.outer(arm, arm))
    solid = Solid(geoms=geoms, centroid=centroid, inertia=inertia)
    low, high = compute_bounds(geoms)
    return solid.transformed(offset=-(low + high) / 2)


def _moments(geom: Geom) -> tuple[float, np.ndarray, np.ndarray]:
    """Volume, centre of mass and inertia over mass about it, of a mesh or a box."""
    if geom.vertices is None or geom.faces is None:
        half = np.square(geom.size)
        return 8 * float(np.prod(geom.size)), geom.position, np.diag(half.sum() - half) / 3
    import trimesh

    mesh = trimesh.Trimesh(geom.vertices, geom.faces, process=False)
    mesh.density = 1.0
    volume = float(mesh.volume)
    return volume, np.array(mesh.center_mass), np.array(mesh.moment_inertia) / volume


def _volume(solid: Solid) -> float:
    """Volume of a drawn solid; of a cylinder from its size [m^3]."""
    return sum(
        2 * math.pi * geom.size[0] ** 2 * geom.size[1] if geom.form == "cylinder" else _moments(geom)[0]
        for geom in solid.geoms
        if geom.group != HIDDEN
    )
