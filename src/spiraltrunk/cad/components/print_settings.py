"""Slicer settings of the printed parts: one table for the guide, the part's JSON and the estimates of mass and time.

All values are ours; no part was printed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.design.materials import TPU, Material
from spiraltrunk.field_docs import explain_fields

FLOW, FLOW_TPU = 10.0, 3.0
"""Extruded volume per time of rigid filaments and of TPU [mm^3/s] (as filament makers state it)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class PrintSettings:
    """Slicer settings of a part; the orientation is that of its file."""

    lines: int
    """Lines of every wall."""
    infill: float
    """Filled share of the inside [-]."""
    stands_on: str
    """Face on the bed."""
    supports: str = "none"
    """Where supports are needed."""

    def layer(self, options: MakeOptions) -> float:
        """Layer height, half the nozzle [mm] (ours)."""
        return options.nozzle / 2


SETTINGS: dict[str, PrintSettings] = {
    "trunk": PrintSettings(
        lines=2, infill=0.15, stands_on="flat cut end: trunk_1 with its base up (in one piece: the base)",
        supports="everywhere, also on the part: in each gap; joints solid, see step Print",
    ),
    "gripper": PrintSettings(
        lines=2, infill=0.15, stands_on="tenon", supports="under the plate; finger joints solid, see step Print"
    ),
    "mould_core": PrintSettings(lines=2, infill=0.15, stands_on="floor"),
    "mould_ring": PrintSettings(lines=2, infill=0.15, stands_on="smooth end"),
    "housing": PrintSettings(lines=4, infill=0.4, stands_on="floor"),
    "lid": PrintSettings(lines=4, infill=0.4, stands_on="outer face, guides up"),
    "neck": PrintSettings(lines=4, infill=0.4, stands_on="foot", supports="inside, under the funnel"),
    "drum": PrintSettings(lines=4, infill=1.0, stands_on="wide flange"),
    "horn": PrintSettings(lines=4, infill=1.0, stands_on="flat side"),
    "adapter": PrintSettings(lines=6, infill=0.6, stands_on="flat side, spigot up"),
    "wedge": PrintSettings(lines=6, infill=0.4, stands_on="lower plate", supports="under the slanted plate"),
    "marker_seat": PrintSettings(lines=3, infill=1.0, stands_on="either end"),
}  # fmt: skip
"""Settings by the part's name without its number."""


def find_settings(name: str) -> PrintSettings:
    """Settings of the part of that name."""
    return SETTINGS[name.rstrip("0123456789").rstrip("_")]


def find_flow(material: Material) -> float:
    """Extruded volume per time [mm^3/s]."""
    return FLOW_TPU if material == TPU else FLOW
