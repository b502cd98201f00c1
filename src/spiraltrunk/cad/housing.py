"""What carries the trunk: motor housing, lid with the servo's bracket, neck, and the adapter to the robot's flange.

From the flange on: adapter, housing with its floor on it and the motors on the floor, drums, lid with a guide hole for
each cable above the trunk's holes, neck with the funnel that section 1 sits in. Outer sizes are the design's.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

from spiraltrunk.cad.forms import Cut, Form, Revolved, Union, box, polar, rod, shifted
from spiraltrunk.cad.options import MakeOptions
from spiraltrunk.cad.part import PLA, Part
from spiraltrunk.cad.sections import SCREW, between_cables, find_screw_ring
from spiraltrunk.cad.winder import find_drum, motor_angles, motor_ring
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, Words

ADAPTER = 10.0
"""Thickness of the adapter without its spigot [mm] (ours: room for the heads of the M6 screws)."""

FOOT, FOOT_WIDE = 5.0, 10.0
"""Thickness of the neck's foot, and how far it stands out [mm] (ours)."""

M3, M4, M6 = 3.4, 4.5, 6.6
"""Holes that screws pass [mm] (ISO 273, medium)."""

M3_INSERT, M4_INSERT = 4.0, 5.6
"""Holes for heat-set inserts [mm] (as their makers state them)."""

M6_HEAD = 11.0
"""Counterbore of an M6 socket head [mm] (DIN 974)."""

NECK_WALL = 4.0
"""Thickness of the neck's wall and funnel [mm] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class Room:
    """Heights and radii inside the housing, in mm; its floor's underside is 0."""

    radius: float
    """Outer radius."""
    height: float
    """Height without adapter and lid."""
    ring: float
    """Radius of the circle of the motors' axes."""
    post: float
    """Radius of the circle of the posts that carry the lid."""
    posts: tuple[float, ...]
    """Angles of the posts [rad]: between the motors."""
    base: float
    """Radius of the circle of screws between floor and adapter."""


def find_room(design: TrunkDesign, options: MakeOptions) -> Room:
    """Where everything goes in the housing.

    Raises:
        DesignError: where motors, drums or servo do not fit.
    """
    housing, motor = design.housing, options.motor
    radius, ring = 1e3 * housing.radius, motor_ring(design, options)
    need = ring + motor.diameter / 2 + options.clearance + options.rim
    if radius < need:
        raise _refuse(
            "housing.radius_mm", radius, need, f"{design.n_cable} motors of {motor.diameter:g} mm side by side"
        )
    height = 1e3 * housing.length - ADAPTER - options.plate
    stack = options.plate + motor.height + find_drum(design, options).height + 2.0
    if height < stack:
        need = stack + ADAPTER + options.plate
        raise _refuse("housing.length_mm", 1e3 * housing.length, need, "floor, motor, drum, lid and adapter")
    posts = tuple(angle + math.pi / design.n_cable for angle in motor_angles(design))
    if 1e3 * design.solid.radius + FOOT_WIDE > radius:
        raise _refuse("housing.radius_mm", radius, 1e3 * design.solid.radius + FOOT_WIDE, "the foot of the neck")
    return Room(
        radius=radius, height=height, ring=ring, post=radius - options.rim - 3.5, posts=posts,
        base=min(radius - 12.0, options.flange.outer / 2 + 6.0),
    )  # fmt: skip


def build_housing(design: TrunkDesign, options: MakeOptions) -> tuple[Part, ...]:
    """Housing, lid and neck."""
    room = find_room(design, options)
    return (_build_cup(design, room, options), _build_lid(design, room, options), _build_neck(design, room, options))


def build_adapter(design: TrunkDesign, options: MakeOptions) -> tuple[Part, ...]:
    """The plate between the robot's flange (ISO 9409-1-50-4-M6) and the housing, standing on the housing's side.

    Its spigot centres it in the flange; the M6 heads are sunk into its other side, beneath the housing's floor.
    """
    flange, room = options.flange, find_room(design, options)
    outer = room.base + 7.0
    spigot = flange.pilot / 2 - options.clearance / 2
    profile = (
        (0.0, 0.0),
        (outer, 0.0),
        (outer, ADAPTER),
        (spigot, ADAPTER),
        (spigot, ADAPTER + flange.pilot_height),
        (0.0, ADAPTER + flange.pilot_height),
    )
    ring = flange.pitch_circle / 2
    corners = [math.pi / 4 + k * math.pi / 2 for k in range(4)]
    tools: list[Form] = [rod(M6 / 2, polar(ring, a, -1), polar(ring, a, ADAPTER + 1)) for a in corners]
    tools += [rod(M6_HEAD / 2, polar(ring, a, -1), polar(ring, a, 6.5)) for a in corners]
    tools.append(rod((flange.dowel + 0.1) / 2, polar(ring, 0, ADAPTER - 6.0), polar(ring, 0, ADAPTER + 1)))
    tools += [rod(M4_INSERT / 2, polar(room.base, a, -1), polar(room.base, a, 7.0)) for a in _base_angles()]
    tools.append(rod(8.0, (0, 0, -1), (0, 0, ADAPTER + flange.pilot_height + 1)))
    top = -1e3 * (design.housing.neck_length + design.housing.length)
    part = Part(
        name="adapter", group="adapter", what="plate for a flange ISO 9409-1-50-4-M6", material=PLA,
        form=Cut(form=Revolved(profile=profile), tools=tuple(tools)), at=(0.0, 0.0, top + ADAPTER), turn=math.pi,
        thinnest="a finer --nozzle-mm",
    )  # fmt: skip
    return (part,)


def _build_cup(design: TrunkDesign, room: Room, options: MakeOptions) -> Part:
    inner, floor, motor = room.radius - options.rim, options.plate, options.motor
    cup = Revolved(
        profile=(
            (0.0, 0.0), (room.radius, 0.0), (room.radius, room.height), (inner, room.height), (inner, floor),
            (0.0, floor),
        )
    )  # fmt: skip
    posts = [rod(4.0, polar(room.post, a, floor / 2), polar(room.post, a, room.height)) for a in room.posts]
    tools: list[Form] = [
        rod(M3_INSERT / 2, polar(room.post, a, room.height - 8), polar(room.post, a, room.height + 1))
        for a in room.posts
    ]
    for axis in motor_angles(design):
        center = polar(room.ring, axis, 0.0)
        tools.append(rod(8.0, (*center[:2], -1), (*center[:2], floor + 1)))
        for q in range(4):
            x, y, _ = polar(motor.floor_circle / 2, axis + math.pi / 4 + q * math.pi / 2, 0)
            tools.append(rod(M4 / 2, (center[0] + x, center[1] + y, -1), (center[0] + x, center[1] + y, floor + 1)))
    tools += [rod(M4 / 2, polar(room.base, a, -1), polar(room.base, a, floor + 1)) for a in _base_angles()]
    x, y, _ = polar(room.radius, room.posts[0] + 0.2, 0)
    tools.append(rod(5.0, (0.8 * x, 0.8 * y, floor + 8), (1.1 * x, 1.1 * y, floor + 8)))
    bottom = -1e3 * (design.housing.neck_length + design.housing.length) + ADAPTER
    return Part(
        name="housing", group="housing", what=f"cup for {design.n_cable} motors", material=PLA,
        form=Cut(form=Union(forms=(cup, *posts)), tools=tuple(tools)), at=(0.0, 0.0, bottom), thinnest="a thicker rim",
    )  # fmt: skip


def _build_lid(design: TrunkDesign, room: Room, options: MakeOptions) -> Part:
    """Printed on its outer side; the servo's bracket stands up."""
    thick, servo = options.plate, options.servo
    disc = Revolved(profile=((0.0, 0.0), (room.radius, 0.0), (room.radius, thick), (0.0, thick)))
    forms: list[Form] = [disc]
    tools: list[Form] = [rod(M3 / 2, polar(room.post, -a, -1), polar(room.post, -a, thick + 1)) for a in room.posts]
    # Sunk, as the neck's foot may lie over them.
    tools += [shifted(_sink(), polar(room.post, -a, 0.0)) for a in room.posts]
    ring, foot = 1e3 * float(design.hole_position[0, 0, 1]), foot_circle(design)
    # Turned over, dorsal stays dorsal and the other side changes sides.
    tools += [rod(options.hole, polar(ring, -a, -1), polar(ring, -a, thick + 1)) for a in design.cable.angles]
    tools += [rod(M4 / 2, polar(foot, -a, -1), polar(foot, -a, thick + 1)) for a in foot_angles(design)]
    if design.gripper is not None:
        tools.append(rod(2.5, (0, 0, -1), (0, 0, thick + 1)))
        wide, deep = servo.lug_pitch + 8.0, 4.0
        # The shaft, not the body, stands on the axis; the arm turns in a plane along the trunk.
        aside, rise = servo.length / 2 - servo.shaft_offset, thick + 10.0
        forms.append(box((wide, deep, rise + servo.width), (aside, 8.0, (rise + servo.width) / 2 + thick / 2)))
        tools.append(box((servo.length + 0.4, 3 * deep, servo.width + 0.4), (aside, 8.0, rise + servo.width / 2)))
        for side in (-0.5, 0.5):
            x = aside + side * servo.lug_pitch
            z = rise + servo.width / 2
            tools.append(rod(0.9, (x, 0, z), (x, 16.0, z)))
        _check_servo(room, options)
    top = -1e3 * design.housing.neck_length
    return Part(
        name="lid", group="housing", what="lid with guide holes and the servo's bracket", material=PLA,
        form=Cut(form=Union(forms=tuple(forms)), tools=tuple(tools)), at=(0.0, 0.0, top), turn=math.pi,
        thinnest="a thicker plate",
    )  # fmt: skip


def _build_neck(design: TrunkDesign, room: Room, options: MakeOptions) -> Part:
    """A tube whose end is the counterpart of section 1's proximal face, printed on its foot."""
    solid = design.solid
    radius, tall, slope = 1e3 * solid.radius, 1e3 * design.housing.neck_length, math.tan(solid.lean_proximal)
    inner = radius - NECK_WALL
    if tall < NECK_WALL + FOOT:
        raise _refuse("housing.neck_length_mm", tall, NECK_WALL + FOOT, "the neck's foot and funnel")
    tube = Revolved(
        profile=(
            (0.0, tall), (radius, tall + radius * slope), (radius, FOOT), (radius + FOOT_WIDE, FOOT),
            (radius + FOOT_WIDE, 0.0),
            (inner, 0.0), (inner, tall - NECK_WALL + inner * slope), (0.0, tall - NECK_WALL),
        )
    )  # fmt: skip
    ring, high = 1e3 * float(design.hole_position[0, 0, 1]), tall + radius * slope + 1.0
    low = tall - NECK_WALL - 1.0
    tools: list[Form] = [rod(options.hole, polar(ring, a, low), polar(ring, a, high)) for a in design.cable.angles]
    tools += [
        rod(
            SCREW / 2, polar(find_screw_ring(design, options), a, low), polar(find_screw_ring(design, options), a, high)
        )
        for a in between_cables(design)
    ]
    tools += [
        rod(M4 / 2, polar(foot_circle(design), a, -1), polar(foot_circle(design), a, FOOT + 1))
        for a in foot_angles(design)
    ]
    if design.gripper is not None:
        tools.append(rod(2.5, (0, 0, low), (0, 0, high)))
    return Part(
        name="neck", group="housing", what="neck with the funnel of section 1", material=PLA,
        form=Cut(form=tube, tools=tuple(tools)), at=(0.0, 0.0, -tall), thinnest="a thicker neck",
    )  # fmt: skip


def foot_circle(design: TrunkDesign) -> float:
    """Radius of the circle of screws through the neck's foot [mm]."""
    return 1e3 * design.solid.radius + FOOT_WIDE / 2 + 0.5


def foot_angles(design: TrunkDesign) -> tuple[float, ...]:
    """Angles of the six screws through the neck's foot [rad]; the same pattern is on lid and wedge."""
    return tuple(math.pi / 6 + k * math.pi / 3 for k in range(6))


def _sink() -> Form:
    """Room for the head of a sunk M3 screw (ISO 10642), from below."""
    return Revolved(profile=((0.0, -0.5), (3.7, -0.5), (M3 / 2 - 0.1, 1.6), (0.0, 1.6)))


def _base_angles() -> tuple[float, ...]:
    return tuple(k * math.pi / 2 for k in range(4))


def _check_servo(room: Room, options: MakeOptions) -> None:
    """The servo stands in the middle, above the motors and between the drums."""
    free = room.ring - options.motor.rotor_circle / 2
    if free < 12.0:
        raise _refuse("room for the servo between the drums", free, 12.0, "a servo of the 9 g class")


def _refuse(name: str, got: float, least: float, why: str) -> DesignError:
    return DesignError(
        f"part housing: {name}", got=Words(f"{got:.1f} mm"), allowed=f"at least {least:.1f} mm, for {why}"
    )
