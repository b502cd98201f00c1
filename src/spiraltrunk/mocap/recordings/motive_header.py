"""Header of a Motive CSV: key and value pairs, then one row each for type, name, ID, quantity and axis.

Files without header cannot be read. Versions differ in labels (empty in 1.21) and in columns before the data (a time
code in 1.24).
"""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from dataclasses import dataclass
from itertools import zip_longest
from typing import NamedTuple, final

from spiraltrunk.errors import TakeError
from spiraltrunk.files.text_lines import Lines, decode

MOST_COLUMNS = 20_000
"""Largest number of columns [-]."""

_MOST_ROWS = 20
_KNOWN = ("1.21", "1.22", "1.23", "1.24")
_KEYS = (
    "format version", "take name", "take notes", "capture frame rate", "export frame rate", "capture start time",
    "total frames in take", "total exported frames", "rotation type", "length units", "coordinate space",
)  # fmt: skip
_UNITS = {"meter": 1.0, "metre": 1.0, "m": 1.0, "centimeter": 1e-2, "centimetre": 1e-2, "cm": 1e-2,
          "millimeter": 1e-3, "millimetre": 1e-3, "mm": 1e-3}  # fmt: skip


class Column(NamedTuple):
    """One column of data; texts except the name are in lower case."""

    place: int
    kind: str
    name: str
    id: str
    quantity: str
    axis: str
    repeat: int
    """Number of earlier columns with the same texts, which distinguishes duplicates."""


@final
@dataclass(frozen=True, kw_only=True)
class Header:
    """Content of the header; None for numbers that it lacks."""

    take: str
    comment: str
    started: str
    rate: float
    """Frames per second of the export [Hz]."""
    capture_rate: float | None
    """Frames per second of the cameras [Hz]."""
    unit: float
    """Length unit [m]."""
    rotation: str
    """Rotation type, such as Quaternion or XYZ; empty if it is missing."""
    frames: int | None
    n_column: int
    """Number of columns of a data row [-]."""
    time: int | None
    """Column of the times."""
    columns: tuple[Column, ...]
    """Columns of data."""
    line: int
    """Line of the axes; the data follow."""
    notes: tuple[str, ...]


def read_header(lines: Lines) -> Header:
    """Read lines up to the row of axes."""
    rows = _read_rows(lines)
    pairs = _read_pairs(rows[0][1])
    labels = [row for row in rows[1:-1] if any(row[1])]
    line, axes = rows[-1]
    columns, n_column = _read_columns(labels, rows[-1], lines.source)
    capture = _read_rate(pairs.get("capture frame rate"))
    rate, frames = _read_rate(pairs.get("export frame rate")) or capture, pairs.get("total exported frames", "")
    if rate is None:
        given = [pairs.get(key, "missing")[:40] for key in ("export frame rate", "capture frame rate")]
        what = f"Export Frame Rate is {given[0]!r} and Capture Frame Rate {given[1]!r}"
        raise TakeError(f"{what}; allowed: one of them a number of Hz", file=lines.source, line=1)
    return Header(
        take=pairs.get("take name", ""), comment=pairs.get("take notes", ""),
        started=pairs.get("capture start time", ""), rotation=pairs.get("rotation type", ""),
        rate=rate, capture_rate=capture, unit=_read_unit(pairs, lines.source),
        frames=int(frames) if re.fullmatch(r"[0-9]{1,15}", frames) else None,
        n_column=n_column, time=_find_time(axes, columns), columns=columns, line=line,
        notes=(*_check_version(pairs["format version"], lines.source), *_check_space(pairs, lines.source)),
    )  # fmt: skip


def _read_rows(lines: Lines) -> list[tuple[int, list[str]]]:
    """Rows with the number of their line, from the first to that of the axes."""
    rows: list[tuple[int, list[str]]] = []
    try:
        for row in csv.reader(decode(line) + "\n" for line in lines):
            cells = [cell.strip() for cell in row]
            if not rows:
                _check_first(cells, lines.source)
            rows.append((lines.number, cells))
            if len(cells) > MOST_COLUMNS:
                reason = f"the row has {len(cells)} columns; allowed: at most {MOST_COLUMNS}"
                raise TakeError(reason, file=lines.source, line=lines.number)
            if cells and cells[0].lower() == "frame":
                return rows
            if len(rows) > _MOST_ROWS:
                break
    except csv.Error as error:
        raise TakeError(f"{error}; allowed: the header of a Motive CSV", file=lines.source, line=lines.number) from None
    if not rows:
        raise TakeError("the file is empty; allowed: a Motive CSV with its header", file=lines.source)
    allowed = "a Motive CSV, exported whole and with Header information on"
    raise TakeError(f"there is no row that begins with Frame; allowed: {allowed}", file=lines.source, line=lines.number)


def _check_first(cells: list[str], source: str) -> None:
    """Refuse a file that is no Motive CSV, with the likely reason."""
    first = cells[0] if cells else ""
    if first.lower() == "format version" and len(cells) > 1:
        return
    if re.match(r"format version\s*[;\t]", first, re.IGNORECASE):
        reason = "cells are divided by semicolons or tabs; allowed: commas between cells and points in numbers, as "
        reason += "Motive writes them: do not save it again from a spreadsheet of another language"
    elif first.lower().startswith(("frame", "time", "type")) or re.fullmatch(r"[-+\d.eE]+", first):
        reason = "the header is missing; allowed: a Motive CSV with its header: export with Header information on"
    else:
        reason = f"it begins with {first[:40]!r}; allowed: a Motive CSV, which begins with 'Format Version'"
    raise TakeError(reason, file=source, line=1)


def _read_pairs(cells: list[str]) -> dict[str, str]:
    """Values by key; keys are found by name, as values may contain commas."""
    pairs: dict[str, str] = {}
    for i, cell in enumerate(cells[:-1]):
        key = cell.lower()
        if key in _KEYS and key not in pairs:
            value = cells[i + 1]
            pairs[key] = "" if value.lower() in _KEYS else value
    return pairs


def _check_version(version: str, source: str) -> list[str]:
    if not re.fullmatch(r"1\.[0-9]{1,2}[0-9.]{0,8}", version):
        reason = f"the format's version is {version[:40]!r}; allowed: {_KNOWN[0]} to {_KNOWN[-1]}"
        raise TakeError(reason, file=source, line=1, column=2)
    note = f"version {version} of the format is none of {_KNOWN[0]} to {_KNOWN[-1]}; read as if it were"
    return [] if version in _KNOWN else [note]


def _check_space(pairs: dict[str, str], source: str) -> list[str]:
    space = pairs.get("coordinate space", "")
    if space and space.lower() not in ("global", "world"):
        reason = f"Coordinate Space is {space[:40]!r}; allowed: Global: export again with World coordinates"
        raise TakeError(reason, file=source, line=1)
    return [] if space else ["the header has no coordinate space; taken as Global"]


def _read_unit(pairs: dict[str, str], source: str) -> float:
    unit = pairs.get("length units", "")
    size = _UNITS.get(unit.lower()) or _UNITS.get(unit.lower().removesuffix("s"))
    if size is None:
        reason = f"Length Units are {unit[:40]!r}; allowed: Meters, Centimeters or Millimeters"
        raise TakeError(reason, file=source, line=1)
    return size


def _read_rate(text: str | None) -> float | None:
    """A rate from 0.01 to 100,000 Hz, or None."""
    try:
        rate = float(text or "")
    except ValueError:
        return None
    return rate if math.isfinite(rate) and 0.01 <= rate <= 1e5 else None


def _find_time(axes: list[str], columns: tuple[Column, ...]) -> int | None:
    """The column of the times, one of those before the data."""
    before = axes[: columns[0].place]
    return next((i for i, label in enumerate(before) if re.match(r"time(?!\s*code)", label, re.IGNORECASE)), None)


def _read_columns(
    labels: list[tuple[int, list[str]]], last: tuple[int, list[str]], source: str
) -> tuple[tuple[Column, ...], int]:
    """Columns with a type, and the number of columns of a row."""
    line, axes = last
    if len(labels) < 2:
        what = f"{len(labels)} rows between the first and that of the axes"
        raise TakeError(f"{what}; allowed: Type, Name, ID and the quantities", file=source, line=line)
    named = _name_rows(labels[:-1])
    rows = [*(named.get(key, []) for key in ("type", "name", "id")), labels[-1][1], axes]
    seen: Counter[tuple[str, ...]] = Counter()
    columns, n_column = [], 1
    for index, (kind, name, ident, quantity, axis) in enumerate(zip_longest(*rows, fillvalue="")):
        if kind or name or quantity or axis:
            n_column = index + 1
        if index > 0 and kind.lower() not in ("", "type"):
            texts = (kind.lower(), name, ident, quantity.lower(), axis.lower())
            columns.append(Column(index, *texts, seen[texts]))
            seen[texts] += 1
    if not columns:
        reason = "no column has a type such as Rigid Body or Marker; allowed: an export with rigid bodies or markers"
        raise TakeError(reason, file=source, line=labels[0][0])
    return tuple(columns), n_column


def _name_rows(labels: list[tuple[int, list[str]]]) -> dict[str, list[str]]:
    """Rows by label, or by order if labels are empty."""
    labelled = {"".join(row[1:2]).lower(): row for _, row in labels}
    if "type" in labelled:
        return labelled
    return dict(zip(("type", "name", "id"), (row for _, row in labels), strict=False))
