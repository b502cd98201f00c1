"""Screws between neck and section 1: heads on flat bosses inside the neck, nuts in pockets of section 1.

They end below the faces of the first gap, so that the joint can close. Heights are from the base joint, in mm.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

from spiraltrunk.cad.components.fasteners import M4, THREADS, Bolt, hexagon, pick_length
from spiraltrunk.cad.geometry.csg import Form, polar, rod
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, Unquoted

NECK_WALL = 4.0
"""Thickness of the neck's wall and funnel [mm] (ours)."""

BOSS = 5.5
"""Radius of the boss under a head [mm] (ours)."""

_THREAD = THREADS["M4"]
_BEYOND, _BELOW, _PLAY = 1.0, 0.3, 0.3
"""Thread beyond the nut, least depth below the face, width of the pocket over that of the nut [mm] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class NeckScrew:
    """Dimensions that neck, section 1 and bill share, in mm."""

    ring: float
    """Radius of the circle of the screws."""
    seat: float
    """Height of the heads' seats, in the neck."""
    length: float
    """Length of the screw."""
    nut: float
    """Height of the pocket's floor, under the nut."""


def find_neck_screw(design: TrunkDesign) -> NeckScrew:
    """The longest screw that ends below the distal face of section 1.

    Raises:
        DesignError: where section 1 is too short for one.
    """
    solid, t1, t2 = design.solid, math.tan(design.solid.lean_proximal), math.tan(design.solid.lean_distal)
    ring = 0.72 * 1e3 * float(design.hole_position[0, 0, 1])
    seat = (ring - BOSS) * t1 - NECK_WALL
    corner = (_THREAD.flats + _PLAY) / math.sqrt(3)
    end = 1e3 * solid.length - (ring + corner) * t2 - _BELOW
    length = pick_length(end - seat)
    least = ring * t1 - seat + 3.0 + _THREAD.nut + _BEYOND
    if length is None or length < least:
        raise DesignError(
            "part neck: screws into section 1", got=Unquoted(f"{end - seat:.1f} mm long at most"),
            allowed=f"at least {least:.1f} mm: a longer section 1, from a larger base",
        )  # fmt: skip
    return NeckScrew(ring=ring, seat=seat, length=length, nut=seat + length - _BEYOND - _THREAD.nut)


def cut_neck_screws(design: TrunkDesign) -> list[Form]:
    """Cuts of section 1: clearance holes, and pockets for the nuts in its distal face."""
    screw, top = find_neck_screw(design), 1e3 * float(design.section_length[0])
    tools: list[Form] = []
    for angle in between_cables(design):
        tools.append(rod(M4 / 2, polar(screw.ring, angle, -1.0), polar(screw.ring, angle, screw.nut + 1.0)))
        tools.append(hexagon(_THREAD.flats + _PLAY, polar(screw.ring, angle, screw.nut), top))
    return tools


def list_neck_bolts(design: TrunkDesign) -> list[Bolt]:
    """The screws in the frame of the straight trunk."""
    screw = find_neck_screw(design)
    return [
        Bolt(
            what="neck to section 1", parts=("neck", "trunk_1"), thread=_THREAD, seat=polar(screw.ring, a, screw.seat),
            along=(0.0, 0.0, 1.0), length=screw.length, nut_at=screw.nut - screw.seat, is_nut_trapped=True,
            way=1e3 * design.housing.neck_length / 2,
        )
        for a in between_cables(design)
    ]  # fmt: skip


def between_cables(design: TrunkDesign) -> tuple[float, ...]:
    """Angles half-way between neighbouring cables, at most four or so [rad]."""
    turns = sorted(angle % (2 * math.pi) for angle in design.cable.angles)
    after = [*turns[1:], turns[0] + 2 * math.pi]
    middles = [(a + b) / 2 for a, b in zip(turns, after, strict=True)]
    return tuple(middles[:: max(1, len(middles) // 4)])
