"""A part: its form, what it is made of, and what its walls must hold."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.cad.geometry.csg import Form


@final
@dataclass(frozen=True, kw_only=True)
class Material:
    """What a part is made of."""

    name: str
    """What to ask for."""
    density: float
    """Density of the solid material [g/cm^3]."""
    flow: float
    """Volume that is laid down in a second [mm^3/s]; 0 where it is cast."""
    infill: float
    """Part of the inside that is filled [-]."""


TPU = Material(name="TPU 95A", density=1.21, flow=3.0, infill=0.15)
"""Printed soft parts (paper; density and flow as filament makers state them; infill ours)."""

PLA = Material(name="PLA or PETG", density=1.25, flow=10.0, infill=0.3)
"""Printed rigid parts (ours)."""

SILICONE = Material(name="Ecoflex 00-30", density=1.07, flow=0.0, infill=1.0)
"""Cast shells (paper; density by its maker)."""


@final
@dataclass(frozen=True, kw_only=True)
class Part:
    """One part, in its own frame: the trunk's axis along z, dorsal along x, standing as it is printed."""

    name: str
    """Name of its files."""
    group: str
    """What it belongs to; `--parts` asks by it."""
    what: str
    """What it is, in a few words."""
    material: Material
    """What it is made of."""
    form: Form
    """Its shape [mm]."""
    count: int = 1
    """How many are needed."""
    at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Where its frame is in the straight trunk's, whose base joint is at 0 [mm]."""
    turn: float = 0.0
    """Turn about x from its own frame to the assembled one [rad]."""
    thinnest: str = ""
    """Which setting makes its thinnest wall thicker."""
    checks_walls: bool = True
    """Whether walls must be two nozzles thick; not so for what is cast."""
    landmarks: tuple[tuple[float, str], ...] = ()
    """Where along the straight trunk's axis what begins, in order, so that a thin wall can be told by name [mm]."""

    def name_place(self, z: float) -> str:
        """What of the part is at a height of its own frame [mm]."""
        along = self.at[2] + z * math.cos(self.turn)
        names = [name for begin, name in self.landmarks if begin <= along]
        return f"{names[-1]}, " if names else ""

    def take_in(self, points: np.ndarray) -> np.ndarray:
        """Points of the assembled robot in the part's own frame, shape (n, 3) [mm]."""
        x, y, z = (np.asarray(points, float) - np.array(self.at)).T
        c, s = math.cos(self.turn), math.sin(self.turn)
        return np.stack([x, c * y + s * z, c * z - s * y], axis=-1)
