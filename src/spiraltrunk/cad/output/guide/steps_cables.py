"""Steps of the guide from the drums to the first pull."""

from __future__ import annotations

from spiraltrunk.cad.components.options import MOST_MOTORS
from spiraltrunk.cad.housing.layout import find_layout
from spiraltrunk.cad.housing.test_stand import N_WEDGE, find_seat_height
from spiraltrunk.cad.output.cable_lengths import KNOT, cable_length, cable_to_hold
from spiraltrunk.cad.output.guide.step import Build, PlannedStep, Step, name_key
from spiraltrunk.cad.output.payload import compute_payload
from spiraltrunk.design.rules import GRAVITY


def plan_cable_steps() -> tuple[PlannedStep, ...]:
    """The steps from the drums to the finished robot."""
    return (
        PlannedStep(frozenset({"drums"}), _drums),
        PlannedStep(frozenset({"drums", "housing", "trunk"}), _thread),
        PlannedStep(frozenset({"drums", "housing", "trunk"}), _knots),
        PlannedStep(frozenset({"gripper", "horn"}), _gripper, lambda build: build.has_gripper),
        PlannedStep(frozenset({"markers"}), _markers),
        PlannedStep(frozenset({"housing", "adapter"}), _payload),
        PlannedStep(frozenset({"housing", "drums"}), _pull),
    )


def _drums(build: Build) -> Step:
    drum, n, tension = build.drum, build.design.n_cable, build.design.cable.tension_max
    return Step(
        title="Cables onto the drums", needs=("printed drums", "housing on the arm"),
        makes=("wound drums",),
        takes=("trunk", "drum to rotor", *(() if {"trunk", "gripper"} & build.groups else ("trials",))),
        work=(
            f"Cut {n} cables of {cable_length(build.design, build.options):.0f} mm with scissors for braid. "
            "Harden one end of each to a needle with a drop of cyanoacrylate glue.",
            f"On the bench, drum on the table: push {KNOT:g} mm of the other end with tweezers from outside through "
            "the small hole at the bottom of the drum's groove into its bore. Tie a double figure of eight in the bore "
            "and pull it tight against the hole.",
            f"Drum onto its rotor, wide flange down, four screws with the {name_key('M3')}, crosswise.",
            f"Turn each rotor by hand anticlockwise, seen from above, until {drum.turns_straight:.1f} turns of cable "
            "lie side by side in one layer, from the bottom up. All drums wind in the same sense, and "
            "anticlockwise pulls (arrows in `pictures/top_view.svg`).",
            "Lock each drum: a strip of masking tape, 6 mm wide, from the drum over its turns to the motor's body. Tie "
            "300 mm of sewing thread to the strip's end and lead it out through the opening in the wall: the strips "
            "are pulled out by it in the last step. Until then they alone hold the turns.",
            "Try the end at the tip before it matters, on 300 mm of the cable for trials: crimp a bead with crimping "
            "pliers and "
            f"knot as in the step after the next, then a pull of {1.25 * tension:.0f} N "
            f"({1.25 * tension / GRAVITY:.1f} kg on a luggage "
            "scale) for a minute. Cyanoacrylate holds UHMWPE badly: where bead or knot slips, tie two figures of eight "
            "on each other, and where that slips too, lower `cable.tension_max_n` to half of what held. We tried none.",
        ),
        check="with the drum held by hand, a pull of 50 N on its cable (5 kg on the luggage scale) moves no knot; the "
        "turns lie side by side and none crosses another.",
    )  # fmt: skip


def _thread(build: Build) -> Step:
    hold = cable_to_hold(build.design)
    return Step(
        title="Thread the trunk and shut the lid",
        needs=("wound drums", "trunk with strands" if build.has_gripper else "trunk on the lid"),
        makes=("threaded trunk",), takes=("cable guides", "lid to housing"),
        work=(
            "Wax the rounded lips of the guides under the lid. A second person holds lid and trunk "
            f"{max(50.0, hold - KNOT):.0f} mm above the housing, dorsal marks in line.",
            "Cable k leaves drum k on the side towards the housing's wall and goes to guide k, the next guide "
            "clockwise "
            "of drum k, seen from above: `pictures/top_view.svg` shows it. Lap its needle 15 mm along the lower end of "
            "pull wire k, which sticks out of guide k, fix the lap with a drop of cyanoacrylate glue and let it dry: "
            f"it must stay thinner than {build.options.hole:g} mm. Draw the wire out at the tip, the cable follows "
            "through neck and holes; cut the lap off and hold the cable at the tip with masking tape. Where it jams, "
            "draw back and make the lap thinner.",
            *(("Lead the servo's wire out through the opening in the wall, along the posts. Keep the strands clear of "
               "the drums.",) if build.has_gripper else ()),
            "Lower the lid and draw the slack out at the tip meanwhile. No cable may be caught under the lid or behind "
            "a drum: look through the opening, and under the lid's rim until it is down. Lid screws with the "
            f"{name_key('M3', is_sunk=True)}.",
        ),
        check=f"at the tip of the straight trunk {hold:.0f} mm of each cable stand out, to 20 mm, and a cable that is "
        "pulled there gives by no more than 2 mm.",
    )  # fmt: skip


def _knots(build: Build) -> Step:
    gaps = build.design.straight_gap
    shown = ", ".join(f"{1e3 * gap:.1f}" for gap in gaps[[0, build.design.n_joint // 2, -1]])
    deep = 4 * build.options.cable
    room = (
        f" Knot and bead must stay inside the ring of {deep:g} mm depth that the gripper's plate leaves, the ends laid "
        "along it: if the knot is higher, leave it out and use what held in the pull on the bench."
        if build.has_gripper
        else ""
    )
    return Step(
        title="Knots at the tip", needs=("threaded trunk",),
        makes=("trunk with cables",), takes=("knots at the tip",),
        work=(
            "Trunk straight up, held along a straight edge. Pull one cable taut by hand (5 N, 0.5 kg), push a bead "
            "down to the face of the tip with tweezers, crimp it lightly with crimping pliers and tie a figure of "
            f"eight on it.{room}",
            "Do the same with the others in turn, then cut the ends 3 mm behind the knots with scissors for braid. "
            "The strips of tape on the drums stay in: without power nothing else holds the turns.",
        ),
        check="with the tape still on the drums, push the tip gently (2 N) away from the side of each cable k in turn: "
        "cable k resists and is taut in the first gap, its drum does not turn. Let go: no cable is slack by more than "
        f"3 mm. Straight, the cable spans {shown} mm in the "
        "first, middle and last gap.",
    )  # fmt: skip


def _gripper(build: Build) -> Step:
    gripper = build.design.gripper
    fingers, legs = (0, 1) if gripper is None else (gripper.n_finger, gripper.n_leg)
    one, other = ("one strand", "one") if legs == 1 else ("two strands, one from each side of the trunk,", "two")
    tie = (
        "tie a figure of eight at the fingertip" if legs == 1 else "tie the two strands of a hole to each other over "
        "4 mm of filament across the hole at the fingertip: the loop slides round it and shares the pull"
    )  # fmt: skip
    return Step(
        title="Gripper", needs=("trunk with cables", "clear gripper"),
        makes=("robot",),
        work=(
            "Finger 1 is the finger in line with one of the two lugs of the tenon. Mark it with a pen.",
            f"Untwist the last 60 mm of both groups. Lead all {2 * fingers * legs} strands into the hole of the "
            f"tenon. In the plate, {fingers} channels lead from there to the fingers: with tweezers fish {one} of "
            f"CLOSE (black end) to the inner hole and {other} of OPEN (white end) to the outer hole of each finger, "
            "through a channel's open end, and on to the fingertip.",
            "Push the tenon in with finger 1 a quarter turn clockwise of dorsal (seen from the tip, looking at the "
            "trunk), drawing the strands along. Turn it by 90 deg anticlockwise: finger 1 is dorsal, the lugs are "
            "locked. A ring of electrical tape over the seam keeps it from turning back.",
            "Servo at its middle (1500 us, fed as on the bench), fingers straight. Pull each strand taut, "
            f"{tie}, cut it 3 mm behind with scissors for braid.",
        ),
        check="1400 us and 1600 us move all fingers, to opposite sides; note which closes. Then go towards the two "
        "pulses noted for the servo, and stop where the fingers meet.",
    )  # fmt: skip


def _markers(build: Build) -> Step:
    design = build.design
    heights = [find_seat_height(1e3 * float(radius)) / 2 for radius in design.section_radius[[0, -1]]]
    return Step(
        title="Only for motion capture: the markers",
        needs=("robot" if build.has_gripper else "trunk with cables", "printed marker seats"),
        makes=("robot with markers",), takes=("marker seats",),
        work=(
            "With a pen mark three places on each section's edge towards the tip, 120 deg apart: a strip of paper as "
            "long as the "
            "section is round, folded in three. The first is dorsal (cable 1), the others follow as the cables do.",
            "Fix a seat to each with cyanoacrylate glue over the primer of the trunk's seam, its end flush with the "
            "edge, marker_seat_NN to section NN. Glue holds on the TPU "
            "rim, not on silicone: put it on the rim only. A seat must not stand into the gap.",
            "Turn a marker's stud into each.",
            f"The markers lie {heights[0]:.1f} mm (section 1) to {heights[1]:.1f} mm (section {design.n_section}) "
            "before the edge that the protocol means: half a seat. Move the pivot of each rigid body in Motive by that "
            "much towards the tip.",
        ),
        check="curl the trunk to every side by hand: all gaps still shut, and no seat comes off.",
    )  # fmt: skip


def _payload(build: Build) -> Step:
    load, design = compute_payload(build.design), build.design
    wedges = f" Each wedge adds {build.estimate('wedge') / N_WEDGE:.0f} g." if "wedge" in build.groups else ""
    neck = sum(row.mass for row in build.bill.made if row.item == "neck")
    printed = build.estimate("trunk") + build.estimate("shells") + neck
    counted = 1e3 * (float(design.section_mass.sum()) + design.housing.total_neck_mass)
    more = (
        f" With the bill's estimate of {printed:.0f} g for trunk, shells and neck in place of the {counted:.0f} g that "
        f"the design counts for them it is {load.mass + 1e-3 * (printed - counted):.2f} kg."
    ) * (neck > 0 and "trunk" in build.groups)
    panda = " A Panda or FR3 carries 3 kg, by its maker's data." * (design.arm.model in ("panda", "fr3"))
    gripper = f", the gripper's {1e3 * design.gripper.mass:.1f} g" if design.gripper is not None else ""
    return Step(
        title="Tell the arm its payload",
        needs=("robot" if build.has_gripper else "trunk with cables", "adapter on the flange"),
        makes=("arm with its payload",),
        work=(
            f"In the arm's settings, before it is powered again: mass {load.mass:.2f} kg, centre of mass "
            f"{1e3 * load.center:.0f} mm from the flange on the flange's z axis (0, 0, {load.center:.3f} m), moments "
            f"about it {load.transverse:.4f}, {load.transverse:.4f}, {load.axial:.4f} kg m2 (x, y, z). They are the "
            "simulation's, with the trunk straight and with the masses of the `trunk.toml` that this page was made "
            f"from; wires{gripper} and what is held come on top. After weighing, `spiraltrunk export trunk.toml "
            "--parts adapter --formats stl --out again` writes this step with your masses into `again/guide.md`: "
            f"use those.{more}{wedges}",
            f"Add up mass, wedges and the heaviest object, and compare the sum with what the arm carries.{panda} The "
            "centre of mass moves with the trunk: stay slow. With wedges it is tilted and further away: weigh and "
            "measure.",
        ),
        check="the arm holds its pose in hand guiding without drifting up or down.",
    )  # fmt: skip


def _pull(build: Build) -> Step:
    motor, drum, cable, layout = (
        build.options.motor, build.drum, build.design.cable, find_layout(build.design, build.options)
    )  # fmt: skip
    per_newton, away = 1e-3 * drum.radius * motor.current / motor.torque, layout.radius + 1e3 * build.design.length
    n = build.design.n_cable
    more = f" and 0x2FE for the ids 5 to {MOST_MOTORS}" * (n > 4)
    return Step(
        title="First pull",
        needs=("robot" if build.has_gripper else "trunk with cables", "checked motors", "arm with its payload"),
        makes=("robot under tension",),
        work=(
            "**The software that drives the motors was never tried on a motor.** It is `spiraltrunk.hardware`; read "
            "`SAFETY.md` and `docs/tutorials/hardware.md` in the source of spiraltrunk (not in this folder), and "
            "follow the tutorial up to the first torque with clamped motors and without cables. Until then the tape "
            "stays on the drums. What can be done without: the push of each side in the step of the knots, the servo "
            "with its own driver, and the models and simulations. Do not take the tape out and wind by hand: the "
            "drums cannot be reached any more.",
            "A program of your own must obey `SAFETY.md`. In short: no command older than 20 ms, current limited in "
            "size and rate, tension never below a floor, and ramped down to it on a fault before it goes to zero.",
            f"What it needs (untried; compare the motor's manual): GM6020 in current mode, frame 0x1FE for "
            f"the ids 1 to 4{more}, two bytes a motor, high byte first, 16384 for 3 A; feedback as on the bench. "
            f"{per_newton:.4f} A pull 1 N ({motor.torque:g} N m at {motor.current:g} A, cable's middle on a circle of "
            f"{2 * drum.radius:.1f} mm; friction is not counted). First limit: {5 * per_newton:.2f} A (5 N). Never "
            f"above {cable.tension_max * per_newton:.2f} A ({cable.tension_max:g} N, `cable.tension_max_n`).",
            f"Wear safety glasses; nobody within {1e-3 * away + 0.5:.1f} m of the trunk and within the arm's reach. "
            f"The "
            "emergency stop lets the cables go: nothing may hang in the trunk that must not fall.",
            "Connect the 24 V supply in place of the bench supply. Emergency stop pressed, pull the strips of tape out "
            "by their threads, and look that no turn springs off: by our estimate the rotors' friction holds a cable "
            f"without load. Home at once: all {n} cables are wound in gently, and where the trunk is straight and all "
            "are taut is the zero of the turn counts. It is lost at power-off, and the trunk must be held before the "
            "power goes.",
            f"Pull one cable in by 5 mm, and let it out again. A cable may be pulled in by {drum.travel_in:.0f} mm "
            f"from straight (then {drum.turns_in:.1f} turns are on the drum) and let out by "
            f"{drum.travel_out:.0f} mm.",
            "A current is no tension before it was compared: with the program, a motor in soft jaws, a drum, and the "
            "cable for trials from it to a luggage scale. The drums of a shut housing cannot be reached: compare "
            "before the step \"Motors into the housing\", or with one more motor and drum.",
        ),
        check="each cable bends the trunk to its own side, the angle in the feedback changes with the sense that was "
        "noted on the bench, and the emergency stop lets go at once.",
    )  # fmt: skip
