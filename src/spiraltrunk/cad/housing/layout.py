"""Layout of the housing: heights, circles and angles that its parts share. In mm."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

from spiraltrunk.cad.components.fasteners import THREADS
from spiraltrunk.cad.components.options import ADAPTER, MakeOptions
from spiraltrunk.cad.geometry.csg import polar
from spiraltrunk.cad.geometry.part import too_small
from spiraltrunk.cad.housing.winder import find_drum, motor_angles, motor_ring
from spiraltrunk.design.trunk import TrunkDesign

FOOT, FOOT_WIDE = 5.0, 10.0
"""Thickness and overhang of the neck's foot [mm] (ours)."""

FOOT_ANGLES = tuple(math.pi / 6 + k * math.pi / 3 for k in range(6))
"""Angles of the screws through the neck's foot and the lid [rad] (ours)."""

POST = 4.0
"""Radius of the posts that carry the lid [mm] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class HousingLayout:
    """Heights and radii of the housing in mm, from its underside."""

    radius: float
    """Outer radius."""
    height: float
    """Height between adapter and lid."""
    ring: float
    """Radius of the circle of the motors' axes."""
    post: float
    """Radius of the circle of the posts that carry the lid."""
    posts: tuple[float, ...]
    """Angles of the posts [rad]: between the motors."""
    base: float
    """Radius of the circle of screws between floor and adapter."""
    bases: tuple[float, ...]
    """Angles of these screws [rad]: between the motors, where a key reaches them."""
    groove: float
    """Height of the middle of the drums' grooves, at which the cables' guides end."""


def find_layout(design: TrunkDesign, options: MakeOptions) -> HousingLayout:
    """Compute the layout.

    Raises:
        DesignError: where motors, drums or screws do not fit.
    """
    housing, motor = design.housing, options.motor
    radius, ring = 1e3 * housing.radius, motor_ring(design, options)
    need = ring + motor.diameter / 2 + options.clearance + options.rim
    if radius < need:
        why = f"{design.n_cable} motors of {motor.diameter:g} mm side by side"
        raise too_small("housing: housing.radius_mm", radius, need, why)
    height = 1e3 * housing.length - ADAPTER - options.plate
    stack = options.plate + motor.height + find_drum(design, options).height + 2.0
    if height < stack:
        need = stack + ADAPTER + options.plate
        raise too_small("housing: housing.length_mm", 1e3 * housing.length, need, "floor, motor, drum, lid and adapter")
    posts = tuple(angle + math.pi / design.n_cable for angle in motor_angles(design))
    if 1e3 * design.solid.radius + FOOT_WIDE > radius:
        raise too_small("housing: housing.radius_mm", radius, 1e3 * design.solid.radius + FOOT_WIDE, "the neck's foot")
    drum, post = find_drum(design, options), radius - options.rim - 3.5
    bases = posts if design.n_cable > 2 else tuple(angle + side for angle in posts for side in (-0.35, 0.35))
    return HousingLayout(
        radius=radius, height=height, ring=ring, post=post, posts=posts, bases=bases,
        base=_find_base(design, options, bases, post), groove=options.plate + motor.height + drum.height / 2,
    )  # fmt: skip


def _find_base(design: TrunkDesign, options: MakeOptions, angles: tuple[float, ...], post: float) -> float:
    """Radius of the circle of the screws into the adapter, outside the flange and clear of the motors."""
    head, motor, ring = THREADS["M4"].head / 2 + 0.5, options.motor, motor_ring(design, options)
    radius, most = options.flange.outer / 2 + 6.0, post - POST - head
    while any(
        math.dist(polar(radius, a, 0), polar(ring, axis, 0)) < motor.diameter / 2 + head
        for a in angles
        for axis in motor_angles(design)
    ):
        radius += 0.5
    if radius > most:
        given = 1e3 * design.housing.radius
        raise too_small("housing: housing.radius_mm", given, given + radius - most, "screws beside the motors")
    return radius


def foot_circle(design: TrunkDesign) -> float:
    """Radius of the circle of screws through the neck's foot [mm]."""
    return 1e3 * design.solid.radius + FOOT_WIDE / 2 + 0.5
