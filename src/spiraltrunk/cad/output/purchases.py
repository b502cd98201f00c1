"""What is bought for the groups of parts: fasteners, cables, motors, electronics, casting and glue."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

from spiraltrunk.cad.checks.assembly import list_bolts
from spiraltrunk.cad.components.fasteners import M3_INSERT, M3_INSERT_DEEP, M4_INSERT, M4_INSERT_DEEP, Bolt
from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.housing.test_stand import N_WEDGE, PER_SECTION, list_wedge_bolts
from spiraltrunk.cad.housing.winder import find_arm
from spiraltrunk.cad.output.cable_lengths import cable_length, strand_length, trial_length
from spiraltrunk.cad.output.electronics import list_electronics, list_servo_electronics
from spiraltrunk.cad.output.purchase import Purchase
from spiraltrunk.cad.trunk.body import build_body
from spiraltrunk.cad.trunk.pieces import plan_planes
from spiraltrunk.cad.trunk.pins import find_pins
from spiraltrunk.design.materials import SILICONE
from spiraltrunk.design.trunk import TrunkDesign

INSERTS = {
    "housing to adapter": ("inserts of the adapter", M4_INSERT, M4_INSERT_DEEP),
    "lid to housing": ("inserts of the housing", M3_INSERT, M3_INSERT_DEEP),
}
"""Joints with heat-set inserts: where these go, diameter and depth of the hole [mm]."""

WASTE = 0.2
"""Silicone that stays in cups and on spatulas, over what is cast [-] (ours)."""

FASTENERS, CABLES, MOTORS, ELECTRONICS, SUPPLIES = "fasteners", "cables", "motors", "electronics", "supplies"
"""Headings of the bill."""


def list_purchases(
    design: TrunkDesign, groups: set[str], names: Collection[str], silicone: float, options: MakeOptions
) -> tuple[Purchase, ...]:
    """Purchased items for the groups that are made.

    Args:
        design: the robot.
        groups: groups that are made.
        names: names of the parts that are made.
        silicone: volume of all shells [mm^3].
        options: how the parts are made.
    """
    rows = [*_list_fasteners(design, groups, names, options), *_list_cables(design, groups, options)]
    if "housing" in groups:
        note = "hole circles unconfirmed: measure first (guide, step 1)"
        rows.append(
            Purchase(kind=MOTORS, item="motor RoboMaster GM6020", count=design.n_cable, place="motors", note=note)
        )
    if design.gripper is not None and {"horn", "housing"} & groups:
        note = "with its round horn and its screws; dimensions unconfirmed: measure first (guide, step 1)"
        if design.gripper.n_leg > 1:
            torque = design.gripper.tension_max * find_arm(design, options) / 1e3
            note += f"; one of {torque:.2f} N m or more closes with the full {design.gripper.tension_max:g} N"
        rows.append(Purchase(kind=MOTORS, item="servo DS-929MG", count=1, place="servo", note=note))
        rows += list_servo_electronics()
    if "housing" in groups:
        rows += list_electronics(design, options)
    rows += _list_supplies(design, groups, silicone, options)
    order = (FASTENERS, CABLES, MOTORS, ELECTRONICS, SUPPLIES)
    return tuple(sorted(rows, key=lambda row: order.index(row.kind)))


def _list_fasteners(
    design: TrunkDesign, groups: set[str], names: Collection[str], options: MakeOptions
) -> list[Purchase]:
    bolts = list_bolts(design, options, names)
    if "wedge" in groups:  # The first wedge is on the flange, the adapter on the last.
        below = list_wedge_bolts(options)
        onto = [bolt for bolt in below if bolt.nut_at is not None]
        bolts = [*bolts, *(bolt for bolt in below if bolt.nut_at is None), *(N_WEDGE * onto)]
    rows = group_bolts(bolts)
    if "drums" in groups:
        rows.append(_screw(4 * design.n_cable, "socket head screw ISO 4762", "M3 x 8", "drum to rotor"))
    if "adapter" in groups:
        rows.append(
            Purchase(kind=FASTENERS, item="dowel pin ISO 8734", count=1, size="6 x 10", material="steel",
                     place="adapter to the arm's flange")
        )  # fmt: skip
    if "trunk" in groups:
        body = build_body(design, options)
        planes = plan_planes(design, body, options)
        rows += [
            Purchase(kind=FASTENERS, item="dowel pin ISO 8734", count=len(pin.angles),
                     size=f"{pin.diameter:g} x {2 * pin.depth:g}", material="steel", place="pieces of the trunk",
                     note=f"across the cut at {pin.height:.0f} mm from the base joint")
            for pin in find_pins(design, body, planes, options)
        ]  # fmt: skip
    return rows


def group_bolts(bolts: Sequence[Bolt]) -> list[Purchase]:
    """Rows for the screws of each purpose, and for their nuts or inserts."""
    rows = []
    for what in dict.fromkeys(bolt.what for bolt in bolts):
        own = [bolt for bolt in bolts if bolt.what == what]
        one, count = own[0], len(own)
        head = "countersunk screw ISO 10642" if one.is_sunk else "socket head screw ISO 4762"
        rows.append(_screw(count, head, f"{one.thread.name} x {one.length:g}", what))
        if one.nut_at is not None:
            rows.append(_screw(count, "nut ISO 4032", one.thread.name, what))
        elif what in INSERTS:
            place, hole, deep = INSERTS[what]
            note = f"for a hole of {hole:g} mm; at most {deep - 0.4:.1f} mm long"
            rows.append(
                Purchase(kind=FASTENERS, item="heat-set insert", count=count, size=one.thread.name, material="brass",
                         place=place, note=note)
            )  # fmt: skip
    return rows


def _screw(count: int, item: str, size: str, place: str) -> Purchase:
    return Purchase(kind=FASTENERS, item=item, count=count, size=size, material="steel 8.8", place=place)


def _list_cables(design: TrunkDesign, groups: set[str], options: MakeOptions) -> list[Purchase]:
    rows, braid, has_drums = [], "UHMWPE, braided", bool({"drums", "housing"} & groups)
    if "drums" in groups:
        rows.append(
            Purchase(kind=CABLES, item="cable", count=design.n_cable, material=braid, place="trunk",
                     size=f"{options.cable:g} mm, {cable_length(design, options):.0f} mm long",
                     note="breaking load 400 N or more")
        )  # fmt: skip
        wide, high = (5 * options.cable, 4 * options.cable)
        room = f"; at most {wide - 0.3:.1f} mm across and 1 mm long" if design.gripper is not None else ""
        rows.append(
            Purchase(kind=CABLES, item="crimp bead", count=design.n_cable, size=f"hole {options.hole:g} mm",
                     material="brass", place="knots at the tip", note=f"under each knot, and a few more to try{room}"
                     + (f": the groove is {high:g} mm deep" if room else ""))
        )  # fmt: skip
    if {"drums", "trunk", "gripper"} & groups:
        rows.append(
            Purchase(kind=CABLES, item="cable for trials", count=1, material=braid, place="trials",
                     size=f"{options.cable:g} mm, {trial_length(design, options, has_drums=has_drums):.0f} mm long",
                     note="tries holes and knots, and compares currents with tensions")
        )  # fmt: skip
    if design.gripper is not None and {"horn", "gripper"} & groups:
        fingers, legs = design.gripper.n_finger, design.gripper.n_leg
        note = f"two groups of {fingers}, one to close and one to open; a little thinner will do"
        if legs > 1:
            note += f"; of each group {fingers} for either side of the trunk's axis"
        rows.append(
            Purchase(kind=CABLES, item="strand", count=2 * fingers * legs, material=braid, place="gripper", note=note,
                     size=f"{options.cable / math.sqrt(fingers * legs):.2f} mm, {strand_length(design):.0f} mm long")
        )  # fmt: skip
    return rows


def _list_supplies(design: TrunkDesign, groups: set[str], silicone: float, options: MakeOptions) -> list[Purchase]:
    def row(item: str, size: str, place: str, note: str, count: int = 1) -> Purchase:
        return Purchase(kind=SUPPLIES, item=item, count=count, size=size, place=place, note=note)

    rows: list[Purchase] = []
    if "trunk" in groups and len(plan_planes(design, build_body(design, options), options)) > 2:
        rows.append(row("cyanoacrylate glue with polyolefin primer", "20 g", "pieces of the trunk",
                        "sticks to TPU; one bottle for needles, laps and marker seats too"))  # fmt: skip
    if "shells" in groups:
        total = 1e-3 * (1 + WASTE) * silicone
        grams = 1e-3 * SILICONE.density * total
        note = f"{100 * WASTE:.0f} % waste included; half of it part A, half part B"
        rows.append(row(f"silicone {SILICONE.name}", f"{total:.0f} ml ({grams:.0f} g)", "shells", note))
    if {"shells", "moulds"} & groups:
        rows.append(row("mould release for platinum silicone", "spray", "shells", "e.g. the silicone maker's own"))
        rows.append(row("modelling clay without sulphur", "50 g", "shells", "seals the moulds' rings"))
    if "drums" in groups:
        rows.append(row("wax or PTFE grease", "5 g", "cable guides", "on the guides' lips"))
    if "markers" in groups:
        count = PER_SECTION * design.n_section
        rows.append(row("reflective marker", "M3 stud", "marker seats", "sphere; size by your cameras", count))
        if not any("cyanoacrylate" in own.item for own in rows):  # Else that of the trunk's seam does.
            rows.append(row("cyanoacrylate glue with polyolefin primer", "5 g", "marker seats", "sticks to TPU"))
    return rows
