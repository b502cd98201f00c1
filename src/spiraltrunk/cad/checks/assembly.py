"""Assembly check by definitions: no screw or nut intersects a part, a motor, a drum or another screw.

There is material under each head and nut, and a straight path for the key.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np

from spiraltrunk.cad.components.fasteners import Bolt
from spiraltrunk.cad.components.options import ADAPTER, MakeOptions
from spiraltrunk.cad.geometry.csg import Form, compute_bounds, contains, polar, rod, shifted, tube
from spiraltrunk.cad.geometry.part import Part
from spiraltrunk.cad.housing.housing import list_housing_bolts
from spiraltrunk.cad.housing.test_stand import list_wedge_bolts
from spiraltrunk.cad.housing.winder import find_drum, motor_angles, motor_ring
from spiraltrunk.cad.trunk.neck_screws import list_neck_bolts
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import PartError

SKIN = 0.05
"""Distance of test points inside a body's surface [mm]."""

_TURNS = 12
"""Number of test points round a body."""

_HOUSED = ("adapter", "housing", "lid", "neck", "trunk_1")


def check_hardware(design: TrunkDesign, options: MakeOptions, parts: Sequence[Part]) -> int:
    """Check screws, nuts, motors and drums against the selected parts.

    Returns:
        The number of screws checked.

    Raises:
        PartError: names the first screw and the part that it does not fit.
    """
    made = {part.name: part for part in parts}
    housed = {name: part for name, part in made.items() if name in _HOUSED}
    bolts = [bolt for bolt in list_bolts(design, options, housed) if set(bolt.parts) <= set(housed)]
    faults = find_faults(bolts, list(housed.values()), build_motors(design, options) if "housing" in made else [])
    if "wedge" in made:
        wedge = list_wedge_bolts(options)
        faults += find_faults(wedge, [made["wedge"]], [])
        bolts += wedge
    if faults:
        more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
        raise PartError(f"{faults[0]}{more}; allowed: none: a larger housing, neck or base")
    return len(bolts)


def list_bolts(design: TrunkDesign, options: MakeOptions, names: Collection[str]) -> list[Bolt]:
    """Screws of the parts of these names, from the flange to section 1."""
    bolts = list_neck_bolts(design) if {"trunk_1", "neck"} & set(names) else []
    if {"adapter", "housing", "lid", "neck"} & set(names):
        bolts = [*list_housing_bolts(design, options), *bolts]
    return [bolt for bolt in bolts if set(bolt.parts) & set(names)]


def find_faults(bolts: Sequence[Bolt], parts: Sequence[Part], bodies: Sequence[tuple[str, Form]]) -> list[str]:
    """Messages of screws that do not fit the parts, or ``bodies``: names and volumes of other components."""
    faults = []
    for i, bolt in enumerate(bolts):
        points = np.concatenate([_fill(form) for form in bolt.forms()])
        name = f"{bolt.what}: screw {bolt.thread.name} x {bolt.length:g} at {_format_place(bolt.seat)}"
        for part in parts:
            inside = contains(part.form, part.to_own_frame(points))
            if inside.any():
                at = points[np.flatnonzero(inside)[0]]
                faults.append(f"{name} is in the material of part {part.name} at {_format_place(at)}")
        for what, body in bodies:
            # A motor's own screws end in it.
            if what != bolt.what.partition(" ")[0] and contains(body, points).any():
                faults.append(f"{name} is in the place of a {what}")
        for other in bolts[:i]:
            if any(contains(form, points).any() for form in other.forms()):
                faults.append(f"{name} is in the place of {other.what} at {_format_place(other.seat)}")
        faults += [f"{name} {fault}" for fault in (*_check_seats(bolt, parts), *_check_key(bolt, parts, bodies))]
    return faults


def _check_seats(bolt: Bolt, parts: Sequence[Part]) -> list[str]:
    """Faults of the material under head and nut; a countersunk head needs none."""
    seat, along, thread = np.array(bolt.seat), np.array(bolt.along), bolt.thread
    rings = []
    if not (bolt.is_sunk or bolt.is_head_elsewhere):
        rings.append(("head", seat + 0.2 * along, thread.head / 2))
    if bolt.nut_at is not None:
        rings.append(("nut", seat + (bolt.nut_at - 0.2) * along, thread.flats / 2))
    faults = []
    for what, middle, outer in rings:
        disc = _fill(rod(outer - 0.3 + SKIN, middle, middle + along))
        around = disc[_TURNS : 2 * _TURNS]  # The outer points of the first layer.
        held = np.zeros(len(around), dtype=bool)
        for part in parts:
            held |= contains(part.form, part.to_own_frame(around))
        if not held.all():
            faults.append(f"has no material under {np.count_nonzero(~held)} of {len(held)} points of its {what}")
    return faults


def _check_key(bolt: Bolt, parts: Sequence[Part], bodies: Sequence[tuple[str, Form]]) -> list[str]:
    """Faults of the key's path: parts that the screw joins, and motors, are there when it is turned."""
    way = bolt.key()
    if way is None:
        return []
    points = _fill(way)
    joined = [part for part in parts if part.name in bolt.parts]
    blocked = [part.name for part in joined if contains(part.form, part.to_own_frame(points)).any()]
    if bolt.what.startswith("housing"):
        blocked += [what for what, body in bodies if what == "motor" and contains(body, points).any()]
    return [f"cannot be reached by a key for {name}" for name in dict.fromkeys(blocked)]


def build_motors(design: TrunkDesign, options: MakeOptions) -> list[tuple[str, Form]]:
    """Names and volumes of motors and drums."""
    drum, motor = find_drum(design, options), options.motor
    floor = -1e3 * (design.housing.neck_length + design.housing.length) + ADAPTER + options.plate
    bodies: list[tuple[str, Form]] = []
    for axis in motor_angles(design):
        at = polar(motor_ring(design, options), axis, floor)
        top = motor.height
        bodies.append(("motor", shifted(rod(motor.diameter / 2, (0, 0, 0), (0, 0, top)), at)))
        bodies.append(("drum", shifted(tube(0.0, drum.flange, top, top + drum.height), at)))
    return bodies


def _fill(form: Form) -> np.ndarray:
    """Test points in a cylinder of `csg.rod`, near its surface and inside, shape (n, 3) [mm]."""
    _, high = compute_bounds(form.form)  # type: ignore[union-attr]
    radius, length = float(high[0]) - SKIN, float(high[2])
    heights = np.linspace(SKIN, length - SKIN, max(3, int(length)))
    turns = 2 * math.pi * np.arange(_TURNS) / _TURNS
    local = np.array([polar(r, turn, z) for z in heights for r in (0.5 * radius, radius) for turn in turns])
    T = np.array(form.T)  # type: ignore[union-attr]
    return np.asarray(local @ T[:3, :3].T + T[:3, 3])


def _format_place(place: Sequence[float] | np.ndarray) -> str:
    x, y, z = (float(value) for value in place)
    return f"({x:.1f}, {y:.1f}, {z:.1f}) mm"
