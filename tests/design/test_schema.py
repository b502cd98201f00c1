"""Numbers cross the file's units exactly, for every float."""

import math
from decimal import Decimal

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from spiraltrunk.design import GripperDesign, MassDesign, Spiral
from spiraltrunk.design.schema import DEGREE, MEGA, MILLI, ONE, Key, Kind, format_value, read_value

UNITS = [ONE, MILLI, MEGA, DEGREE]


def number(unit):
    return Key("a", Spiral, "a", unit)


@pytest.mark.parametrize("unit", UNITS)
@given(value=st.floats(allow_nan=False, allow_infinity=False))
@example(value=5e-324)
@example(value=1.7976931348623157e308)
@example(value=2.2250738585072014e-308)
def test_every_float_reads_back_as_itself(unit, value):
    text = format_value(value, number(unit))
    assert read_value("a", Decimal(text), number(unit)) == value


@pytest.mark.parametrize("unit", [MILLI, MEGA])
@given(text=st.decimals(Decimal("0.001"), Decimal(1000), places=6).map(str))
def test_short_decimals_come_out_as_they_went_in(unit, text):
    value = read_value("a", Decimal(text), number(unit))
    assert Decimal(format_value(value, number(unit))) == Decimal(text)


@given(st.integers(-720, 720))
def test_whole_degrees_come_out_whole_and_mean_what_code_means(degrees):
    key = number(DEGREE)
    value = read_value("a", degrees, key)
    assert format_value(value, key) == f"{degrees}.0"
    assert value == pytest.approx(math.radians(degrees), rel=3e-16)


@pytest.mark.parametrize(
    ("degrees", "code"),
    [(30, math.pi / 6), (60, math.pi / 3), (90, math.pi / 2), (120, 2 * math.pi / 3), (135, 3 * math.pi / 4),
     (180, math.pi), (240, 4 * math.pi / 3), (360, 2 * math.pi)],
)  # fmt: skip
def test_degrees_are_the_fractions_of_pi_that_code_writes(degrees, code):
    assert read_value("a", degrees, number(DEGREE)) == code
    assert format_value(code, number(DEGREE)) == f"{degrees}.0"


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0.0"), (-0.0, "0.0"), (1, "1.0"), (0.1, "0.1"), (1e-5, "0.00001"), (1e-7, "1e-7"), (1.5e20, "1.5e+20"),
     (123456789.0, "123456789.0")],
)  # fmt: skip
def test_numbers_are_short_and_toml(value, text):
    assert format_value(value, number(ONE)) == text


def test_millimetres_move_the_point_alone():
    assert format_value(0.044, number(MILLI)) == "44.0"
    assert format_value(3.825e-3, number(MILLI)) == "3.825"
    assert read_value("a", Decimal("3.825"), number(MILLI)) == 3.825e-3


def test_arrays_counts_and_texts():
    masses = Key("sections_g", MassDesign, "sections", MILLI, Kind.NUMBERS)
    assert format_value((0.026, 0.0213), masses) == "[26.0, 21.3]"
    assert read_value("m", [26, Decimal("21.3")], masses) == (0.026, 0.0213)
    assert format_value(3, Key("n_finger", GripperDesign, "n_finger", kind=Kind.COUNT)) == "3"
    assert format_value('a "b" \\', Key("a", Spiral, "a", kind=Kind.TEXT)) == '"a \\"b\\" \\\\"'
