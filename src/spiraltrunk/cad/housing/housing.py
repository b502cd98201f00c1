"""Motor housing with lid and neck, and adapter to the robot's flange. In mm.

From the flange: adapter, housing with the motors on its floor, drums, lid with a guide for each cable and the servo's
bracket, neck with the funnel that section 1 sits in. Outer dimensions are the design's.
"""

from __future__ import annotations

import math

from spiraltrunk.cad.components.fasteners import (
    M3,
    M3_INSERT,
    M3_INSERT_DEEP,
    M4,
    M4_INSERT,
    M4_INSERT_DEEP,
    M6,
    M6_HEAD,
    THREADS,
    Bolt,
    sink,
)
from spiraltrunk.cad.components.options import ADAPTER, MOST_MOTORS, MakeOptions
from spiraltrunk.cad.geometry.csg import (
    QUARTERS,
    Common,
    Cut,
    Form,
    Revolved,
    Union,
    box,
    polar,
    rod,
    rods,
    shifted,
    tube,
    turned,
)
from spiraltrunk.cad.geometry.part import Part, too_small
from spiraltrunk.cad.housing.layout import FOOT, FOOT_ANGLES, FOOT_WIDE, POST, HousingLayout, find_layout, foot_circle
from spiraltrunk.cad.housing.winder import find_drum, motor_angles
from spiraltrunk.cad.trunk.neck_screws import BOSS, NECK_WALL, between_cables, find_neck_screw
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, Unquoted

SPIGOT_SEAT = 6.5
"""Depth of the counterbores for the adapter's M6 heads [mm] (ours)."""

GUIDE, LIP = 7.0, 2.5
"""Outer radius of a cable's guide under the lid, and radius of the rounded lip at its end [mm] (ours)."""

PORT = 14.0
"""Width and height of the opening in the housing's wall for the wires and their plugs [mm] (ours)."""

PORT_TURN = 0.2
"""Angle of that opening past the first post [rad] (ours)."""

_DEEP, _RISE, _BAR = 4.0, 10.0, 3.0
"""Thickness of the servo's bracket, distance of the servo from the lid, height of the bracket beyond it (ours)."""

_FORE, _AFT = 7.0, 18.0
"""Reach of the servo from its lugs towards the axis, with gears, and away from it (9 g class)."""


def build_housing(design: TrunkDesign, options: MakeOptions) -> tuple[Part, ...]:
    """Housing, lid and neck.

    Raises:
        DesignError: for more motors than have ids on one bus, or where something does not fit.
    """
    if design.n_cable > MOST_MOTORS:
        allowed = f"at most {MOST_MOTORS}, one for each id of a GM6020 on its bus; or other parts than the housing"
        raise DesignError("part housing", got=Unquoted(f"for {design.n_cable} cables"), allowed=allowed)
    layout = find_layout(design, options)
    return (
        _build_cup(design, layout, options),
        _build_lid(design, layout, options),
        _build_neck(design, layout, options),
    )


def build_adapter(design: TrunkDesign, options: MakeOptions) -> tuple[Part, ...]:
    """The plate between the robot's flange (ISO 9409-1-50-4-M6) and the housing, printed with the housing's side down.

    A spigot centres it in the flange. The M6 heads are counterbored below the housing's floor.
    """
    flange, layout = options.flange, find_layout(design, options)
    outer = layout.base + 7.0
    spigot = flange.pilot / 2 - options.clearance / 2
    ring, tall = flange.pitch_circle / 2, ADAPTER + flange.pilot_height
    profile = ((0.0, 0.0), (outer, 0.0), (outer, ADAPTER), (spigot, ADAPTER), (spigot, tall), (0.0, tall))
    tools = [*rods(M6 / 2, ring, QUARTERS, -1, ADAPTER + 1), *rods(M6_HEAD / 2, ring, QUARTERS, -1, SPIGOT_SEAT)]
    tools.append(rod((flange.dowel + 0.1) / 2, polar(ring, 0, ADAPTER - 6.0), polar(ring, 0, ADAPTER + 1)))
    # It is turned over about x for assembly, so angles change their sign.
    tools += rods(M4_INSERT / 2, layout.base, [-a for a in layout.bases], -1, M4_INSERT_DEEP)
    tools.append(rod(8.0, (0, 0, -1), (0, 0, tall + 1)))
    top = -1e3 * (design.housing.neck_length + design.housing.length)
    return (
        Part(name="adapter", group="adapter", what="plate for a flange ISO 9409-1-50-4-M6",
             material=design.housing.filament, form=Cut(form=Revolved(profile=profile), tools=tuple(tools)),
             at=(0.0, 0.0, top + ADAPTER), turn=math.pi),
    )  # fmt: skip


def _build_cup(design: TrunkDesign, layout: HousingLayout, options: MakeOptions) -> Part:
    inner, floor = layout.radius - options.rim, options.plate
    cup = Revolved(
        profile=(
            (0.0, 0.0), (layout.radius, 0.0), (layout.radius, layout.height), (inner, layout.height), (inner, floor),
            (0.0, floor),
        )
    )  # fmt: skip
    posts = rods(POST, layout.post, layout.posts, floor / 2, layout.height)
    tools = rods(M3_INSERT / 2, layout.post, layout.posts, layout.height - M3_INSERT_DEEP, layout.height + 1)
    for axis in motor_angles(design):
        tools += rods(8.0, layout.ring, [axis], -1, floor + 1)
        for x, y in _motor_screws(layout, axis, options):
            tools.append(rod(M4 / 2, (x, y, -1), (x, y, floor + 1)))
            tools.append(shifted(sink(THREADS["M4"], M4), (x, y, 0.0)))  # Countersunk, as the adapter lies over them.
    tools += rods(M4 / 2, layout.base, layout.bases, -1, floor + 1)
    port = box((0.3 * layout.radius, PORT, PORT), (0.95 * layout.radius, 0, floor + 1.0 + PORT / 2))
    tools.append(turned(port, "z", layout.posts[0] + PORT_TURN))
    bottom = -1e3 * (design.housing.neck_length + design.housing.length) + ADAPTER
    return Part(
        name="housing", group="housing", what=f"cup for {design.n_cable} motors",
        material=design.housing.filament, form=Cut(form=Union(forms=(cup, *posts)), tools=tuple(tools)),
        at=(0.0, 0.0, bottom), thinnest="a thicker rim",
    )  # fmt: skip


def _build_lid(design: TrunkDesign, layout: HousingLayout, options: MakeOptions) -> Part:
    """The lid; it is turned over about x for assembly, so angles change their sign."""
    thick = options.plate
    tools = rods(M3 / 2, layout.post, [-a for a in layout.posts], -1, thick + 1)
    # Countersunk, as the neck's foot may lie over them.
    tools += [shifted(sink(THREADS["M3"], M3), polar(layout.post, -a, 0.0)) for a in layout.posts]
    ring, end = 1e3 * float(design.hole_position[0, 0, 1]), thick + layout.height - layout.groove
    angles = [-a for a in design.cable.angles]
    forms: list[Form] = [tube(0.0, layout.radius, 0.0, thick), *rods(GUIDE, ring, angles, thick / 2, end)]
    tools += [form for a in angles for form in _bore_guide(polar(ring, a, end), options)]
    tools += rods(M4 / 2, foot_circle(design), [-a for a in FOOT_ANGLES], -1, thick + 1)
    if design.gripper is not None:
        stand, openings = _build_bracket(design, layout, options)
        forms.append(stand)
        tools += [rod(2.5, (0, 0, -1), (0, 0, thick + 1)), *openings]
    top = -1e3 * design.housing.neck_length
    return Part(
        name="lid", group="housing", what="lid with cable guides and the servo's bracket",
        material=design.housing.filament, form=Cut(form=Union(forms=tuple(forms)), tools=tuple(tools)),
        at=(0.0, 0.0, top), turn=math.pi,
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
        raise too_small("housing: room between lid and drums", room_left, tall, "a servo of the 9 g class")
    wall = box((servo.bracket, _DEEP, tall - thick / 2), (aside, away, (tall + thick / 2) / 2))
    openings: list[Form] = [box((servo.length + 0.4, 3 * _DEEP, servo.width + 0.4), (aside, away, middle))]
    for side in (-0.5, 0.5):
        x = aside + side * servo.lug_pitch
        openings.append(rod(0.9, (x, away - _DEEP, middle), (x, away + _DEEP, middle)))
    return turned(wall, "z", turn), [turned(form, "z", turn) for form in openings]


def find_bracket(design: TrunkDesign, layout: HousingLayout, options: MakeOptions) -> tuple[float, float]:
    """Place of the servo's bracket nearest to the axis with the servo clear of cable guides, nuts and posts.

    Returns:
        Rotation about the axis, 0 towards y [rad], and distance of the bracket's middle from the axis.

    Raises:
        DesignError: where there is no room for it.
    """
    ring, foot, servo = 1e3 * float(design.hole_position[0, 0, 1]), foot_circle(design), options.servo
    nut = THREADS["M4"].flats / math.sqrt(3) + 0.5

    def measure(radius: float, angle: float, wide: float, near: float, far: float) -> float:
        """Distance of a point from a rectangle beside the y axis."""
        x, y, _ = polar(radius, angle, 0.0)
        return math.hypot(max(abs(x - servo.aside) - wide / 2, 0.0), max(near - y, 0.0, y - far))

    for away in range(8, int(layout.radius)):
        body = (servo.lug_pitch + 5.0, away - _FORE, away + _AFT)
        wall = (servo.bracket, away - _DEEP / 2, away + _DEEP / 2)
        if max(math.hypot(abs(servo.aside) + wide / 2, far) for wide, _, far in (body, wall)) > layout.post - 5.0:
            break
        for turn in (step * math.pi / 12 for step in range(24)):
            is_clear = all(measure(ring, -a - turn, *body) >= GUIDE + 0.5 for a in design.cable.angles)
            if is_clear and all(measure(foot, -a - turn, *wall) >= nut for a in FOOT_ANGLES):
                return turn, float(away)
    why = "a servo of the 9 g class beside the cables"
    raise too_small("housing: housing.radius_mm", layout.radius, layout.radius + 5.0, why)


def _build_neck(design: TrunkDesign, layout: HousingLayout, options: MakeOptions) -> Part:
    """A tube whose end mates with section 1's proximal face, printed on its foot."""
    solid = design.solid
    radius, tall, slope = 1e3 * solid.radius, 1e3 * design.housing.neck_length, math.tan(solid.lean_proximal)
    inner = radius - NECK_WALL
    if tall < NECK_WALL + FOOT:
        raise too_small("housing: housing.neck_length_mm", tall, NECK_WALL + FOOT, "the neck's foot and funnel")
    shell = Revolved(
        profile=(
            (0.0, tall), (radius, tall + radius * slope), (radius, FOOT), (radius + FOOT_WIDE, FOOT),
            (radius + FOOT_WIDE, 0.0),
            (inner, 0.0), (inner, tall - NECK_WALL + inner * slope), (0.0, tall - NECK_WALL),
        )
    )  # fmt: skip
    ring, high = 1e3 * float(design.hole_position[0, 0, 1]), tall + radius * slope + 1.0
    screw = find_neck_screw(design)
    low = tall - NECK_WALL - 1.0
    tools = rods(options.hole, ring, design.cable.angles, low, high)
    tools += rods(M4 / 2, screw.ring, between_cables(design), low, high)
    below = Revolved(profile=((0.0, 0.0), (radius, 0.0), (radius, tall + radius * slope), (0.0, tall)))
    seat = tall + screw.seat
    bosses = [Common(form=boss, other=below) for boss in rods(BOSS, screw.ring, between_cables(design), seat, high)]
    tools += rods(M4 / 2, foot_circle(design), FOOT_ANGLES, -1, FOOT + 1)
    if design.gripper is not None:
        tools.append(rod(2.5, (0, 0, low), (0, 0, high)))
    return Part(
        name="neck", group="housing", what="neck with the funnel of section 1",
        material=design.housing.filament, form=Cut(form=Union(forms=(shell, *bosses)), tools=tuple(tools)),
        at=(0.0, 0.0, -tall),
        thinnest="a thicker neck",
    )  # fmt: skip


def _motor_screws(layout: HousingLayout, axis: float, options: MakeOptions) -> list[tuple[float, float]]:
    """Places (x, y) of the four screws of the motor at the angle ``axis``."""
    (x, y, _), radius = polar(layout.ring, axis, 0.0), options.motor.floor_circle / 2
    return [(x + u, y + v) for u, v, _ in (polar(radius, axis + quarter, 0.0) for quarter in QUARTERS)]


def list_housing_bolts(design: TrunkDesign, options: MakeOptions) -> list[Bolt]:
    """Screws of adapter, housing, lid and the neck's foot in the frame of the straight trunk."""
    layout, m3, m4, m6 = find_layout(design, options), THREADS["M3"], THREADS["M4"], THREADS["M6"]
    neck = -1e3 * design.housing.neck_length
    floor = neck - 1e3 * design.housing.length + ADAPTER
    flange, up, down = options.flange.pitch_circle / 2, (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)
    bolts = [
        Bolt(what="adapter to the arm's flange", parts=("adapter",), thread=m6, length=12.0, along=down,
             seat=polar(flange, a, floor - SPIGOT_SEAT))
        for a in QUARTERS
    ]  # fmt: skip
    bolts += [
        Bolt(what="housing to adapter", parts=("housing", "adapter"), thread=m4, length=12.0, along=down,
             seat=polar(layout.base, a, floor + options.plate), way=layout.height - options.plate - m4.head_height)
        for a in layout.bases
    ]  # fmt: skip
    bolts += [
        Bolt(what="motor to housing", parts=("housing",), thread=m4, length=10.0, along=up, is_sunk=True,
             seat=(*place, floor))
        for axis in motor_angles(design)
        for place in _motor_screws(layout, axis, options)
    ]  # fmt: skip
    bolts += [
        Bolt(what="lid to housing", parts=("lid", "housing"), thread=m3, length=10.0, along=down, is_sunk=True,
             seat=polar(layout.post, a, neck), way=20.0)
        for a in layout.posts
    ]  # fmt: skip
    bolts += [
        Bolt(what="neck to lid", parts=("neck", "lid"), thread=m4, length=16.0, along=down,
             seat=polar(foot_circle(design), a, neck + FOOT), nut_at=FOOT + options.plate, way=20.0)
        for a in FOOT_ANGLES
    ]  # fmt: skip
    return bolts
