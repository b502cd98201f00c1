"""Joint bench records as CSV: static loads of single joints, and ring-downs."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from spiraltrunk.errors import TakeError
from spiraltrunk.files.text_lines import open_take

STATIC_COLUMNS = {"joint": (1.0, 199.0), "lever_arm_m": (0.0, 10.0), "mass_g": (0.0, 1e6), "angle_deg": (0.0, 180.0)}
"""Columns of static loads, with the least and the largest number allowed."""

RING_DOWN_COLUMNS = {"time_s": (-1e9, 1e9), "acceleration": (-1e9, 1e9)}
"""Columns of a ring-down, likewise."""

_MOST_BYTES = 20_000_000


@final
@dataclass(frozen=True, kw_only=True)
class StaticLoads:
    """Readings of one joint."""

    joint: int
    """Joint, 1 at the base."""
    bend: np.ndarray
    """Deflections, shape (n,) [rad]."""
    mass: np.ndarray
    """Scale readings, shape (n,) [kg]."""
    lever_arm: np.ndarray
    """Distance from the joint to where the scale pushes, shape (n,) [m]."""


def load_static_loads(path: str | Path) -> tuple[StaticLoads, ...]:
    """Readings by joint, from the base on.

    Raises:
        TakeError: for anything else than such a record, with file, line and column.
    """
    joint, lever_arm, mass, angle = _read(path, STATIC_COLUMNS).T
    return tuple(
        StaticLoads(
            joint=int(one), bend=np.radians(angle[joint == one]), mass=1e-3 * mass[joint == one],
            lever_arm=lever_arm[joint == one],
        )
        for one in np.unique(joint)
    )  # fmt: skip


def load_ring_down(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and accelerations of a ring-down, shapes (n,).

    Raises:
        TakeError: for anything else than such a record, with file, line and column.
    """
    time, acceleration = _read(path, RING_DOWN_COLUMNS).T
    return time, acceleration


def _read(path: str | Path, columns: dict[str, tuple[float, float]]) -> np.ndarray:
    """The numbers, shape (n, n_column)."""
    file = str(path)
    with open_take(path, f"a joint bench record, CSV of {', '.join(columns)}") as stream:
        data = stream.read(_MOST_BYTES + 1)
    if len(data) > _MOST_BYTES:
        raise TakeError(f"it has more than {_MOST_BYTES} bytes; allowed: a shorter record", file=file)
    try:
        rows = list(csv.reader(io.StringIO(data.decode("utf-8-sig"), newline=None)))
    except (UnicodeDecodeError, csv.Error) as error:
        raise TakeError(f"no text with commas: {error}; allowed: CSV in UTF-8", file=file) from None
    head = [cell.strip().lower() for cell in rows[0]] if rows else []
    if head != list(columns):
        given = ", ".join(head)[:80] or "none"
        raise TakeError(f"its columns are {given}; allowed: {','.join(columns)}", file=file, line=1)
    table = []
    for line, row in enumerate(rows[1:], 2):
        if any(cell.strip() for cell in row):
            if len(row) != len(columns):
                raise TakeError(f"{len(row)} cells; allowed: {len(columns)}", file=file, line=line)
            cells = enumerate(zip(row, columns.items(), strict=True), 1)
            table.append([_parse(cell, column, (file, line, place)) for place, (cell, column) in cells])
    if not table:
        raise TakeError("it holds no reading; allowed: one line each", file=file)
    return np.array(table)


def _parse(cell: str, column: tuple[str, tuple[float, float]], where: tuple[str, int, int]) -> float:
    name, (least, most) = column
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not least <= value <= most or (name == "joint" and not value.is_integer()):
        number = "a whole number from " if name == "joint" else ""
        file, line, place = where
        given = cell.strip()[:40] if math.isfinite(value) else repr(cell.strip()[:40])
        raise TakeError(
            f"{name} is {given}; allowed: {number}{least:g} to {most:g}",
            file=file,
            line=line,
            column=place,
        )
    return value
