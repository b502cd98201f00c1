"""Electronics: supply, bus, servo driver, fuses and wires, sized by the number of motors and their current.

All choices are ours and untried: no motor was powered. Sizes follow from `Motor.current` at 24 V.
"""

from __future__ import annotations

import math

from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.output.enclosure import list_enclosure
from spiraltrunk.cad.output.purchase import Purchase
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, Unquoted

VOLTAGE = 24.0
"""Supply of the GM6020 [V] (maker's data)."""

_FUSES = (2.0, 3.0, 5.0, 7.5, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0)
"""Currents of blade fuses [A] (ISO 8820)."""

_WIRES = ((5.0, "0.75 mm2 (18 AWG)"), (10.0, "1.5 mm2 (16 AWG)"), (20.0, "2.5 mm2 (14 AWG)"), (40.0, "6 mm2 (10 AWG)"))
"""Largest fuse [A] and wire behind it (ours: open air, up to 3 m)."""

MOTORS, SERVO = "electronics of the motors", "electronics of the servo"
"""Places of these rows."""


def motor_fuse(options: MakeOptions) -> float:
    """Fuse of one motor [A]: the next above 1.25 times its current (ours)."""
    return _pick_fuse(1.25 * options.motor.current, 1.25)


def main_fuse(design: TrunkDesign, options: MakeOptions) -> float:
    """Fuse of all motors [A]: the next above 1.1 times their current (ours)."""
    return _pick_fuse(1.1 * design.n_cable * options.motor.current, 1.1 * design.n_cable)


def supply_current(design: TrunkDesign, options: MakeOptions) -> float:
    """Least current of the supply [A]: that of the main fuse and a fifth more, for the servo and losses (ours)."""
    return math.ceil(1.2 * main_fuse(design, options))


def pick_wire(fuse: float) -> str:
    """Cross-section of a wire behind a fuse [A]."""
    return next(wire for most, wire in _WIRES if fuse <= most)


def list_electronics(design: TrunkDesign, options: MakeOptions) -> list[Purchase]:
    """Supply, emergency stop, fuses, wires and bus of the motors."""
    n, main, own = design.n_cable, main_fuse(design, options), motor_fuse(options)
    supply = supply_current(design, options)
    peak = f"{n} motors of {options.motor.current:g} A"
    rows = (
        (1, "power supply, protected against overload", f"{VOLTAGE:g} V DC, {supply:g} A or more", peak),
        (1, "emergency stop button", "1 normally closed contact", "within reach of the operator, in the relay's coil"),
        (1, "relay or contactor", f"coil {VOLTAGE:g} V DC, contact {2 * main:g} A at {VOLTAGE:g} V DC or more",
         "cuts the motors' plus; a contact rated for AC alone does not open at DC"),
        (1, "diode 1N4007", "1 A, 1000 V", "across the relay's coil, ring to plus"),
        (1, "capacitor", "1000 uF, 50 V", "across the motors' supply: a motor that is pulled round feeds back"),
        (1, "blade fuse with holder", f"{main:g} A", "from the supply to the relay"),
        (n, "blade fuse with holder", f"{own:g} A", "one a motor, behind the relay"),
        (1, "pair of wires, red and black", f"{pick_wire(main)}, 2 m", "supply, main fuse, relay, fuse block"),
        (n, "pair of wires, red and black", f"{pick_wire(own)}, 3 m", "fuse block to motor, along the arm"),
        (1, "pair of wires", f"{pick_wire(2.0)}, 3 m", "emergency stop button and relay's coil"),
        (n, "power plug of the motor", "XT30 by its manual: compare", "often comes with the motor"),
        (1, "USB-CAN adapter", "gs_usb (candleLight), 1 Mbit/s",
         "SocketCAN on Linux; or a RoboMaster development board as bus master, as in the paper"),
        (n, "CAN cable, twisted pair", "0.25 mm2 (24 AWG); 3 m to motor 1, 0.3 m from motor to motor",
         "with the motor's plug; often comes with it"),
        (1, "resistor", "120 ohm, 0.25 W", "far end of the bus, unless the last motor's own is switched on"),
    )  # fmt: skip
    box = list_enclosure(n, MOTORS, power=VOLTAGE * supply, has_servo=design.gripper is not None)
    return box + [
        Purchase(kind="electronics", item=item, count=count, size=size, place=MOTORS, note=note)
        for count, item, size, note in rows
    ]


def list_servo_electronics() -> list[Purchase]:
    """Supply and driver of the gripper's servo."""
    rows = (
        (1, "servo driver with USB", "1 channel, 50 Hz, 1000 to 2000 us",
         "a servo controller, or the RoboMaster development board's PWM output"),
        (1, "step-down converter", f"{VOLTAGE:g} V to 5 V, 3 A", "feeds the servo, not the USB port"),
        (1, "blade fuse with holder", "2 A", "before the converter"),
        (1, "pair of wires, red and black", f"{pick_wire(2.0)}, 1 m", "main fuse to converter, converter to driver"),
        (1, "servo extension lead", "3 x 0.34 mm2 (22 AWG), 3 m", "servo to driver, along the arm"),
    )  # fmt: skip
    return [
        Purchase(kind="electronics", item=item, count=count, size=size, place=SERVO, note=note)
        for count, item, size, note in rows
    ]


def _pick_fuse(least: float, share: float) -> float:
    """The next fuse from ``least`` [A], which is ``share`` times the current of one motor.

    Raises:
        DesignError: where there is none.
    """
    found = next((fuse for fuse in _FUSES if fuse >= least), None)
    if found is None:
        allowed = f"at most {_FUSES[-1] / share:.3g} A, for a blade fuse of {_FUSES[-1]:g} A"
        raise DesignError("motor.current", got=Unquoted(f"{least / share:g} A"), allowed=allowed)
    return found
