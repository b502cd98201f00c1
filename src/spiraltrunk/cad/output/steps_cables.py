"""Steps of the guide from the drums to the first pull."""

from __future__ import annotations

from spiraltrunk.cad.housing.test_stand import find_seat_height
from spiraltrunk.cad.output.cable_lengths import KNOT, cable_length, cable_to_hold
from spiraltrunk.cad.output.step import Build, Step, name_key


def list_cable_steps(build: Build) -> list[Step]:
    """The steps from the drums to the finished robot."""
    steps = [_drums(build), _thread(build), _knots(build)]
    if build.has_gripper:
        steps.append(_gripper(build))
    return [*steps, _markers(build), _pull(build)]


def _drums(build: Build) -> Step:
    drum, n = build.drum, build.design.n_cable
    return Step(
        title="Cables onto the drums", groups=frozenset({"drums"}), needs=("printed drums", "housing on the arm"),
        makes=("wound drums",), takes=("trunk", "drum to rotor"),
        tools=(name_key("M3"), "tweezers", "masking tape", "sewing thread"),
        work=(
            f"Cut {n} cables of {cable_length(build.design, build.options):.0f} mm. "
            "Harden one end of each to a needle.",
            f"On the bench: push {KNOT:g} mm of the other end from outside through the small hole at the bottom of the "
            "drum's groove into its bore. Tie a double figure of eight in the bore and pull it tight against the hole.",
            "Drum onto its rotor, wide flange down, four screws, crosswise.",
            f"Turn each rotor by hand anticlockwise, seen from above, until {drum.turns_straight:.1f} turns of cable "
            "lie side by side in one layer, from the bottom up. All drums wind in the same sense, and "
            "anticlockwise pulls.",
            "Lock each drum: a strip of tape from the drum over its turns to the motor's body. Tie 300 mm of thread to "
            "the strip's end and lead it out through the opening in the wall: the strips are pulled out by it later.",
        ),
        check="with the drum held by hand, a pull of 50 N on its cable (5 kg on a luggage scale) moves no knot; the "
        "turns lie side by side and none crosses another.",
    )  # fmt: skip


def _thread(build: Build) -> Step:
    hold = cable_to_hold(build.design, build.options)
    return Step(
        title="Thread the trunk and shut the lid", groups=frozenset({"drums", "housing", "trunk"}),
        needs=("wound drums", "trunk with strands" if build.has_gripper else "trunk on the lid"),
        makes=("threaded trunk",), takes=("cable guides", "lid to housing"),
        tools=(name_key("M3", is_sunk=True), "a second person", "tweezers", "masking tape"),
        work=(
            "Wax the rounded lips of the guides under the lid. The second person holds lid and trunk "
            f"{max(50.0, hold - KNOT):.0f} mm above the housing, dorsal marks in line.",
            "Cable k goes from drum k, on the drum's side that is away from the housing's middle, into guide k, "
            "through the neck, and through row k of holes to the tip. Draw it out at the tip; tape it there.",
            *(("Lead the servo's wire out through the opening in the wall. Keep the strands clear of the drums.",)
              if build.has_gripper else ()),
            "Lower the lid and draw the slack out at the tip meanwhile. No cable may be caught under the lid or behind "
            "a drum: look through the opening. Lid screws.",
        ),
        check=f"at the tip of the straight trunk {hold:.0f} mm of each cable stand out, to 20 mm, and a cable that is "
        "pulled there gives by no more than 2 mm.",
    )  # fmt: skip


def _knots(build: Build) -> Step:
    gaps = build.design.straight_gap
    shown = ", ".join(f"{1e3 * gap:.1f}" for gap in gaps[[0, build.design.n_joint // 2, -1]])
    deep = 4 * build.options.cable
    room = (
        f" Knot and bead must stay inside the ring of {deep:g} mm depth that the gripper's plate leaves: if the knot "
        "is higher, crimp the bead, put a drop of cyanoacrylate on it, and leave the knot out."
        if build.has_gripper
        else ""
    )
    return Step(
        title="Knots at the tip", groups=frozenset({"drums", "housing", "trunk"}), needs=("threaded trunk",),
        makes=("trunk with cables",), takes=("knots at the tip",),
        tools=("crimping pliers", "scissors for braid", "tweezers", "straight edge"),
        work=(
            "Trunk straight up, held along a straight edge. Pull one cable taut by hand (5 N, 0.5 kg), push a bead "
            f"down to the face of the tip, crimp it lightly and tie a figure of eight on it.{room}",
            "Do the same with the others in turn, then cut the ends 3 mm behind the knots.",
            "Pull the strips of tape out of the housing by their threads.",
        ),
        check=f"let go, the trunk stands or hangs without any cable slack by more than 3 mm. Straight, the cable spans "
        f"{shown} mm in the first, middle and last gap.",
    )  # fmt: skip


def _gripper(build: Build) -> Step:
    gripper = build.design.gripper
    fingers = 0 if gripper is None else gripper.n_finger
    return Step(
        title="Gripper", groups=frozenset({"gripper", "horn"}), needs=("trunk with cables", "clear gripper"),
        makes=("robot",), tools=("tweezers", "scissors for braid", "electrical tape"),
        work=(
            f"Untwist the last 60 mm of both groups. Lead all {2 * fingers} strands into the hole of the tenon. In the "
            f"plate, {fingers} channels lead from there to the fingers: fish one strand of CLOSE to the inner hole and "
            "one of OPEN to the outer hole of each finger, through a channel's open end, and on to the fingertip.",
            "Push the tenon in with finger 1 a quarter turn clockwise of dorsal (seen from the tip, looking at the "
            "trunk), drawing the strands along. Turn it by 90 deg anticlockwise: finger 1 is dorsal, the lugs are "
            "locked. A ring of tape over the seam keeps it from turning back.",
            "Servo at its middle (1500 us), fingers straight. Pull each strand taut, tie a figure of eight at the "
            "fingertip, cut it 3 mm behind.",
        ),
        check="1400 us and 1600 us move all fingers, to opposite sides; note which closes. Then go towards the two "
        "pulses noted for the servo, and stop where the fingers meet.",
    )  # fmt: skip


def _markers(build: Build) -> Step:
    design = build.design
    heights = [find_seat_height(1e3 * float(radius)) / 2 for radius in design.section_radius[[0, -1]]]
    return Step(
        title="Only for motion capture: the markers", groups=frozenset({"markers"}),
        needs=("robot" if build.has_gripper else "trunk with cables", "printed marker seats"),
        makes=("robot with markers",), takes=("marker seats",), tools=("pen", "strip of paper"),
        work=(
            "Mark three places on each section's edge towards the tip, 120 deg apart: a strip of paper as long as the "
            "section is round, folded in three. The first is dorsal (cable 1), the others follow as the cables do.",
            "Glue a seat to each, its end flush with the edge, marker_seat_NN to section NN. Glue holds on the TPU "
            "rim, not on silicone: put it on the rim only. A seat must not stand into the gap.",
            "Turn a marker's stud into each.",
            f"The markers lie {heights[0]:.1f} mm (section 1) to {heights[1]:.1f} mm (section {design.n_section}) "
            "before the edge that the protocol means: half a seat. Move the pivot of each rigid body in Motive by that "
            "much towards the tip.",
        ),
        check="curl the trunk to every side by hand: all gaps still shut, and no seat comes off.",
    )  # fmt: skip


def _pull(build: Build) -> Step:
    motor, drum, cable = build.options.motor, build.drum, build.design.cable
    per_newton = 1e-3 * drum.radius * motor.current / motor.torque
    return Step(
        title="First pull", groups=frozenset({"housing", "drums"}),
        needs=("robot" if build.has_gripper else "trunk with cables", "checked motors"), makes=("robot under tension",),
        tools=("safety glasses", "emergency stop within reach", "luggage scale"),
        work=(
            "Read `SAFETY.md` of the project first; `spiraltrunk export` moves nothing, and what drives the motors "
            "must obey it. Nobody within reach of trunk and arm. The emergency stop lets the cables go: nothing may "
            "hang in the trunk that must not fall.",
            f"{per_newton:.4f} A pull 1 N ({motor.torque:g} N m at {motor.current:g} A on a drum of "
            f"{2 * drum.radius:.1f} mm; friction is not counted). Limit the current to {5 * per_newton:.2f} A (5 N) "
            f"first. Never above {cable.tension_max * per_newton:.2f} A ({cable.tension_max:g} N, "
            "`cable.tension_max_n`).",
            "Connect the 24 V supply in place of the bench supply. Take the slack up with 2 N on every cable: this is "
            "the zero of the turn counts. It is lost at power-off.",
            f"Pull one cable in by 5 mm, and let it out again. A cable may be pulled in by {drum.travel_in:.0f} mm "
            f"from straight (then {drum.turns_in:.1f} turns are on the drum) and let out by "
            f"{drum.travel_out:.0f} mm.",
            "Compare the current with a luggage scale on a free cable before you call it a tension.",
        ),
        check="each cable bends the trunk to its own side, the angle in the feedback changes with the sense that was "
        "noted on the bench, and the emergency stop lets go at once.",
    )  # fmt: skip
