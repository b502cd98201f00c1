"""Handle of a standing object: found beside a body, with the body's circle, and nowhere else."""

import math

import numpy as np
import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.objects.everyday import draw_object
from spiraltrunk.sim.objects.geoms import Geom, Solid
from spiraltrunk.sim.objects.handle import find_handle
from spiraltrunk.sim.objects.spec import ObjectSpec
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.sim.scene.options import SceneOptions


def draw(kind, seed, **ranges):
    return draw_object(np.random.default_rng(seed), kind=kind, **ranges)


@pytest.mark.parametrize("seed", range(20))
def test_a_mugs_body_is_the_circle_beside_its_handle(seed):
    """A drawn handle points along the object's z, which is at its yaw of 0 the world's -x (UPRIGHT turns x up)."""
    shape = draw("handled", seed)
    _, body, whole = shape.size
    handle = find_handle(shape)
    np.testing.assert_allclose(handle.direction, [-1.0, 0.0, 0.0], atol=0.05)
    assert handle.body_width == pytest.approx(body, rel=0.01)
    np.testing.assert_allclose(handle.body_offset, (whole - body) / 2 * -handle.direction, atol=0.03 * body)


@pytest.mark.parametrize("yaw", [0.5, -2.0, 4.0])
def test_a_handle_turns_with_its_object(yaw):
    shape = draw("handled", 3)
    straight, turned = find_handle(shape), find_handle(shape, yaw)
    for one, other in ((straight.direction, turned.direction), (straight.body_offset, turned.body_offset)):
        np.testing.assert_allclose(other[:2], turn(yaw) @ one[:2], atol=1e-12)
    assert turned.body_width == straight.body_width


def turn(yaw):
    return np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])


@pytest.mark.parametrize("kind", ["cylinder", "box", "superquadric", "revolution"])
@pytest.mark.parametrize("seed", range(25))
def test_what_has_no_handle_is_given_none(kind, seed):
    assert find_handle(draw(kind, seed)) is None


def _plates(*sizes):
    """A solid of boxes, x up: centres and extents across, [mm]."""
    geoms = tuple(
        Geom(form="box", size=(0.05, wide / 2e3, deep / 2e3), position=np.array([0.0, y / 1e3, z / 1e3]))
        for y, z, wide, deep in sizes
    )
    return Solid(geoms=geoms, centroid=np.zeros(3), inertia=np.eye(3) * 1e-3)


@pytest.mark.parametrize("ratio", [2.0, 3.0, 4.0, 4.5, 5.0, 6.0, 8.0, 40.0])
def test_a_flat_box_from_a_file_has_no_handle(ratio):
    shape = ObjectSpec(kind="solid", size=(0.1, 0.02, 0.02 * ratio), mass=0.1, loaded=_plates((0, 0, 20, 20 * ratio)))
    assert find_handle(shape) is None


@pytest.mark.parametrize("solid", [_plates((0, 0, 60, 15), (22, 25, 15, 70)), _plates((0, 0, 60, 15), (0, 30, 15, 60))])
def test_letters_have_no_handle(solid):
    assert find_handle(ObjectSpec(kind="solid", size=(0.1, 0.06, 0.07), mass=0.1, loaded=solid)) is None


@pytest.mark.parametrize("name", ["ball-30", "cube-28", "bottle-70", "cone-35", "ring-90", "box-80"])
def test_nothing_of_the_catalogue_has_one(name):
    assert find_handle(parse_object(name)) is None


@pytest.mark.parametrize(("support", "orientation"), [("ground", "lying"), ("hung", "lying")])
def test_only_what_stands_is_announced_with_its_handle(support, orientation):
    shape = draw("handled", 3)
    assert build_task(PAPER, SceneOptions(shape=shape, support=support, orientation=orientation)).target.handle is None
    stands = build_task(PAPER, SceneOptions(shape=shape, support="ground", orientation="upright", yaw=0.7))
    np.testing.assert_array_equal(stands.target.handle.direction, find_handle(shape, 0.7).direction)
