"""Parts of a trunk that do not follow from its spiral: elastic joints, cables and masses."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

from spiraltrunk.checks import check_number, check_numbers
from spiraltrunk.errors import DesignError, Unquoted
from spiraltrunk.field_docs import explain_fields


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class JointDesign:
    """Elastic cylinder between two sections, given at joint 1; joint i is scaled by k_p^(i-1)."""

    radius: float
    """Radius of the cylinder at joint 1 [m] (authors' code: 3.825 mm)."""
    length: float
    """Length of the cylinder at joint 1 [m] (authors' code: 2.10 mm)."""
    youngs_modulus: float = 16.9e6
    """Young's modulus of the printed TPU 95A [Pa] (paper, section "Resting under gravity")."""
    damping_time: float = 0.04
    """Damping over stiffness of every joint [s] (ours; the paper gives none)."""
    stiffness: tuple[float, ...] | None = None
    """Bending stiffness of each joint, base to tip [N m/rad], as measured; None takes E I / L."""

    def __post_init__(self) -> None:
        check_number("joint.radius", self.radius, least=1e-5, below=1.0)
        check_number("joint.length", self.length, least=1e-5, below=1.0)
        check_number("joint.youngs_modulus", self.youngs_modulus, least=1e3, below=1e12)
        check_number("joint.damping_time", self.damping_time, least=0.0, below=10.0)
        if self.stiffness is not None:
            check_numbers("joint.stiffness", self.stiffness, least=1e-12, most=1e6)

    @property
    def base_stiffness(self) -> float:
        """E I / L of joint 1 with I = pi r^4 / 4 [N m/rad] (paper, equations for M, I and curvature)."""
        return self.youngs_modulus * math.pi * self.radius**4 / (4 * self.length)


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class CableDesign:
    """Cables along the trunk, through one hole in each face of every section."""

    angles: tuple[float, ...]
    """Directions of the cables about the axis from dorsal (+y) towards +z, cable 1 first [rad]."""
    hole_fraction: float = 0.6
    """Distance of a hole from the backbone over the half-width of its face [-] (authors' code)."""
    tension_max: float = 60.0
    """Largest tension of a cable [N] (GM6020: 2.22 N m on a drum of up to 37 mm radius)."""
    friction: float = 0.0
    """Coefficient of friction between cable and holes, mu in T exp(-mu w) [-] (the paper gives none; 0.1 to 0.15 is
    plausible)."""

    def __post_init__(self) -> None:
        check_numbers("cable.angles", self.angles, least=-100.0, most=100.0)
        if not 2 <= len(self.angles) <= 12:
            raise DesignError("cable.angles", got=Unquoted(f"{len(self.angles)} cables"), allowed="2 to 12 cables")
        turns = sorted(angle % (2 * math.pi) for angle in self.angles)
        gaps = [b - a for a, b in zip(turns, [*turns[1:], turns[0] + 2 * math.pi], strict=True)]
        if min(gaps) < math.radians(5.0) - 1e-9:  # Rounding of angles that are exactly 5 deg apart.
            raise DesignError("cable.angles", got=self.angles, allowed="cables at least 5 deg apart")
        check_number("cable.hole_fraction", self.hole_fraction, above=0.0, below=1.0)
        check_number("cable.tension_max", self.tension_max, least=1e-3, below=1e4)
        check_number("cable.friction", self.friction, least=0.0, below=2.0)


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class MassDesign:
    """Masses of the sections."""

    density: float = 196.3
    """Effective density over the revolved solid [kg/m^3]: the authors' 191.3 g over the volume of their 18 sections."""
    sections: tuple[float, ...] | None = None
    """Mass of each section, base to tip [kg], as measured; None follows from the density."""
    center_fraction: float | None = None
    """Distance of the centre of mass from the proximal joint over the section's length [-]; None: the centroid."""

    def __post_init__(self) -> None:
        check_number("mass.density", self.density, least=0.1, below=3e4)
        if self.sections is not None:
            check_numbers("mass.sections", self.sections, least=1e-12, most=1e3)
        if self.center_fraction is not None:
            check_number("mass.center_fraction", self.center_fraction, above=0.0, below=1.0)
