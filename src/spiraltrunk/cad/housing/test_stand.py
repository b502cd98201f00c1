"""Parts for measurements: wedges between flange (or bench) and adapter, and seats for motion-capture markers."""

from __future__ import annotations

import math

from spiraltrunk.cad.components.fasteners import M6, THREADS, Bolt
from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.geometry.csg import QUARTERS, Cut, Form, Prism, Union, box, polar, rod, rods, shifted, turned
from spiraltrunk.cad.geometry.part import Part
from spiraltrunk.design.trunk import TrunkDesign

TILT = math.pi / 4
"""Tilt of one wedge [rad]: none to three give the paper's 0, 45, 90 and 135 deg."""

PLATE, WEB = 6.0, 6.0
"""Thickness of the wedge's plates and side walls [mm] (ours)."""

KEY = 26.0
"""Distance of the plates from their line of intersection [mm]: room for an angled key (ours)."""

N_WEDGE = 3
"""Wedges for the largest tilt of the paper, 135 deg."""

PER_SECTION = 3
"""Markers on each section (paper)."""

MARKER_SCREW = 2.5
"""Diameter of the hole for a marker's self-tapping M3 stud [mm] (ours)."""


def build_wedge(design: TrunkDesign, options: MakeOptions) -> tuple[Part, ...]:
    """Two plates at 45 deg with the flange's holes in both, between two walls; open at the front for the key."""
    flange, (reach, middle) = options.flange, _find_plates(options)
    far, near = middle + reach, middle - reach
    plate = box((2 * reach, 2 * reach, PLATE), (middle, 0, PLATE / 2))
    upper = turned(box((2 * reach, 2 * reach, PLATE), (middle, 0, -PLATE / 2)), "y", -TILT)
    side = (
        (near, 0.0), (far, 0.0), (far * math.cos(TILT), far * math.sin(TILT)),
        (near * math.cos(TILT), near * math.sin(TILT)),
    )  # fmt: skip
    wall = turned(Prism(corners=tuple((x, -z) for x, z in side), bottom=0.0, top=WEB), "x", -math.pi / 2)
    walls = [shifted(wall, (0, y, 0)) for y in (-reach, reach - WEB)]
    holes: list[Form] = [rod(flange.pilot / 2 + options.clearance / 2, (0, 0, -1.0), (0, 0, PLATE + 1))]
    holes += rods(M6 / 2, flange.pitch_circle / 2, QUARTERS, -1.0, PLATE + 1)
    holes += rods((flange.dowel + 0.1) / 2, flange.pitch_circle / 2, [0.0], -1.0, PLATE + 1)
    tools = [shifted(hole, (middle, 0, 0)) for hole in holes]
    tools += [turned(shifted(hole, (middle, 0, -PLATE)), "y", -TILT) for hole in holes]
    form = Cut(form=Union(forms=(plate, upper, *walls)), tools=tuple(tools))
    what = "wedge of 45 deg between flange and adapter"
    material = design.housing.filament
    return (Part(name="wedge", group="wedge", what=what, material=material, form=form, count=N_WEDGE),)


def _find_plates(options: MakeOptions) -> tuple[float, float]:
    """Half the width of the plates, and distance of their middles from the line of intersection [mm]."""
    reach = max(options.flange.outer / 2 + 12.0, options.flange.pitch_circle / 2 + 8.0 + WEB)
    return reach, reach + KEY


def list_wedge_bolts(options: MakeOptions) -> list[Bolt]:
    """Screws of a wedge in its own frame: four into its support, four that hold the adapter or the next wedge."""
    m6, (_, middle), c, s = THREADS["M6"], _find_plates(options), math.cos(TILT), math.sin(TILT)
    bolts = []
    for x, y, _ in (polar(options.flange.pitch_circle / 2, quarter, 0.0) for quarter in QUARTERS):
        bolts.append(
            Bolt(what="wedge to flange or bench", parts=("wedge",), thread=m6, length=16.0,
                 seat=(middle + x, y, PLATE), along=(0.0, 0.0, -1.0), way=16.0)
        )  # fmt: skip
        above, along = middle + x, (s, 0.0, -c)  # Of the upper plate, from above.
        seat = (above * c - 3.5 * s, y, above * s + 3.5 * c)
        bolts.append(
            Bolt(what="adapter or wedge onto wedge", parts=("wedge",), thread=m6, length=20.0, seat=seat, along=along,
                 nut_at=PLATE + 3.5, is_head_elsewhere=True)
        )  # fmt: skip
    return bolts


def find_seat_height(radius: float) -> float:
    """Height and width of the marker seat on a section of this radius [mm] (ours)."""
    return min(max(5.0, 0.3 * radius), 1.4 * radius)


def build_markers(design: TrunkDesign, options: MakeOptions) -> tuple[Part, ...]:
    """A marker seat for each section: a block hollowed to the rim's radius, to be glued flush with the distal edge."""
    parts = []
    for n in range(design.n_section):
        radius = 1e3 * float(design.section_radius[n])
        wide = find_seat_height(radius)
        deep = max(3.0 * options.wall, 4.0)
        hollow = radius - math.sqrt(max(radius**2 - wide**2 / 4, 0.0))
        block = box((deep + hollow, wide, wide), (radius - hollow + (deep + hollow) / 2, 0, wide / 2))
        screw = min(MARKER_SCREW / 2, wide / 2 - options.wall)
        start, end = (radius + options.wall, 0, wide / 2), (radius + deep + 1, 0, wide / 2)
        form = Cut(form=block, tools=(rod(radius, (0, 0, -1), (0, 0, wide + 1)), rod(screw, start, end)))
        edge = design.section_length[:n].sum() + design.scale[n] * design.solid.rim_end
        place = (radius, 0.0, 1e3 * float(edge) - wide)
        parts.append(
            Part(name=f"marker_seat_{n + 1:02d}", group="markers", what=f"marker seat of section {n + 1}",
                 material=design.housing.filament, form=shifted(form, (-radius, 0, 0)), count=PER_SECTION, at=place)
        )  # fmt: skip
    return tuple(parts)
