"""The winders' drum: how large it may be beside its motor, and how much cable it has to take in and pay out."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

from spiraltrunk.checks import check_number
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, Unquoted
from spiraltrunk.field_docs import explain_fields

SCREW_HEAD = 2.9e-3
"""Radius of the head of a rotor's M3 screw: a key reaches it beside the drum's rim [m] (ISO 4762, with clearance)."""

LEAST_RADIUS = 5e-3
"""Least radius of a drum (ours: tighter bends wear a braided cable) [m]."""

DEAD_TURNS = 2.0
"""Turns that stay on a drum to unload the knot [-] (ours)."""

SPARE = 0.1
"""Relative spare travel [-] (ours)."""

PITCH = 1.2
"""Width of a turn on the drum over the cable's diameter [-] (ours)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class DrumOptions:
    """Motor and cable for which a drum is made; by default RoboMaster GM6020 and UHMWPE braid."""

    cable_diameter: float = 0.5e-3
    """Diameter of the UHMWPE cables [m] (ours: braid of some 500 N)."""
    motor_diameter: float = 66.7e-3
    """Outer diameter of the motor [m] (maker's data)."""
    motor_clearance: float = 0.2e-3
    """Clearance around a motor [m] (ours)."""
    rotor_circle: float = 28e-3
    """Pitch circle of the M3 screws that hold the drum [m]: unconfirmed."""
    torque_max: float = 2.22
    """Largest torque of the motor [N m] (0.741 N m/A at 3 A)."""

    def __post_init__(self) -> None:
        for name in ("cable_diameter", "motor_diameter", "rotor_circle"):
            check_number(f"drum.{name}", getattr(self, name), above=0.0, below=1.0)
        check_number("drum.motor_clearance", self.motor_clearance, least=0.0, below=1.0)
        check_number("drum.torque_max", self.torque_max, above=0.0, below=1e4)


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class DrumDesign:
    """A winder's drum; CAD makes it, and the winder's control computes with it."""

    winding_radius: float
    """Radius of the centre line of the cable in the first layer [m]."""
    cable_diameter: float
    """Diameter of the cable [m]."""
    width: float
    """Axial length of the winding surface [m]."""
    travel_in: float
    """Cable to wind in from straight until all gaps on its side are closed [m]."""
    travel_out: float
    """Cable to pay out from straight until all gaps on its side are fully open [m]."""
    dead_turns: float
    """Turns that stay on the drum to unload the knot [-]."""

    def __post_init__(self) -> None:
        check_number("drum.cable_diameter", self.cable_diameter, least=1e-5, below=0.1)
        check_number("drum.winding_radius", self.winding_radius, above=self.cable_diameter / 2, below=1.0)
        check_number("drum.width", self.width, least=self.cable_diameter, below=1.0)
        check_number("drum.travel_in", self.travel_in, above=0.0, below=100.0)
        check_number("drum.travel_out", self.travel_out, least=0.0, below=100.0)
        check_number("drum.dead_turns", self.dead_turns, least=0.0, below=100.0)


def size_drum(design: TrunkDesign, options: DrumOptions | None = None) -> DrumDesign:
    """Drum that winds the whole stroke in one layer.

    Its radius is limited by the distance of its axis from the cable's hole and by the rotor's screws; its width holds
    the dead turns, the travel with `SPARE`, and one turn more. The tension is the motor's torque over the radius.

    Raises:
        DesignError: where the motor is too weak, or the hole too near to the drum's axis.
    """
    options = DrumOptions() if options is None else options
    rim = options.rotor_circle / 2 - SCREW_HEAD
    radius = min(_hole_distance(design, options) - 2e-3, rim - 2.5 * options.cable_diameter)
    _check_radius(radius, design.cable.tension_max, options.torque_max)
    travel_in = design.cable_stroke
    travel_out = opening(float(2 * design.hole_to_joint.sum()), design.delta_theta)
    turns = full_turns(travel_in + travel_out, radius, DEAD_TURNS)
    return DrumDesign(
        winding_radius=radius, cable_diameter=options.cable_diameter,
        width=winding_width(options.cable_diameter, turns), travel_in=travel_in, travel_out=travel_out,
        dead_turns=DEAD_TURNS,
    )  # fmt: skip


def opening(width: float, delta_theta: float) -> float:
    """Cable that gaps take up when they open from ``delta_theta`` to twice that [rad], in the unit of ``width``.

    A chord grows from 2 R sin(delta_theta / 2) to 2 R sin(delta_theta); ``width`` is the sum of 2 R over the joints.
    """
    half = delta_theta / 2
    return width * (math.sin(2 * half) - math.sin(half))


def full_turns(travel: float, radius: float, dead_turns: float) -> float:
    """Turns in one layer when the cable is wound in, dead turns and spare travel included; lengths in any one unit."""
    return (1 + SPARE) * travel / (2 * math.pi * radius) + dead_turns


def winding_width(cable_diameter: float, turns: float) -> float:
    """Width of a drum that holds the turns in one layer, and one more, in the unit of the cable's diameter."""
    return PITCH * cable_diameter * (turns + 1)


def motor_ring(width: float, n_cable: int) -> float:
    """Distance of the motors' axes from the trunk's: one motor for each cable, side by side, each so wide."""
    return width / 2 / math.sin(math.pi / n_cable)


def motor_angles(design: TrunkDesign) -> tuple[float, ...]:
    """Angles of the motors' axes, one for each cable in the order of the design, from 0 to below 2 pi [rad].

    They are evenly spaced, and the first cable's motor is half a step past it; so is every other one where the cables
    are evenly spaced too. The offset gives each cable a free length to its drum, and thereby a small fleet angle.
    """
    step, first = 2 * math.pi / design.n_cable, design.cable.angles[0] % (2 * math.pi)
    past = [(angle - design.cable.angles[0]) % (2 * math.pi) for angle in design.cable.angles]
    return tuple((first + step * (sorted(past).index(each) + 0.5)) % (2 * math.pi) for each in past)


def _hole_distance(design: TrunkDesign, options: DrumOptions) -> float:
    """Least distance of a drum's axis from the hole of its cable at the base [m]."""
    ring = motor_ring(options.motor_diameter + 2 * options.motor_clearance, design.n_cable)
    hole = float(design.hole_position[0, 0, 1])
    places = zip(motor_angles(design), design.cable.angles, strict=True)
    return min(math.dist(_polar(ring, axis), _polar(hole, angle)) for axis, angle in places)


def _check_radius(radius: float, tension_max: float, torque_max: float) -> None:
    if radius < LEAST_RADIUS:
        hint = "the cable holes at the base lie too near to the motors' axes; take another base"
        raise DesignError(
            "part drum: radius", got=Unquoted(f"{1e3 * radius:.2f} mm"),
            allowed=f"at least {1e3 * LEAST_RADIUS:.2f} mm: {hint}",
        )  # fmt: skip
    if torque_max / radius < tension_max:
        raise DesignError(
            "part drum: tension", got=Unquoted(f"{torque_max / radius:.0f} N at most on {1e3 * radius:.1f} mm"),
            allowed=f"at least cable.tension_max_n, {tension_max:g} N: a stronger motor or less tension",
        )  # fmt: skip


def _polar(radius: float, angle: float) -> tuple[float, float]:
    return radius * math.cos(angle), radius * math.sin(angle)
