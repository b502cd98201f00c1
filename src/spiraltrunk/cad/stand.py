"""For measuring: a wedge that tilts the base by 45 deg, and seats for motion-capture markers on the sections.

One wedge tilts by 45 deg, two by 90, three by 135, none by 0: the four tilts of the paper's measurement.
"""

from __future__ import annotations

import math

from spiraltrunk.cad.forms import Cut, Form, Prism, Union, box, polar, rod, shifted, turned
from spiraltrunk.cad.housing import M4, foot_angles, foot_circle
from spiraltrunk.cad.options import MakeOptions
from spiraltrunk.cad.part import PLA, Part
from spiraltrunk.design.trunk import TrunkDesign

TILT = math.pi / 4
"""Tilt of one wedge [rad] (paper: 0, 45, 90 and 135 deg)."""

PLATE, WEB = 6.0, 6.0
"""Thickness of the wedge's plates and side walls [mm] (ours)."""

PER_SECTION = 3
"""Markers on each section (paper)."""

MARKER_SCREW = 2.5
"""Hole that a marker's M3 stud cuts its thread in [mm] (ours)."""


def build_wedge(design: TrunkDesign, options: MakeOptions) -> tuple[Part, ...]:
    """Two plates at 45 deg with the neck's pattern of holes on both, between two walls; open to turn the screws."""
    reach = foot_circle(design) + 8.0
    middle = reach + 2 * PLATE  # From the hinge line to the middle of each plate.
    plate = box((2 * reach, 2 * reach, PLATE), (middle, 0, PLATE / 2))
    upper = turned(box((2 * reach, 2 * reach, PLATE), (middle, 0, -PLATE / 2)), "y", -TILT)
    far = middle + reach
    corner = (far * math.cos(TILT), far * math.sin(TILT))
    near = middle - reach
    side = ((near, 0.0), (far, 0.0), corner, (near * math.cos(TILT), near * math.sin(TILT)))
    walls = [_upright(side, y) for y in (-reach, reach - WEB)]
    tools: list[Form] = []
    for angle in foot_angles(design):
        x, y, _ = polar(foot_circle(design), angle, 0.0)
        tools.append(rod(M4 / 2, (middle + x, y, -1), (middle + x, y, PLATE + 1)))
        tools.append(turned(rod(M4 / 2, (middle + x, y, -PLATE - 1), (middle + x, y, 1)), "y", -TILT))
    for form in (
        rod(12.0, (middle, 0, -1), (middle, 0, PLATE + 1)),
        turned(rod(12.0, (middle, 0, -PLATE - 1), (middle, 0, 1)), "y", -TILT),
    ):
        tools.append(form)
    form = Cut(form=Union(forms=(plate, upper, *walls)), tools=tuple(tools))
    part = Part(
        name="wedge", group="wedge", what="wedge of 45 deg for the neck's foot", material=PLA, form=form, count=3,
        at=(0.0, 0.0, 0.0), thinnest="a finer --nozzle-mm",
    )  # fmt: skip
    return (part,)


def build_markers(design: TrunkDesign, options: MakeOptions) -> tuple[Part, ...]:
    """A seat for one marker for each section: a block hollowed to the rim's radius, glued to the lower edge."""
    parts = []
    for n in range(design.n_section):
        radius = 1e3 * float(design.section_radius[n])
        wide = max(5.0, 0.3 * radius)
        wide = min(wide, 1.4 * radius)
        deep = max(3.0 * options.wall, 4.0)
        hollow = radius - math.sqrt(max(radius**2 - wide**2 / 4, 0.0))
        block = box((deep + hollow, wide, wide), (radius - hollow + (deep + hollow) / 2, 0, wide / 2))
        tools = (
            rod(radius, (0, 0, -1), (0, 0, wide + 1)),
            rod(
                min(MARKER_SCREW / 2, wide / 2 - options.wall),
                (radius + options.wall, 0, wide / 2),
                (radius + deep + 1, 0, wide / 2),
            ),
        )
        form = shifted(Cut(form=block, tools=tools), (-radius, 0, 0))
        parts.append(
            Part(
                name=f"marker_seat_{n + 1:02d}",
                group="markers",
                what=f"marker seat of section {n + 1}",
                material=PLA,
                form=form,
                count=PER_SECTION,
                at=(radius, 0.0, 1e3 * float(design.section_length[:n].sum())),
                thinnest="a finer --nozzle-mm",
            )
        )
    return tuple(parts)


def _upright(side: tuple[tuple[float, float], ...], y: float) -> Form:
    """A wall of that outline in x and z, ``WEB`` thick from ``y`` on."""
    drawn = turned(Prism(corners=tuple((x, -z) for x, z in side), bottom=0.0, top=WEB), "x", -math.pi / 2)
    return shifted(drawn, (0, y, 0))
