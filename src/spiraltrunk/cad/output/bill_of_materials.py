"""Bill of materials: printed and cast parts, and what is bought for them."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.components.print_settings import find_flow, find_settings
from spiraltrunk.cad.output.filament import list_filament
from spiraltrunk.cad.output.make_part import MadePart
from spiraltrunk.cad.output.purchase import Purchase
from spiraltrunk.cad.output.purchases import list_purchases
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.field_docs import explain_fields

TRAVEL = 1.3
"""Time of a print over the time of extrusion [-] (ours)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class MadeRow:
    """A printed or cast part in the bill."""

    item: str
    """Name of the part and of its files."""
    count: int
    """Number of pieces."""
    material: str
    """Material."""
    mass: float
    """Estimated mass of one piece [g]."""
    hours: float | None
    """Estimated printing time of one piece [h]; None where it is cast."""
    note: str
    """What it is."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Bill:
    """What a robot is made of."""

    made: tuple[MadeRow, ...]
    """Printed and cast parts."""
    bought: tuple[Purchase, ...]
    """Purchased items, one row for each place that they go to."""


def estimate_print(made: MadePart, options: MakeOptions) -> tuple[float, float]:
    """Estimate mass [g] and printing time [h] of one piece from its `PrintSettings`.

    mass = density (A w + f (V - A w)) and time = `TRAVEL` (A w + f (V - A w)) / flow, with area A, volume V, thickness
    w of the lines in a wall and infill f (ours). Cast parts are solid.
    """
    part, volume = made.part, made.finding.volume
    if part.material.is_cast:
        return 1e-6 * part.material.density * volume, 0.0
    settings = find_settings(part.name)
    wall = min(volume, settings.lines * options.nozzle * made.finding.area)
    laid = wall + settings.infill * (volume - wall)
    return 1e-6 * part.material.density * laid, TRAVEL * laid / find_flow(part.material) / 3600.0


def build_bill(design: TrunkDesign, made: Sequence[MadePart], options: MakeOptions) -> Bill:
    """Build the bill of the made parts, with what is bought for their groups."""
    rows = []
    for one in made:
        mass, hours = estimate_print(one, options)
        rows.append(
            MadeRow(item=one.part.name, count=one.part.count, material=one.part.material.name, mass=mass,
                    hours=hours or None, note=one.part.what)
        )  # fmt: skip
    names = {one.part.name for one in made}
    silicone = sum(one.finding.volume for one in made if one.part.group == "shells")
    bought = list_purchases(design, {one.part.group for one in made}, names, silicone, options)
    return Bill(made=tuple(rows), bought=(*list_filament(sum_masses(made, options)), *bought))


def sum_masses(made: Sequence[MadePart], options: MakeOptions) -> dict[str, float]:
    """Estimated mass of all pieces of each printed material [g]."""
    masses: dict[str, float] = {}
    for one in made:
        if not one.part.material.is_cast:
            mass = one.part.count * estimate_print(one, options)[0]
            masses[one.part.material.name] = masses.get(one.part.material.name, 0.0) + mass
    return masses


def format_markdown(design: TrunkDesign, bill: Bill) -> str:
    """The bill as a Markdown page."""
    lines = [
        f"# Bill of materials: {escape(design.name)}", "",
        "Nothing was built from this list yet. Where each item goes is in `guide.md`.", "",
        "## To make", "",
        "Masses and times are estimates from the settings in `guide.md`, with 30 % of the time for moves. Supports and "
        "what a failed print takes are not counted.", "",
        "| quantity | part | material | g each | h each | what it is |", "|---|---|---|---|---|---|",
    ]  # fmt: skip
    for row in bill.made:
        hours = "" if row.hours is None else f"{max(row.hours, 0.1):.1f}"
        lines.append(f"| {row.count} | {row.item} | {row.material} | {row.mass:.1f} | {hours} | {row.note} |")
    lines += ["", "| material | g | h |", "|---|---|---|"]
    for name in dict.fromkeys(row.material for row in bill.made):
        own = [row for row in bill.made if row.material == name]
        total = sum(row.count * row.mass for row in own)
        duration = sum(row.count * (row.hours or 0.0) for row in own)
        lines.append(f"| {name} | {total:.0f} | {f'{duration:.0f}' if duration else ''} |")
    for kind in dict.fromkeys(row.kind for row in bill.bought):
        lines += [
            "", f"## To buy: {kind}", "",
            "| quantity | item | size | material | where it goes | note |", "|---|---|---|---|---|---|",
        ]  # fmt: skip
        lines += [
            f"| {row.count} | {row.item} | {row.size} | {row.material} | {row.place} | {row.note} |"
            for row in bill.bought
            if row.kind == kind
        ]
    return "\n".join(lines) + "\n"


def escape(text: str) -> str:
    """A text on one line with Markdown's special characters escaped."""
    return re.sub(r"([\\`*_{}\[\]<>()#+!|])", r"\\\1", " ".join(text.split()))


def format_csv(bill: Bill) -> str:
    """The bill as CSV."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(("kind", "item", "count", "size", "material", "place", "mass_each_g", "print_each_h", "note"))
    for one in bill.made:
        hours = "" if one.hours is None else f"{one.hours:.2f}"
        table.writerow(("made", one.item, one.count, "", one.material, "", f"{one.mass:.2f}", hours, one.note))
    for row in bill.bought:
        table.writerow((row.kind, row.item, row.count, row.size, row.material, row.place, "", "", row.note))
    return text.getvalue()
