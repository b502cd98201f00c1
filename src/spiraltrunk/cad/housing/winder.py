"""Winder drums for the trunk's cables, and the servo's double arm for the gripper's."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

from spiraltrunk.cad.components.options import ADAPTER, MakeOptions, to_mm
from spiraltrunk.cad.geometry.csg import QUARTERS, Cut, Form, Revolved, Union, box, polar, rod, rods
from spiraltrunk.cad.geometry.part import Part
from spiraltrunk.cad.trunk.gripper import strand_travel
from spiraltrunk.design import drum as sizing
from spiraltrunk.design.drum import SCREW_HEAD, SPARE, full_turns, opening, size_drum, winding_width
from spiraltrunk.design.trunk import TrunkDesign

ROTOR_SCREW, TIE = 3.2, 1.2
"""Diameter of the holes for the rotor's M3 screws, and of holes for cable ends [mm]."""


@final
@dataclass(frozen=True, kw_only=True)
class Drum:
    """A winder drum, in mm."""

    radius: float
    """Radius of the wound cable's centre line."""
    rim: float
    """Radius of the retaining rim."""
    flange: float
    """Radius of the flange on the motor."""
    width: float
    """Axial length of the winding surface, for one layer of cable."""
    wall: float
    """Thickness of rim and flange."""
    travel_in: float
    """Cable to wind in from straight until all gaps on its side are closed."""
    travel_out: float
    """Cable to pay out from straight until all gaps on its side are fully open."""
    turns: float
    """Turns on the drum when wound in, dead turns included."""
    dead_turns: float
    """Turns that stay on the drum to unload the knot."""

    @property
    def turns_straight(self) -> float:
        """Turns on the drum when the trunk is straight."""
        return self.travel_out / (2 * math.pi * self.radius) + self.dead_turns

    @property
    def turns_in(self) -> float:
        """Turns on the drum when all gaps on its side are closed."""
        return self.turns_straight + self.travel_in / (2 * math.pi * self.radius)

    @property
    def height(self) -> float:
        """Total height."""
        return self.width + 2 * self.wall


def find_drum(design: TrunkDesign, options: MakeOptions) -> Drum:
    """The drum of `size_drum`, in mm, with rim and flange.

    Raises:
        DesignError: where the motor is too weak, or the hole too near to the drum's axis.
    """
    sized, motor = size_drum(design, options.drum), options.motor
    radius, (travel_in, travel_out) = to_mm(sized.winding_radius), find_travel(design)
    turns = full_turns(travel_in + travel_out, radius, sized.dead_turns)
    return Drum(
        radius=radius, rim=motor.rotor_circle / 2 - 1e3 * SCREW_HEAD,
        flange=motor.rotor_circle / 2 + ROTOR_SCREW / 2 + options.wall, width=winding_width(options.cable, turns),
        wall=max(3.0, options.wall), travel_in=travel_in, travel_out=travel_out, turns=turns,
        dead_turns=sized.dead_turns,
    )  # fmt: skip


def find_travel(design: TrunkDesign) -> tuple[float, float]:
    """Cable to wind in until all gaps on its side are closed, and to pay out until all are open [mm]."""
    return 1e3 * design.cable_stroke, opening(1e3 * float(2 * design.hole_to_joint.sum()), design.delta_theta)


def build_drums(design: TrunkDesign, options: MakeOptions) -> tuple[Part, ...]:
    """The drum, one for each cable, printed on its flange."""
    drum = find_drum(design, options)
    core = drum.radius - options.cable / 2
    top = drum.wall + drum.width
    profile = (
        (0.0, 0.0), (drum.flange, 0.0), (drum.flange, drum.wall), (core, drum.wall), (core, top), (drum.rim, top),
        (drum.rim, drum.height), (0.0, drum.height),
    )  # fmt: skip
    holes = rods(ROTOR_SCREW / 2, options.motor.rotor_circle / 2, QUARTERS, -1, drum.wall + 1)
    tie: Form = rod(TIE / 2, (0.0, 0.0, drum.wall + TIE), (drum.rim + 1, 0.0, drum.wall + TIE))
    bore = rod(max(2.0, core / 3), (0, 0, -1), (0, 0, drum.height + 1))
    form = Cut(form=Revolved(profile=profile), tools=(bore, *holes, tie))
    at = polar(motor_ring(design, options), motor_angles(design)[0], _drum_height(design, options))
    what = (
        f"winder drum, groove {2 * core:.1f} mm across ({2 * drum.radius:.1f} mm to the cable's middle), "
        f"{drum.turns:.1f} turns"
    )
    return (
        Part(name="drum", group="drums", what=what, count=design.n_cable, material=design.housing.filament,
             form=form, at=at),
    )  # fmt: skip


def find_arm(design: TrunkDesign, options: MakeOptions) -> float:
    """Radius of the double arm [mm], so that the servo's rotation gives the fingers' full cable travel.

    An arm of radius r winds r sin(turn) by a rotation of ``turn`` from the middle, and most at 90 deg.
    """
    if design.gripper is None:
        return 0.0
    return (1 + SPARE) * 1e3 * strand_travel(design.gripper) / math.sin(math.radians(min(90.0, options.servo.turn)))


def build_horn(design: TrunkDesign, options: MakeOptions) -> tuple[Part, ...]:
    """The double arm: a bar on the servo's round horn, with one cable group tied to each end."""
    if design.gripper is None:
        return ()
    arm, hub = find_arm(design, options), options.servo.hub_diameter
    thick, wide = 3.0, max(6.0, options.hole + 4 * options.wall)
    length = max(arm, hub / 2 + 3.0)
    ends = [rod(wide / 2, (x, 0, 0), (x, 0, thick)) for x in (length, -length)]
    middle = rod(hub / 2 + 2 * options.wall + 1, (0, 0, 0), (0, 0, thick))
    body = Union(forms=(box((2 * length, wide, thick), (0, 0, thick / 2)), middle, *ends))
    ties = [rod(TIE / 2, (x, 0, -1), (x, 0, thick + 1)) for x in (arm, -arm)]
    screws = [rod(0.6, (0, y, -1), (0, y, thick + 1)) for y in (0.42 * hub, -0.42 * hub)]
    shaft = rod(1.2, (0, 0, -1), (0, 0, thick + 1))
    return (
        Part(name="horn", group="horn", what=f"double arm of the servo, {arm:.1f} mm to each cable",
             material=design.housing.filament,
             form=Cut(form=body, tools=(shaft, *ties, *screws)), turn=math.pi / 2,
             at=(0.0, -options.servo.width, _drum_height(design, options) + 20.0)),
    )  # fmt: skip


def motor_ring(design: TrunkDesign, options: MakeOptions) -> float:
    """Distance of the motors' axes from the trunk's [mm]."""
    return sizing.motor_ring(options.motor.diameter + 2 * options.clearance, design.n_cable)


def motor_angles(design: TrunkDesign) -> tuple[float, ...]:
    """Angles of the motors' axes [rad]."""
    return sizing.motor_angles(design)


def _drum_height(design: TrunkDesign, options: MakeOptions) -> float:
    housing = design.housing
    bottom = -1e3 * (housing.neck_length + housing.length)
    return bottom + ADAPTER + options.plate + options.motor.height
