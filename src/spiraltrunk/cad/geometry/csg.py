"""Constructive solid geometry: a part is a tree of revolved polygons, prisms and Boolean operations, in plain numbers.

The kernel builds the tree (`occ.build_solid`); volume and membership are computed here from the definition alone, as an
independent check. Lengths are in mm, angles in rad. The axis of the trunk is z, towards the tip; x is dorsal.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from itertools import product
from typing import final

import numpy as np

SAMPLES = 1 << 13
"""Number of quadrature points of a volume without closed form."""


@final
@dataclass(frozen=True, kw_only=True)
class Revolved:
    """A polygon revolved about z."""

    profile: tuple[tuple[float, float], ...]
    """Corners (radius, z), in order round the polygon [mm]."""
    start: float = 0.0
    """Angle at which the revolution begins [rad]."""
    arc: float = 2 * math.pi
    """Angle of the revolution, up to 2 pi [rad]."""


@final
@dataclass(frozen=True, kw_only=True)
class Prism:
    """A polygon in x and y, extruded along z."""

    corners: tuple[tuple[float, float], ...]
    """Corners (x, y), in order round the polygon [mm]."""
    bottom: float
    """Least z [mm]."""
    top: float
    """Largest z [mm]."""


@final
@dataclass(frozen=True, kw_only=True)
class Moved:
    """A form under a rigid transform."""

    form: Form
    """The form before the transform."""
    T: tuple[tuple[float, ...], ...]
    """Rigid transform, 4 rows of 4 [-, mm]."""


@final
@dataclass(frozen=True, kw_only=True)
class Union:
    """Union of forms; the first is the largest, as its volume counts in full."""

    forms: tuple[Form, ...]
    """The operands."""


@final
@dataclass(frozen=True, kw_only=True)
class Cut:
    """Difference of a form and tools."""

    form: Form
    """The minuend."""
    tools: tuple[Form, ...]
    """The subtrahends."""


@final
@dataclass(frozen=True, kw_only=True)
class Common:
    """Intersection of two forms."""

    form: Form
    """One operand, whose volume is computed."""
    other: Form
    """The other operand."""


Form = Revolved | Prism | Moved | Union | Cut | Common


QUARTERS = tuple(math.pi / 4 + k * math.pi / 2 for k in range(4))
"""Angles of four screws on a circle, half-way between the axes [rad]."""


def tube(inner: float, outer: float, low: float, high: float, *, start: float = 0.0, arc: float = 2 * math.pi) -> Form:
    """A tube about z between two radii and two heights, or its sector of ``arc`` from ``start`` on [rad]."""
    return Revolved(profile=((inner, low), (outer, low), (outer, high), (inner, high)), start=start, arc=arc)


def rod(radius: float, start: Sequence[float] | np.ndarray, end: Sequence[float] | np.ndarray) -> Form:
    """A cylinder between two points."""
    along = np.subtract(end, start)
    length = float(np.linalg.norm(along))
    return Moved(form=tube(0.0, radius, 0.0, length), T=_frame(along / length, start))


def rods(radius: float, ring: float, angles: Iterable[float], low: float, high: float) -> list[Form]:
    """Cylinders along z between two heights, at ``angles`` [rad] on a circle of radius ``ring``."""
    return [rod(radius, polar(ring, angle, low), polar(ring, angle, high)) for angle in angles]


def box(size: Sequence[float], center: Sequence[float]) -> Prism:
    """A box along the axes."""
    x, y, z = (float(value) for value in center)
    a, b, c = (float(value) / 2 for value in size)
    return Prism(corners=((x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b)), bottom=z - c, top=z + c)


def shifted(form: Form, by: Sequence[float]) -> Form:
    """The form translated."""
    return Moved(form=form, T=((1, 0, 0, float(by[0])), (0, 1, 0, float(by[1])), (0, 0, 1, float(by[2])), (0, 0, 0, 1)))


def turned(form: Form, axis: str, angle: float) -> Form:
    """The form rotated about x, y or z by ``angle`` [rad]."""
    i = "xyz".index(axis)
    T = np.eye(4)
    j, k = (i + 1) % 3, (i + 2) % 3
    T[j, j] = T[k, k] = math.cos(angle)
    T[k, j], T[j, k] = math.sin(angle), -math.sin(angle)
    return Moved(form=form, T=tuple(map(tuple, T.tolist())))


def polar(radius: float, angle: float, z: float) -> tuple[float, float, float]:
    """Point of cylindrical coordinates, ``angle`` from dorsal [rad]."""
    return (radius * math.cos(angle), radius * math.sin(angle), z)


def compute_bounds(form: Form) -> np.ndarray:
    """Axis-aligned bounding box, not necessarily tight, shape (2, 3) [mm]."""
    match form:
        case Revolved(profile=profile):
            widest = max(r for r, _ in profile)
            heights = [z for _, z in profile]
            return np.array([[-widest, -widest, min(heights)], [widest, widest, max(heights)]])
        case Prism(corners=corners, bottom=bottom, top=top):
            plane = np.array(corners)
            return np.array([[*plane.min(axis=0), bottom], [*plane.max(axis=0), top]])
        case Moved(form=inner, T=T):
            low, high = compute_bounds(inner)
            ends = np.array(list(product(*zip(low, high, strict=True)))) @ np.array(T)[:3, :3].T + np.array(T)[:3, 3]
            return np.stack([ends.min(axis=0), ends.max(axis=0)])
        case Union(forms=forms):
            boxes = np.stack([compute_bounds(part) for part in forms])
            return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])
        case Cut(form=inner):
            return compute_bounds(inner)
        case Common(form=inner, other=other):
            one, two = compute_bounds(inner), compute_bounds(other)
            return np.stack([np.maximum(one[0], two[0]), np.minimum(one[1], two[1])])


def contains(form: Form, points: np.ndarray) -> np.ndarray:
    """Whether points (n, 3) [mm] lie in the form, shape (n,) [bool]."""
    match form:
        case Revolved(profile=profile, start=start, arc=arc):
            radial = np.stack([np.hypot(points[:, 0], points[:, 1]), points[:, 2]], axis=-1)
            inside = _in_polygon(radial, profile)
            if arc < 2 * math.pi:
                inside &= np.mod(np.arctan2(points[:, 1], points[:, 0]) - start, 2 * math.pi) <= arc
            return inside
        case Prism(corners=corners, bottom=bottom, top=top):
            return _in_polygon(points[:, :2], corners) & (points[:, 2] >= bottom) & (points[:, 2] <= top)
        case Moved(form=inner, T=T):
            turn = np.array(T)
            return contains(inner, (points - turn[:3, 3]) @ turn[:3, :3])
        case Union(forms=forms):
            return _in_any(forms, points)
        case Cut(form=inner, tools=tools):
            return contains(inner, points) & ~_in_any(tools, points)
        case Common(form=inner, other=other):
            return contains(inner, points) & contains(other, points)


def compute_volume(form: Form) -> float:
    """Volume of the form [mm^3]: in closed form for revolved polygons and prisms, else by quasi-Monte Carlo.

    A union counts of each form the part that is in none before it. A cut takes from its form the part of each tool that
    is in the form and in no tool before it. These parts are means over the first points of the Halton sequence in the
    smaller of tool and form, so the result is reproducible.
    """
    match form:
        case Revolved(profile=profile, arc=arc):
            r, z = np.array(profile).T  # Pappus: the first moment of the polygon about the axis, times the angle.
            after, above = np.roll(r, -1), np.roll(z, -1)
            return arc * abs(float(np.sum((r * above - after * z) * (r + after)) / 6))
        case Prism(corners=corners, bottom=bottom, top=top):
            x, y = np.array(corners).T
            return abs(float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2)) * (top - bottom)
        case Moved(form=inner):
            return compute_volume(inner)
        case Union(forms=forms):
            shares = [_share(part, partial(_in_any, forms[:i])) for i, part in enumerate(forms)]
            return sum(compute_volume(part) * (1.0 - share) for part, share in zip(forms, shares, strict=True))
        case Cut(form=inner, tools=tools):
            whole = compute_volume(inner)
            return whole - sum(_compute_taken(inner, whole, tools, i) for i in range(len(tools)))
        case Common(form=inner, other=other):
            return compute_volume(inner) * _share(inner, partial(contains, other))


def _compute_taken(form: Form, whole: float, tools: tuple[Form, ...], i: int) -> float:
    """Volume that tool ``i``, and no tool before it, takes from a form of volume ``whole`` [mm^3]."""
    size = compute_volume(tools[i])
    small, large = (tools[i], form) if size < whole else (form, tools[i])
    return min(size, whole) * _share(small, lambda points: contains(large, points) & ~_in_any(tools[:i], points))


def _share(form: Form, test: Callable[[np.ndarray], np.ndarray]) -> float:
    """Share of a form's volume in which the test holds [-]."""
    low, high = compute_bounds(form)
    points = low + _unit_points() * (high - low)
    points = points[contains(form, points)]
    return float(np.mean(test(points))) if len(points) else 0.0


@cache
def _unit_points() -> np.ndarray:
    """Halton sequence in the unit cube without its first point, the origin; shape (SAMPLES, 3)."""
    from scipy.stats.qmc import Halton

    return np.asarray(Halton(3, scramble=False).random(SAMPLES + 1)[1:])


def _in_any(forms: Sequence[Form], points: np.ndarray) -> np.ndarray:
    inside = np.zeros(len(points), dtype=bool)
    for form in forms:
        low, high = compute_bounds(form)
        is_near = ~inside
        for axis in range(3):  # Column by column: a reduction of each row by itself takes several times as long.
            is_near &= (points[:, axis] >= low[axis]) & (points[:, axis] <= high[axis])
        near = np.flatnonzero(is_near)
        inside[near] = contains(form, points[near]) if len(near) else False
    return inside


def _in_polygon(points: np.ndarray, corners: Sequence[tuple[float, float]]) -> np.ndarray:
    """Whether points lie in a polygon, by the even-odd rule."""
    inside = np.zeros(len(points), dtype=bool)
    x, y = points[:, 0], points[:, 1]
    for (x0, y0), (x1, y1) in zip(corners, (*corners[1:], corners[0]), strict=True):
        if y0 != y1:
            inside ^= ((y0 > y) != (y1 > y)) & (x < x0 + (y - y0) * ((x1 - x0) / (y1 - y0)))
    return inside


def _frame(direction: np.ndarray, origin: Sequence[float] | np.ndarray) -> tuple[tuple[float, ...], ...]:
    """Rigid transform that maps z to ``direction`` and the origin to ``origin``."""
    other = np.array([1.0, 0.0, 0.0]) if abs(direction[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    x = np.cross(other, direction)
    x /= np.linalg.norm(x)
    rows = np.column_stack([x, np.cross(direction, x), direction, origin])
    return (*map(tuple, rows.tolist()), (0.0, 0.0, 0.0, 1.0))
