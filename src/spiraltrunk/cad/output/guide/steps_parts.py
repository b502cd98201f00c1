"""Steps of the guide that make the parts: measuring, printing, joining, casting, weighing."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from spiraltrunk.cad.housing.winder import motor_ring
from spiraltrunk.cad.output import filament
from spiraltrunk.cad.output.guide.step import Build, PlannedStep, Step, join
from spiraltrunk.cad.output.purchase import Purchase
from spiraltrunk.cad.trunk.gripper import STRAND, build_finger, find_seat
from spiraltrunk.cad.trunk.pieces import plan_planes
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


_PIECES = "pieces of the trunk"
"""Place of the trunk's pins and glue in the bill."""


def plan_part_steps() -> tuple[PlannedStep, ...]:
    """The steps from the bought motors to a weighed trunk."""
    return (
        PlannedStep(frozenset({"housing", "drums", "horn"}), _measure),
        PlannedStep(frozenset(PRINTED), _print),
        PlannedStep(frozenset({"trunk", "gripper", "housing", "wedge"}), _clear),
        PlannedStep(frozenset({"trunk"}), _join, lambda build: build.n_piece > 1),
        PlannedStep(frozenset({"shells", "moulds"}), _cast, lambda build: build.n_shell > 0),
        PlannedStep(frozenset({"shells", "trunk"}), _dress, lambda build: build.n_shell > 0),
        PlannedStep(frozenset({"trunk"}), _weigh),
    )


def _measure(build: Build) -> Step:
    servo, has_motors = build.options.servo, bool({"housing", "drums"} & build.groups)
    work = _measure_motors(build) if has_motors else []
    if build.has_gripper:
        work.append(
            f"Servo, with the calliper: body {servo.length:g} x {servo.width:g} mm, lug holes "
            f"{servo.lug_pitch:g} mm apart, shaft {servo.shaft_offset:g} mm from the near end, hub of the round horn "
            f"{servo.hub_diameter:g} mm across."
        )
    work.append(
        f"{_say_motor_distance(build) if has_motors else ''}If a number differs by more than 0.2 mm, export again "
        'with yours (see "Other dimensions" below).'
    )
    return Step(
        title="Measure what was bought",
        makes=("measured motors",), takes=("motors", "servo"), work=tuple(work),
        check="every number agrees with the export that you print from.",
    )  # fmt: skip


def _measure_motors(build: Build) -> list[str]:
    motor, floor, wall = build.options.motor, build.options.plate, build.drum.wall
    return [
        f"With a calliper, motor: pitch circle of the four M4 threads in its underside ({motor.floor_circle:g} mm "
        f"assumed), pitch "
        f"circle of the four M3 threads in its rotor ({motor.rotor_circle:g} mm), diameter ({motor.diameter:g} mm), "
        f"height ({motor.height:g} mm).",
        f"Depth of these threads: the M4 screws enter by {10 - floor:g} mm and the M3 screws by {8 - wall:g} mm. A "
        "screw that is longer than its thread is deep can touch the winding: take a shorter one.",
    ]


def _say_motor_distance(build: Build) -> str:
    motor, ring = build.options.motor, motor_ring(build.design, build.options)
    apart = 2 * ring * math.sin(math.pi / build.design.n_cable)
    return f"Motors {motor.diameter:g} mm wide stand {apart:.1f} mm apart. "


def _print(build: Build) -> Step:
    makes = tuple(name for group, names in PRINTED.items() if group in build.groups for name in names)
    work = [
        'Set each part up for the 3D printer in a slicer with modifier bodies, as the table "Print settings" says. '
        "Load it as it lies in its file: the orientation is right. Temperatures are those on the spool's label. Dry "
        "TPU before (8 h at 50 degC, our choice).",
    ]
    if "trunk" in build.groups:
        wide = 2 * max(joint.radius for joint in build.body.joints) + 2.0
        starts, planes = build.body.starts, plan_planes(build.design, build.body, build.options)
        thin = float(starts[-1]) - (planes[-2] if build.n_piece > 1 else 0.0)
        work.append(
            f"Trunk: the elastic joints must be solid. Put a modifier cylinder of {wide:.0f} mm diameter on the axis, "
            f"over the whole height of each piece, with 100 % infill. The thinnest joint, {build.design.n_joint}, is "
            f"{2 * build.body.joints[-1].radius:.2f} mm thick: print at 15 mm/s from {thin - 2:.0f} to {thin + 4:.0f} "
            f"mm above the bed{f' (trunk_{build.n_piece})' * (build.n_piece > 1)}."
        )
    if "gripper" in build.groups:
        work.append(f"Gripper: 100 % infill at the finger joints: {join(_list_finger_joints(build))} from the bed.")
    return Step(
        title="Print",
        needs=("measured motors",) if {"housing", "drums", "horn"} & build.groups else (), makes=makes,
        takes=(filament.PLACE,), work=tuple(work),
        check="the largest dimensions agree with `size_m` in each part's JSON file to 0.3 mm (it is in m: 0.088 is 88 "
        "mm; all other lengths there and in the files of the shapes are in mm), and no wall has a hole or a split "
        "layer.",
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
    soft = tuple(name for name in ("trunk", "gripper") if name in build.groups)
    rigid = tuple(name for name, group in (("neck", "housing"), ("wedges", "wedge")) if group in build.groups)
    cleared = tuple("trunk" if name == "trunk" and build.n_piece == 1 else f"clear {name}" for name in soft)
    return Step(
        title="Take the supports out and clear the holes",
        needs=tuple(f"printed {name}" for name in (*soft, *rigid)), makes=(*cleared, *(f"clear {n}" for n in rigid)),
        takes=("trials",) if soft else (),
        work=(
            *((f"Break the supports out of the {join(rigid)}.",) if rigid else ()),
            *((_clear_gaps(), *_clear_holes(build)) if soft else ()),
        ),
        check="the cable for trials slides in each row of holes when a weight of 50 g hangs on it." if soft
        else "no support is left.",
    )  # fmt: skip


def _clear_gaps() -> str:
    return (
        "With a flush cutter and tweezers take the supports out of the gaps, from outside inwards. Leave the round "
        "joint on the axis unhurt: it is the spring. Bend each joint once to every side until the faces of the gap "
        "meet. Remove what keeps them apart."
    )


def _clear_holes(build: Build) -> tuple[str, ...]:
    """Sentences on the holes: no drill is long enough for the rows, and none fits the gaps."""
    needle = (
        "Make a needle of the cable for trials: harden its last 20 mm with a drop of cyanoacrylate glue and cut it at "
        "a slant with scissors for braid."
    )
    fingers = f"Clear the gripper's fingers with a drill {STRAND * build.options.hole:g} mm in the pin vice."
    rows = (*_clear_rows(build), *_clear_channel(build)) if "trunk" in build.groups else ()
    return (*rows, *((fingers,) if "gripper" in build.groups else ()), needle)


def _clear_rows(build: Build) -> tuple[str, ...]:
    """The sentence on the rows of cable holes."""
    return (
        f"Clear each row of cable holes with a spring steel wire {0.8 * build.options.hole:.1f} mm thick and "
        f"{_reach(build)} mm long, one end cut at a slant, the other in a pin vice: twist it through one section after "
        "the other from the piece's end and guide it across the gaps with tweezers (the rows run closer to the axis "
        "from section to section). A drill is too short for the rows and does not fit into the gaps.",
    )


def _clear_channel(build: Build) -> tuple[str, ...]:
    """The sentence on the channel of the gripper's strands."""
    if not build.has_gripper:
        return ()
    hollow, pair = build.body.n_hollow, 0.8 * build.options.pair_hole
    beside = (
        f" from section {hollow + 1} on there are two holes of {build.options.hole:g} mm beside the axis, for the wire "
        "of the rows."
    ) * (hollow < build.design.n_joint)
    axis = (
        f"Clear the channel on the trunk's axis in the same way with a spring steel wire {pair:.1f} mm thick; it runs "
        f"through the joints;{beside} If it is fused and does not open from either end, print the piece again, drier "
        "and slower: there is no other way for the gripper's strands. Find out now, before the pieces are joined."
    ).replace("joints; If", "joints. If")
    return (axis,)


def _reach(build: Build) -> int:
    """Length of a wire that passes the longest piece of the trunk and can be held at its end [mm]."""
    planes = plan_planes(build.design, build.body, build.options)
    return 50 * math.ceil((max(high - low for low, high in pairwise(planes)) + 100.0) / 50)


def _join(build: Build) -> Step:
    pins = [row for row in build.bill.bought if row.item.startswith("dowel") and row.place == _PIECES]
    where = "between pins and rim" if pins else "on the faces"
    return Step(
        title="Join the pieces of the trunk", needs=("clear trunk",), makes=("trunk",),
        takes=(_PIECES,),
        work=(
            f"Lay the {build.n_piece} pieces in a row on a flat table, trunk\\_1 at the base.{_say_pins(pins)}",
            "Put a soft steel wire 0.5 mm thick through each cable hole across the cut, and through those of the "
            "gripper's channel. Fit the "
            "pieces dry: every hole meets a hole, and the seam is shut. Of several ways that fit, any is right.",
            f"Brush primer on both faces, wait as its maker says, put glue {where} (not within 3 mm of a "
            "hole), press together for one minute, hold with two rubber bands along the trunk until it has cured, "
            "and pull the wires out.",
        ),
        check="the seam holds a pull of 20 N by hand, and the weight of 50 g still pulls a cable through.",
    )  # fmt: skip


def _say_pins(rows: Sequence[Purchase]) -> str:
    """What is done with the pins of all cuts, of which the bill has a row each; nothing where no cut has room."""
    if not rows:
        return ""
    sizes = sorted({row.size.split(" ")[0] for row in rows}, key=float)
    drills = " or ".join(f"drill {size} mm" for size in sizes) + ", as thick as the pin," * (len(sizes) > 1)
    lengths = " (the bill says which at which cut)" * (len({row.size for row in rows}) > 1)
    return (
        f" Push the {sum(row.count for row in rows)} pins{lengths} half their length into the piece nearer to the "
        f"base, without glue. Where a pin does not go in by hand, open its hole with a {drills} by hand."
    )


def _cast(build: Build) -> Step:
    return Step(
        title="Cast the shells", needs=("printed moulds",), makes=("shells",),
        takes=("shells",),
        work=(
            "Spray core and ring of each mould with release and let it dry as its maker says.",
            "Set ring NN on the step of core NN, the end without ridges down; it fits no other way. Press clay round "
            "the "
            "seam outside. Level the moulds on a tray with a spirit level.",
            f"Weigh equal parts A and B of {SILICONE.name} on a scale to 0.1 g, in cups and spatulas that are new. "
            "`bom.md` gives the grams of each shell. Mix for what you "
            "can pour within the pot life, and wear nitrile gloves: latex stops the cure. Pot life, degassing and cure "
            "time are those of the silicone's data sheet.",
            "Degas the mixture in a vacuum chamber, or without one pour it in a thin stream from high up. Fill each "
            "mould to the brim and scrape "
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
        title="Put the shells on", needs=("trunk", "shells"),
        makes=("trunk with shells",),
        work=(
            f"Wet shell {seats[0]:02d} in water with a drop of dish soap, stretch it over the tip, and roll it along "
            f"the trunk into the groove of "
            f"section {seats[0]}. Go on with the next, up to {seats[-1]:02d}: from the base to the tip, as no shell "
            f"can pass another.{rest}",
            f"The shells are {100 * build.options.shell_grip:g} % narrower than their grooves and hold without glue. "
            f"A shell "
            "is a plain ring: either end may point to the base.",
        ),
        check="each shell lies between its two rims all round, and no shell stands in a gap when the trunk is curled.",
    )  # fmt: skip


def _weigh(build: Build) -> Step:
    design = build.design
    volume = design.solid.volume * float((design.scale**3).sum())
    keys = "put the result into `mass.density_kg_per_m3`"
    if design.mass.sections is not None:
        keys += " and delete `mass.sections_g`, which holds the masses of the authors' trunk"
    clothes = " with its shells" * bool(build.n_shell)
    work = [
        f"On a scale to 0.1 g: trunk{clothes} in kg, divided by {volume:.6g} m3, the volume of the sections' outlines: "
        f"{keys}. Sections of one piece cannot be weighed one by one; who prints a second trunk can cut it at the "
        "joints and give `mass.sections_g`.",
    ]
    if "gripper" in build.groups:
        work.append("Gripper in g: `gripper.mass_g`.")
    if "housing" in build.groups:
        work.append(
            "Neck in kg: a new line `neck_mass_kg = ...` in the section `[housing]`. The housing is weighed when its "
            "motors are in."
        )
    needs = (build.dressed, *(f"clear {n}" for n, group in _WEIGHED if group in build.groups))
    return Step(
        title="Weigh, and write it into the `trunk.toml` beside this page", needs=needs,
        makes=("weighed trunk",), work=tuple(work),
        check="on a Linux computer, `spiraltrunk export trunk.toml --formats mjcf --out models` reads the file and "
            "writes models with your "
        f"masses. {_expect_mass(build)}",
    )  # fmt: skip


_WEIGHED = (("gripper", "gripper"), ("neck", "housing"))
"""What is weighed beside the trunk, and its group."""


def _expect_mass(build: Build) -> str:
    """What the scale may show: the design's and the bill's number, and what each counts."""
    soft, skin = build.estimate("trunk"), build.estimate("shells")
    design = 1e3 * float(build.design.section_mass.sum())
    whole = f" and {skin:.0f} g of silicone, together {soft + skin:.0f} g" * bool(skin)
    return (
        f"Which number you will get nobody knows yet: the design counts {design:.0f} g for all sections (its default "
        "density is that of the authors' trunk, and whether that was weighed with its shells is not published), "
        f"`bom.md` estimates {soft:.0f} g of TPU{whole}."
    )
