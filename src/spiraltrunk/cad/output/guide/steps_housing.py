"""Steps of the guide from the electronics on the bench to the housing on the arm."""

from __future__ import annotations

import math

from spiraltrunk.cad.components.fasteners import THREADS
from spiraltrunk.cad.components.options import ADAPTER
from spiraltrunk.cad.housing.housing import PORT, SPIGOT_SEAT
from spiraltrunk.cad.housing.layout import find_layout
from spiraltrunk.cad.housing.winder import find_arm, motor_angles
from spiraltrunk.cad.output import electronics
from spiraltrunk.cad.output.guide.step import Build, PlannedStep, Step, join, name_key, name_spanner
from spiraltrunk.cad.output.top_view import find_port, find_servo

TORQUES = ", ".join(f"{name} {thread.torque:g} N m" for name, thread in THREADS.items())
"""Torque of each thread, as the guide says it."""

_FEEDBACK = 0x204
"""CAN id of a motor's feedback less its own id (GM6020, public drivers)."""


def plan_housing_steps() -> tuple[PlannedStep, ...]:
    """The steps from the electronics to the open housing on the arm, with the trunk on its lid beside it."""
    return (
        PlannedStep(frozenset({"housing"}), _power),
        PlannedStep(frozenset({"horn", "housing"}), _servo, lambda build: build.has_gripper),
        PlannedStep(frozenset({"housing", "adapter"}), _inserts),
        PlannedStep(frozenset({"housing"}), _motors),
        PlannedStep(frozenset({"trunk", "housing"}), _neck),
        PlannedStep(frozenset({"housing"}), _lid),
        PlannedStep(frozenset({"horn", "housing", "gripper"}), _bracket, lambda build: build.has_gripper),
        PlannedStep(frozenset({"adapter", "wedge"}), _flange),
        PlannedStep(frozenset({"wedge"}), _wedge),
        PlannedStep(frozenset({"adapter"}), _adapter),
        PlannedStep(frozenset({"housing", "adapter"}), _cup),
    )


def _power(build: Build) -> Step:
    design, options = build.design, build.options
    n, own, main = design.n_cable, electronics.motor_fuse(options), electronics.main_fuse(design, options)
    ids = join([f"0x{_FEEDBACK + k:X}" for k in range(1, n + 1)])
    return Step(
        title="Wire the motors on the bench, without cables or drums",
        needs=("measured motors",), makes=("checked motors",), takes=(electronics.MOTORS,),
        work=(
            f"With a crimping tool or soldering iron build the power path: supply plus, fuse {main:g} A, relay "
            f"contact, then for each motor a fuse of "
            f"{own:g} A and its plug; the capacitor across the motors' side. Wires: {electronics.pick_wire(main)} up "
            f"to the fuse block, {electronics.pick_wire(own)} from there. The relay's coil is fed from behind the "
            f"{main:g} A fuse through the emergency stop button, which stays in until it is turned; the diode lies "
            "across the coil, its ring to plus. Released, the button gives the motors power again: stand clear. The "
            "leads run along the arm.",
            "Screw supply, relay, fuse block, adapter and the items of the servo to the floor of the enclosure, which "
            "stands beside the arm: the supply along one side, the others beside it, 15 mm apart. The cable glands go "
            "into the knock-outs of one wall. Each lead goes through a gland of its own, which clamps its sheath, with "
            "a loop of 40 mm behind it. An enclosure of metal is earthed before mains is connected. A gentle pull by "
            "hand moves no lead. The lid is closed whenever mains is on.",
            f"Give the motors the ids 1 to {n} with their switches, by the motor's manual, and write the number on "
            "each. Motor k winds cable k. No motor of another kind (M3508, M2006) may share this bus: their ids "
            "overlap.",
            f"Chain the bus: adapter, motor 1, and so on to motor {n}: H to H, L to L, and ground. 120 ohm at the "
            f"adapter (its jumper) and 120 ohm at motor {n} (its switch, or the resistor).",
            "Power off: measure with a multimeter 55 to 65 ohm between H and L.",
            "Clamp the motors between soft jaws, rotors free. Set a bench supply with a current limit to 24 V and 1 A, "
            "connect it instead of the big supply, and switch on. Send no command. It feeds relay coil and idle motors "
            "alone; the converter of the next step is not connected yet. If it reaches its limit, 2 A are still "
            "harmless: we have not measured what idle motors take.",
            "On a Linux computer (`candump` is in the package can-utils): `sudo ip link set can0 up type can bitrate "
            "1000000`, then `candump can0`.",
            "Turn each rotor by hand: bytes 0 and 1 of its frame are the angle, 0 to 8191, high byte first. Note for "
            "each motor whether it rises when the rotor turns anticlockwise, seen from above the rotor.",
        ),
        check=f"`candump` shows the frames {ids} and no other; the emergency stop ends them at once; no motor is warm "
        "after 10 min.",
    )  # fmt: skip


def _servo(_: Build) -> Step:
    return Step(
        title="Set the servo to its middle", needs=("measured motors",),
        makes=("servo at its middle",), takes=(electronics.SERVO,),
        work=(
            "Feed the converter from behind the main fuse, before the relay, through its own fuse: the gripper keeps "
            "its hold when the motors are cut. For this step the bench supply (24 V, 1 A) feeds it, the motors "
            "unplugged. Set it to 5.0 V by the multimeter before the servo is connected. Its ground and the servo "
            "driver's are joined.",
            "With the driver's own program, on a computer with USB, send 1500 us at 50 Hz: the "
            "middle. Then 1400 and 1600 us, and wider in "
            "steps of 50 us, up to 1000 and 2000 us. Stop where the servo hums against its end and note the two "
            "pulses.",
            "Go back to 1500 us and switch off. Do not turn the shaft by hand any more.",
        ),
        check="the shaft turns about 90 deg to either side of the middle. If less, the fingers will not shut fully "
            "with "
        "this double arm: export again with the smaller of the two angles as `turn` (see \"Other dimensions\") and "
        "print the file `horn` alone again, with a longer arm.",
    )  # fmt: skip


def _inserts(_: Build) -> Step:
    return Step(
        title="Melt the inserts in",
        needs=("printed housing", "printed adapter"), makes=("housing with inserts", "adapter with inserts"),
        takes=("inserts of the adapter", "inserts of the housing"),
        work=(
            "Set a soldering iron with insert tip to 20 degC above the filament's printing temperature. M4 into the "
            "flat side of the adapter, M3 into "
            "the ends of the posts inside the housing. Let each sink by its weight until it is flush.",
            "Press each level with a cold metal plate while the plastic sets.",
        ),
        check="a screw turns in by hand, at a right angle to the face, to its full length.",
    )  # fmt: skip


def _motors(build: Build) -> Step:
    places = join(
        [f"motor {k + 1} at {math.degrees(angle):.0f} deg" for k, angle in enumerate(motor_angles(build.design))]
    )
    share = 100 * (12.0 * build.design.n_cable + 20.0) / PORT**2  # Pairs of wires 5 x 2.4 mm; bus, servo, threads.
    cables = join([f"{math.degrees(angle):.0f}" for angle in build.design.cable.angles]) + " deg"
    return Step(
        title="Motors into the housing",
        needs=("housing with inserts", "adapter with inserts", "checked motors", "printed lid", "printed drums",
               *(("printed double arm", "servo at its middle") if build.has_gripper else ())),
        makes=("housing with motors",), takes=("motor to housing",),
        work=(
            f"Hold the housing open side up. Draw the dorsal mark with a pen on the rim {_say_dorsal(build)}. "
            f"Anticlockwise from the mark stand {places}, each over its hole in the floor, and guide and "
            f"cable k at {cables}. All angles in this guide are counted so; `pictures/top_view.svg` shows them.",
            "Stand each motor on the floor, turn it until its plugs point to the middle, and screw it from below with "
            f"four screws and the {name_key('M4', is_sunk=True)}, crosswise. No thread lock: it attacks the plastic.",
            f"Lead all wires out through the opening of {PORT:g} x {PORT:g} mm; tie them to the nearest post, clear of "
            "the rotors. One after the other, a plug at a time; a plug that does not pass is cut off and put on again "
            f"outside. Later {'the lead of the servo and ' * build.has_gripper}the threads of the drums' tapes pass "
            f"here too: by our estimate all of them fill {share:.0f} % of the opening.",
            f"On a scale to 10 g, weigh it together with lid, drums, adapter, "
            f"{'double arm, servo, ' * build.has_gripper}and the bag of "
            "their screws. In kg: a new line `mass_kg = ...` in the section `[housing]` of `trunk.toml`.",
        ),
        check="every rotor turns a full turn by hand without touching a wire, and `candump` still shows all frames.",
    )  # fmt: skip


def _say_dorsal(build: Build) -> str:
    """Where dorsal lies on the housing's rim: over a post, where cable 1 is dorsal."""
    layout, step = find_layout(build.design, build.options), 2 * math.pi / build.design.n_cable
    if math.isclose(layout.posts[0], step):
        port = math.degrees(find_port(layout))
        return (
            f"over one of the posts: the one from which the opening for the wires lies {port:.0f} deg anticlockwise, "
            "seen from above, just past the next post"
        )
    past = math.degrees(layout.posts[0] % (2 * math.pi))
    return f"{past:.0f} deg clockwise, seen from above, from the post just past which the opening for the wires lies"


def _neck(build: Build) -> Step:
    n, long = build.design.n_cable, math.ceil((1e3 * build.design.housing.neck_length + 30) / 50) * 50
    wires = f"{n} rows" + (" and 2 through the channel on the axis, one from each of its holes in the tip's socket"
                           if build.has_gripper else "")  # fmt: skip
    return Step(
        title="Neck onto section 1", needs=("weighed trunk", "clear neck"),
        makes=("trunk with neck",), takes=("neck to section 1",),
        work=(
            "Mark dorsal on the trunk with a pen. With a gripper it is the cable hole half-way "
            "between the two slots of the socket in the tip; without one, any hole of cable 1. The cables are counted "
            "anticlockwise from dorsal, seen from the tip.",
            "Put section 1 into the neck's funnel: cable holes over cable holes, screw holes over screw holes. Copy "
            "the dorsal mark to the neck.",
            "Push each nut with tweezers through the first gap into its pocket in the far face of section 1. Put the "
            f"screws in from inside the neck, through its open foot, with a {name_key('M4', long=long)}: its long arm "
            "reaches the heads, its short arm is the handle. Tighten them in turn, by two fingers only.",
            "Pull wires, while the neck is open: cut soft steel wire 0.3 mm thick into pieces of "
            f"{build.pull_wire} mm, one for each of the {wires}. Push each from the tip to the base, across the gaps "
            "with tweezers, into the neck and out at its foot, and bend both ends over. They stay in until a "
            "cable or strand takes their place: nobody hits a hole of the lid through the closed neck. Mark the wire "
            "of each cable with its number on masking tape.",
        ),
        check="the seam is shut all round, the first gap still closes to every side (no nut or screw stands out), and "
        "every pull wire slides.",
    )  # fmt: skip


def _lid(build: Build) -> Step:
    layout = find_layout(build.design, build.options)
    high = math.ceil((layout.height - layout.groove + 10.0) / 10) * 10
    middle = " the two wires from the axis through the hole in its middle," * build.has_gripper
    servo = math.degrees(find_servo(build.design, build.options)) if build.has_gripper else 0.0
    turned = (
        f" The lid fits in {build.design.n_cable} ways: take the one in which the servo's bracket stands "
        f"{servo:.0f} deg anticlockwise of dorsal, seen from the tip, near the opening for the wires."
    ) * build.has_gripper
    return Step(
        title="Neck onto the lid", needs=("trunk with neck", "printed lid"),
        makes=("trunk on the lid",), takes=("neck to lid",),
        work=(
            f"Lay the lid with its rim on two blocks of {high:.0f} mm, flat face up, guides down and free between the "
            f"blocks.{turned}",
            f"Bring the foot of the neck over it: pull wire k through the lid's hole over guide k,{middle} "
            "then set the foot down, each cable hole of the neck over a guide. Copy the dorsal mark to the lid's edge.",
            f"Screws from above with a {name_key('M4')}, nuts from below with a {name_spanner('M4')}, tightened "
            "crosswise.",
        ),
        check="every pull wire sticks out of its own guide and slides.",
    )  # fmt: skip


def _bracket(build: Build) -> Step:
    gripper = build.design.gripper
    fingers, legs = (0, 1) if gripper is None else (gripper.n_finger, gripper.n_leg)
    return Step(
        title="Servo, double arm and the gripper's strands",
        needs=("trunk on the lid", "servo at its middle", "printed double arm"), makes=("trunk with strands",),
        takes=("gripper",),
        work=(
            "Servo (and its screws, all from the servo's own bag) into the opening of the lid's bracket, shaft towards "
            "the axis. The two screws of its lugs cut their thread into the holes of 1.8 mm of the bracket, from the "
            "shaft's side, with a small screwdriver.",
            "Clear the two outer holes of the double arm (file `horn`) with a drill 1.2 mm. Double arm onto the "
            "servo's "
            "round horn with two short screws of the bag. Press the horn on the shaft so that the double arm lies "
            "parallel to the lid and to the bracket's wall, and fix it with the centre screw. Do not turn the shaft to "
            "get there: move the horn by one tooth.",
            f"Two groups of {fingers * legs} strands. Blacken the free ends of one group over 100 mm with a pen: "
            "CLOSE; the other stays white: OPEN. Knot each group together at one end (a figure of eight), push the "
            "other ends "
            f"with tweezers through the hole at one end of the double arm, "
            f"{find_arm(build.design, build.options):.1f} mm from the shaft. The knot stays on the face away from the "
            "servo. The other group through the other hole.",
            "Twist each group, one turn per 10 mm. Lap its strands one behind the other, 10 mm apart, on the end of "
            "one of the two pull wires in the lid's middle hole, with cyanoacrylate glue; let it dry and draw both "
            f"groups through, one after the other. {_say_channel(build)}They come out in the socket of the tip; cut "
            "the laps off behind the black.",
        ),
        check="either group slides when a weight of 50 g hangs on it, and they do not turn round each other.",
    )  # fmt: skip


def _say_channel(build: Build) -> str:
    """Where the gripper's two groups part."""
    hollow = build.body.n_hollow
    if hollow >= build.design.n_joint:
        return ""
    inside = f"inside joints 1 to {hollow} and " if hollow else ""
    gripper = build.design.gripper
    sides = "one group on each side"
    if gripper is not None and gripper.n_leg > 1:
        sides = (
            f"half of each group on each side: part each group into two bundles of {gripper.n_finger} strands before "
            "it is drawn, and draw the two bundles of a group through opposite holes of the four"
        )
    return f"They run {inside}beside the thinner joints from {hollow + 1} on, {sides}. "


def _flange(_: Build) -> Step:
    return Step(
        title="Prepare the arm's flange", makes=("flange facing up",),
        work=(
            "Bring the arm into a pose with its flange up, brakes on, power off; it stays off until the payload is "
            "set. From here on the robot is built on the arm, or on a plate with the same holes: the adapter's screws "
            "lie under the housing.",
            "Choose the tilt now. Between flange and the wedge under the adapter, wedges can be added and taken away "
            "later; the screws of the adapter are covered as soon as the housing stands on it. Who may want another "
            "tilt later puts the adapter on a wedge now (untried).",
        ),
        check="the flange does not move when it is pushed by hand.",
    )  # fmt: skip


def _wedge(_: Build) -> Step:
    return Step(
        title="Only to measure at a tilt: the wedges",
        needs=("clear wedges", "flange facing up"),
        makes=("tilted flange",), takes=("wedge to flange or bench", "adapter or wedge onto wedge"),
        work=(
            "None, one, two or three wedges tilt the base by 0, 45, 90 or 135 deg from hanging. Without tilt, go on.",
            f"First wedge onto the flange (or bench) with the four M6 x 16 and the {name_key('M6')}. Each further "
            f"wedge "
            f"onto it with four M6 x 20 and nuts (with a {name_spanner('M6')}), thin side over thin side. The next "
            f"step "
            "fixes the adapter to the last wedge in the same way, instead of to the flange, and without the dowel.",
            "The trunk swings towards the thin side, and the protocol wants it to swing to dorsal: turn the adapter so "
            "that its dowel hole, which marks dorsal, lies over the thin side.",
            "The M6 x 16 enter the flange by 10 mm: compare the depth of its threads.",
        ),
        check="an angle gauge on the last plate reads the tilt to 1 deg.",
    )  # fmt: skip


def _adapter(build: Build) -> Step:
    roll = math.degrees(build.design.arm.roll)
    return Step(
        title="Adapter onto the arm's flange",
        needs=("adapter with inserts", "flange facing up"),
        makes=("adapter on the flange",), takes=("adapter to the arm's flange",),
        work=(
            "The hole of the dowel marks dorsal, and the mounted adapter hides it: with a pen draw a dorsal mark on "
            "the adapter's edge beside it.",
            f"Dowel into the flange, spigot into its recess, four screws with the {name_key('M6')} from the flat side. "
            f"They enter the flange by "
            f"{12.0 - (ADAPTER - SPIGOT_SEAT):g} mm: compare the depth of its threads.",
            f"The models assume dorsal {roll:g} deg from the x axis of the arm's flange "
            "(`arm.roll_deg`). Measure it on your arm and correct the number in `trunk.toml`.",
        ),
        check="no screw head stands above the flat side, and the adapter does not rock.",
    )  # fmt: skip


def _cup(build: Build) -> Step:
    long = math.ceil((find_layout(build.design, build.options).height - build.options.plate + 10) / 10) * 10
    return Step(
        title="Housing onto the adapter",
        needs=("housing with motors", "adapter on the flange"), makes=("housing on the arm",),
        takes=("housing to adapter",),
        work=(
            "Stand the housing on the adapter, dorsal mark over dorsal mark (with wedges: over the thin side).",
            f"Screws from above, between the motors, with the long arm of a {name_key('M4', long=long)}, turned by its "
            "short arm.",
        ),
        check="the housing does not rock, and every rotor still turns freely.",
    )  # fmt: skip
