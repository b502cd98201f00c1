"""A page on how to build the robot, in the numbers of the design."""

from __future__ import annotations

import math
from collections.abc import Sequence

from spiraltrunk.cad.bill import cable_length, gripper_cable_length
from spiraltrunk.cad.options import MakeOptions
from spiraltrunk.cad.sections import PIN_DEPTH, between_cables, build_body
from spiraltrunk.cad.winder import DEAD_TURNS, find_arm, find_drum
from spiraltrunk.cad.workshop import Made
from spiraltrunk.design.trunk import TrunkDesign


def format_guide(design: TrunkDesign, made: Sequence[Made], options: MakeOptions) -> str:
    """The guide; steps for parts that were not asked for are there all the same."""
    steps = (_print_trunk, _cast_shells, _build_housing, _run_cables, _build_gripper, _fit)
    text = [f"# Building {' '.join(design.name.split())}", "", _summary(design), ""]
    number = 1
    for step in steps:
        lines = step(design, made, options)
        if lines:
            text += [f"{number}. " + "\n   ".join(lines)]
            number += 1
    return "\n".join(text) + "\n"


def _summary(design: TrunkDesign) -> str:
    return (
        f"{design.n_section} sections, {1e3 * design.length:.0f} mm long, {1e3 * design.base_width:.0f} mm wide at "
        f"the base, {design.n_cable} cables. Parts are listed in `bom.md`, drawn in `pictures/exploded.svg`."
    )


def _print_trunk(design: TrunkDesign, made: Sequence[Made], options: MakeOptions) -> list[str]:
    body = build_body(design, options)
    pieces = [one for one in made if one.part.group == "trunk"]
    hollow = sum(joint.bore > 0 for joint in body.joints)
    lines = [
        "**Trunk**, TPU 95A, standing, nozzle "
        f"{options.nozzle:g} mm, supports in the gaps, in {max(1, len(pieces))} piece(s). Print the elastic joints "
        f"solid; the last one, joint {design.n_joint}, is {2 * body.joints[-1].radius:.2f} mm thick: slowly there.",
    ]
    if len(pieces) > 1:
        lines.append(
            f"Join the pieces with {len(between_cables(design))} pins of 3 mm, {PIN_DEPTH:g} mm deep on either side, "
            "and glue; the cables' pull keeps them shut. Turn the first piece over for printing: its cut end is flat."
        )
    if design.gripper is not None and hollow < design.n_joint:
        lines.append(
            f"The gripper's cables run inside joints 1 to {hollow} and beside the thinner ones from joint {hollow + 1} "
            "on, one on each side."
        )
    return lines


def _cast_shells(design: TrunkDesign, made: Sequence[Made], options: MakeOptions) -> list[str]:
    body = build_body(design, options)
    count = sum(seat is not None for seat in body.seats)
    if not count:
        return []
    return [
        f"**Shells**, Ecoflex 00-30, {count} of them: put each mould's ring on its core's step, fill to the brim, let "
        f"it cure, peel. They are {100 * options.shell_grip:g} % narrower than their seats; stretch them over the rims."
    ]


def _build_housing(design: TrunkDesign, made: Sequence[Made], options: MakeOptions) -> list[str]:
    return [
        "**Housing**: adapter to the arm's flange (4 M6, spigot and dowel), cup onto the adapter (4 M4 from inside), "
        f"{design.n_cable} motors onto the floor, drums onto the rotors, lid last.",
        "The motors' hole circles are unconfirmed: measure yours, and set `Motor.floor_circle` and "
        "`Motor.rotor_circle` (spiraltrunk.cad.options).",
    ]


def _run_cables(design: TrunkDesign, made: Sequence[Made], options: MakeOptions) -> list[str]:
    drum = find_drum(design, options)
    turns = drum.travel_out / (2 * math.pi * drum.radius) + DEAD_TURNS
    gaps = ", ".join(f"{1e3 * gap:.1f}" for gap in design.straight_gap[[0, design.n_joint // 2, -1]])
    return [
        f"**Cables**: cut {design.n_cable} of {cable_length(design, options):.0f} mm. Thread from the tip, stopper "
        f"knot at the tip, through the neck and the lid to the drum ({2 * drum.radius:.1f} mm across). Straight, the "
        f"gaps are {gaps} mm at the first, middle and last joint.",
        f"Wind on until the trunk is straight and free of slack, with {turns:.1f} turns on the drum: it "
        f"then pulls {drum.travel_in:.0f} mm in and pays {drum.travel_out:.0f} mm out.",
    ]


def _build_gripper(design: TrunkDesign, made: Sequence[Made], options: MakeOptions) -> list[str]:
    if design.gripper is None:
        return []
    return [
        f"**Gripper**: two cables of {gripper_cable_length(design, options):.0f} mm, each parted into "
        f"{design.gripper.n_finger} strands: one through the inner, one through the outer holes of the fingers, "
        "knotted at the fingertips; push the tenon into the tip and turn it by a quarter. Tie the cables to the two "
        "ends of the double arm, "
        f"{find_arm(design, options):.1f} mm from the shaft, at the servo's middle.",
    ]


def _fit(design: TrunkDesign, made: Sequence[Made], options: MakeOptions) -> list[str]:
    return [
        "**Fit**: neck onto section 1 with the long M4 screws, neck's foot onto the lid (6 M4). For measuring, put the "
        "neck on none, one, two or three wedges: 0, 45, 90 or 135 deg. Then weigh the sections "
        "and enter what you find in `trunk.toml`.",
    ]
