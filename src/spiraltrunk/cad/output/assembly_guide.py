"""Assembly guide: a page with the dimensions of the design and a step for each group of parts that was made."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.housing.layout import find_layout
from spiraltrunk.cad.housing.winder import DEAD_TURNS, find_arm, find_drum, motor_angles
from spiraltrunk.cad.output.bill_of_materials import cable_length, escape, gripper_cable_length
from spiraltrunk.cad.output.make_part import MadePart
from spiraltrunk.cad.trunk.body import build_body
from spiraltrunk.cad.trunk.pieces import plan_planes
from spiraltrunk.cad.trunk.pins import find_pins
from spiraltrunk.design.trunk import TrunkDesign


def format_guide(design: TrunkDesign, made: Sequence[MadePart], options: MakeOptions) -> str:
    """The guide as a Markdown page."""
    groups = {one.part.group for one in made}
    text = [
        f"# Building {escape(design.name)}", "",
        f"{design.n_section} sections, {1e3 * design.length:.0f} mm long, {1e3 * design.base_width:.0f} mm wide at "
        f"the base, {design.n_cable} cables. What was made and what is to be bought is listed in `bom.md`, what it "
        "looks like is in `pictures`. Dorsal is where cable 1 runs.", "",
    ]  # fmt: skip
    lines = [step(design, options) if callable(step) else [step] for group, step in _STEPS.items() if group in groups]
    text += [f"{number}. " + "\n   ".join(step) for number, step in enumerate(lines, start=1)]
    text += ["", "Then weigh the sections, shells on, and put what you find into `mass.sections_g` of `trunk.toml`."]
    return "\n".join(text) + "\n"


def _print_trunk(design: TrunkDesign, options: MakeOptions) -> list[str]:
    body = build_body(design, options)
    planes = plan_planes(design, body, options)
    lines = [
        "**Trunk**, TPU 95A, standing as in its files, nozzle "
        f"{options.nozzle:g} mm, supports in the gaps and under the first face, in {len(planes) - 1} piece(s). Print "
        f"the elastic joints solid; the last one, joint {design.n_joint}, is {2 * body.joints[-1].radius:.2f} mm "
        "thick: slowly there.",
    ]
    if len(planes) > 2:
        pins = [
            f"{len(pin.angles)} of {pin.diameter:g} x {2 * pin.depth:g} mm at {pin.height:.0f} mm from the base"
            for pin in find_pins(design, body, planes, options)
        ]
        told = f"with pins ({', '.join(pins)}) and " if pins else "with "
        lines.append(
            f"Join the pieces {told}a glue for TPU (cyanoacrylate with primer); the cables' pull keeps them shut."
        )
    if design.gripper is not None and body.n_hollow < design.n_joint:
        lines.append(
            f"The gripper's cables run inside joints 1 to {body.n_hollow} and beside the thinner ones from joint "
            f"{body.n_hollow + 1} on, one on each side."
        )
    return lines


def _cast_shells(design: TrunkDesign, options: MakeOptions) -> list[str]:
    count = sum(seat is not None for seat in build_body(design, options).seats)
    return [
        f"**Shells**, Ecoflex 00-30, {count} of them: wax or spray the moulds, put each ring on its core's step, fill "
        "to the brim, let it cure by its maker's sheet, peel. They are "
        f"{100 * options.shell_grip:g} % narrower than their seats; stretch them over the rims."
    ]


def _mount_adapter(design: TrunkDesign, options: MakeOptions) -> list[str]:
    bases = len(find_layout(design, options).bases)
    return [
        f"**Adapter**: {bases} M4 inserts into its flat side first; then spigot and dowel into the arm's flange, four "
        "M6 x 12."
    ]


def _build_housing(design: TrunkDesign, options: MakeOptions) -> list[str]:
    bases = len(find_layout(design, options).bases)
    motors = ", ".join(
        f"the one at {math.degrees(angle):.0f} deg from dorsal winds cable {cable + 1}"
        for cable, angle in enumerate(motor_angles(design))
    )
    return [
        f"**Housing**: {design.n_cable} motors onto the floor, sunk screws from below; {motors}. Then the cup onto the "
        f"adapter: {bases} M4 x 12 between the motors, with a long key from above. Drums onto the rotors.",
        "Print the neck on its foot with supports inside. Neck onto section 1: screws from inside the neck, nuts in "
        "the pockets of section 1's far face, through the first gap. Then the servo into its bracket, and the neck's "
        "foot onto the lid with nuts below. The lid comes last, when the cables are on their drums.",
        "The motors' hole circles are unconfirmed: measure yours, and set `Motor.floor_circle` and "
        "`Motor.rotor_circle` (spiraltrunk.cad.components.options).",
    ]


def _run_cables(design: TrunkDesign, options: MakeOptions) -> list[str]:
    drum = find_drum(design, options)
    around = 2 * math.pi * drum.radius
    turns = drum.travel_out / around + DEAD_TURNS
    gaps = ", ".join(f"{1e3 * gap:.1f}" for gap in design.straight_gap[[0, design.n_joint // 2, -1]])
    return [
        f"**Cables**: cut {design.n_cable} of {cable_length(design, options):.0f} mm. Thread from the tip, stopper "
        "knot over a washer or bead at the tip, through neck, lid and the guide under the lid, over the guide's round "
        f"lip to the drum ({2 * drum.radius:.1f} mm across); wax the lip. Straight, the gaps are {gaps} mm at the "
        "first, middle and last joint.",
        f"Wind on until the trunk is straight and free of slack, with {turns:.1f} turns on the drum: it then pulls "
        f"{drum.travel_in:.0f} mm in, to {turns + drum.travel_in / around:.1f} turns, and pays "
        f"{drum.travel_out:.0f} mm out.",
    ]


def _tie_gripper(design: TrunkDesign, options: MakeOptions) -> list[str]:
    n_finger = 0 if design.gripper is None else design.gripper.n_finger
    return [
        f"**Gripper's cables**: two of {gripper_cable_length(design, options):.0f} mm, each parted into "
        f"{n_finger} strands: one through the inner, one through the outer holes of the fingers, "
        "knotted at the fingertips. Down the trunk's channel and through the neck; tie them to the two ends of the "
        f"double arm, {find_arm(design, options):.1f} mm from the shaft, at the servo's middle.",
    ]


_STEPS: dict[str, str | Callable[[TrunkDesign, MakeOptions], list[str]]] = {
    "trunk": _print_trunk,
    "shells": _cast_shells,
    "gripper": "**Gripper**, TPU 95A, standing on its tenon, supports under the plate. Push the tenon into the tip and "
    "turn it by a quarter; before that, the trunk's cables are knotted at the tip.",
    "adapter": _mount_adapter,
    "housing": _build_housing,
    "drums": _run_cables,
    "horn": _tie_gripper,
    "wedge": "**Wedges**, for measuring: none, one, two or three between flange (or bench) and adapter tilt the base "
    "by 0, 45, 90 or 135 deg. The first goes onto the flange with four M6 x 16; the next one, and the adapter, onto it "
    "with four M6 x 20 and nuts.",
    "markers": "**Markers**, for measuring: glue three seats onto each section's edge towards the base, the first "
    "dorsal, the others 120 deg from it, and turn a marker's M3 stud into each.",
}
"""Text of each group's step, or the function that writes its paragraphs."""
