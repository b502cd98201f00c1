"""Self-collision of the curled trunk: no two sections may overlap with every joint bent to its limit.

Sections are bodies of revolution about axes in one plane. Their deepest overlap lies in that plane, where they are
convex polygons.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations
from operator import itemgetter
from typing import final

import numpy as np

from spiraltrunk.design.spiral import radius
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, Unquoted

TOUCH = 1e-4
"""Overlap that counts as contact [m]: the accuracy of a printer."""


@final
@dataclass(frozen=True, kw_only=True)
class Overlap:
    """The deepest overlap of two sections of the curled trunk."""

    depth: float
    """Penetration depth along the direction of least separation [m]; negative for a gap."""
    sections: tuple[int, int]
    """The two sections, counted from 1 at the base."""


def find_overlap(design: TrunkDesign, bend: float | None = None) -> Overlap:
    """The deepest overlap with every joint bent by ``bend`` in one plane [rad]; the limit if None."""
    angle = design.joint_limit if bend is None else bend
    polygons = [_place(design, n, angle) for n in range(design.n_section)]
    pairs = combinations(range(design.n_section), 2)
    depth, i, j = max(((_depth(polygons[i], polygons[j]), i, j) for i, j in pairs), key=itemgetter(0))
    return Overlap(depth=depth, sections=(i + 1, j + 1))


def check_curl(design: TrunkDesign) -> Overlap:
    """Check the deepest overlap at the joint limit, and return it.

    Raises:
        DesignError: where sections collide; names them and the depth.
    """
    worst = find_overlap(design)
    first, second = worst.sections
    allowed = TOUCH + compute_allowed_overlap(design, second)
    if worst.depth > allowed:
        raise DesignError(
            f"part trunk: overlap of sections {first} and {second} with all joints bent "
            f"{math.degrees(design.joint_limit):.4g} deg",
            got=Unquoted(f"{1e3 * worst.depth:.2f} mm"),
            allowed=f"at most {1e3 * allowed:.2f} mm: a k of (1 + exp(-2 pi b)) / 2 or less",
        )  # fmt: skip
    return worst


def compute_allowed_overlap(design: TrunkDesign, section: int) -> float:
    """Allowed overlap [m]: depth by which corners of one turn enter the sides of the next in a compact spiral.

    Corners lie on the spiral; sides are its chords, which lie inside it by up to r (1 - cos(delta_theta / 2)). With an
    integer number of sections in a turn, corner meets corner. Else a corner meets a side at the fraction p of its
    length, where the chord lies inside by 4 p (1 - p) of that. The skin is soft enough for it.
    """
    part = (2 * math.pi / design.delta_theta) % 1.0
    if min(part, 1.0 - part) < 1e-9:
        return 0.0
    theta = design.theta_base - (section - 1) * design.delta_theta
    return 4 * part * (1 - part) * float(radius(design.spiral, theta)) * (1 - math.cos(design.delta_theta / 2))


def _place(design: TrunkDesign, n: int, angle: float) -> np.ndarray:
    """Outline of section ``n`` in the plane of the curl, shape (6, 2) [m]."""
    solid = design.solid
    ends = np.array([solid.rim_start - 1j * solid.radius, solid.rim_end - 1j * solid.radius])
    outline = float(design.scale[n]) * np.array([0.0, *ends, solid.length, *ends[::-1].conj()])
    joint = (design.section_length[:n] * np.exp(1j * angle * np.arange(n))).sum()
    placed = joint + outline * np.exp(1j * angle * n)
    return np.stack([placed.real, placed.imag], axis=-1)


def _depth(one: np.ndarray, other: np.ndarray) -> float:
    """Penetration depth of two convex polygons: distance of the origin from the faces of their Minkowski difference."""
    from scipy.spatial import ConvexHull

    return float(-ConvexHull((one[:, None] - other).reshape(-1, 2)).equations[:, -1].max())
