"""Filament to buy: the mass of each printed material in whole spools."""

from __future__ import annotations

import math
from collections.abc import Mapping

from spiraltrunk.cad.output.purchase import Purchase

SPOOL = 1000.0
"""Filament on a spool [g] (the usual size)."""

SPARE = 0.3
"""Filament for supports, purge lines and failed prints, over what the parts take [-] (ours)."""

PLACE = "3D printer"
"""Place of these rows."""


def list_filament(masses: Mapping[str, float]) -> list[Purchase]:
    """One row for each material: ceil((1 + `SPARE`) m / `SPOOL`) spools for parts of mass m.

    Args:
        masses: estimated mass of all pieces of each printed material, by its name [g].
    """
    return [
        Purchase(
            kind="filament", item=f"filament {name}", count=math.ceil((1 + SPARE) * mass / SPOOL),
            size=f"1.75 mm, spool of {SPOOL / 1000:g} kg", material=name, place=PLACE,
            note=f"{mass:.0f} g in the parts, {100 * SPARE:.0f} % more for supports and trials: "
            f"{(1 + SPARE) * mass:.0f} g; the diameter is your printer's",
        )
        for name, mass in masses.items()
    ]  # fmt: skip
