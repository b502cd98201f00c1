"""Options of making the parts, and dimensions of the purchased components."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import final

from spiraltrunk.checks import check_count, check_number
from spiraltrunk.design.drum import DrumOptions
from spiraltrunk.errors import DesignError
from spiraltrunk.field_docs import explain_fields

ADAPTER = 10.0
"""Thickness of the adapter without its spigot [mm] (ours: room for the heads of the M6 screws)."""

_DRUM = DrumOptions()


MOST_MOTORS = 7
"""GM6020 motors on one bus: ids 1 to 7 (maker's manual) [-]."""

_MOST_LENGTH = 1000.0
"""Every dimension of a component is below this [mm] (ours): a slip of the unit is refused."""

_LEAST_TURN = 10.0
"""Least rotation of a servo to either side [deg] (ours): the double arm is six times as long as at 90 deg."""


def _check_lengths(prefix: str, lengths: object, names: tuple[str, ...], *, least: float | None = None) -> None:
    """Refuse lengths [mm] that are not positive, or below ``least`` where it is given, or not below `_MOST_LENGTH`."""
    above, least = (0.0, -math.inf) if least is None else (-math.inf, least)
    for name in names:
        check_number(f"{prefix}{name}", getattr(lengths, name), above=above, least=least, below=_MOST_LENGTH)


def to_mm(length: float) -> float:
    """A length [m] in mm, without the rounding error that the multiplication adds to a decimal."""
    return round(1e3 * length, 12)


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Motor:
    """Motor of the winders, RoboMaster GM6020, in mm."""

    diameter: float = to_mm(_DRUM.motor_diameter)
    """Outer diameter (maker's data)."""
    height: float = 45.0
    """Height with rotor (maker's data)."""
    floor_circle: float = 56.0
    """Pitch circle of the four M4 screws that hold it to the floor: unconfirmed, measure your motor."""
    rotor_circle: float = to_mm(_DRUM.rotor_circle)
    """Pitch circle of the four M3 screws that hold the drum: unconfirmed, measure your motor."""
    current: float = 3.0
    """Largest current [A] (maker's data)."""
    torque: float = _DRUM.torque_max
    """Largest torque [N m] (0.741 N m/A at 3 A)."""

    def __post_init__(self) -> None:
        _check_lengths("motor.", self, ("diameter", "height", "floor_circle", "rotor_circle"))
        check_number("motor.current", self.current, above=0.0, most=100.0)
        check_number("motor.torque", self.torque, above=0.0, below=1e4)


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Servo:
    """Servo of the gripper, DS-929MG, 9 g class; without a data sheet, so all is unconfirmed. In mm."""

    length: float = 23.0
    """Length of the body."""
    width: float = 12.2
    """Width of the body."""
    lug_pitch: float = 28.0
    """Distance between the screws in its lugs."""
    shaft_offset: float = 5.9
    """Distance of the shaft from the near end of the body."""
    hub_diameter: float = 7.2
    """Diameter of the hub of its round horn, onto which the double arm is screwed."""
    turn: float = 90.0
    """Rotation to either side [deg] (paper: 90 deg open, 90 deg closed)."""

    def __post_init__(self) -> None:
        _check_lengths("servo.", self, ("length", "width", "lug_pitch", "hub_diameter"))
        check_number("servo.shaft_offset", self.shaft_offset, least=0.0, most=self.length)
        check_number("servo.turn", self.turn, least=_LEAST_TURN, most=180.0)

    @property
    def aside(self) -> float:
        """Offset of the body's middle from the shaft."""
        return self.length / 2 - self.shaft_offset

    @property
    def bracket(self) -> float:
        """Width of its bracket (ours)."""
        return self.lug_pitch + 8.0


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Flange:
    """Robot flange ISO 9409-1-50-4-M6, in mm."""

    pitch_circle: float = 50.0
    """Circle of the four M6 screws (the standard's designation)."""
    pilot: float = 31.5
    """Centring recess in the robot's flange (the standard: H7)."""
    pilot_height: float = 4.0
    """Height of the adapter's spigot (ours: less than the depth of the recess)."""
    dowel: float = 6.0
    """Dowel hole, on the pitch circle, 45 deg from the screws (the standard: H7)."""
    outer: float = 63.0
    """Outer diameter of the robot's flange (the standard)."""

    def __post_init__(self) -> None:
        _check_lengths("flange.", self, ("pitch_circle", "pilot", "pilot_height", "dowel", "outer"))


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Remedies:
    """What refusals advise, in the words of where a person sets it; by default those of the command line."""

    nozzle: str = "a finer --nozzle-mm"
    """How walls may be thinner."""
    bed: str = "a larger --bed-mm"
    """How parts may be larger."""
    tall_bed: str = "a larger --bed-mm Z"
    """How parts may be taller."""
    tolerance: str = "a finer --tolerance-mm"
    """How meshes come nearer to the solids."""
    bare: str = "no [gripper]"
    """How a trunk has no gripper."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class MakeOptions:
    """Options of making the parts; lengths in mm."""

    nozzle: float = 0.4
    """Diameter of the nozzle; walls and elastic joints are at least two of it."""
    bed: tuple[float, float, float] = (256.0, 256.0, 256.0)
    """Build volume of the printer (Bambu X1-Carbon, the paper's)."""
    tolerance: float = 0.05
    """Largest deviation of the meshes from the solids."""
    seed: int = 0
    """Seed of the wrinkles of the shells."""
    cable: float = to_mm(_DRUM.cable_diameter)
    """Diameter of the UHMWPE cables (ours: braid of some 500 N)."""
    hole_play: float = 0.5
    """Diametral clearance of a cable in its hole (ours)."""
    shell_depth: float = 0.2
    """Share of a section's radius that the silicone shell replaces [-] (paper: 20 % of the periphery is cut off, which
    we read as a fifth of the radius)."""
    shell_grip: float = 0.03
    """Relative undersize of a shell's inner radius to its seat, so that it grips [-] (ours)."""
    n_wrinkle: int = 9
    """Horizontal cuts in each shell (ours; the paper gives no number)."""
    clearance: float = to_mm(_DRUM.motor_clearance)
    """Clearance between mating parts (ours)."""
    plate: float = 5.0
    """Thickness of plates that carry motors and arm (ours)."""
    rim: float = 2.4
    """Thickness of the housing's wall (ours: six lines of 0.4 mm)."""
    motor: Motor = field(default_factory=Motor)
    """The winders' motors."""
    servo: Servo = field(default_factory=Servo)
    """The gripper's servo."""
    flange: Flange = field(default_factory=Flange)
    """The arm's flange."""
    remedies: Remedies = field(default_factory=Remedies)
    """What refusals advise."""

    def __post_init__(self) -> None:
        check_number("nozzle_mm", self.nozzle, least=0.05, most=1.5)
        check_number("tolerance_mm", self.tolerance, least=0.005, most=0.5)
        check_count("seed", self.seed, least=0, most=2**32 - 1)
        if not isinstance(self.bed, tuple) or len(self.bed) != 3:
            raise DesignError("bed_mm", got=self.bed, allowed="three lengths, X Y Z")
        for axis, size in zip("XYZ", self.bed, strict=True):
            check_number(f"bed_mm {axis}", size, least=40.0, most=5000.0)
        _check_lengths("", self, ("cable", "plate", "rim"))
        _check_lengths("", self, ("hole_play", "clearance"), least=0.0)
        check_number("shell_depth", self.shell_depth, above=0.0, below=1.0)
        check_number("shell_grip", self.shell_grip, least=0.0, below=1.0)
        check_count("n_wrinkle", self.n_wrinkle, least=0, most=1000)

    @property
    def drum(self) -> DrumOptions:
        """Motor and cable for which the drums are sized."""
        return DrumOptions(
            cable_diameter=self.cable / 1e3, motor_diameter=self.motor.diameter / 1e3,
            motor_clearance=self.clearance / 1e3, rotor_circle=self.motor.rotor_circle / 1e3,
            torque_max=self.motor.torque,
        )  # fmt: skip

    @property
    def least_wall(self) -> float:
        """Thinnest wall that passes the checks: two lines."""
        return 2 * self.nozzle

    @property
    def wall(self) -> float:
        """Thinnest wall of the definitions: both faces may deviate inwards by the tolerance."""
        return self.least_wall + 2 * self.tolerance

    @property
    def hole(self) -> float:
        """Diameter of a cable's hole."""
        return self.cable + self.hole_play

    @property
    def pair_hole(self) -> float:
        """Diameter of a hole that two cables share."""
        return 2 * self.cable + self.hole_play
