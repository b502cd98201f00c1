"""Materials of the parts: one catalogue for design, models, parts and bill of materials."""

from __future__ import annotations

from typing import NamedTuple, final

from spiraltrunk.errors import DesignError


@final
class Material(NamedTuple):
    """Material of a part."""

    name: str
    """Name in the design file and in the bill of materials."""
    density: float
    """Density of the solid material [kg/m^3]."""
    softening: float | None = None
    """Temperature at which it yields under load [degC]: heat deflection at 0.45 MPa; None where that is no limit."""
    is_cast: bool = False
    """Whether it is cast in a mould, and not printed."""


TPU = Material(name="TPU 95A", density=1210.0)
"""Trunk and gripper (paper; density as filament makers state it). Its modulus is `JointDesign.youngs_modulus`."""

SILICONE = Material(name="Ecoflex 00-30", density=1070.0, is_cast=True)
"""Shells (paper; density by its maker)."""

PETG = Material(name="PETG", density=1270.0, softening=68.0)
"""Rigid parts by default (ours: the motors warm the housing; values as filament makers state them)."""

_RIGID = (
    PETG,
    Material(name="PLA", density=1240.0, softening=55.0),
    Material(name="ASA", density=1070.0, softening=86.0),
)

RIGID = {material.name: material for material in _RIGID}
"""Filaments for the rigid parts by name (values as filament makers state them)."""


def find_rigid(field: str, name: str) -> Material:
    """The filament for rigid parts of that name.

    Raises:
        DesignError: names ``field`` and lists the filaments.
    """
    if name not in RIGID:
        raise DesignError(field, got=name, allowed=", ".join(RIGID))
    return RIGID[name]
