"""Bill of materials: what is printed and cast, what is bought, how long each cable is."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from spiraltrunk.cad.housing import ADAPTER, foot_angles
from spiraltrunk.cad.options import MakeOptions
from spiraltrunk.cad.part import Material
from spiraltrunk.cad.sections import between_cables, find_screw_ring
from spiraltrunk.cad.winder import find_drum, motor_ring
from spiraltrunk.cad.workshop import Made
from spiraltrunk.design.trunk import TrunkDesign

KNOT = 60.0
"""Cable for a knot or for tying an end [mm] (ours)."""

LINES = 2
"""Lines of every printed wall [-] (ours: what the walls are checked for)."""

TRAVEL = 1.3
"""Time of a print over that in which material flows [-] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class Row:
    """One line of the bill."""

    item: str
    """What."""
    count: int
    """How many."""
    material: str
    """Of what, or where it goes."""
    mass: float | None = None
    """Mass of one [g]; None where it is not known."""
    hours: float | None = None
    """Printing time of one [h]; None where nothing is printed."""
    note: str = ""
    """Anything else."""


def estimate_print(made: Made, options: MakeOptions) -> tuple[float, float]:
    """Mass [g] and printing time [h] of one: walls of `LINES` lines, and infill within them.

    A rule of thumb: mass = density (A w + f (V - A w)), time = material / flow x `TRAVEL`; what is cast is solid.
    """
    material: Material = made.part.material
    volume = made.finding.volume
    wall = min(volume, LINES * options.nozzle * made.finding.area)
    laid = wall + material.infill * (volume - wall) if material.flow else volume
    hours = TRAVEL * laid / material.flow / 3600.0 if material.flow else 0.0
    return 1e-3 * material.density * laid, hours


def cable_length(design: TrunkDesign, options: MakeOptions) -> float:
    """Length to cut for one of the trunk's cables [mm].

    From the knot at the tip through the straight trunk and the neck to the drum, what may be paid out, the turns that
    stay on the drum, and both ends.
    """
    drum = find_drum(design, options)
    inside = 1e3 * float(design.cable_in_section.sum() + design.straight_gap.sum())
    neck = 1e3 * design.housing.neck_length + 2 * options.plate
    way = math.dist((motor_ring(design, options), 0.0), (1e3 * float(design.hole_position[0, 0, 1]), 0.0)) + 40.0
    return inside + neck + way + 2 * math.pi * drum.radius * drum.turns + 2 * KNOT


def gripper_cable_length(design: TrunkDesign, options: MakeOptions) -> float:
    """Length to cut for one group of the gripper's cables [mm]: servo to fingertip and back slack, and both ends."""
    if design.gripper is None:
        return 0.0
    return 1e3 * (design.length + design.housing.neck_length + design.gripper.finger_length) + 80.0 + 2 * KNOT


def build_bill(design: TrunkDesign, made: Sequence[Made], options: MakeOptions) -> tuple[Row, ...]:
    """The whole bill: what was made first, then what is bought for it."""
    rows = []
    for one in made:
        mass, hours = estimate_print(one, options)
        rows.append(
            Row(
                item=one.part.name,
                count=one.part.count,
                material=one.part.material.name,
                mass=mass,
                hours=hours or None,
                note=one.part.what,
            )
        )
    return (*rows, *_buy(design, {one.part.group for one in made}, made, options))


def format_markdown(design: TrunkDesign, rows: Sequence[Row]) -> str:
    """The bill as a page."""
    lines = [
        f"# Bill of materials: {' '.join(design.name.split())}", "",
        "Masses and times are estimates: walls of two lines, infill as the material's, 30 % for moves.", "",
        "| item | count | material | g each | h each | note |", "|---|---|---|---|---|---|",
    ]  # fmt: skip
    for row in rows:
        mass = "" if row.mass is None else f"{row.mass:.1f}"
        hours = "" if row.hours is None else f"{row.hours:.1f}"
        lines.append(f"| {row.item} | {row.count} | {row.material} | {mass} | {hours} | {row.note} |")
    lines += ["", "## By material", "", "| material | g | h |", "|---|---|---|"]
    for name in dict.fromkeys(row.material for row in rows if row.mass is not None):
        own = [row for row in rows if row.material == name and row.mass is not None]
        total = sum(row.count * (row.mass or 0.0) for row in own)
        duration = sum(row.count * (row.hours or 0.0) for row in own)
        lines.append(f"| {name} | {total:.0f} | {duration:.0f} |")
    return "\n".join(lines) + "\n"


def format_csv(rows: Sequence[Row]) -> str:
    """The bill as a table for a spreadsheet."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(("item", "count", "material", "mass_each_g", "print_each_h", "note"))
    for row in rows:
        mass = "" if row.mass is None else f"{row.mass:.2f}"
        hours = "" if row.hours is None else f"{row.hours:.2f}"
        table.writerow((row.item, row.count, row.material, mass, hours, row.note))
    return text.getvalue()


def _buy(design: TrunkDesign, groups: set[str], made: Sequence[Made], options: MakeOptions) -> list[Row]:
    """What is bought for the groups that are made."""
    n, rows = design.n_cable, []
    if "trunk" in groups:
        pieces = sum(one.part.group == "trunk" for one in made)
        ring = find_screw_ring(design, options)
        solid = design.solid
        through = 1e3 * solid.length - ring * (math.tan(solid.lean_proximal) + math.tan(solid.lean_distal))
        screws = len(between_cables(design))
        long = 5 * math.ceil((through + 4.0 + 6.0) / 5)
        rows.append(Row(item=f"screw M4 x {long} with nut", count=screws, material="neck to section 1"))
        if pieces > 1:
            pins = (pieces - 1) * screws
            rows.append(Row(item="steel pin 3 x 16", count=pins, material="between pieces of the trunk"))
    if "drums" in groups:
        drum, length = find_drum(design, options), cable_length(design, options)
        note = (
            f"{length:.0f} mm each; {drum.turns:.1f} turns on the drum when wound in, {drum.travel_in:.0f} mm in and "
            f"{drum.travel_out:.0f} mm out from straight; a stopper knot at the tip, two half hitches at the drum"
        )
        rows.append(Row(item=f"UHMWPE cable {options.cable:g} mm", count=n, material="trunk", note=note))
        rows.append(Row(item="screw M3 x 8", count=4 * n, material="drum to rotor"))
    if "horn" in groups:
        way = gripper_cable_length(design, options)
        fingers = 0 if design.gripper is None else design.gripper.n_finger
        note = f"{way:.0f} mm each, braided of {fingers} strands, which part at the gripper; a knot at each fingertip"
        rows.append(Row(item=f"UHMWPE cable {options.cable:g} mm", count=2, material="gripper", note=note))
        rows.append(Row(item="servo DS-929MG", count=1, material="lid", note="with its round horn and screws"))
    if "housing" in groups:
        rows.append(Row(item="motor GM6020", count=n, material="housing", mass=None, note="hole circles unconfirmed"))
        rows.append(Row(item="screw M4 x 10", count=4 * n, material="housing's floor to motor"))
        rows.append(Row(item="screw M3 x 10, sunk, with insert", count=n, material="lid to housing"))
        rows.append(Row(item="screw M4 x 14 with nut", count=len(foot_angles(design)), material="neck's foot to lid"))
    if "adapter" in groups:
        rows.append(
            Row(item="screw M6 x 12", count=4, material="adapter to the arm's flange", note=f"{ADAPTER:g} mm plate")
        )
        rows.append(Row(item="dowel pin 6 x 10", count=1, material="adapter to the arm's flange"))
        rows.append(Row(item="screw M4 x 10, sunk, with insert", count=4, material="housing's floor to adapter"))
    if "shells" in groups:
        volume = sum(one.finding.volume for one in made if one.part.group == "shells")
        rows.append(
            Row(
                item="silicone Ecoflex 00-30",
                count=1,
                material="shells",
                note=f"{1.2e-3 * volume:.0f} ml with 20 % waste",
            )
        )
    if "markers" in groups:
        rows.append(Row(item="reflective marker with M3 stud", count=3 * design.n_section, material="marker seats"))
    return rows
