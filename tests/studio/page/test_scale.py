"""Scales of sliders: their ends, and what is a number."""

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.studio.page.scale import Scale, is_number

SCALE = Scale(label="Angle", unit="mm", least=2.0, most=90.0, step=0.5, hint="A measure")


@pytest.mark.parametrize(
    ("value", "least", "most"),
    [
        (50.0, 2.0, 90.0),
        (29041.27, 2.0, 29100.0),
        (2.4123e-5, 2.41e-5, 90.0),
        (-0.71234, -0.713, 90.0),
        (0.0, 0.0, 90.0),
    ],
)
def test_a_scale_includes_a_value_by_an_end_of_3_digits(value, least, most):
    scale = SCALE.include(value)
    assert (scale.least, scale.most) == (least, most)
    assert scale.accepts(value)


def test_digits_are_those_of_ascii():
    assert all(map(is_number, ("1", "-2.5", "+.5", "3.", "1e-3", "2E4")))
    assert not any(map(is_number, ("\u0662", "1_000", "1,5", "", ".", "nan", "inf", "0x1", "1 2")))
    assert SCALE.refuse("\u0662").startswith("Angle was '\u0662'; allowed: a number, 2 to 90 mm")
