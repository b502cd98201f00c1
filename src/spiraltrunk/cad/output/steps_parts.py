"""Steps of the guide that make the parts: measuring, printing, joining, casting, weighing."""

from __future__ import annotations

import math

from spiraltrunk.cad.housing.layout import find_layout
from spiraltrunk.cad.output.step import Build, Step, join
from spiraltrunk.cad.trunk.gripper import STRAND, build_finger, find_seat
from spiraltrunk.design.materials import SILICONE

PRINTED = {
    "trunk": ("printed trunk",),
    "gripper": ("printed gripper",),
    "moulds": ("printed moulds",),
    "housing": ("printed housing", "printed lid", "printed neck"),
    "drums": ("printed drums",),
    "horn": ("printed double arm",),
    "adapter": ("printed adapter",),
    "wedge": ("printed wedges",),
    "markers": ("printed marker seats",),
}
"""What the printing step makes of each group."""


def list_part_steps(build: Build) -> list[Step]:
    """The steps from the bought motors to a weighed trunk."""
    steps = [_measure(build), _print(build), _clear(build)]
    if build.n_piece > 1:
        steps.append(_join(build))
    if build.n_shell:
        steps += [_cast(build), _dress(build)]
    return [*steps, _weigh(build)]


def _measure(build: Build) -> Step:
    motor, servo, layout = build.options.motor, build.options.servo, find_layout(build.design, build.options)
    floor, wall = build.options.plate, build.drum.wall
    work = [
        f"Motor: pitch circle of the four M4 threads in its underside ({motor.floor_circle:g} mm assumed), pitch "
        f"circle of the four M3 threads in its rotor ({motor.rotor_circle:g} mm), diameter ({motor.diameter:g} mm), "
        f"height ({motor.height:g} mm).",
        f"Depth of these threads: the M4 screws enter by {10 - floor:g} mm and the M3 screws by {8 - wall:g} mm. A "
        "screw that is longer than its thread is deep can touch the winding: take a shorter one.",
    ]
    if build.has_gripper:
        work.append(
            f"Servo: body {servo.length:g} x {servo.width:g} mm, lug holes {servo.lug_pitch:g} mm apart, shaft "
            f"{servo.shaft_offset:g} mm from the near end, hub of the round horn {servo.hub_diameter:g} mm across."
        )
    work.append(
        f"Motors {motor.diameter:g} mm wide stand {2 * layout.ring * math.sin(math.pi / build.design.n_cable):.1f} mm "
        'apart. If a number differs by more than 0.2 mm, export again with yours (see "Other dimensions" below).'
    )
    return Step(
        title="Measure what was bought", groups=frozenset({"housing", "drums", "horn"}),
        makes=("measured motors",), takes=("motors", "servo"), tools=("calliper",), work=tuple(work),
        check="every number agrees with the export that you print from.",
    )  # fmt: skip


def _print(build: Build) -> Step:
    makes = tuple(name for group, names in PRINTED.items() if group in build.groups for name in names)
    work = [
        'Set each part up as the table "Print settings" says. Load it as it lies in its file: the orientation is '
        "right. Temperatures are those on the spool's label. Dry TPU before (8 h at 50 degC, our choice).",
    ]
    if "trunk" in build.groups:
        wide = 2 * max(joint.radius for joint in build.body.joints) + 2.0
        work.append(
            f"Trunk: the elastic joints must be solid. Put a modifier cylinder of {wide:.0f} mm on the axis, over the "
            f"whole height of each piece, with 100 % infill. Joint {build.design.n_joint} is "
            f"{2 * build.body.joints[-1].radius:.2f} mm thick: print the layers near it at 15 mm/s."
        )
    if "gripper" in build.groups:
        work.append(f"Gripper: 100 % infill at the finger joints: {join(_list_finger_joints(build))} from the bed.")
    return Step(
        title="Print", groups=frozenset(PRINTED),
        needs=("measured motors",) if {"housing", "drums", "horn"} & build.groups else (), makes=makes,
        tools=("3D printer", "slicer with modifier bodies", "calliper"), work=tuple(work),
        check="the largest dimensions agree with `size_m` in each part's JSON file to 0.3 mm, and no wall is open.",
    )  # fmt: skip


def _list_finger_joints(build: Build) -> list[str]:
    """Height ranges of the finger joints in the gripper's file."""
    if build.design.gripper is None:
        return []
    seat = find_seat(build.design, build.options)
    finger = build_finger(build.design.gripper, build.design.joint.youngs_modulus, build.options)
    base, (t1, t2) = seat.lip + seat.lug + seat.plate, finger.slopes
    ranges = []
    for j, r in enumerate(finger.joints):
        z = base + sum(finger.lengths[:j])
        ranges.append(f"{z - r * t2 - 0.5:.1f} to {z + r * t1 + 0.5:.1f} mm")
    return ranges


def _clear(build: Build) -> Step:
    options = build.options
    soft = tuple(name for name in ("trunk", "gripper") if name in build.groups)
    makes = ["trunk" if name == "trunk" and build.n_piece == 1 else f"clear {name}" for name in soft]
    drills = [f"drill {options.hole:g} mm in a pin vice"]
    holes = f"Push the {options.hole:g} mm drill through every cable hole by hand"
    if build.has_gripper:
        drills += [f"drill {options.pair_hole:g} mm", f"drill {STRAND * options.hole:g} mm"]
        holes += (
            f", the {options.pair_hole:g} mm drill through the channel on the trunk's axis, the "
            f"{STRAND * options.hole:g} mm drill through the gripper's fingers"
        )
    return Step(
        title="Take the supports out and clear the holes", groups=frozenset({"trunk", "gripper"}),
        needs=tuple(f"printed {name}" for name in soft), makes=tuple(makes),
        tools=("flush cutter", "tweezers", *drills, "weight of 50 g", "scissors for braid", "cyanoacrylate glue"),
        work=(
            "Cut the supports out of the gaps from outside inwards. Leave the round joint on the axis unhurt: it is "
            "the spring.",
            "Bend each joint once to every side until the faces of the gap meet. Remove what keeps them apart.",
            f"{holes}. Then make a needle: harden 20 mm of a piece of cable with a drop of glue and cut it at a slant.",
        ),
        check="a cable in each row of holes slides when a weight of 50 g hangs on it.",
    )  # fmt: skip


def _join(build: Build) -> Step:
    n = build.count("pieces of the trunk")
    return Step(
        title="Join the pieces of the trunk", groups=frozenset({"trunk"}), needs=("clear trunk",), makes=("trunk",),
        takes=("pieces of the trunk",), tools=("flat table", "2 rubber bands", "steel wire 0.5 mm"),
        work=(
            f"Lay the {build.n_piece} pieces in a row, trunk\\_1 at the base. Push the {n} pins half their length into "
            "the piece nearer to the base, without glue. Where a pin does not go in by hand, drill the hole to its "
            "diameter.",
            "Put a wire through each cable hole across the cut, and through those of the gripper's channel. Fit the "
            "pieces dry: every hole meets a hole, and the seam is shut. Of several ways that fit, any is right.",
            "Brush primer on both faces, wait as its maker says, put glue between pins and rim (not within 3 mm of a "
            "hole), press together for one minute, and pull the wires out.",
        ),
        check="the seam holds a pull of 20 N by hand, and the weight of 50 g still pulls a cable through.",
    )  # fmt: skip


def _cast(build: Build) -> Step:
    return Step(
        title="Cast the shells", groups=frozenset({"shells", "moulds"}), needs=("printed moulds",), makes=("shells",),
        takes=("shells",),
        tools=("scale 0.1 g", "cups and spatulas", "nitrile gloves", "vacuum chamber (or patience)", "spirit level"),
        work=(
            "Spray core and ring of each mould with release and let it dry as its maker says.",
            "Set ring NN on the step of core NN. Press clay round the seam outside. Level the moulds on a tray.",
            f"Weigh equal parts A and B of {SILICONE.name}. `bom.md` gives the grams of each shell. Mix for what you "
            "can pour within the pot life, and wear nitrile gloves: latex stops the cure. Pot life, degassing and cure "
            "time are those of the silicone's data sheet.",
            "Degas the mixture, or pour it in a thin stream from high up. Fill each mould to the brim and scrape "
            "it flat.",
            "When it has cured, pull the core out first. Then fold the shell inwards off the ridges of the ring. The "
            "ridges have made the shell's wrinkles.",
        ),
        check=f"all {build.n_shell} shells are free of sticky places and of bubbles wider than 2 mm.",
    )  # fmt: skip


def _dress(build: Build) -> Step:
    seats = [n + 1 for n, seat in enumerate(build.body.seats) if seat is not None]
    bare = build.design.n_section - len(seats)
    rest = f" The other {bare} {'sections stay' if bare > 1 else 'section stays'} bare." if bare else ""
    return Step(
        title="Put the shells on", groups=frozenset({"shells", "trunk"}), needs=("trunk", "shells"),
        makes=("trunk with shells",), tools=("water with a drop of dish soap",),
        work=(
            f"Wet shell {seats[0]:02d}, stretch it over the tip, and roll it along the trunk into the groove of "
            f"section {seats[0]}. Go on with the next, up to {seats[-1]:02d}: from the base to the tip, as no shell "
            f"can pass another.{rest}",
            f"The shells are {100 * build.options.shell_grip:g} % narrower than their grooves and hold without glue.",
        ),
        check="each shell lies between its two rims all round, and no shell stands in a gap when the trunk is curled.",
    )  # fmt: skip


def _weigh(build: Build) -> Step:
    design = build.design
    volume = design.solid.volume * float((design.scale**3).sum())
    keys = "put the result into `mass.density_kg_per_m3`"
    if design.mass.sections is not None:
        keys += " and delete `mass.sections_g`, which holds the masses of the authors' trunk"
    work = [
        f"Trunk in kg divided by {volume:.6g} m3, the volume of the sections' outlines: {keys}. Sections of one piece "
        "cannot be weighed one by one; who prints a second trunk can cut it at the joints and give `mass.sections_g`.",
    ]
    if "gripper" in build.groups:
        work.append("Gripper in g: `gripper.mass_g`.")
    if "housing" in build.groups:
        work.append(
            "Neck in kg, its supports out: `housing.neck_mass_kg`. The housing is weighed when its motors are in."
        )
    return Step(
        title="Weigh, and write it into the `trunk.toml` beside this page", groups=frozenset({"trunk"}),
        needs=(build.dressed, *(["clear gripper"] if "gripper" in build.groups else [])), makes=("weighed trunk",),
        tools=("scale 0.1 g",), work=tuple(work),
        check="`spiraltrunk export trunk.toml --formats mjcf --out models` reads the file and writes models with your "
        "masses. The estimate in `bom.md` is rough: for the authors' trunk it is 40 % too high.",
    )  # fmt: skip
