"""Lid of the housing with cable guides and the servo's bracket, printed with its outer side down. In mm."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

from spiraltrunk.cad.components.fasteners import M3, M4, THREADS, sink
from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.geometry.csg import Cut, Form, Revolved, Union, box, polar, rod, rods, shifted, turned
from spiraltrunk.cad.geometry.part import PLA, Part
from spiraltrunk.cad.housing.layout import FOOT_ANGLES, HousingLayout, foot_circle, too_small
from spiraltrunk.cad.housing.winder import find_drum
from spiraltrunk.design.trunk import TrunkDesign

GUIDE, LIP = 7.0, 2.5
"""Outer radius of a cable's guide under the lid, and radius of the rounded lip at its end [mm] (ours)."""


_DEEP, _RISE, _BAR = 4.0, 10.0, 3.0
"""Thickness of the servo's bracket, distance of the servo from the lid, height of the bracket beyond it (ours)."""

_FORE, _AFT = 7.0, 18.0
"""Reach of the servo from its lugs towards the axis, with gears, and away from it (9 g class)."""


def find_bracket(design: TrunkDesign, layout: HousingLayout, options: MakeOptions) -> tuple[float, float]:
    """Place of the bracket nearest to the axis with the servo clear of cable guides, nuts and posts.

    Returns:
        Rotation about the axis, 0 towards y [rad], and distance of the bracket's middle from the axis.

    Raises:
        DesignError: where there is no room for it.
    """
    ring, foot = 1e3 * float(design.hole_position[0, 0, 1]), foot_circle(design)
    guides = [polar(ring, -a, 0.0) for a in design.cable.angles]
    nuts = [polar(foot, -a, 0.0) for a in FOOT_ANGLES]
    aside, nut = options.servo.aside, THREADS["M4"].flats / math.sqrt(3) + 0.5
    for away in range(8, int(layout.radius)):
        body = _Box(middle=aside, wide=options.servo.lug_pitch + 5.0, near=away - _FORE, far=away + _AFT)
        wall = _Box(middle=aside, wide=options.servo.bracket, near=away - _DEEP / 2, far=away + _DEEP / 2)
        if max(body.reach, wall.reach) > layout.post - 5.0:
            break
        for step in range(24):
            turn = step * math.pi / 12
            is_clear = all(body.distance(place, turn) >= GUIDE + 0.5 for place in guides)
            if is_clear and all(wall.distance(place, turn) >= nut for place in nuts):
                return turn, float(away)
    raise too_small(
        "housing.radius_mm", layout.radius, layout.radius + 5.0, "a servo of the 9 g class beside the cables"
    )


def build_lid(design: TrunkDesign, layout: HousingLayout, options: MakeOptions) -> Part:
    """The lid; it is turned over about x for assembly, so angles change their sign."""
    thick = options.plate
    disc = Revolved(profile=((0.0, 0.0), (layout.radius, 0.0), (layout.radius, thick), (0.0, thick)))
    tools = rods(M3 / 2, layout.post, [-a for a in layout.posts], -1, thick + 1)
    # Countersunk, as the neck's foot may lie over them.
    tools += [shifted(sink(THREADS["M3"], M3), polar(layout.post, -a, 0.0)) for a in layout.posts]
    ring, end = 1e3 * float(design.hole_position[0, 0, 1]), thick + layout.height - layout.groove
    angles = [-a for a in design.cable.angles]
    forms: list[Form] = [disc, *rods(GUIDE, ring, angles, thick / 2, end)]
    tools += [form for a in angles for form in _bore_guide(polar(ring, a, end), options)]
    tools += rods(M4 / 2, foot_circle(design), [-a for a in FOOT_ANGLES], -1, thick + 1)
    if design.gripper is not None:
        stand, openings = _build_bracket(design, layout, options)
        forms.append(stand)
        tools += [rod(2.5, (0, 0, -1), (0, 0, thick + 1)), *openings]
    top = -1e3 * design.housing.neck_length
    return Part(
        name="lid", group="housing", what="lid with cable guides and the servo's bracket", material=PLA,
        form=Cut(form=Union(forms=tuple(forms)), tools=tuple(tools)), at=(0.0, 0.0, top), turn=math.pi,
        thinnest="a thicker plate",
    )  # fmt: skip


def _bore_guide(end: tuple[float, float, float], options: MakeOptions) -> list[Form]:
    """Cuts of a guide with this end: the cable's bore, and a rounded lip over which it turns to its drum."""
    x, y, z = end
    steps = [math.pi / 2 * k / 6 for k in range(7)]
    lip = [(options.hole + LIP * (1 - math.cos(a)), z - LIP + LIP * math.sin(a)) for a in steps]
    wide = lip[-1][0]
    trumpet = Revolved(profile=((0.0, z - LIP), *lip, (wide, z + 1.0), (0.0, z + 1.0)))
    return [rod(options.hole, (x, y, -1.0), (x, y, z + 1.0)), shifted(trumpet, (x, y, 0.0))]


def _build_bracket(design: TrunkDesign, layout: HousingLayout, options: MakeOptions) -> tuple[Form, list[Form]]:
    """The bracket: a wall, and the cuts of the servo's opening and lugs; the servo's shaft points to the axis."""
    servo, thick, (turn, away) = options.servo, options.plate, find_bracket(design, layout, options)
    middle, aside = thick + _RISE + servo.width / 2, servo.aside
    tall = middle + servo.width / 2 + _BAR
    room_left = thick + layout.height - layout.groove - find_drum(design, options).height / 2 - 1.0
    if tall > room_left:
        raise too_small("room for the servo between lid and drums", room_left, tall, "a servo of the 9 g class")
    wall = box((servo.bracket, _DEEP, tall - thick / 2), (aside, away, (tall + thick / 2) / 2))
    openings: list[Form] = [box((servo.length + 0.4, 3 * _DEEP, servo.width + 0.4), (aside, away, middle))]
    for side in (-0.5, 0.5):
        x = aside + side * servo.lug_pitch
        openings.append(rod(0.9, (x, away - _DEEP, middle), (x, away + _DEEP, middle)))
    return turned(wall, "z", turn), [turned(form, "z", turn) for form in openings]


@final
@dataclass(frozen=True, kw_only=True)
class _Box:
    """A rectangle in the plane of the lid, before its rotation about the axis."""

    middle: float
    wide: float
    near: float
    far: float

    @property
    def reach(self) -> float:
        """Distance of its farthest corner from the axis."""
        return math.hypot(abs(self.middle) + self.wide / 2, self.far)

    def distance(self, place: tuple[float, float, float], turn: float) -> float:
        """Distance of a point from the rotated rectangle."""
        c, s = math.cos(turn), math.sin(turn)
        x, y = c * place[0] + s * place[1], c * place[1] - s * place[0]
        return math.hypot(max(abs(x - self.middle) - self.wide / 2, 0.0), max(self.near - y, 0.0, y - self.far))
