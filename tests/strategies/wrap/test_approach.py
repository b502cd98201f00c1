"""A wide object with corners is approached so that no corner faces the housing."""

import dataclasses
import math

import numpy as np
import pytest

from spiraltrunk import strategies
from spiraltrunk.design.presets import PAPER
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.strategies.wrap.approach import (
    ACROSS,
    DIAGONAL,
    DISTAL_RIGHT,
    LEFT,
    RIGHT,
    approach_direction,
    find_turn,
    is_turned,
)

OBLONG = "box:x_mm=100,y_mm=60,z_mm=160,mass_g=200"
LOW = "box:x_mm=100,y_mm=60,z_mm=100,mass_g=200"


def _scene(name, yaw_deg=0.0):
    return SceneOptions(
        support="ground", orientation="upright", shape=_standing(name), position=(0.46, 0.12, 0.0),
        yaw=math.radians(yaw_deg),
    )  # fmt: skip


def _standing(name):
    shape = parse_object(name)
    if shape.up == "x" or not name.startswith("box:"):
        return shape
    x, y, z = shape.size
    return dataclasses.replace(shape, size=(z, x, y), up="x")


def _task(name, yaw_deg=0.0):
    return build_task(PAPER, _scene(name, yaw_deg))


@pytest.mark.parametrize("name", ["cylinder-120", "bottle-70", "box-60"])
@pytest.mark.parametrize("yaw_deg", [0.0, 40.0, 75.0])
def test_round_and_narrow_objects_are_taken_from_ahead(name, yaw_deg):
    assert find_turn(_task(name, yaw_deg), 0.0) == 0.0
    assert not is_turned(_task(name, yaw_deg))


@pytest.mark.parametrize("yaw_deg", np.arange(-90.0, 90.0, 12.0))
def test_a_wide_square_box_is_approached_at_its_corner_wherever_a_turn_reaches_that(yaw_deg):
    task = _task("box-80", yaw_deg)
    turn = find_turn(task, 0.0)
    assert RIGHT <= turn <= LEFT
    angle = (task.target.side_yaw - turn) % (math.pi / 2)
    low, high = DIAGONAL
    assert low - 1e-9 <= angle <= high + 1e-9 or turn in (RIGHT, LEFT)
    beyond = min(abs(angle - low), abs(angle - high))
    assert beyond <= math.radians(10.0) + 1e-9 or low < angle < high


@pytest.mark.parametrize(("yaw_deg", "turn_deg"), [(0.0, -20.0), (20.0, 0.0), (40.0, 0.0), (50.0, 10.0), (80.0, -30.0)])
def test_the_least_turn_is_taken(yaw_deg, turn_deg):
    assert math.degrees(find_turn(_task("box-80", yaw_deg), 0.0)) == pytest.approx(turn_deg)


@pytest.mark.parametrize("yaw_deg", np.arange(-90.0, 90.0, 30.0))
def test_the_longer_side_is_brought_across_the_way(yaw_deg):
    task = _task(OBLONG, yaw_deg)
    before, turn = task.target.side_yaw % math.pi, find_turn(task, 0.0)
    after = (task.target.side_yaw - turn) % math.pi

    def off(angle):
        return max(0.0, ACROSS[0] - angle, angle - ACROSS[1])

    assert off(after) <= off(before) + 1e-9
    assert off(after) == pytest.approx(0.0, abs=1e-9) or turn in (RIGHT, LEFT)


def test_a_distal_wrap_turns_less():
    turns = [find_turn(_task(LOW, yaw), 0.0, is_distal=True) for yaw in np.arange(-90.0, 90.0, 15.0)]
    assert min(turns) == DISTAL_RIGHT
    assert max(turns) == LEFT


def test_an_unknown_yaw_turns_nothing():
    task = _task("box-80", 80.0)
    unknown = dataclasses.replace(task, target=dataclasses.replace(task.target, side_yaw=None))
    assert find_turn(unknown, 0.0) == 0.0


@pytest.mark.parametrize("name", ["wrap-oblique-low", pytest.param("wrap-horizontal", marks=pytest.mark.slow)])
def test_the_whole_plan_is_turned_about_the_object(name):
    """All moves round the object, up to the carry, are those without a turn, turned about the vertical through it."""
    strategy = strategies.get(name)
    plain, turned = (SimPlant(PAPER, _scene("box-80", yaw)).reset() for yaw in (20.0, 80.0))
    angle = find_turn(turned.task, 0.0)
    assert angle < -0.4
    way, before = approach_direction(turned), approach_direction(plain)
    assert np.degrees(math.atan2(way[1], way[0]) - math.atan2(before[1], before[0])) == pytest.approx(
        math.degrees(angle)
    )
    c, s = math.cos(angle), math.sin(angle)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    middle = plain.task.target.position * [1.0, 1.0, 0.0]
    first, second = strategy.base_path(plain), strategy.base_path(turned)
    for one, other in list(zip(first, second, strict=True))[:10]:
        np.testing.assert_allclose(other[:3, :3], rotation @ one[:3, :3], atol=1e-6)
        np.testing.assert_allclose(other[:3, 3], middle + rotation @ (one[:3, 3] - middle), atol=1e-6)


def test_the_announced_side_turns_with_the_object():
    assert _task("cylinder-60").target.side_yaw is None
    straight, turned = _task(OBLONG), _task(OBLONG, 25.0)
    assert straight.target.longer_side == pytest.approx(0.1)
    assert math.degrees(turned.target.side_yaw - straight.target.side_yaw) == pytest.approx(25.0)
