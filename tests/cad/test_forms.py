"""Volumes of forms against closed forms, and against points in boxes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.cad.geometry.csg import (
    Common,
    Cut,
    Prism,
    Revolved,
    Union,
    box,
    compute_bounds,
    compute_volume,
    contains,
    polar,
    rod,
    shifted,
    turned,
)

CONE = Revolved(profile=((0.0, 0.0), (3.0, 0.0), (0.0, 5.0)))


def test_a_turned_polygon_has_pappus_volume():
    assert compute_volume(CONE) == pytest.approx(math.pi * 9 * 5 / 3, rel=1e-12)
    quarter = Revolved(profile=CONE.profile, start=1.0, arc=math.pi / 2)
    assert compute_volume(quarter) == pytest.approx(math.pi * 15 / 4, rel=1e-12)


@given(st.floats(0.1, 10), st.floats(0.1, 10), st.floats(0.1, 4))
def test_a_section_has_the_volume_of_the_design(length, radius, part):
    from spiraltrunk.design import SectionSolid

    lean = math.atan(part * length / (10 * radius))
    solid = SectionSolid(length=length, radius=radius, lean_proximal=lean, lean_distal=lean / 2)
    form = Revolved(profile=((0.0, 0.0), (radius, solid.rim_start), (radius, solid.rim_end), (0.0, length)))
    assert compute_volume(form) == pytest.approx(solid.volume, rel=1e-9)


def test_a_hole_through_a_plate_takes_its_cylinder():
    plate = box((20, 20, 4), (0, 0, 0))
    drilled = Cut(form=plate, tools=(rod(1.5, (3, 2, -5), (3, 2, 5)),))
    assert compute_volume(drilled) == pytest.approx(1600 - math.pi * 1.5**2 * 4, rel=1e-3)


def test_a_large_tool_takes_its_share():
    block = box((4, 4, 4), (10.0, 0, 0))
    left = Cut(form=block, tools=(rod(10.0, (0, 0, -50), (0, 0, 50)),))
    inside = 4 * (2 * math.sqrt(96) + 100 * math.asin(0.2) - 4 * 8)  # The circle's part beyond x = 8, within y +- 2.
    assert compute_volume(left) == pytest.approx(64 - inside, rel=5e-3)


def test_what_overlaps_counts_once():
    one, other = box((2, 2, 2), (0, 0, 0)), box((2, 2, 2), (1, 0, 0))
    assert compute_volume(Union(forms=(one, other))) == pytest.approx(12, rel=2e-3)
    assert compute_volume(Common(form=one, other=other)) == pytest.approx(4, rel=2e-3)
    assert compute_volume(Cut(form=one, tools=(other, other))) == pytest.approx(4, rel=2e-3)


@given(st.floats(-3, 3), st.sampled_from("xyz"), st.tuples(*[st.floats(-5, 5)] * 3))
def test_moving_changes_no_volume_and_moves_the_points(angle, axis, by):
    moved = shifted(turned(CONE, axis, angle), by)
    assert compute_volume(moved) == compute_volume(CONE)
    c, s = math.cos(angle), math.sin(angle)
    turn = {"x": [[1, 0, 0], [0, c, -s], [0, s, c]], "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
            "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]]}[axis]  # fmt: skip
    points = np.random.default_rng(0).uniform(-4, 6, (200, 3))
    assert (contains(CONE, points) == contains(moved, points @ np.transpose(turn) + by)).mean() > 0.99


def test_bounds_hold_what_is_inside():
    form = Union(forms=(turned(CONE, "y", 1.0), Prism(corners=((0, 0), (3, 0), (0, 2)), bottom=-1, top=7)))
    points = np.random.default_rng(1).uniform(-9, 9, (20000, 3))
    inside = points[contains(form, points)]
    low, high = compute_bounds(form)
    assert len(inside) > 100
    assert (inside >= low).all()
    assert (inside <= high).all()


def test_a_rod_lies_between_its_ends():
    form = rod(0.5, (1, 2, 3), (4, 6, 3))
    assert compute_volume(form) == pytest.approx(math.pi * 0.25 * 5)
    assert contains(form, np.array([[1.1, 2.1, 3.0], [2.5, 4.0, 3.4], [2.5, 4.0, 3.6], [4.4, 6.4, 3.0]])).tolist() == [
        True, True, False, False,
    ]  # fmt: skip


def test_polar_starts_dorsal():
    assert polar(2.0, 0.0, 1.0) == (2.0, 0.0, 1.0)
    assert polar(2.0, math.pi / 2, 1.0) == pytest.approx((0.0, 2.0, 1.0))
