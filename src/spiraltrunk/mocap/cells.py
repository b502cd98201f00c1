"""The data rows of a Motive CSV as numbers; what is blank is not a number."""

from __future__ import annotations

import csv
import re
from array import array
from collections.abc import Callable, Sequence
from operator import itemgetter
from typing import NamedTuple, NoReturn, final

import numpy as np

from spiraltrunk.errors import TakeError
from spiraltrunk.mocap.lines import Lines, decode

MOST_CELLS = 150_000_000
"""Numbers up to which a recording is read [-]: 1.2 GB of memory, an hour of 18 bodies with their markers at 100 Hz."""

_BLANK = re.compile(rb"[\s,\"]*")
_COMMA = re.compile(r"[-+]?\d+,\d+")


@final
class Table(NamedTuple):
    """Numbers by row and column."""

    values: np.ndarray
    """Shape (n_row, n_wanted) [-]."""
    line: np.ndarray
    """Line of each row, shape (n_row,) [-]."""
    cut: str
    """What is wrong with the last row, which is left out; empty where nothing is."""


def read_cells(lines: Lines, n_column: int, wanted: Sequence[int]) -> Table:
    """The columns ``wanted`` of all rows; a last row that is cut off is left out.

    Raises:
        TakeError: for a cell that is no number and a row of another length, with line and column.
    """
    values, numbers = array("d"), array("q")
    pick = _pick(n_column, wanted)
    cut: TakeError | None = None
    width, most = n_column - 1, MOST_CELLS - len(wanted)
    for line in lines:
        if cut is not None and not _BLANK.fullmatch(line):
            raise cut
        row = line
        if b",," in row:
            row = row.replace(b",,", b",nan,").replace(b",,", b",nan,")
        if row.endswith(b","):
            row += b"nan"
        try:
            if row.count(b",") != width or b"_" in row:
                raise ValueError
            found = list(map(float, pick(row.split(b","))))
        except ValueError:
            if _BLANK.fullmatch(line):
                continue
            try:
                found = _read_carefully(line, n_column, wanted, lines)
            except TakeError as error:
                cut = error
                continue
        if len(values) > most:
            told = f"the recording has more than {MOST_CELLS} numbers; allowed: fewer: export it in parts"
            raise TakeError(told, file=lines.source, line=lines.number)
        values.fromlist(found)
        numbers.append(lines.number)
    reason = "" if cut is None else str(cut)
    if cut is None and not lines.is_ended and numbers and numbers[-1] == lines.number:
        reason = f"{lines.source!r}, line {lines.number}: the file ends within the line"
        del values[len(values) - len(wanted) :], numbers[-1:]
    table = np.frombuffer(values, float) if values else np.empty(0)
    return Table(table.reshape(-1, len(wanted)), np.array(numbers, np.int64), reason)


def _pick(n_column: int, wanted: Sequence[int]) -> Callable[[list[bytes]], Sequence[bytes]]:
    if list(wanted) == list(range(n_column)):
        return lambda cells: cells
    if len(wanted) == 1:
        return lambda cells: cells[wanted[0] : wanted[0] + 1]
    return itemgetter(*wanted)


def _read_carefully(line: bytes, n_column: int, wanted: Sequence[int], lines: Lines) -> list[float]:
    """A row that plain reading does not take: quoted cells, more blank ones, or a fault that is to be told."""
    try:
        cells = [cell.strip() for cell in next(csv.reader([decode(line)]), [])]
    except csv.Error as error:
        raise TakeError(f"{error}; allowed: rows of numbers", file=lines.source, line=lines.number) from None
    while len(cells) > n_column and not cells[-1]:
        cells.pop()
    if len(cells) != n_column:
        told = f"the row has {len(cells)} cells, the header {n_column} columns; allowed: equally many"
        if len(cells) > 1.5 * n_column:
            told += ", with points and not commas in numbers: export with English number formats"
        raise TakeError(told, file=lines.source, line=lines.number)
    return [_read_cell(cells[index], index + 1, lines) for index in wanted]


def _read_cell(text: str, column: int, lines: Lines) -> float:
    if not text:
        return float("nan")
    try:
        if "_" in text or not text.isascii():
            raise ValueError
        return float(text)
    except ValueError:
        _refuse(text, column, lines)


def _refuse(text: str, column: int, lines: Lines) -> NoReturn:
    what = "a number with a decimal point, or a blank cell"
    if _COMMA.fullmatch(text):
        what += ": export with English number formats"
    raise TakeError(f"the cell is {text[:40]!r}; allowed: {what}", file=lines.source, line=lines.number, column=column)
