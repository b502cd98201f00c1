"""Closed forms of the spiral against quadrature, finite differences and the law of self-similarity."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from spiraltrunk.design.spiral import Spiral, arc_length, chord, points, radius

SPIRALS = st.builds(Spiral, a=st.floats(1e-3, 10.0), b=st.floats(0.01, 1.5))
ANGLES = st.floats(-6.0, 6.0)


@given(SPIRALS, ANGLES)
def test_radius_is_the_distance_of_the_point_from_the_pole(spiral, theta):
    assert np.linalg.norm(points(spiral, theta)) == pytest.approx(float(radius(spiral, theta)), rel=1e-14)


@given(SPIRALS, ANGLES)
def test_radius_solves_its_differential_equation(spiral, theta):
    step = 1e-5
    growth = (radius(spiral, theta + step) - radius(spiral, theta - step)) / (2 * step)
    assert growth == pytest.approx(spiral.b * radius(spiral, theta), rel=1e-8)


def test_the_curve_is_drawn_as_in_the_paper():
    """Equation 2: x = -r cos(theta), y = r sin(theta)."""
    spiral = Spiral(a=2.0, b=0.1)
    assert points(spiral, 0.0) == pytest.approx([-2.0, 0.0])
    assert points(spiral, math.pi / 2) == pytest.approx([0.0, 2.0 * math.exp(0.05 * math.pi)])


@given(SPIRALS, ANGLES, ANGLES)
def test_turning_the_spiral_is_scaling_it(spiral, theta, turn):
    rotation = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    scaled = math.exp(spiral.b * turn) * rotation @ points(spiral, theta)
    np.testing.assert_allclose(points(spiral, theta + turn), scaled, rtol=0, atol=1e-13 * np.linalg.norm(scaled))


@given(SPIRALS, ANGLES, ANGLES)
def test_arc_length_is_the_integral_of_the_speed(spiral, start, end):
    numeric, _ = quad(lambda theta: float(radius(spiral, theta)) * math.hypot(1.0, spiral.b), start, end, epsrel=1e-12)
    scale = float(radius(spiral, max(start, end)))
    assert float(arc_length(spiral, start, end)) == pytest.approx(numeric, rel=1e-10, abs=1e-12 * scale)


@given(SPIRALS, ANGLES, ANGLES)
def test_chord_is_the_distance_of_the_points(spiral, start, end):
    distance = np.linalg.norm(points(spiral, end) - points(spiral, start))
    scale = float(radius(spiral, max(start, end)))
    assert float(chord(spiral, start, end)) == pytest.approx(distance, rel=1e-9, abs=1e-14 * scale)


@given(SPIRALS, ANGLES, st.floats(0.0, 3.0))
def test_an_arc_is_at_least_its_chord(spiral, start, turn):
    arc = float(arc_length(spiral, start, start + turn))
    assert arc >= float(chord(spiral, start, start + turn)) - 1e-12 * float(radius(spiral, start + turn))


def test_a_short_chord_keeps_its_digits():
    spiral = Spiral(a=1.0, b=0.16)
    assert float(chord(spiral, 0.0, 1e-12)) == pytest.approx(1e-12 * math.hypot(1.0, 0.16), rel=1e-3)


def test_arrays_broadcast():
    spiral = Spiral(a=1.0, b=0.2)
    start, end = np.zeros((3, 1)), np.linspace(1.0, 2.0, 4)
    assert points(spiral, end).shape == (4, 2)
    for law in (arc_length, chord):
        batch = law(spiral, start, end)
        assert batch.shape == (3, 4)
        assert batch[2, 1] == law(spiral, 0.0, end[1])
