"""Pictures of the printed robot: its exploded view, and a sheet with one part of each kind."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, final

from spiraltrunk.report.solids.solids_picture import DrawnSolid, write_exploded, write_sheet

if TYPE_CHECKING:
    from trimesh import Trimesh

_COLORS = {
    "trunk": (0.62, 0.67, 0.74), "gripper": (0.86, 0.47, 0.41), "shells": (0.93, 0.78, 0.66),
    "moulds": (0.80, 0.80, 0.84), "housing": (0.42, 0.47, 0.55), "drums": (0.90, 0.72, 0.30),
    "horn": (0.90, 0.72, 0.30), "adapter": (0.55, 0.62, 0.55),
    "wedge": (0.66, 0.62, 0.74), "markers": (0.55, 0.72, 0.70),
}  # fmt: skip

_APART = 45.0
"""Gap between neighbours in the exploded view [mm]."""

_ORDER = ("adapter", "housing", "drum", "horn", "lid", "neck")
"""Parts before the trunk, from the arm on."""


@final
@dataclass(frozen=True, kw_only=True)
class PlacedPart:
    """One part and its place in the robot."""

    name: str
    """Its name."""
    group: str
    """Its group, which gives the colour."""
    count: int
    """How many the robot needs."""
    mesh: Trimesh
    """Surface in its own frame [mm]."""
    at: tuple[float, float, float]
    """Origin of its frame in that of the straight trunk [mm]."""
    turn: float
    """Rotation about x into the frame of the straight trunk [rad]."""

    def assembled(self) -> Trimesh:
        """Its surface in the frame of the straight trunk [mm]."""
        return _turn(self.mesh, self.turn, (1.0, 0.0, 0.0)).apply_translation(self.at)


def write_pictures(parts: Sequence[PlacedPart], folder: Path, *, title: str, n_cable: int) -> None:
    """Write ``parts.png``, and ``exploded.png`` and ``exploded.svg`` where more than one part can be exploded.

    Raises:
        OSError: where a file cannot be written.
    """
    kinds: dict[str, PlacedPart] = {}
    for part in parts:
        kinds.setdefault(part.name if part.group == "trunk" else re.sub(r"_\d+$", "", part.name), part)
    write_sheet([_draw_alone(part) for part in kinds.values()], folder / "parts.png", title=f"{title}: parts")
    apart = explode(parts, n_cable)
    if len(apart) > 1:
        paths = [folder / f"exploded.{ending}" for ending in ("png", "svg")]
        write_exploded(apart, paths, title=f"{title}: taken apart")


def _draw_alone(part: PlacedPart) -> DrawnSolid:
    size = " x ".join(f"{value:.0f}" for value in part.mesh.extents) + " mm"
    note = f"{size}, {part.count} needed" if part.count > 1 else size
    return DrawnSolid(name=part.name, mesh=part.mesh, color=_COLORS[part.group], note=note)


def explode(parts: Sequence[PlacedPart], n_cable: int) -> list[DrawnSolid]:
    """The robot's parts pulled apart along its axis; shells lifted off their sections, a drum for each cable."""
    by_name = {part.name: part for part in parts}
    chain = [by_name[name] for name in _ORDER if name in by_name]
    chain += [part for part in parts if part.group in ("trunk", "gripper")]
    solids: list[DrawnSolid] = []
    shift, end = 0.0, -math.inf
    for part in chain:
        mesh = part.assembled()
        low, high = (float(z) for z in mesh.bounds[:, 2])
        shift = max(shift, end + _APART - low) if solids else shift
        count, plural = (n_cable, "s") if part.group == "drums" else (1, "")
        for k in range(count):
            copy = _turn(mesh, 2 * math.pi * k / count, (0.0, 0.0, 1.0))
            name = "" if k else part.name + plural
            solids.append(DrawnSolid(name=name, mesh=copy.apply_translation((0, 0, shift)), color=_COLORS[part.group]))
        for shell in parts if part.group == "trunk" else ():
            if shell.group == "shells" and low <= shell.at[2] < high:
                lifted = shell.assembled()
                lifted.apply_translation((1.9 * float(lifted.bounds[1, 0]) + 25.0, 0, shift))
                name = "" if any(solid.name == "shells" for solid in solids) else "shells"
                solids.append(DrawnSolid(name=name, mesh=lifted, color=_COLORS["shells"]))
        end = high + shift
    return solids


def _turn(mesh: Trimesh, angle: float, axis: tuple[float, float, float]) -> Trimesh:
    """A copy rotated about an axis through the origin by an angle [rad]."""
    from trimesh.transformations import rotation_matrix

    return mesh.copy().apply_transform(rotation_matrix(angle, axis))  # type: ignore[no-untyped-call]
