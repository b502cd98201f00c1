"""Profiles of objects against closed forms."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from spiraltrunk.design import presets
from spiraltrunk.errors import DesignError, UnknownName
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.objects.profile import compute_profile, measure_section, reach_along
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.sim.scene.options import SceneOptions


def test_a_cylinder_has_its_diameter_at_every_height():
    profile = compute_profile(parse_object("cylinder:diameter_mm=60,height_mm=240,mass_g=250"))
    np.testing.assert_allclose(profile.width_most, 0.06, rtol=5e-4)
    np.testing.assert_allclose(profile.width_least, 0.06, rtol=5e-4)
    np.testing.assert_allclose(profile.girth, math.pi * 0.06, rtol=5e-4)
    assert profile.total_height == pytest.approx(0.24)
    assert profile.center_height == pytest.approx(0.12)
    assert profile.topple_angle == pytest.approx(math.atan(60 / 240), abs=math.radians(0.5))
    assert profile.support_radius == pytest.approx(0.03, rel=1e-6)
    assert (profile.grip_width, profile.grip_height) == pytest.approx((0.06, 0.12), rel=1e-3)


def test_a_cone_narrows_linearly_and_stands_on_its_base():
    profile = compute_profile(parse_object("cone:diameter_mm=80,height_mm=160,mass_g=200"))
    np.testing.assert_allclose(profile.width_most, 0.08 * (1 - profile.height / 0.16), atol=3e-4)
    assert profile.center_height == pytest.approx(0.04)
    assert profile.topple_angle == pytest.approx(math.atan(40 / 40), abs=math.radians(0.5))


def test_a_ball_rolls():
    profile = compute_profile(parse_object("sphere:diameter_mm=80,mass_g=200"))
    chord = 2 * np.sqrt(np.maximum(0, 0.04**2 - (profile.height - 0.04) ** 2))
    np.testing.assert_allclose(profile.width_most[5:-5], chord[5:-5], rtol=3e-3)
    assert profile.topple_angle == profile.support_radius == 0.0


def test_a_box_has_its_diagonal_and_falls_over_its_shorter_side():
    profile = compute_profile(parse_object("bar-12x20"))
    np.testing.assert_allclose(profile.width_least, 0.012, rtol=1e-9)
    np.testing.assert_allclose(profile.width_most, math.hypot(0.012, 0.020), rtol=1e-9)
    np.testing.assert_allclose(profile.girth, 0.064, rtol=1e-9)
    assert profile.topple_angle == pytest.approx(math.atan(12 / 150), abs=math.radians(0.3))
    assert profile.support_radius == pytest.approx(0.006, rel=1e-6)


def test_the_neck_of_a_bottle_is_the_least_width_to_grip():
    profile = compute_profile(parse_object("bottle:diameter_mm=70,height_mm=220,neck_mm=30,mass_g=350"))
    assert profile.grip_width == pytest.approx(0.03, rel=1e-3)
    assert 0.7 * 0.22 < profile.grip_height < 0.9 * 0.22
    assert profile.at(0.05) == pytest.approx((0.07, 0.07, math.pi * 0.07), rel=1e-3)


def test_lying_it_is_as_high_as_wide_and_rolls():
    profile = compute_profile(parse_object("cylinder-60"), "lying")
    assert profile.total_height == pytest.approx(0.06, rel=1e-3)
    assert profile.topple_angle == 0.0
    assert profile.at(0.03)[1] == pytest.approx(math.hypot(0.24, 0.06), rel=1e-3)


def test_a_turn_about_the_vertical_changes_nothing():
    shape = parse_object("bar-12x20")
    straight = compute_profile(shape, np.eye(3))
    turned = compute_profile(shape, Rotation.from_rotvec([0, 0, 0.7]).as_matrix())
    for name in ("height", "width_least", "width_most", "girth"):
        np.testing.assert_allclose(getattr(turned, name), getattr(straight, name), rtol=1e-9)
    assert turned.topple_angle == pytest.approx(straight.topple_angle, abs=math.radians(0.3))


@pytest.mark.parametrize("name", ["ball-60", "cone-90", "ring-90", "bottle-70", "box-60", "cylinder-32"])
def test_the_reach_of_many_directions_is_that_of_each(name):
    directions = np.random.default_rng(0).normal(size=(50, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    for geom in parse_object(name).solid.geoms:
        expected = [geom.reach(direction) for direction in directions]
        np.testing.assert_allclose(reach_along(geom, directions), expected, atol=1e-12)


def test_sections_without_area_have_no_width():
    assert measure_section(np.zeros((1, 2))) == (0.0, 0.0, 0.0)
    assert measure_section(np.array([[0.0, 0.0], [0.03, 0.04], [0.015, 0.02]])) == pytest.approx((0.0, 0.05, 0.1))


def test_the_task_announces_the_profile_of_the_pose():
    shape = parse_object("cylinder-60")
    for support, orientation, height in (
        ("ground", "upright", 0.24),
        ("ground", "lying", 0.06),
        ("hung", "lying", 0.06),
    ):
        task = build_task(presets.PAPER, SceneOptions(shape=shape, support=support, orientation=orientation))
        assert task.target.profile.total_height == pytest.approx(height, rel=1e-3)


def test_other_orientations_are_refused():
    shape = parse_object("cylinder-60")
    with pytest.raises(UnknownName, match="known: lying, upright"):
        compute_profile(shape, "tilted")
    for matrix in (np.eye(2), 2 * np.eye(3), np.diag([1.0, 1.0, -1.0]), np.full((3, 3), np.nan)):
        with pytest.raises(DesignError, match="a rotation matrix"):
            compute_profile(shape, matrix)
