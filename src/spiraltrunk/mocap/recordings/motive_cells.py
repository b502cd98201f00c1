"""The data rows of a Motive CSV as numbers; what is blank is not a number."""

from __future__ import annotations

import csv
import re
from array import array
from collections.abc import Sequence
from typing import NamedTuple, final

import numpy as np

from spiraltrunk.errors import TakeError
from spiraltrunk.files.text_lines import Lines, decode
from spiraltrunk.mocap.recordings.decimals import read_decimals

MOST_CELLS = 150_000_000
"""Numbers up to which a recording is read [-]: 1.2 GB of memory, an hour of 18 bodies with their markers at 100 Hz."""

_BATCH = 1 << 19
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
    reader = _Reader(lines.source, n_column, wanted)
    for line in lines:
        reader.add(line, lines.number)
    reader.flush()
    reason = "" if reader.cut is None else str(reader.cut)
    if reader.cut is None and not lines.is_ended and reader.numbers and reader.numbers[-1] == lines.number:
        reason = f"{lines.source!r}, line {lines.number}: the file ends within the line"
        del reader.values[len(reader.values) - len(wanted) :], reader.numbers[-1:]
    table = np.frombuffer(reader.values, float) if reader.values else np.empty(0)
    return Table(table.reshape(-1, len(wanted)), np.array(reader.numbers, np.int64), reason)


@final
class _Reader:
    """Rows as they come: many plain ones at once, others one by one."""

    def __init__(self, source: str, n_column: int, wanted: Sequence[int]) -> None:
        self.values, self.numbers = array("d"), array("q")
        self.cut: TakeError | None = None
        self._source, self._n_column, self._wanted = source, n_column, list(wanted)
        self._batch: list[bytes] = []
        self._size = 0

    def add(self, line: bytes, number: int) -> None:
        """Take in a line; after one with a fault nothing but blank ones may come."""
        if self.cut is not None and not _BLANK.fullmatch(line):
            raise self.cut
        if line.count(b",") != self._n_column - 1:
            if _BLANK.fullmatch(line):
                return
            self.flush()
            self._add_carefully(line, number)
            return
        if (len(self.numbers) + 1) * len(self._wanted) > MOST_CELLS:
            told = f"the recording has more than {MOST_CELLS} numbers; allowed: fewer: export it in parts"
            raise TakeError(told, file=self._source, line=number)
        self._batch.append(line)
        self.numbers.append(number)
        self._size += len(line)
        if self._size > _BATCH:
            self.flush()

    def flush(self) -> None:
        """Turn the lines that have come into numbers."""
        batch, self._batch, self._size = self._batch, [], 0
        if not batch:
            return
        values, is_plain = read_decimals(b",".join(batch) + b",")
        table = values.reshape(len(batch), -1)[:, self._wanted]
        odd = np.flatnonzero(~is_plain.reshape(len(batch), -1)[:, self._wanted].all(axis=1))
        first = len(self.numbers) - len(batch)
        for row in odd:
            try:
                table[row] = self._read_carefully(batch[row], self.numbers[first + row])
            except TakeError as error:
                self._stop(error, is_last=row == len(batch) - 1)
                table = table[:-1]
        self.values.frombytes(np.ascontiguousarray(table).tobytes())

    def _stop(self, error: TakeError, *, is_last: bool) -> None:
        """Leave out a last row with a fault, for the case that it is the file's last."""
        if not is_last:
            raise error
        self.cut = error
        self.numbers.pop()

    def _add_carefully(self, line: bytes, number: int) -> None:
        try:
            self.values.fromlist(self._read_carefully(line, number))
            self.numbers.append(number)
        except TakeError as error:
            self.cut = error

    def _read_carefully(self, line: bytes, number: int) -> list[float]:
        """A row that is not plain: quoted cells, exponents, more blank ones, or a fault that is to be told."""
        try:
            cells = [cell.strip() for cell in next(csv.reader([decode(line)]), [])]
        except csv.Error as error:
            raise TakeError(f"{error}; allowed: rows of numbers", file=self._source, line=number) from None
        while len(cells) > self._n_column and not cells[-1]:
            cells.pop()
        if len(cells) != self._n_column:
            told = f"the row has {len(cells)} cells, the header {self._n_column} columns; allowed: equally many"
            if len(cells) > 1.5 * self._n_column:
                told += ", with points and not commas in numbers: export with English number formats"
            raise TakeError(told, file=self._source, line=number)
        return [_read_cell(cells[index], self._source, number, index + 1) for index in self._wanted]


def _read_cell(text: str, source: str, line: int, column: int) -> float:
    if not text:
        return float("nan")
    try:
        if "_" in text or not text.isascii():
            raise ValueError
        return float(text)
    except ValueError:
        what = "a number with a decimal point, or a blank cell"
        if _COMMA.fullmatch(text):
            what += ": export with English number formats"
        told = f"the cell is {text[:40]!r}; allowed: {what}"
        raise TakeError(told, file=source, line=line, column=column) from None
