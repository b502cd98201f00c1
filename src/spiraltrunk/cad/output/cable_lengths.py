"""Lengths to cut for the cables of trunk and gripper, in mm."""

from __future__ import annotations

import math

from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.geometry.csg import polar
from spiraltrunk.cad.housing.layout import find_layout
from spiraltrunk.cad.housing.winder import find_drum, find_travel, motor_angles, motor_ring
from spiraltrunk.design.drum import SPARE
from spiraltrunk.design.trunk import TrunkDesign

KNOT = 60.0
"""Cable for a knot or for tying an end [mm] (ours)."""


def cable_length(design: TrunkDesign, options: MakeOptions) -> float:
    """Length to cut for one of the trunk's cables [mm].

    It runs from the knot at the tip through the straight trunk, the neck and its guide to the drum, with all turns on
    the drum and both ends.
    """
    drum, layout = find_drum(design, options), find_layout(design, options)
    inside, neck = _length_in_trunk(design), options.plate + layout.height - layout.groove
    hole, axis = polar(1e3 * float(design.hole_position[0, 0, 1]), design.cable.angles[0], 0.0), motor_angles(design)[0]
    apart = math.dist(hole, polar(motor_ring(design, options), axis, 0.0))
    way = math.sqrt(max(apart**2 - drum.radius**2, 0.0))
    return inside + neck + way + 2 * math.pi * drum.radius * drum.turns + 2 * KNOT


def _length_in_trunk(design: TrunkDesign) -> float:
    """Length of a cable in the straight trunk and its neck [mm]."""
    return 1e3 * float(design.cable_in_section.sum() + design.straight_gap.sum() + design.housing.neck_length)


def cable_to_hold(design: TrunkDesign) -> float:
    """What of `cable_length` stands out at the tip of the straight trunk before the knot is made [mm].

    The drum takes it in: the travel in, and the spare of both travels.
    """
    travel_in, travel_out = find_travel(design)
    return KNOT + (1 + SPARE) * travel_in + SPARE * travel_out


def trial_length(design: TrunkDesign, options: MakeOptions, *, has_drums: bool) -> float:
    """Length of the cable for trials [mm]: one more cable, and four pieces of 300 mm for knots (ours).

    Without drums it only passes trunk and neck, and needs no housing.
    """
    one = cable_length(design, options) if has_drums else _length_in_trunk(design) + 2 * KNOT
    return 100 * math.ceil((one + 4 * 300.0) / 100)


def strand_length(design: TrunkDesign) -> float:
    """Length to cut for a strand of the gripper [mm]: from servo to fingertip, with slack and both ends."""
    if design.gripper is None:
        return 0.0
    return 1e3 * (design.length + design.housing.neck_length + design.gripper.finger_length) + 80.0 + 2 * KNOT
