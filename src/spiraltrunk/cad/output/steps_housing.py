"""Steps of the guide from the electronics on the bench to the housing on the arm."""

from __future__ import annotations

import math

from spiraltrunk.cad.components.fasteners import THREADS
from spiraltrunk.cad.components.options import ADAPTER
from spiraltrunk.cad.housing.housing import PORT, SPIGOT_SEAT
from spiraltrunk.cad.housing.layout import find_layout
from spiraltrunk.cad.housing.winder import find_arm, motor_angles
from spiraltrunk.cad.output import electronics
from spiraltrunk.cad.output.step import Build, Step, join, name_key, name_spanner

TORQUES = ", ".join(f"{name} {thread.torque:g} N m" for name, thread in THREADS.items())
"""Torque of each thread, as the guide says it."""

_FEEDBACK = 0x204
"""CAN id of a motor's feedback less its own id (GM6020, public drivers)."""


def list_housing_steps(build: Build) -> list[Step]:
    """The steps from the electronics to the open housing on the arm, with the trunk on its lid beside it."""
    steps = [_power(build), *([_servo()] if build.has_gripper else []), _inserts(), _motors(build), _neck(), _lid()]
    if build.has_gripper:
        steps.append(_bracket(build))
    return [*steps, _wedge(), _adapter(build), _cup(build)]


def _power(build: Build) -> Step:
    design, options = build.design, build.options
    n, own, main = design.n_cable, electronics.motor_fuse(options), electronics.main_fuse(design, options)
    ids = join([f"0x{_FEEDBACK + k:X}" for k in range(1, n + 1)])
    return Step(
        title="Wire the motors on the bench, without cables or drums", groups=frozenset({"housing"}),
        needs=("measured motors",), makes=("checked motors",), takes=(electronics.MOTORS,),
        tools=("multimeter", "crimping tool or soldering iron", "bench supply with a current limit", "Linux computer"),
        work=(
            f"Build the power path: supply plus, fuse {main:g} A, relay contact, then for each motor a fuse of "
            f"{own:g} A and its plug; the capacitor across the motors' side. Wires: {electronics.pick_wire(main)} up "
            f"to the fuse block, {electronics.pick_wire(own)} from there. The relay's coil is fed from behind the "
            f"{main:g} A fuse through the emergency stop button, which stays in until it is turned; the diode lies "
            "across the coil, its ring to plus. Released, the button gives the motors power again: stand clear.",
            f"Give the motors the ids 1 to {n} with their switches, by the motor's manual, and write the number on "
            "each. Motor k winds cable k. No motor of another kind (M3508, M2006) may share this bus: their ids "
            "overlap.",
            f"Chain the bus: adapter, motor 1, and so on to motor {n}: H to H, L to L, and ground. 120 ohm at the "
            f"adapter (its jumper) and 120 ohm at motor {n} (its switch, or the resistor).",
            "Power off: measure 55 to 65 ohm between H and L.",
            "Clamp the motors between soft jaws, rotors free. Set the bench supply to 24 V and 1 A instead of the big "
            "supply, and switch on. Send no command.",
            "`sudo ip link set can0 up type can bitrate 1000000`, then `candump can0`.",
            "Turn each rotor by hand: bytes 0 and 1 of its frame are the angle, 0 to 8191, high byte first. Note for "
            "each motor whether it rises when the rotor turns anticlockwise, seen from above the rotor.",
        ),
        check=f"`candump` shows the frames {ids} and no other; the emergency stop ends them at once; no motor is warm "
        "after 10 min.",
    )  # fmt: skip


def _servo() -> Step:
    return Step(
        title="Set the servo to its middle", groups=frozenset({"horn", "housing"}), needs=("measured motors",),
        makes=("servo at its middle",), takes=(electronics.SERVO,), tools=("multimeter", "computer"),
        work=(
            "Feed the converter from behind the main fuse, before the relay, through its own fuse: the gripper keeps "
            "its hold when the motors are cut. Set it to 5.0 V before the servo is connected. Its ground and the servo "
            "driver's are joined.",
            "With the driver's own program send 1500 us at 50 Hz: the middle. Then 1400 and 1600 us, and wider in "
            "steps of 50 us, up to 1000 and 2000 us. Stop where the servo hums against its end and note the two "
            "pulses.",
            "Go back to 1500 us and switch off. Do not turn the shaft by hand any more.",
        ),
        check="the shaft turns about 90 deg to either side of the middle. If less, note the angle: the fingers will "
        "not shut fully.",
    )  # fmt: skip


def _inserts() -> Step:
    return Step(
        title="Melt the inserts in", groups=frozenset({"housing", "adapter"}),
        needs=("printed housing", "printed adapter"), makes=("housing with inserts", "adapter with inserts"),
        takes=("inserts of the adapter", "inserts of the housing"), tools=("soldering iron with insert tip",),
        work=(
            "Iron at 20 degC above the filament's printing temperature. M4 into the flat side of the adapter, M3 into "
            "the ends of the posts inside the housing. Let each sink by its weight until it is flush.",
            "Press it level with a cold metal plate while the plastic sets.",
        ),
        check="a screw turns in by hand, at a right angle to the face, to its full length.",
    )  # fmt: skip


def _motors(build: Build) -> Step:
    places = join(
        [f"motor {k + 1} at {math.degrees(angle):.0f} deg" for k, angle in enumerate(motor_angles(build.design))]
    )
    return Step(
        title="Motors into the housing", groups=frozenset({"housing"}),
        needs=("housing with inserts", "checked motors"),
        makes=("housing with motors",), takes=("motor to housing",),
        tools=(name_key("M4", is_sunk=True), "pen", "scale"),
        work=(
            "Hold the housing open side up. Choose one of its posts and draw the dorsal mark on the rim there. "
            f"Anticlockwise from the mark, seen from above, stand {places}, each over its hole in the floor. All "
            "angles in this guide are counted so.",
            "Stand each motor on the floor, turn it until its plugs point to the middle, and screw it from below with "
            "four screws, crosswise. No thread lock: it attacks the plastic.",
            f"Lead all wires out through the opening of {PORT:g} x {PORT:g} mm; tie them to the nearest post, clear of "
            "the rotors. A plug that does not pass is cut off and put on again outside.",
            f"Weigh it together with lid, drums, adapter, {'double arm, servo, ' * build.has_gripper}and the bag of "
            "their screws. In kg: `housing.mass_kg`.",
        ),
        check="every rotor turns a full turn by hand without touching a wire, and `candump` still shows all frames.",
    )  # fmt: skip


def _neck() -> Step:
    return Step(
        title="Neck onto section 1", groups=frozenset({"trunk", "housing"}), needs=("weighed trunk", "printed neck"),
        makes=("trunk with neck",), takes=("neck to section 1",), tools=(name_key("M4"), "tweezers"),
        work=(
            "Take the supports out of the neck. Mark dorsal on the trunk. With a gripper it is the cable hole half-way "
            "between the two slots of the socket in the tip; without one, any hole of cable 1. The cables are counted "
            "anticlockwise from dorsal, seen from the tip.",
            "Put section 1 into the neck's funnel: cable holes over cable holes, screw holes over screw holes. Copy "
            "the dorsal mark to the neck.",
            "Push each nut with tweezers through the first gap into its pocket in the far face of section 1. Put the "
            "screws in from inside the neck and tighten them in turn.",
        ),
        check="the seam is shut all round, and the first gap still closes to every side: no nut or screw stands out.",
    )  # fmt: skip


def _lid() -> Step:
    return Step(
        title="Neck onto the lid", groups=frozenset({"housing"}), needs=("trunk with neck", "printed lid"),
        makes=("trunk on the lid",), takes=("neck to lid",), tools=(name_key("M4"), name_spanner("M4")),
        work=(
            "Lid with its flat face up, guides down. Foot of the neck on it: each cable hole of the neck over a guide. "
            "Copy the dorsal mark to the lid's edge.",
            "Screws from above, nuts from below, tightened crosswise.",
        ),
        check="a straight wire goes through each guide, the neck and section 1.",
    )  # fmt: skip


def _bracket(build: Build) -> Step:
    gripper = build.design.gripper
    fingers = 0 if gripper is None else gripper.n_finger
    return Step(
        title="Servo, double arm and the gripper's strands", groups=frozenset({"horn", "housing", "gripper"}),
        needs=("trunk on the lid", "servo at its middle", "printed double arm"), makes=("trunk with strands",),
        takes=("gripper",), tools=("screwdriver of the servo's screws", "drill 1.2 mm", "tweezers"),
        work=(
            "Servo into the opening of the lid's bracket, shaft towards the axis, with its own two screws.",
            "Double arm onto the servo's round horn with the two short screws of the servo's set. Press the horn on "
            "the shaft so that the arm stands across the bracket, level with the lid, and fix it with the centre "
            "screw. Do not turn the shaft to get there: move the horn by one tooth.",
            f"Two groups of {fingers} strands. Knot each group together at one end (a figure of eight), push the other "
            f"ends through the hole at one end of the double arm, {find_arm(build.design, build.options):.1f} mm from "
            "the shaft. The knot stays on the "
            "face away from the servo. The other group through the other hole.",
            "Twist each group, one turn per 10 mm. Lead both through the hole in the middle of the lid and the neck, "
            f"then along the trunk's axis. {_say_channel(build)}They come out in the socket of the tip. Put a tape "
            "flag on each: CLOSE and OPEN.",
        ),
        check="either group slides when a weight of 50 g hangs on it, and they do not turn round each other.",
    )  # fmt: skip


def _say_channel(build: Build) -> str:
    """Where the gripper's two groups part."""
    hollow = build.body.n_hollow
    if hollow >= build.design.n_joint:
        return ""
    inside = f"inside joints 1 to {hollow} and " if hollow else ""
    return f"They run {inside}beside the thinner joints from {hollow + 1} on, one group on each side. "


def _wedge() -> Step:
    return Step(
        title="Only to measure at a tilt: the wedges", groups=frozenset({"wedge"}), needs=("printed wedges",),
        makes=("tilted flange",), takes=("wedge to flange or bench", "adapter or wedge onto wedge"),
        tools=(name_key("M6"), name_spanner("M6"), "angle gauge"),
        work=(
            "None, one, two or three wedges tilt the base by 0, 45, 90 or 135 deg from hanging. Without tilt, go on.",
            "First wedge onto the flange (or bench) with the four M6 x 16. Each further wedge onto it with four M6 x "
            "20 and nuts, thin side over thin side. The next step fixes the adapter to the last wedge in the same way, "
            "instead of to the flange, and without the dowel.",
            "The trunk swings towards the thin side, and the protocol wants it to swing to dorsal: turn the adapter so "
            "that its dowel hole, which marks dorsal, lies over the thin side.",
            "The M6 x 16 enter the flange by 10 mm: compare the depth of its threads.",
        ),
        check="the gauge on the last plate reads the tilt to 1 deg.",
    )  # fmt: skip


def _adapter(build: Build) -> Step:
    roll = math.degrees(build.design.arm.roll)
    return Step(
        title="Adapter onto the arm's flange", groups=frozenset({"adapter"}), needs=("adapter with inserts",),
        makes=("adapter on the flange",), takes=("adapter to the arm's flange",), tools=(name_key("M6"),),
        work=(
            "Bring the arm into a pose with its flange up, brakes on, power off. From here on the robot is built on "
            "the arm, or on a plate with the same holes: the adapter's screws lie under the housing.",
            f"Dowel into the flange, spigot into its recess, four screws from the flat side. They enter the flange by "
            f"{12.0 - (ADAPTER - SPIGOT_SEAT):g} mm: compare the depth of its threads.",
            f"The dowel marks dorsal. The models assume dorsal {roll:g} deg from the x axis of the arm's flange "
            "(`arm.roll_deg`). Measure it on your arm and correct the number in `trunk.toml`.",
        ),
        check="no screw head stands above the flat side, and the adapter does not rock.",
    )  # fmt: skip


def _cup(build: Build) -> Step:
    long = math.ceil((find_layout(build.design, build.options).height - build.options.plate + 10) / 10) * 10
    return Step(
        title="Housing onto the adapter", groups=frozenset({"housing", "adapter"}),
        needs=("housing with motors", "adapter on the flange"), makes=("housing on the arm",),
        takes=("housing to adapter",), tools=(f"{name_key('M4')}, {long} mm long",),
        work=(
            "Stand the housing on the adapter, dorsal mark over the dowel (with wedges: over the thin side).",
            "Screws from above, between the motors, with the long key.",
        ),
        check="the housing does not rock, and every rotor still turns freely.",
    )  # fmt: skip
