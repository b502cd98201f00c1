"""A part: form, material, place in the robot and limits of its checks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.cad.geometry.csg import Form
from spiraltrunk.design.materials import Material
from spiraltrunk.errors import DesignError, Unquoted
from spiraltrunk.field_docs import explain_fields


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Part:
    """One part in its own frame: the trunk's axis along z, dorsal along x, oriented as printed."""

    name: str
    """Name, also of its files."""
    group: str
    """Group, as `--parts` names it."""
    what: str
    """Short description."""
    material: Material
    """Material."""
    form: Form
    """Shape [mm]."""
    count: int = 1
    """Number of pieces in the robot."""
    at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Origin of its frame in that of the straight trunk, whose base joint is at 0 [mm]."""
    turn: float = 0.0
    """Rotation about x into the frame of the straight trunk [rad]."""
    thinnest: str = ""
    """Which setting makes its thinnest wall thicker, for the error message; empty where a finer nozzle alone helps."""
    checks_walls: bool = True
    """Whether its walls must be two nozzles thick; cast parts have no such limit."""
    landmarks: tuple[tuple[float, str], ...] = ()
    """Begin along the straight trunk's axis [mm] and name of its regions, in order, for error messages."""

    def name_place(self, z: float) -> str:
        """Name of the region at a height in its own frame [mm], for a message."""
        along = self.at[2] + z * math.cos(self.turn)
        names = [name for begin, name in self.landmarks if begin <= along]
        return f"{names[-1]}, " if names else ""

    def to_own_frame(self, points: np.ndarray) -> np.ndarray:
        """Points of the assembled robot in the part's own frame, shape (n, 3) [mm]."""
        x, y, z = (np.asarray(points, float) - np.array(self.at)).T
        c, s = math.cos(self.turn), math.sin(self.turn)
        return np.stack([x, c * y + s * z, c * z - s * y], axis=-1)


def too_small(what: str, got: float, least: float, hint: str) -> DesignError:
    """The error for a dimension [mm] below the least that a part needs, with the reason or the remedy."""
    return DesignError(
        f"part {what}", got=Unquoted(f"{round(got, 2)} mm"), allowed=f"at least {round(least, 2)} mm: {hint}"
    )
