"""Plain decimals are read to the bit as `float` reads them, and others are left to it."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.mocap.recordings.decimals import read_decimals

plain = st.from_regex(r"-?[0-9]{1,9}(\.[0-9]{0,6})?|-?\.[0-9]{1,9}", fullmatch=True)


@given(st.lists(st.one_of(plain, st.just("")), min_size=1, max_size=30))
def test_plain_numbers_are_floats(cells):
    values, is_plain = read_decimals(",".join(cells).encode() + b",")
    assert is_plain.all()
    expected = np.array([float(cell or "nan") for cell in cells])
    np.testing.assert_array_equal(values, expected)
    np.testing.assert_array_equal(np.signbit(values)[expected == 0], np.signbit(expected)[expected == 0])


@given(st.lists(st.text('0123456789-+.eEnaif_ "', max_size=24), min_size=1, max_size=8))
def test_what_is_called_plain_is_what_float_says(cells):
    values, is_plain = read_decimals(",".join(cells).encode() + b",")
    for cell, value, is_one in zip(cells, values, is_plain, strict=True):
        if is_one and cell:
            assert value == float(cell)
        else:
            assert np.isnan(value)


def test_what_has_too_many_digits_is_left():
    values, is_plain = read_decimals(
        b"123456789012345,1234567890123456,0.123456789012345678901234567890,1.2.3,-,.,--1,1-,"
    )
    np.testing.assert_array_equal(is_plain, [True] + [False] * 7)
    assert values[0] == 123456789012345.0
