"""The maker's two pictures: the robot taken apart along its axis, and every kind of part on one sheet."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from spiraltrunk.report.solids.solids_picture import PictureSolid, write_exploded, write_sheet

_COLORS = {
    "trunk": (0.62, 0.67, 0.74), "gripper": (0.86, 0.47, 0.41), "shells": (0.93, 0.78, 0.66),
    "moulds": (0.80, 0.80, 0.84), "housing": (0.42, 0.47, 0.55), "drums": (0.90, 0.72, 0.30),
    "horn": (0.90, 0.72, 0.30), "adapter": (0.55, 0.62, 0.55),
    "wedge": (0.66, 0.62, 0.74), "markers": (0.55, 0.72, 0.70),
}  # fmt: skip

_APART = 45.0
"""Room between neighbours of the exploded view [mm]."""

_ORDER = ("adapter", "housing", "drum", "horn", "lid", "neck")
"""What comes before the trunk, from the arm on."""


@final
@dataclass(frozen=True, kw_only=True)
class Placed:
    """One part and where it belongs."""

    name: str
    """Its name."""
    group: str
    """What it belongs to."""
    note: str
    """What it is."""
    count: int
    """How many there are."""
    corners: np.ndarray
    """Triangles in its own frame, shape (n, 3, 3) [mm]."""
    at: tuple[float, float, float]
    """Where its frame is in the straight trunk's [mm]."""
    turn: float
    """Turn about x into that frame [rad]."""


def write_pictures(placed: Sequence[Placed], folder: Path, *, title: str, n_cable: int) -> None:
    """Write ``parts.png``, and ``exploded.png`` and ``exploded.svg`` where there is more than one part to take apart.

    Raises:
        OSError: where a file cannot be written.
    """
    write_sheet([_plain(part, placed) for part in _kinds(placed)], folder / "parts.png", title=f"{title}: parts")
    apart = explode(placed, n_cable)
    if len(apart) > 1:
        paths = [folder / f"exploded.{ending}" for ending in ("png", "svg")]
        write_exploded(apart, paths, title=f"{title}: taken apart")


def explode(placed: Sequence[Placed], n_cable: int) -> list[PictureSolid]:
    """The parts of the robot, assembled but pulled apart along its axis; shells lifted off their sections."""
    by_name = {part.name: part for part in placed}
    chain = [by_name[name] for name in _ORDER if name in by_name]
    chain += [part for part in placed if part.group in ("trunk", "gripper")]
    solids: list[PictureSolid] = []
    shift, last = 0.0, -math.inf
    for part in chain:
        corners = assembled(part)
        low, high = float(corners[..., 2].min()), float(corners[..., 2].max())
        shift = max(shift, last + _APART - low) if math.isfinite(last) else shift
        solids += _copies(part, corners + np.array([0.0, 0.0, shift]), n_cable)
        if part.group == "trunk":
            inside = [other for other in placed if other.group == "shells" and low <= other.at[2] < high]
            solids += [_lifted(other, shift) for other in inside]
        last = high + shift
    return [
        solid if i == 0 or solid.name != "shells" or not _has(solids[:i]) else _unnamed(solid)
        for i, solid in enumerate(solids)
    ]


def assembled(part: Placed) -> np.ndarray:
    """Its triangles in the straight trunk's frame, shape (n, 3, 3) [mm]."""
    c, s = math.cos(part.turn), math.sin(part.turn)
    turned = part.corners @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
    return np.asarray(turned + part.at)


def _copies(part: Placed, corners: np.ndarray, n_cable: int) -> list[PictureSolid]:
    """A drum for each motor, one of everything else."""
    color, count = _COLORS[part.group], n_cable if part.group == "drums" else 1
    copies = []
    for k in range(count):
        angle = 2 * math.pi * k / count
        c, s = math.cos(angle), math.sin(angle)
        turned = corners @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        name = part.name if k == 0 else ""
        copies.append(PictureSolid(name=f"{name}s" if name and count > 1 else name, corners=turned, color=color))
    return copies


def _lifted(part: Placed, shift: float) -> PictureSolid:
    corners = assembled(part)
    beside = np.array([1.9 * float(corners[..., 0].max()) + 25.0, 0.0, shift])
    return PictureSolid(name="shells", corners=corners + beside, color=_COLORS["shells"])


def _has(solids: Sequence[PictureSolid]) -> bool:
    return any(solid.name == "shells" for solid in solids)


def _unnamed(solid: PictureSolid) -> PictureSolid:
    return PictureSolid(name="", corners=solid.corners, color=solid.color)


def _kinds(placed: Sequence[Placed]) -> list[Placed]:
    """One part of each family that differs in size alone: the first."""
    kinds: dict[str, Placed] = {}
    for part in placed:
        family = part.name if part.group == "trunk" else re.sub(r"_\d+$", "", part.name)
        kinds.setdefault(family, part)
    return list(kinds.values())


def _plain(part: Placed, placed: Sequence[Placed]) -> PictureSolid:
    size = np.ptp(part.corners, axis=(0, 1))
    note = " x ".join(f"{value:.0f}" for value in size) + " mm"
    if part.count > 1:
        note += f", {part.count} needed"
    return PictureSolid(name=part.name, corners=part.corners, color=_COLORS[part.group], note=note)
