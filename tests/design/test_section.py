"""The section's closed integrals against slices of the solid, summed along its axis."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from spiraltrunk.design.section import SectionSolid
from spiraltrunk.errors import DesignError

LEANS = st.floats(-1.0, -1e-3) | st.just(0.0) | st.floats(1e-3, 1.0)


@st.composite
def solids(draw):
    length, lean_1, lean_2 = draw(st.floats(1e-3, 10.0)), draw(LEANS), draw(LEANS)
    widest = length / max(math.tan(lean_1) + math.tan(lean_2), 0.2)
    return SectionSolid(
        length=length, radius=widest * draw(st.floats(0.05, 0.95)), lean_proximal=lean_1, lean_distal=lean_2
    )


def slice_radii(solid, x):
    """Inner and outer radius of the slice at x: a face that leans in bounds outside, one that leans out inside."""
    inner, outer = np.zeros_like(x), np.full_like(x, solid.radius)
    for lean, depth in ((solid.lean_proximal, x), (solid.lean_distal, solid.length - x)):
        slope = math.tan(lean)
        if slope > 0:
            outer = np.minimum(outer, depth / slope)
        elif slope < 0:
            inner = np.maximum(inner, depth / slope)
    return inner, np.maximum(outer, inner)


def integrate_slices(solid, density):
    """Integral of ``density(x, inner, outer)`` over the axis; between the edges it is a polynomial."""
    edges = np.unique([0.0, solid.rim_start, solid.rim_end, solid.length])
    nodes, weights = np.polynomial.legendre.leggauss(8)
    total = 0.0
    for start, end in pairwise(edges):
        x = (start + end) / 2 + (end - start) / 2 * nodes
        total += (end - start) / 2 * float(weights @ density(x, *slice_radii(solid, x)))
    return total


def disc(power):
    """pi (R^n - r^n) / (n / 2), n = 2: area, n = 4: polar moment of a ring."""
    return lambda _, inner, outer: math.pi * (outer**power - inner**power) / (power / 2)


@given(solids())
def test_volume_is_the_sum_of_the_slices(solid):
    assert solid.volume == pytest.approx(integrate_slices(solid, disc(2)), rel=1e-10)


@given(solids())
def test_centroid_is_the_mean_of_the_slices(solid):
    moment = integrate_slices(solid, lambda x, inner, outer: x * math.pi * (outer**2 - inner**2))
    assert solid.centroid == pytest.approx(
        moment / integrate_slices(solid, disc(2)), rel=1e-9, abs=1e-10 * solid.length
    )


@given(solids())
def test_gyration_about_the_axis_is_that_of_the_slices(solid):
    polar = integrate_slices(solid, disc(4))
    assert solid.gyration_axial == pytest.approx(polar / integrate_slices(solid, disc(2)), rel=1e-9)


@given(solids())
def test_gyration_across_the_axis_is_that_of_the_slices(solid):
    volume = integrate_slices(solid, disc(2))

    def about_centroid(x, inner, outer):
        area, diametral = math.pi * (outer**2 - inner**2), math.pi * (outer**4 - inner**4) / 4
        return diametral + (x - solid.centroid) ** 2 * area

    assert solid.gyration_transverse == pytest.approx(integrate_slices(solid, about_centroid) / volume, rel=1e-8)


def test_a_cylinder_is_a_cylinder():
    solid = SectionSolid(length=3.0, radius=2.0, lean_proximal=0.0, lean_distal=0.0)
    assert solid.volume == pytest.approx(12 * math.pi)
    assert solid.centroid == pytest.approx(1.5)
    assert solid.gyration_axial == pytest.approx(2.0**2 / 2)
    assert solid.gyration_transverse == pytest.approx((3 * 2.0**2 + 3.0**2) / 12)


def test_a_cone_is_a_cone():
    """Two faces that meet on the rim, all but a hair: a double cone of half height 1 and radius 1."""
    solid = SectionSolid(length=2.0, radius=1.0 - 1e-12, lean_proximal=math.pi / 4, lean_distal=math.pi / 4)
    assert solid.volume == pytest.approx(2 * math.pi / 3)
    assert solid.gyration_axial == pytest.approx(3 / 10)


@given(solids())
def test_turning_a_section_round_mirrors_it(solid):
    mirror = SectionSolid(
        length=solid.length, radius=solid.radius, lean_proximal=solid.lean_distal, lean_distal=solid.lean_proximal
    )
    assert mirror.volume == pytest.approx(solid.volume, rel=1e-12)
    assert mirror.centroid == pytest.approx(solid.length - solid.centroid, rel=1e-9, abs=1e-9 * solid.length)
    assert mirror.gyration_transverse == pytest.approx(solid.gyration_transverse, rel=1e-8)


@given(solids(), st.floats(0.01, 100.0))
def test_a_scaled_section_has_scaled_moments(solid, factor):
    large = SectionSolid(
        length=factor * solid.length,
        radius=factor * solid.radius,
        lean_proximal=solid.lean_proximal,
        lean_distal=solid.lean_distal,
    )
    assert large.volume == pytest.approx(factor**3 * solid.volume, rel=1e-12)
    assert large.gyration_transverse == pytest.approx(factor**2 * solid.gyration_transverse, rel=1e-8)


@given(LEANS, LEANS, st.floats(1.0, 2.0))
def test_faces_that_cross_inside_are_refused_with_the_largest_radius(lean_1, lean_2, excess):
    slopes = math.tan(lean_1) + math.tan(lean_2)
    assume(slopes > 0.01)
    with pytest.raises(DesignError, match=f"radius below {1.0 / slopes:g} m"):
        SectionSolid(length=1.0, radius=excess * 1.001 / slopes, lean_proximal=lean_1, lean_distal=lean_2)


def test_a_length_lost_in_rounding_is_refused_as_a_design():
    """Parallel faces have no largest radius; a length below rounding still leaves no outer surface."""
    with pytest.raises(DesignError, match="outer surface of positive length"):
        SectionSolid(length=1e-300, radius=1.0, lean_proximal=0.1, lean_distal=-0.1)
