"""Mount of the trunk: motor housing and arm."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import final

from spiraltrunk.checks import check_number, check_numbers, check_text
from spiraltrunk.design.materials import PETG, Material, find_rigid
from spiraltrunk.errors import DesignError, Unquoted
from spiraltrunk.field_docs import explain_fields

HOUSING_MASS = 1.85
"""Mass of the housing with motors, its parts printed in PETG [kg] (ours: three GM6020 of 0.468 kg, servo, printed
parts, screws and wires)."""

PRINTED_MASS = 0.44
"""What of `HOUSING_MASS` is printed [kg]: the bill's estimate for cup, lid, drums, adapter and double arm in PETG."""

NECK_MASS = 0.060
"""Mass of the neck in PETG [kg] (ours: a printed shell)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class HousingDesign:
    """Cylinder between the arm's flange and the trunk, with three GM6020 motors and a servo inside.

    The paper shows it (figure 1b) and gives no measures: ours hold three motors of 66.7 mm at 120 deg.
    """

    radius: float = 0.075
    """Outer radius [m] (ours)."""
    length: float = 0.110
    """Length from the flange to where the neck begins [m] (ours)."""
    material: str = PETG.name
    """Filament of the housing and of every other rigid printed part: PETG, PLA or ASA (ours)."""
    mass: float | None = None
    """Mass with motors, without neck [kg], as weighed; None follows from the material."""
    neck_length: float = 0.060
    """Length of the neck between housing and trunk, as wide as section 1 [m] (ours: keeps a wrapped object clear of the
    housing; it belongs to the trunk and collides)."""
    neck_mass: float | None = None
    """Mass of the neck [kg], as weighed; None follows from the material."""

    def __post_init__(self) -> None:
        check_text("housing.material", self.material)
        find_rigid("housing.material", self.material)
        for name in ("radius", "length", "neck_length"):
            check_number(f"housing.{name}", getattr(self, name), least=1e-3, below=1.0)
        for name, mass in (("housing.mass", self.mass), ("housing.neck_mass", self.neck_mass)):
            if mass is not None:
                check_number(name, mass, least=1e-6, below=100.0)

    @property
    def filament(self) -> Material:
        """The material of the rigid parts."""
        return find_rigid("housing.material", self.material)

    @property
    def total_mass(self) -> float:
        """Mass with motors, without neck [kg]: as weighed, or m_PETG + m_printed (rho / rho_PETG - 1)."""
        if self.mass is not None:
            return self.mass
        return HOUSING_MASS + PRINTED_MASS * (self.filament.density / PETG.density - 1.0)

    @property
    def total_neck_mass(self) -> float:
        """Mass of the neck [kg]: as weighed, or that in PETG times rho / rho_PETG."""
        return NECK_MASS * (self.filament.density / PETG.density) if self.neck_mass is None else self.neck_mass


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class ArmDesign:
    """The rigid arm that carries the housing."""

    model: str = "panda"
    """Name of an arm that the simulator describes, such as "panda" or "fr3", or the path of another arm's MJCF file
    (relative paths start at the design's file)."""
    mount_site: str = "flange"
    """Site of the arm to which the housing is fixed, its z axis along the trunk."""
    base_height: float = 0.80
    """Height of the arm's base above the floor [m] (ours: a pedestal, so that the trunk can hang)."""
    roll: float = math.pi / 4
    """Rotation of the trunk about the mount's z axis, from the mount's x to dorsal [rad] (ours: the ventral side faces
    left in the Panda's ready pose)."""
    home: tuple[float, ...] | None = None
    """Initial joint positions [rad or m]; None takes the arm's own."""

    def __post_init__(self) -> None:
        check_text("arm.model", self.model, most=1000)
        check_text("arm.mount_site", self.mount_site)
        check_number("arm.base_height", self.base_height, least=0.0, below=10.0)
        check_number("arm.roll", self.roll, above=-10.0, below=10.0)
        if self.home is not None:
            check_numbers("arm.home", self.home, least=-100.0, most=100.0)
            if not 1 <= len(self.home) <= 32:
                raise DesignError("arm.home", got=Unquoted(f"{len(self.home)} numbers"), allowed="1 to 32 numbers")

    @property
    def is_file(self) -> bool:
        """Whether the model is the path of a file: anything but up to 40 letters, digits, - and _."""
        return re.fullmatch(r"[A-Za-z0-9_-]{1,40}", self.model) is None
