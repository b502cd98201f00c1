"""Plain decimal numbers by the million: digits with at most one point and a minus, as recordings have them.

All digits together are a whole number below 2^53 and the power of ten that divides it is exact, so that one division
gives the double that `float` gives. What is written otherwise is left to `float`.
"""

from __future__ import annotations

import numpy as np

_MOST_DIGITS = 15
_POWERS = 10 ** np.arange(19, dtype=np.int64)
_COMMA, _MINUS, _POINT, _ZERO = 44, 45, 46, 48


def read_decimals(text: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of cells that each end in a comma, and which of them are plain.

    Args:
        text: cells, the last one with its comma too.

    Returns:
        Values, not a number for blank cells and for those that are not plain, shape (n,) [-]; which are plain or blank,
        shape (n,) [bool].
    """
    letters = np.frombuffer(text, np.uint8)
    ends = np.flatnonzero(letters == _COMMA)
    starts = np.concatenate([[0], ends[:-1] + 1])
    length = ends - starts
    digit = letters - np.uint8(_ZERO)  # What is below zero wraps round to more than nine.
    is_digit, is_point = digit < 10, letters == _POINT
    is_negative = letters[starts] == _MINUS
    digits = np.add.reduceat(is_digit, starts, dtype=np.int64)
    points = np.add.reduceat(is_point, starts, dtype=np.int64)
    is_plain = (digits + points + is_negative == length) & (points <= 1) & (digits >= 1) & (digits <= _MOST_DIGITS)
    so_far = np.cumsum(is_digit, dtype=np.int32)
    after = np.repeat(so_far[ends], length + 1) - so_far
    share = _POWERS[np.minimum(after, len(_POWERS) - 1)] * np.where(is_digit, digit, np.uint8(0))
    whole = np.add.reduceat(share, starts)
    decimals = np.add.reduceat(np.where(is_point, after, np.int32(0)), starts)
    values = whole / _POWERS[np.minimum(decimals, len(_POWERS) - 1)]
    np.negative(values, out=values, where=is_negative)
    values[~is_plain] = np.nan
    return values, is_plain | (length == 0)
