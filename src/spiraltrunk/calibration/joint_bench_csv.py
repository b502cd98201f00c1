"""Bench records as CSV: static loads of joints, and ring-downs."""

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

LOADS = ("joint", "lever_arm_m", "mass_g", "angle_deg")
"""Columns of static loads."""

RING = ("time_s", "acceleration")
"""Columns of a ring-down."""

_MOST_BYTES = 20_000_000
_MOST_NUMBER = 1e9
_LEAST_LOADS, _MOST_LOADS = (1.0, 0.0, 0.0, 0.0), (199.0, 10.0, 1e6, 180.0)
"""Least and largest joint, lever arm [m], mass [g] and angle [deg] of a reading."""


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
    """Where the scale pushes, from the joint, shape (n,) [m]."""


def load_static_loads(path: str | Path) -> tuple[StaticLoads, ...]:
    """Readings by joint, the base's first.

    Raises:
        TakeError: with file, line and column, for what is no such record.
    """
    table, lines = _read(path, LOADS)
    joints = table[:, 0]
    _refuse_outside(table, lines, str(path))
    wrong = np.flatnonzero(joints != np.rint(joints))
    if len(wrong):
        raise TakeError(
            f"joint is {joints[wrong[0]]:g}; allowed: a whole number from 1", file=str(path), line=lines[int(wrong[0])],
            column=1,
        )  # fmt: skip
    return tuple(
        StaticLoads(
            joint=int(joint), bend=np.radians(table[joints == joint, 3]), mass=1e-3 * table[joints == joint, 2],
            lever_arm=table[joints == joint, 1],
        )
        for joint in np.unique(joints)
    )  # fmt: skip


def _refuse_outside(table: np.ndarray, lines: list[int], file: str) -> None:
    for column, (least, most) in enumerate(zip(_LEAST_LOADS, _MOST_LOADS, strict=True)):
        outside = np.flatnonzero((table[:, column] < least) | (table[:, column] > most))
        if len(outside):
            row = int(outside[0])
            told = f"{LOADS[column]} is {table[row, column]:g}; allowed: {least:g} to {most:g}"
            raise TakeError(told, file=file, line=lines[row], column=column + 1)


def load_ring_down(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and accelerations of a ring-down, shapes (n,).

    Raises:
        TakeError: with file, line and column, for what is no such record.
    """
    table, _ = _read(path, RING)
    return table[:, 0], table[:, 1]


def _read(path: str | Path, columns: tuple[str, ...]) -> tuple[np.ndarray, list[int]]:
    """All numbers, and the line in which each row stands."""
    with open_take(path) as file:
        data = file.read(_MOST_BYTES + 1)
    name = str(path)
    if len(data) > _MOST_BYTES:
        raise TakeError(f"it has more than {_MOST_BYTES} bytes; allowed: a shorter record", file=name)
    try:
        rows = list(csv.reader(io.StringIO(data.decode("utf-8-sig"), newline=None)))
    except (UnicodeDecodeError, csv.Error) as error:
        raise TakeError(f"no text with commas: {error}; allowed: CSV in UTF-8", file=name) from None
    given = tuple(cell.strip().lower() for cell in rows[0]) if rows else ()
    if given != columns:
        raise TakeError(
            f"its columns are {', '.join(given)[:80] or 'none'}; allowed: {','.join(columns)}", file=name, line=1
        )
    filled = [(line, row) for line, row in enumerate(rows[1:], 2) if any(cell.strip() for cell in row)]
    if not filled:
        raise TakeError("it holds no reading; allowed: one line each", file=name)
    numbers = [
        [_number(cell, (name, line, column)) for column, cell in enumerate(_fit(row, columns, (name, line)), 1)]
        for line, row in filled
    ]
    return np.array(numbers), [line for line, _ in filled]


def _fit(row: list[str], columns: tuple[str, ...], where: tuple[str, int]) -> list[str]:
    if len(row) != len(columns):
        raise TakeError(f"{len(row)} cells; allowed: {len(columns)}", file=where[0], line=where[1])
    return row


def _number(cell: str, where: tuple[str, int, int]) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not abs(value) <= _MOST_NUMBER:
        file, line, column = where
        raise TakeError(
            f"{cell[:40]!r} is no finite number; allowed: one up to {_MOST_NUMBER:g}", file=file, line=line,
            column=column,
        )  # fmt: skip
    return value
