"""Bill of materials: printed and cast parts, purchased parts, lengths of the cables."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

from spiraltrunk.cad.checks.assembly import list_bolts
from spiraltrunk.cad.components.fasteners import Bolt
from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.geometry.csg import polar
from spiraltrunk.cad.geometry.part import Material
from spiraltrunk.cad.housing.layout import find_layout
from spiraltrunk.cad.housing.test_stand import list_wedge_bolts
from spiraltrunk.cad.housing.winder import find_drum, motor_angles, motor_ring
from spiraltrunk.cad.output.make_part import MadePart
from spiraltrunk.cad.trunk.body import build_body
from spiraltrunk.cad.trunk.pieces import plan_planes
from spiraltrunk.cad.trunk.pins import find_pins
from spiraltrunk.design.trunk import TrunkDesign

KNOT = 60.0
"""Cable for a knot or for tying an end [mm] (ours)."""

_INSERTS = ("housing to adapter", "lid to housing")
"""Joints with heat-set inserts."""

LINES = 2
"""Lines of every printed wall [-] (ours: the thickness that is checked)."""

TRAVEL = 1.3
"""Time of a print over the time of extrusion [-] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class Row:
    """One line of the bill."""

    item: str
    """Name of the item."""
    count: int
    """Number of pieces."""
    material: str
    """Material of a made part, or place of a purchased one."""
    mass: float | None = None
    """Mass of one piece [g]; None where unknown."""
    hours: float | None = None
    """Printing time of one piece [h]; None where it is not printed."""
    note: str = ""
    """Remark."""


def estimate_print(made: MadePart, options: MakeOptions) -> tuple[float, float]:
    """Estimate mass [g] and printing time [h] of one piece: walls of `LINES` lines with infill inside.

    mass = density (A w + f (V - A w)) and time = `TRAVEL` (A w + f (V - A w)) / flow, with area A, volume V, wall w and
    infill f (ours). Cast parts are solid.
    """
    material: Material = made.part.material
    volume = made.finding.volume
    wall = min(volume, LINES * options.nozzle * made.finding.area)
    laid = wall + material.infill * (volume - wall) if material.flow else volume
    hours = TRAVEL * laid / material.flow / 3600.0 if material.flow else 0.0
    return 1e-3 * material.density * laid, hours


def cable_length(design: TrunkDesign, options: MakeOptions) -> float:
    """Length to cut for one of the trunk's cables [mm].

    It runs from the knot at the tip through the straight trunk, the neck and its guide to the drum, with all turns on
    the drum and both ends.
    """
    drum, layout = find_drum(design, options), find_layout(design, options)
    inside = 1e3 * float(design.cable_in_section.sum() + design.straight_gap.sum())
    neck = 1e3 * design.housing.neck_length + options.plate + layout.height - layout.groove
    hole, axis = polar(1e3 * float(design.hole_position[0, 0, 1]), design.cable.angles[0], 0.0), motor_angles(design)[0]
    apart = math.dist(hole, polar(motor_ring(design, options), axis, 0.0))
    way = math.sqrt(max(apart**2 - drum.radius**2, 0.0))
    return inside + neck + way + 2 * math.pi * drum.radius * drum.turns + 2 * KNOT


def gripper_cable_length(design: TrunkDesign, options: MakeOptions) -> float:
    """Length to cut for one group of the gripper's cables [mm]: from servo to fingertips, with slack and both ends."""
    if design.gripper is None:
        return 0.0
    return 1e3 * (design.length + design.housing.neck_length + design.gripper.finger_length) + 80.0 + 2 * KNOT


def build_bill(design: TrunkDesign, made: Sequence[MadePart], options: MakeOptions) -> tuple[Row, ...]:
    """Build the bill: made parts first, then the purchased parts for them."""
    rows = []
    for one in made:
        part, (mass, hours) = one.part, estimate_print(one, options)
        rows.append(
            Row(item=part.name, count=part.count, material=part.material.name, mass=mass, hours=hours or None,
                note=part.what)
        )  # fmt: skip
    return (*rows, *_list_purchases(design, {one.part.group for one in made}, made, options))


def format_markdown(design: TrunkDesign, rows: Sequence[Row]) -> str:
    """The bill as a Markdown page."""
    lines = [
        f"# Bill of materials: {escape(design.name)}", "",
        "Masses and times are estimates: walls of two lines, infill as the material's, 30 % for moves.", "",
        "| item | count | material | g each | h each | note |", "|---|---|---|---|---|---|",
    ]  # fmt: skip
    lines += [f"| {' | '.join(_cells(row, 1))} |" for row in rows]
    lines += ["", "## By material", "", "| material | g | h |", "|---|---|---|"]
    for name in dict.fromkeys(row.material for row in rows if row.mass is not None):
        own = [row for row in rows if row.material == name]
        total = sum(row.count * (row.mass or 0.0) for row in own)
        duration = sum(row.count * (row.hours or 0.0) for row in own)
        lines.append(f"| {name} | {total:.0f} | {duration:.0f} |")
    return "\n".join(lines) + "\n"


def escape(text: str) -> str:
    """A text on one line with Markdown's special characters escaped."""
    return re.sub(r"([\\`*_{}\[\]<>()#+!|])", r"\\\1", " ".join(text.split()))


def format_csv(rows: Sequence[Row]) -> str:
    """The bill as CSV."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(("item", "count", "material", "mass_each_g", "print_each_h", "note"))
    table.writerows(_cells(row, 2) for row in rows)
    return text.getvalue()


def _cells(row: Row, digits: int) -> tuple[str, ...]:
    """Texts of a row, with so many decimals; empty where a value is unknown."""
    mass, hours = ("" if value is None else f"{value:.{digits}f}" for value in (row.mass, row.hours))
    return row.item, str(row.count), row.material, mass, hours, row.note


def _list_purchases(design: TrunkDesign, groups: set[str], made: Sequence[MadePart], options: MakeOptions) -> list[Row]:
    """Purchased parts for the groups that are made."""
    n, rows = design.n_cable, []
    if "trunk" in groups:
        body = build_body(design, options)
        planes = plan_planes(design, body, options)
        if len(planes) > 2:
            rows.append(Row(item="glue for TPU, with primer", count=1, material="between pieces of the trunk"))
        rows += [
            Row(item=f"steel pin {pin.diameter:g} x {2 * pin.depth:g}", count=len(pin.angles),
                material="between pieces of the trunk", note=f"across the cut at {pin.height:.0f} mm from the base")
            for pin in find_pins(design, body, planes, options)
        ]  # fmt: skip
    if "drums" in groups:
        drum, length = find_drum(design, options), cable_length(design, options)
        note = (
            f"{length:.0f} mm each; the drum takes {drum.turns:.1f} turns: {drum.travel_in:.0f} mm in and "
            f"{drum.travel_out:.0f} mm out from straight; a stopper knot at the tip, two half hitches at the drum"
        )
        rows += [
            Row(item=f"UHMWPE cable {options.cable:g} mm", count=n, material="trunk", note=note),
            Row(item="washer or bead, 1 mm hole", count=n, material="under the knots at the tip"),
            Row(item="screw M3 x 8", count=4 * n, material="drum to rotor"),
        ]
    if design.gripper is not None and {"horn", "gripper"} & groups:
        fingers = design.gripper.n_finger
        note = (
            f"{gripper_cable_length(design, options):.0f} mm each, braided of {fingers} strands of "
            f"{options.cable / math.sqrt(fingers):.2f} mm, which part at the gripper; a knot at each fingertip"
        )
        rows.append(Row(item=f"UHMWPE cable {options.cable:g} mm", count=2, material="gripper", note=note))
    if design.gripper is not None and {"horn", "housing"} & groups:
        rows.append(Row(item="servo DS-929MG", count=1, material="lid", note="with its round horn and screws"))
    if "housing" in groups:
        rows.append(Row(item="motor GM6020", count=n, material="housing", note="hole circles unconfirmed"))
    if "adapter" in groups:
        rows.append(Row(item="dowel pin 6 x 10", count=1, material="adapter to the arm's flange"))
    if "shells" in groups:
        volume = sum(one.finding.volume for one in made if one.part.group == "shells")
        note = f"{1.2e-3 * volume:.0f} ml with 20 % waste"
        rows.append(Row(item="silicone Ecoflex 00-30", count=1, material="shells", note=note))
    if "markers" in groups:
        rows.append(Row(item="reflective marker with M3 stud", count=3 * design.n_section, material="marker seats"))
    rows += _group_bolts(list_bolts(design, options, {one.part.name for one in made}))
    if "wedge" in groups:
        below, above = _group_bolts(list_wedge_bolts(options))
        rows += [below, replace(above, count=3 * above.count)]
    return rows


def _group_bolts(bolts: Sequence[Bolt]) -> list[Row]:
    """One row for the screws of each purpose."""
    rows = []
    for what in dict.fromkeys(bolt.what for bolt in bolts):
        own = [bolt for bolt in bolts if bolt.what == what]
        one = own[0]
        held = " with nut" if one.nut_at is not None else " with insert" if what in _INSERTS else ""
        head = ", sunk" if one.is_sunk else ""
        rows.append(Row(item=f"screw {one.thread.name} x {one.length:g}{head}{held}", count=len(own), material=what))
    return rows
