"""The paper's three design principles: from a few requirements to one spiral, its graspable range and payload.

Source: "Grasping by Spiraling", Methods, "Determining the Optimal Parameters", with two misprints corrected: with
theta_min the end of the inner contour, GH = a exp(b theta_min) (exp(2 pi b) - 1) and
HJ = a exp(b theta_min) (1 + exp(pi b)), so HJ = m GH gives m = 1 / (exp(pi b) - 1).
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

from spiraltrunk.checks import Range, check_number, check_range, check_tip, check_type
from spiraltrunk.design.gripper import GripperDesign
from spiraltrunk.design.parts import CableDesign, JointDesign
from spiraltrunk.design.spiral import Spiral, radius
from spiraltrunk.design.trunk import MOST_SECTIONS, TrunkDesign
from spiraltrunk.errors import DesignError, Unquoted

GRAVITY = 9.81
"""Acceleration of gravity [m/s^2]."""

M_MEANING = "smallest graspable object over the tip's width; a small m gives a slender tip"
"""What m is for the trunk, as help and hints tell it; the tip gripper's ranges meet the trunk's there (principle 2)."""

PAPER_M = 1.53
"""Largest object of the tip gripper over its base width [-] (paper, Methods)."""

_JOINT_RADIUS, _JOINT_LENGTH = 3.825 / 44.0, 2.10 / 44.0
"""Radius and length of the joint over the base radius [-] (authors' code: 3.825 and 2.10 mm on 44 mm)."""

_PAPER_TIP_WIDTH = 0.0213
"""Width of the authors' tip, which the default gripper fits [m]."""

_PAYLOAD_COEFFICIENT = 1.81604
"""Fits `payload` to the one published number, 4.89 kg at the smallest object of the authors' robot [-]."""

RANGES = {
    "m": Range(least=0.2, most=10.0),
    "b": Range(least=0.03, most=0.6),
    "delta_theta": Range(above=0.0, below=math.pi / 2),
    "arm_radius": Range(least=0.001, most=0.3),
    "turns": Range(least=0.75, most=5.0),
}
"""Ranges of the requirements of `design_from_rules` [-, 1/rad, rad, m, turns] (ours): each, with the others at their
defaults, gives a trunk with a printable tip, at most 200 sections and a graspable range."""

LEAST_TIP_WIDTH = 1e-4
"""Least width of the tip of a design from rules [m] (ours: a hair, a quarter of a printer's nozzle)."""


class GraspableRange(NamedTuple):
    """Smallest and largest width of the objects that the trunk can wrap [m]."""

    minimum: float
    maximum: float

    @property
    def is_empty(self) -> bool:
        """Whether the trunk wraps nothing: it is too short for half a turn round its smallest object."""
        return self.maximum < self.minimum


def growth_from_overlap(m: float) -> float:
    """Growth b = ln((1 + m) / m) / pi at which gripper and trunk ranges overlap (principle 2) [1/rad]."""
    return math.log((1 + m) / m) / math.pi


def compactness(b: float) -> float:
    """Compactness k = (1 + exp(-2 pi b)) / 2 at which successive turns touch without a gap (principle 1) [-]."""
    return (1 + math.exp(-2 * math.pi * b)) / 2


def design_from_rules(
    *,
    m: float | None = None,
    b: float | None = None,
    delta_theta: float = math.pi / 6,
    arm_radius: float = 0.044,
    turns: float = 1.5,
    name: str = "from-rules",
) -> TrunkDesign:
    """The trunk that follows from the paper's three principles.

    Args:
        m: largest object of the tip gripper over its base width [-]; 1.53 unless ``b`` is given.
        b: growth per radian [-], instead of ``m`` (the authors' code rounds it to 0.16).
        delta_theta: angle per section [rad]; it divides ``turns`` into at most 200 sections.
        arm_radius: radius of the arm's last link, matched by section 1 (principle 3) [m].
        turns: turns of the backbone's spiral from tip (theta = pi / 2) to base.
        name: name of the design.

    Raises:
        DesignError: for a value out of its range in `RANGES`, for both ``m`` and ``b``, for turns that are not whole
            sections, or for values that together leave no tip.
    """
    if m is not None and b is not None:
        raise DesignError("m", got=m, allowed="m or b, not both (m = 1 / (exp(pi b) - 1))")
    if b is None:
        check_range("m", PAPER_M if m is None else m, RANGES["m"])
        b = growth_from_overlap(PAPER_M if m is None else m)
    check_range("b", b, RANGES["b"])
    check_range("arm_radius", arm_radius, RANGES["arm_radius"])
    n_section = _count_sections(delta_theta, turns)
    unit = build_bare(b, delta_theta, n_section)
    spiral = Spiral(a=arm_radius / unit.solid.radius, b=b)
    check_tip(spiral.a * unit.tip_width, LEAST_TIP_WIDTH)
    section, joint = spiral.a * unit.solid.length, _JOINT_LENGTH * arm_radius
    if section <= joint:
        allowed = f"longer than its joint, {1e3 * joint:.3g} mm: fewer sections, each of a wider angle"
        raise DesignError("length of section 1", got=Unquoted(f"{1e3 * section:.3g} mm"), allowed=allowed)
    return build_compact(spiral=spiral, delta_theta=delta_theta, n_section=n_section, name=name)


def graspable_range(design: TrunkDesign) -> GraspableRange:
    """Smallest and largest width that the trunk wraps.

    The smallest is the width inside the tip's inner turn, HJ = GH / (exp(pi b) - 1) (paper, Methods). The largest is
    the diameter D of the circle round which the whole trunk makes half a turn: the integral of ds / ((D + w) / 2) over
    the backbone's arc equals pi, with w the local width; for a spiral the integral is elementary. A trunk too short for
    half a turn round the smallest wraps nothing: its largest is 0.

    Raises:
        DesignError: for what is no design.
    """
    check_type("design", design, TrunkDesign)
    b = design.spiral.b
    minimum = design.tip_width / (math.exp(math.pi * b) - 1)
    inner = float(radius(design.spiral, design.theta_tip))
    outer = float(radius(design.spiral, design.theta_base))
    half = design.k - math.exp(-2 * math.pi * b)
    ratio = math.exp(math.pi * b * half / (design.k * math.sqrt(1 + b**2)))
    maximum = 2 * half * (outer - ratio * inner) / (ratio - 1)
    return GraspableRange(minimum, maximum if maximum >= minimum else 0.0)


def payload(design: TrunkDesign, width: float | None = None) -> float:
    """Mass of the heaviest object of ``width`` [m] that the trunk holds by wrapping [kg]; smallest object by default.

    An empirical fit, as no formula is published: the moment of the largest cable tension at the base joint over the
    lever of the object's weight, (width + base width) / 2, times a factor fitted to the one published number, 4.89 kg
    at 33 mm. Measured payloads are smaller.

    Raises:
        DesignError: for what is no design, or a width that is not above 0.
    """
    check_type("design", design, TrunkDesign)
    width = graspable_range(design).minimum if width is None else width
    check_number("width", width, above=0.0)
    moment = design.cable.tension_max * float(design.hole_to_joint[0])
    return _PAYLOAD_COEFFICIENT * moment / (GRAVITY * (width + design.base_width) / 2)


def build_compact(
    *, spiral: Spiral, delta_theta: float, n_section: int, name: str, cable: CableDesign | None = None
) -> TrunkDesign:
    """The compact trunk on one spiral; joints and gripper have the proportions of the authors' robot, a first guess."""
    bare = build_bare(spiral.b, delta_theta, n_section, spiral.a, name)
    joint = JointDesign(radius=_JOINT_RADIUS * bare.solid.radius, length=_JOINT_LENGTH * bare.solid.radius)
    gripper = GripperDesign().scaled(bare.tip_width / _PAPER_TIP_WIDTH)
    return replace(bare, joint=joint, gripper=gripper, cable=bare.cable if cable is None else cable)


def build_bare(b: float, delta_theta: float, n_section: int = 2, a: float = 1.0, name: str = "bare") -> TrunkDesign:
    """The sections of a compact spiral with joints of negligible size, from which sizes are computed."""
    joint = JointDesign(radius=1e-5, length=1e-5)
    return TrunkDesign(
        name=name, spiral=Spiral(a=a, b=b), k=compactness(b), delta_theta=delta_theta, n_section=n_section, joint=joint
    )


def _count_sections(delta_theta: float, turns: float) -> int:
    check_range("turns", turns, RANGES["turns"])
    least = 2 * math.pi * turns / MOST_SECTIONS * (1 - 1e-9)
    check_range("delta_theta", delta_theta, RANGES["delta_theta"]._replace(above=-math.inf, least=least))
    total = math.degrees(2 * math.pi * turns)
    exact = total / math.degrees(delta_theta)
    n_section = round(exact)
    if abs(exact - n_section) > 1e-6 * exact:
        few = max(math.floor(exact), math.floor(total / 90 * (1 + 1e-9)) + 1)  # Below 90 deg also as it is printed.
        near = ", ".join(f"{total / n:.9g} deg ({n} sections)" for n in (few, few + 1) if n <= MOST_SECTIONS)
        allowed = f"an angle that divides {total:g} deg into whole sections, such as {near}"
        raise DesignError("delta_theta", got=Unquoted(f"{math.degrees(delta_theta):g} deg"), allowed=allowed)
    return n_section
