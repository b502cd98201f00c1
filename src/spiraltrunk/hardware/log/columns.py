"""Columns of a channel, gathered message by message and turned into arrays."""

from __future__ import annotations

from typing import Any, final

import numpy as np

from spiraltrunk.errors import DriveError, describe
from spiraltrunk.hardware.log.channels import CHANNELS, Column, list_columns

_BLOCK = 4096
"""Messages after which values become an array, which takes a tenth of the room of Python's objects."""

_DTYPES = {"number": float, "integer": np.int64, "boolean": bool}


@final
class Columns:
    """Values of one channel's fields."""

    def __init__(self, topic: str) -> None:
        self._topic = topic
        self._columns = list_columns(topic)
        self._values: dict[str, list[Any]] = {name: [] for name in self._columns}
        self._blocks: dict[str, list[np.ndarray]] = {name: [] for name in self._columns}
        self._n = 0

    def add(self, message: dict[str, Any]) -> None:
        """Take over one message.

        Raises:
            DriveError: where a field is missing or of another type.
        """
        for name, column in self._columns.items():
            if name not in message and not column.is_later:
                raise DriveError(f"a message of {self._topic} has no {name}; allowed: {', '.join(self._columns)}")
            value = message.get(name)
            if column.kind == "string" and not _is_text(value, column.depth):
                raise _refuse(self._topic, name, value)
            self._values[name].append(value)
        self._n += 1
        if self._n % _BLOCK == 0:
            self._pack()

    def build(self) -> Any:
        """The channel's dataclass.

        Raises:
            DriveError: where a field changes its shape or type.
        """
        self._pack()
        return CHANNELS[self._topic](**{name: self._join(name, column) for name, column in self._columns.items()})

    def _pack(self) -> None:
        for name, column in self._columns.items():
            if column.kind != "string" and self._values[name]:
                self._blocks[name].append(self._to_array(name, column, self._values[name]))
                self._values[name] = []

    def _to_array(self, name: str, column: Column, values: list[Any]) -> np.ndarray:
        try:
            found = np.array(_fill(values, column.depth), dtype=object if column.kind == "number" else None)
            array = found.astype(_DTYPES[column.kind], casting="unsafe" if column.kind == "number" else "same_kind")
        except (ValueError, TypeError, OverflowError):
            raise _refuse(self._topic, name, values[0]) from None
        is_number = column.kind != "number" or all(type(one) in _NUMBERS for one in found.flat)
        if array.ndim != 1 + column.depth or not is_number or np.isinf(array).any():
            raise _refuse(self._topic, name, values[0])
        return array

    def _join(self, name: str, column: Column) -> Any:
        if column.kind == "string":
            texts = self._values[name]
            return tuple(tuple(text) if isinstance(text, list) else text for text in texts)
        blocks = self._blocks[name]
        if not blocks:
            return np.empty((0,) * (1 + column.depth), _DTYPES[column.kind])
        shapes = {block.shape[1:] for block in blocks if 0 not in block.shape[1:]}
        if len(shapes) > 1:
            raise _refuse(self._topic, name, sorted(shapes))
        shape = shapes.pop() if shapes else blocks[0].shape[1:]
        filled = [block if block.shape[1:] == shape else np.full((len(block), *shape), np.nan) for block in blocks]
        return np.concatenate(filled)


_NUMBERS = (float, int, type(None))


def _fill(values: list[Any], depth: int) -> list[Any]:
    """The values, of which those that are missing become arrays of NaN.

    Raises:
        ValueError: where their shape is irregular.
    """
    if depth == 0 or None not in values:
        return values
    shape = next((np.shape(value) for value in values if value is not None), (0,) * depth)
    missing = np.full(shape, np.nan).tolist()
    return [missing if value is None else value for value in values]


def _is_text(value: object, depth: int) -> bool:
    if depth and isinstance(value, list):
        return all(isinstance(one, str) for one in value)
    return value is None or (depth == 0 and isinstance(value, str))


def _refuse(topic: str, name: str, value: object) -> DriveError:
    return DriveError(f"{name} of {topic} is {describe(value)}; allowed: what `spiraltrunk drive` writes there")
