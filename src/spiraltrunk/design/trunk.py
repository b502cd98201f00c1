"""The trunk: one frozen description, and the lengths, stiffnesses and masses that follow from it.

A section's frame has its origin in the centre of the proximal joint, x along the straight axis towards the tip and y
dorsal (the paper's cable 1). Section n = 1 is at the base, joint i lies between sections i and i + 1. Each size is the
first one times k_p^(n-1), the spiral's self-similarity (paper, Results, "Soft Manipulator Design").
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import final

import numpy as np

from spiraltrunk.checks import check_count, check_number, check_text, check_tip, check_type
from spiraltrunk.design.gripper import GripperDesign
from spiraltrunk.design.mount import ArmDesign, HousingDesign
from spiraltrunk.design.parts import CableDesign, JointDesign, MassDesign
from spiraltrunk.design.section import SectionSolid
from spiraltrunk.design.spiral import Spiral, arc_length, chord, radius
from spiraltrunk.errors import DesignError, Unquoted
from spiraltrunk.field_docs import explain_fields

MOST_SECTIONS = 200
"""Largest number of sections [-] (ours)."""

_LEAST_TIP_WIDTH = 1e-5
"""Least width of the tip of any design [m] (ours: a tenth of a hair)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class TrunkDesign:
    """A logarithmic-spiral trunk with its joints, cables, masses, gripper, housing and arm."""

    name: str
    """Name that files and tables show."""
    spiral: Spiral
    """Outer contour; the inner contour is one turn further in, the backbone is k times the outer contour."""
    k: float
    """Compactness: backbone radius over contour radius [-] (paper, Methods, equation for k)."""
    delta_theta: float = math.pi / 6
    """Angle of the spiral per section [rad] (paper: 30 deg); also the gap between neighbouring faces."""
    n_section: int = 18
    """Number of sections, 18 over 1.5 turns in the paper; there is one joint fewer."""
    theta_tip: float = math.pi / 2
    """Angle of the spiral at the end of the tip [rad] (paper: 90 deg)."""
    joint: JointDesign = field(default_factory=lambda: JointDesign(radius=3.825e-3, length=2.10e-3))
    """Elastic joints between the sections."""
    cable: CableDesign = field(default_factory=lambda: CableDesign(angles=(0.0, 2 * math.pi / 3, 4 * math.pi / 3)))
    """Cables, their holes and their friction."""
    mass: MassDesign = field(default_factory=MassDesign)
    """Masses of the sections, or the density that they follow from."""
    gripper: GripperDesign | None = field(default_factory=GripperDesign)
    """Gripper at the tip, or None."""
    housing: HousingDesign = field(default_factory=HousingDesign)
    """Winder housing between the arm's flange and the trunk."""
    arm: ArmDesign = field(default_factory=ArmDesign)
    """Robot arm that carries housing and trunk."""

    def __post_init__(self) -> None:
        check_text("name", self.name)
        self._check_parts()
        check_number("delta_theta", self.delta_theta, above=0.0, below=math.pi / 2)
        check_count("n_section", self.n_section, least=2, most=MOST_SECTIONS)
        check_number("theta_tip", self.theta_tip, above=-100.0, below=100.0)
        inner = math.exp(-2 * math.pi * self.spiral.b)
        check_number("k", self.k, above=inner, below=1.0)
        self._check_sizes()

    def _check_parts(self) -> None:
        check_type("spiral", self.spiral, Spiral)
        check_type("joint", self.joint, JointDesign)
        check_type("cable", self.cable, CableDesign)
        check_type("mass", self.mass, MassDesign)
        check_type("gripper", self.gripper, (GripperDesign, type(None)))
        check_type("housing", self.housing, HousingDesign)
        check_type("arm", self.arm, ArmDesign)

    def _check_sizes(self) -> None:
        if self.spiral.b * (self.n_section * self.delta_theta + abs(self.theta_tip)) > 100:
            raise DesignError("n_section", got=self.n_section, allowed="a spiral that grows by less than e^100")
        check_tip(self.tip_width, _LEAST_TIP_WIDTH)
        solid = self.solid
        check_number("joint.radius", self.joint.radius, below=self.cable.hole_fraction * solid.radius)
        check_number("joint.length", self.joint.length, below=solid.length)
        for name, values, count in (
            ("joint.stiffness", self.joint.stiffness, self.n_joint),
            ("mass.sections", self.mass.sections, self.n_section),
        ):
            if values is not None and len(values) != count:
                raise DesignError(name, got=Unquoted(f"{len(values)} numbers"), allowed=f"{count} numbers")

    # The spiral cut into sections.

    @property
    def n_joint(self) -> int:
        """Number of elastic joints, n_section - 1."""
        return self.n_section - 1

    @property
    def n_cable(self) -> int:
        """Number of cables."""
        return len(self.cable.angles)

    @property
    def theta_base(self) -> float:
        """Angle of the spiral at the base [rad] (paper: 7 pi / 2)."""
        return self.theta_tip + self.n_section * self.delta_theta

    @property
    def k_p(self) -> float:
        """Ratio of neighbouring sections exp(-b delta_theta) [-] (paper: 0.9196)."""
        return math.exp(-self.spiral.b * self.delta_theta)

    @property
    def backbone(self) -> Spiral:
        """The backbone's spiral: k times the outer contour."""
        return Spiral(a=self.k * self.spiral.a, b=self.spiral.b)

    @cached_property
    def scale(self) -> np.ndarray:
        """k_p^(n-1), shape (n_section,) [-]."""
        return self.k_p ** np.arange(self.n_section)

    @cached_property
    def face_half_width(self) -> float:
        """Length of section 1's proximal face from backbone to contour, AB of the paper's figure 4a [m]."""
        outer = float(radius(self.spiral, self.theta_base))
        return outer * (self.k - math.exp(-2 * math.pi * self.spiral.b))

    @cached_property
    def solid(self) -> SectionSolid:
        """Section 1; section n is the same times k_p^(n-1)."""
        length = float(chord(self.backbone, self.theta_base, self.theta_base - self.delta_theta))
        lean = math.pi / 2 - self._face_angle
        return SectionSolid(
            length=length,
            radius=self.face_half_width * math.sin(self._face_angle),
            lean_proximal=lean,
            lean_distal=self.delta_theta - lean,
        )

    @property
    def _face_angle(self) -> float:
        """Angle between a section's axis and its proximal face [rad] (66.12 deg for b = 0.16)."""
        turn = self.delta_theta
        return math.atan2(self.k_p * math.sin(turn), 1.0 - self.k_p * math.cos(turn))

    @cached_property
    def section_length(self) -> np.ndarray:
        """Lengths between joint centres, shape (n_section,) [m]."""
        return self.solid.length * self.scale

    @cached_property
    def section_radius(self) -> np.ndarray:
        """Radii of the outer surfaces, shape (n_section,) [m]."""
        return self.solid.radius * self.scale

    @property
    def length(self) -> float:
        """Length of the straight trunk, sum of the sections [m]."""
        return float(self.section_length.sum())

    @property
    def arc_length(self) -> float:
        """Length of the backbone's spiral [m]."""
        return float(arc_length(self.backbone, self.theta_tip, self.theta_base))

    @property
    def base_width(self) -> float:
        """Width of section 1, twice its radius [m]."""
        return 2 * self.solid.radius

    @property
    def tip_width(self) -> float:
        """Width of the face at the tip, GH of the paper's figure 4a [m]."""
        return 2 * self.face_half_width * self.k_p**self.n_section

    @property
    def taper(self) -> float:
        """Full angle of the cone through the face edges of the straight trunk [rad]."""
        narrowing = self.face_half_width * (1.0 - self.k_p) / self.solid.length
        return 2 * math.atan(narrowing)

    # Joints.

    @cached_property
    def joint_stiffness(self) -> np.ndarray:
        """Bending stiffness E I / L (with k_p^3 along the trunk) or the override, shape (n_joint,) [N m/rad]."""
        if self.joint.stiffness is not None:
            return np.array(self.joint.stiffness)
        return self.joint.base_stiffness * self.scale[:-1] ** 3

    @property
    def joint_limit(self) -> float:
        """Largest bend of a joint in any direction, at which neighbouring faces touch [rad]."""
        return self.delta_theta

    # Cables.

    @cached_property
    def hole_position(self) -> np.ndarray:
        """Axial and radial position of the proximal and the distal hole, shape (n_section, 2, 2) [m]."""
        part, solid = self.cable.hole_fraction, self.solid
        ring = part * solid.radius
        first = np.array([[part * solid.rim_start, ring], [solid.length - part * (solid.length - solid.rim_end), ring]])
        return self.scale[:, None, None] * first

    @cached_property
    def cable_direction(self) -> np.ndarray:
        """Unit vectors from the axis to the cables in the section's frame, shape (n_cable, 3) [-]."""
        angle = np.array(self.cable.angles)
        return np.stack([np.zeros_like(angle), np.cos(angle), np.sin(angle)], axis=-1)

    @cached_property
    def cable_in_section(self) -> np.ndarray:
        """Length of each cable inside the sections, constant, shape (n_section,) [m]."""
        return self.hole_position[:, 1, 0] - self.hole_position[:, 0, 0]

    @cached_property
    def hole_to_joint(self) -> np.ndarray:
        """Distance of the holes on both sides of a joint from its centre, R_hole, shape (n_joint,) [m]."""
        return self.cable.hole_fraction * self.face_half_width * self.scale[1:]

    @cached_property
    def straight_gap(self) -> np.ndarray:
        """Cable across each gap of the straight trunk, 2 R_hole sin(delta_theta / 2), shape (n_joint,) [m]."""
        return 2 * self.hole_to_joint * math.sin(self.delta_theta / 2)

    @property
    def cable_stroke(self) -> float:
        """Cable to pull in from straight until every gap on its side is closed [m]."""
        return float(self.straight_gap.sum())

    # Masses.

    @cached_property
    def section_mass(self) -> np.ndarray:
        """Masses, base to tip, shape (n_section,) [kg]."""
        if self.mass.sections is not None:
            return np.array(self.mass.sections)
        return self.mass.density * self.solid.volume * self.scale**3

    @cached_property
    def section_center(self) -> np.ndarray:
        """Centres of mass from the proximal joints, shape (n_section,) [m]."""
        fraction = self.mass.center_fraction
        return self.section_length * (self.solid.centroid / self.solid.length if fraction is None else fraction)

    @cached_property
    def section_inertia(self) -> np.ndarray:
        """Moments (axial, transverse) about the centres of mass, shape (n_section, 2) [kg m^2]."""
        gyration = np.array([self.solid.gyration_axial, self.solid.gyration_transverse])
        return self.section_mass[:, None] * self.scale[:, None] ** 2 * gyration

    @property
    def total_mass(self) -> float:
        """Mass of sections and gripper, without the housing [kg]."""
        return float(self.section_mass.sum()) + (0.0 if self.gripper is None else self.gripper.mass)


def ventral_cables(design: TrunkDesign) -> np.ndarray:
    """Which cables pull ventral, shape (n_cable,) [bool]."""
    return design.cable_direction[:, 1] < -1e-6
