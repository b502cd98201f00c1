"""Data rows of a Motive CSV as numbers; blank cells are not a number."""

from __future__ import annotations

import csv
import math
import re
from array import array
from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from spiraltrunk.errors import TakeError
from spiraltrunk.files.text_lines import Lines, decode

MOST_CELLS = 150_000_000
"""Largest number of cells [-]: 1.2 GB of memory, an hour of 18 bodies with their markers at 100 Hz."""

_BLANK = re.compile(rb"[\s,\"]*")
_COMMA = re.compile(r"[-+]?\d+,\d+")


def read_cells(lines: Lines, n_column: int, wanted: Sequence[int]) -> tuple[np.ndarray, np.ndarray, str]:
    """Read the columns ``wanted`` of all rows, without a last row that is incomplete.

    Returns:
        Numbers, shape (n_row, n_wanted), the line of each row, shape (n_row,), and why a last row was left out.
    """
    values, numbers = array("d"), array("q")
    fault: TakeError | None = None
    for line in lines:
        if line.count(b",") != n_column - 1 and _BLANK.fullmatch(line):
            continue
        if fault is not None:
            raise fault
        if (len(numbers) + 1) * len(wanted) > MOST_CELLS:
            reason = f"the recording has more than {MOST_CELLS} numbers; allowed: fewer: export it in parts"
            raise TakeError(reason, file=lines.source, line=lines.number)
        try:
            row = _read_row(line, lines, n_column, wanted)
        except TakeError as error:
            fault = error  # Raised only if another row follows.
            continue
        values.fromlist(row)
        numbers.append(lines.number)
    reason = "" if fault is None else str(fault)
    if fault is None and not lines.is_ended and numbers and numbers[-1] == lines.number:
        reason = f"{lines.source!r}, line {lines.number}: the file ends within the line"
        del values[len(values) - len(wanted) :], numbers[-1:]
    return np.array(values).reshape(-1, len(wanted)), np.array(numbers, np.int64), reason


def _read_row(line: bytes, lines: Lines, n_column: int, wanted: Sequence[int]) -> list[float]:
    """Numbers of a row, which may have quoted cells or trailing empty cells."""
    plain = line.split(b",")
    if len(plain) == n_column and not (b"_" in line or b"n" in line or b"N" in line):  # No nan, which is refused.
        with suppress(ValueError):
            return [float(plain[index] or "nan") for index in wanted]
    try:
        cells = [cell.strip() for cell in next(csv.reader([decode(line)]), [])]
    except csv.Error as error:
        raise TakeError(f"{error}; allowed: rows of numbers", file=lines.source, line=lines.number) from None
    while len(cells) > n_column and not cells[-1]:
        cells.pop()
    if len(cells) != n_column:
        reason = f"the row has {len(cells)} cells, the header {n_column} columns; allowed: equally many"
        if len(cells) > 1.5 * n_column:
            reason += ", with points and not commas in numbers: export with English number formats"
        raise TakeError(reason, file=lines.source, line=lines.number)
    return [_read_cell(cells[index], lines, index + 1) for index in wanted]


def _read_cell(text: str, lines: Lines, column: int) -> float:
    if not text:
        return math.nan
    try:
        value = float(text)
        if "_" in text or not text.isascii() or math.isnan(value):
            raise ValueError
        return value
    except ValueError:
        allowed = "a number with a decimal point, or a blank cell"
        if _COMMA.fullmatch(text):
            allowed += ": export with English number formats"
        reason = f"the cell is {text[:40]!r}; allowed: {allowed}"
        raise TakeError(reason, file=lines.source, line=lines.number, column=column) from None
