"""Steel pins that align two pieces of the trunk. Heights are along the axis from the base joint, in mm."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.geometry.csg import Form, rods
from spiraltrunk.cad.trunk.neck_screws import between_cables
from spiraltrunk.design.trunk import TrunkDesign

if TYPE_CHECKING:
    from spiraltrunk.cad.trunk.body import Body

DEPTHS = (8.0, 6.0, 5.0, 4.0, 3.0)
"""Half the standard lengths of pins (ISO 8734)."""

_SPARE = 0.3
"""Depth of a hole beyond half the pin (ours)."""

_THICK, _THIN = 3.0, 2.0
"""Diameters of pins in sections wider and narrower than `_WIDE` (ours)."""

_WIDE = 30.0


@final
@dataclass(frozen=True, kw_only=True)
class Pin:
    """A set of equal pins across one plane."""

    height: float
    """Height of the plane."""
    ring: float
    """Radius of their circle."""
    angles: tuple[float, ...]
    """Their angles from dorsal [rad]."""
    diameter: float
    """Diameter of pin and hole."""
    depth: float
    """Depth on either side: half its length."""

    def holes(self, low: float, high: float) -> list[Form]:
        """Holes in the piece between two heights; none where the plane is not one of its ends."""
        if self.height not in (low, high):
            return []
        deep = self.depth + _SPARE
        return rods(self.diameter / 2, self.ring, self.angles, self.height - deep, self.height + deep)


def find_pins(design: TrunkDesign, body: Body, planes: Sequence[float], options: MakeOptions) -> tuple[Pin, ...]:
    """Pins across each inner plane, at the largest product of depth and radius; none where there is no room.

    Each hole keeps a wall to both faces of its section, to the shell's seat and to the channel on the axis.
    """
    found = (_find_pin(design, body, z, options) for z in planes[1:-1])
    return tuple(pin for pin in found if pin is not None)


def _find_pin(design: TrunkDesign, body: Body, z: float, options: MakeOptions) -> Pin | None:
    n = int(np.searchsorted(body.starts, z)) - 1
    start, length = float(body.starts[n]), 1e3 * float(design.section_length[n])
    t1, t2 = math.tan(design.solid.lean_proximal), math.tan(design.solid.lean_distal)
    radius, seat = 1e3 * float(design.section_radius[n]), body.seats[n]
    diameter = _THICK if 2 * radius > _WIDE else _THIN
    free = diameter / 2 + options.wall
    outer = (radius if seat is None else seat.inner) - free
    inner = options.pair_hole / 2 if n < body.n_hollow else body.find_aside(options) + options.hole / 2
    best = None
    for ring in np.linspace(outer, max(inner + free, 0.0), 40) if outer > inner + free else ():
        room = min(z - start - ring * t1, start + length - ring * t2 - z) - options.wall - _SPARE - diameter / 2 * t1
        depth = next((d for d in DEPTHS if d <= room), 0.0)
        if depth and (best is None or depth * ring > best.depth * best.ring):
            best = Pin(height=z, ring=float(ring), angles=between_cables(design), diameter=diameter, depth=depth)
    return best
