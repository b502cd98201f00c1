"""Bayonet joint of trunk and gripper: a socket in the last section, and a tenon with two lugs.

The gripper's plate replaces the end of the last section, so that the fingers are where the design has them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.geometry.csg import Form, Revolved, rod
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, Unquoted

LUG_ARC, ENTRY_ARC = math.radians(50.0), math.radians(60.0)
"""Angles of a lug and of its entry slot [rad]."""

TURN = math.pi / 2
"""Rotation from entry to lock [rad]."""


@final
@dataclass(frozen=True, kw_only=True)
class TipSeat:
    """Dimensions that socket and tenon share, in mm."""

    radius: float
    """Radius of the last section."""
    plate: float
    """Thickness of the gripper's plate."""
    knot: float
    """Depth of the groove under the plate for the knots of the trunk's cables."""
    ring: float
    """Radius of the circle of the cables."""
    inner: float
    """Radius of the socket's mouth."""
    outer: float
    """Radius of the undercut for the lugs."""
    lip: float
    """Thickness of the socket's lip."""
    lug: float
    """Height of a lug."""
    clearance: float
    """Clearance all round."""
    bore: float
    """Radius of the hole for the gripper's cables through the tenon."""

    @property
    def undercut(self) -> float:
        """Depth of the undercut's floor below the section's end."""
        return self.lip + self.lug + self.clearance

    @property
    def depth(self) -> float:
        """Depth of the socket, with room for the cables below the tenon."""
        return self.undercut + self.lip / 2


def find_seat(design: TrunkDesign, options: MakeOptions) -> TipSeat:
    """Size the joint to fit inside the circle of the last section's cable holes.

    Raises:
        DesignError: where the tip is too small for it.
    """
    ring = 1e3 * float(design.hole_position[-1, 0, 1])
    outer = ring - options.hole / 2 - options.wall
    inner = 0.7 * outer
    bore = inner - options.clearance - options.wall
    knot = 4 * options.cable
    seat = TipSeat(
        radius=1e3 * float(design.section_radius[-1]), plate=knot + options.hole + 2.2 * options.wall, knot=knot,
        ring=ring, inner=inner, outer=outer, lip=1.5 * options.wall, lug=1.5 * options.wall,
        clearance=options.clearance, bore=bore,
    )  # fmt: skip
    _check_room(design, seat, options)
    return seat


def add_socket(seat: TipSeat, end: float) -> list[Form]:
    """Cuts of the last section, which ends at ``end`` on the axis [mm]."""
    tools: list[Form] = [rod(seat.inner, (0, 0, end - seat.depth), (0, 0, end + 1.0))]
    floor, roof, top = end - seat.undercut, end - seat.lip, end + 1.0
    for k in range(2):
        entry = math.pi / 2 + math.pi * k - ENTRY_ARC / 2
        tools.append(_sector(seat.inner - 0.5, seat.outer, (floor, roof), (entry, ENTRY_ARC + TURN)))
        tools.append(_sector(seat.inner - 0.5, seat.outer, (roof - 0.5, top), (entry, ENTRY_ARC)))
    return tools


def build_tenon(seat: TipSeat) -> list[Form]:
    """The tenon in its locked position, below z = 0; the first form reaches into the plate."""
    neck, bottom = seat.inner - seat.clearance, -(seat.lip + seat.lug)
    forms: list[Form] = [rod(neck, (0, 0, bottom), (0, 0, seat.knot / 2))]
    roof = -seat.lip - seat.clearance / 2
    for k in range(2):
        start = math.pi / 2 + math.pi * k + TURN - LUG_ARC / 2
        forms.append(_sector(neck - 0.5, seat.outer - seat.clearance, (bottom, roof), (start, LUG_ARC)))
    return forms


def _sector(inner: float, outer: float, heights: tuple[float, float], angles: tuple[float, float]) -> Form:
    low, high = heights
    start, arc = angles
    return Revolved(profile=((inner, low), (outer, low), (outer, high), (inner, high)), start=start, arc=arc)


def _check_room(design: TrunkDesign, seat: TipSeat, options: MakeOptions) -> None:
    if seat.bore < options.hole / 2:
        raise DesignError(
            "part gripper: radius of the hole in its tenon", got=Unquoted(f"{seat.bore:.2f} mm"),
            allowed=f"at least {options.hole / 2:.2f} mm: a wider tip, a finer --nozzle-mm or no [gripper]",
        )  # fmt: skip
    solid, scale = design.solid, 1e3 * float(design.scale[-1])
    cone = seat.outer * math.tan(solid.lean_proximal)
    left = scale * solid.length - seat.plate - seat.depth - cone
    if left < options.wall:
        raise DesignError(
            f"part trunk, section {design.n_section}: floor under the gripper's socket", got=Unquoted(f"{left:.2f} mm"),
            allowed=f"at least {options.wall:.2f} mm: a longer tip section, a finer --nozzle-mm or no [gripper]",
        )  # fmt: skip
