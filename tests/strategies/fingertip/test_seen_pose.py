"""Grips of objects that lie or stand otherwise than announced, and of wide ones that lie."""

import dataclasses
import math

import numpy as np
import pytest

from spiraltrunk import strategies
from spiraltrunk.control.messages import Goal, Target, Task
from spiraltrunk.control.object_handle import Handle
from spiraltrunk.design import presets
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import ModelError
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.objects.everyday import draw_everyday
from spiraltrunk.sim.objects.profile import compute_profile
from spiraltrunk.strategies.assessment import assess
from spiraltrunk.strategies.fingertip.finger_model import closing_tension, finger_bend, finger_points
from spiraltrunk.strategies.fingertip.gripped_object import is_wide, upper_width
from spiraltrunk.strategies.fingertip.plan import (
    SAFETY,
    SEEN_ERROR,
    SIZE_ERROR,
    closing,
    find_seen_task,
    gripping_base,
    opening,
    set_aside,
    side_share,
    tip_height,
    turned_across,
)
from spiraltrunk.strategies.fingertip.tip_grip import TipGrip

GROUND, LARGE = 0.45, presets.get("paper-large-grip")
UP, LEVEL = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
HANGING = np.array([[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]])


def announce(kind="cylinder", width=0.05, length=0.08, axis=UP, design=LARGE):
    height = length if axis[2] > 0.5 and kind != "sphere" else width
    target = Target(kind=kind, width=width, length=length, mass=0.1, axis=axis,
                    position=np.array([0.45, 0.10, GROUND + height / 2]))  # fmt: skip
    goal = Goal(lift=0.2, aside=np.array([0.0, 0.2, 0.0]), place=target.position, ground=GROUND)
    return Task(design=design, target=target, goal=goal)


def test_a_can_that_has_fallen_over_is_gripped_lower():
    task = announce()
    seen = find_seen_task(task, np.array([0.5, 0.1, GROUND + 0.025]), LEVEL)
    np.testing.assert_array_equal(seen.target.axis, LEVEL)
    assert tip_height(seen) < tip_height(task) - 0.01


def test_a_body_lower_than_announced_is_gripped_as_it_is_seen():
    task = announce(kind="mjcf", width=0.04, length=0.068)
    seen = find_seen_task(task, np.array([0.45, 0.1, GROUND + 0.02]), UP)
    assert seen.target.position[2] == pytest.approx(GROUND + 0.02)
    assert tip_height(seen) < tip_height(task)


@pytest.mark.parametrize("rise", [-0.004, 0.0, 0.004])
@pytest.mark.parametrize(
    ("kind", "axis", "way"),
    [("cylinder", UP, -UP), ("cylinder", LEVEL, np.array([0.0, 1.0, 0.0])), ("sphere", UP, LEVEL)],
)
def test_what_is_seen_within_the_errors_stays_as_announced(kind, axis, way, rise):
    """The axis has no sign, a yaw is no fall, and a ball has no axis."""
    task = announce(kind=kind, axis=axis)
    assert find_seen_task(task, task.target.position + np.array([0.01, -0.01, rise]), way) is task


@pytest.mark.parametrize("angle", np.radians([-85.0, -31.0, 0.0, 20.0, 44.0, 89.0]))
@pytest.mark.parametrize("kind", ["box", "cylinder"])
def test_open_fingers_clear_both_sides_of_a_wide_lying_object(kind, angle):
    """Their tips stand off its middle plane by more than half its width on either side, and by equal distances."""
    axis = np.array([math.cos(angle), math.sin(angle), 0.0])
    task = announce(kind=kind, width=0.042, length=0.14, axis=axis)
    rotation, gripper, across = turned_across(HANGING, axis, task), LARGE.gripper, np.array([-axis[1], axis[0], 0.0])
    tips = finger_points(gripper, finger_bend(gripper, opening(task) * gripper.tension_max))[..., -1, 0]
    turns = 2 * np.pi * np.arange(3) / 3
    fingers = np.cos(turns)[:, None] * rotation[:, 1] + np.sin(turns)[:, None] * rotation[:, 2]
    beside = (set_aside(task, rotation, axis) + tips * fingers) @ across
    least = np.abs(beside).min() - gripper.phalanx_width[-1] / 2
    assert least > (1 + SIZE_ERROR) * 0.021
    assert {-1.0, 1.0} == set(np.sign(beside))


def test_slender_standing_and_round_objects_are_gripped_in_their_middle():
    rod = announce(width=0.03, axis=LEVEL)
    for task in (rod, announce(), announce(kind="sphere", width=0.07, axis=LEVEL)):
        assert not is_wide(task)
        np.testing.assert_array_equal(set_aside(task, HANGING, task.target.axis), 0.0)


def test_the_papers_pinch_of_its_bars_is_as_before():
    """Its widest bar is 20 mm: none of the catalogue's is wide."""
    assert not is_wide(announce(kind="box", width=0.020, length=0.15, axis=LEVEL, design=PAPER))


def test_three_fingers_stand_three_quarters_off_the_middle():
    """cos 0 = 1 on one side and cos 120 deg = -1/2 on the other: shifted by a quarter, both are at 3/4."""
    assert side_share(3) == pytest.approx(0.75)
    assert side_share(2) == pytest.approx(1.0)


def test_the_highest_base_is_that_of_the_lift_over_the_grip():
    task = announce()
    base = float(gripping_base(task, task.target.position)[2])
    assert TipGrip().highest_base(task) == pytest.approx(base + 0.2)
    low = dataclasses.replace(task, goal=dataclasses.replace(task.goal, lift=0.05))
    assert TipGrip().highest_base(low) == pytest.approx(base + 2.0 * LARGE.gripper.finger_length)


def test_a_tall_object_is_gripped_at_the_height_that_is_seen():
    """A tenth of 187 mm is half a finger: fingers above a cone that is 6 % lower than announced closed on nothing."""
    shape = draw_everyday(np.random.default_rng(1002)).shape
    task = announce(kind=shape.kind, width=shape.width, length=shape.length, design=PAPER)
    task = dataclasses.replace(task, target=dataclasses.replace(task.target, profile=compute_profile(shape)))
    assert shape.length == pytest.approx(0.187, abs=1e-3)
    at = task.target.position
    for rise in (-0.006, 0.0, 0.004):
        seen = find_seen_task(task, at + np.array([0.0, 0.0, rise]), UP)
        top = GROUND + shape.length + 2 * rise
        assert seen.target.profile.total_height == pytest.approx(top - GROUND)
        assert top + 2 * SEEN_ERROR < tip_height(seen) < top + 2 * SEEN_ERROR + 0.25 * PAPER.gripper.finger_length
    low = announce(kind="cylinder", width=0.03, length=0.07, design=PAPER)
    assert find_seen_task(low, low.target.position + np.array([0.0, 0.0, 0.004]), UP) is low


def test_what_has_fallen_to_where_it_cannot_be_gripped_is_said():
    task = announce(width=0.06, length=0.10, axis=UP)
    flat = find_seen_task(dataclasses.replace(task, design=PAPER), np.array([0.45, 0.1, GROUND + 0.03]), LEVEL)
    with pytest.raises(ModelError, match="do not open round 60 mm"):
        tip_height(flat)


def test_one_finger_against_two_carries_half_of_a_wide_object():
    """Three fingers round a rod share its weight; beside a wide one the normal finger bears as much as both others."""
    gripper, command = LARGE.gripper, {}
    for width in (0.034, 0.036):  # Either side of half of what the fingers enclose.
        task = announce(width=width, length=0.14, axis=LEVEL)
        command[width] = closing(dataclasses.replace(task, target=dataclasses.replace(task.target, mass=0.12)))
    assert is_wide(announce(width=0.036, axis=LEVEL))
    force, radius = 0.12 * 9.81 / (2 * 0.8 / SAFETY), 0.036 / 2
    assert command[0.036] == pytest.approx(closing_tension(gripper, radius, force) / gripper.tension_max, rel=1e-3)
    assert command[0.036] > 1.2 * command[0.034]


def _profiled(shape, axis, orientation):
    """A task of a real object, with its profile in an orientation."""
    spec = parse_object(shape)
    profile = compute_profile(spec, orientation)
    task = announce(kind=spec.kind, width=spec.width, length=spec.length, axis=axis)
    target = dataclasses.replace(task.target, profile=profile)
    target = dataclasses.replace(target, position=np.array([0.45, 0.1, GROUND + profile.total_height / 2]))
    return dataclasses.replace(task, target=target)


def test_a_bottle_is_gripped_at_its_neck():
    """Its body of 90 mm is wider than the fingers enclose; its neck, on the top 84 mm of it, is 30 mm."""
    task = _profiled("bottle:diameter_mm=90,height_mm=280,neck_mm=30,mass_g=300", UP, "upright")
    assert upper_width(task) == pytest.approx(0.030, rel=0.02)
    assert tip_height(task) > GROUND + 0.28
    blind = dataclasses.replace(task, target=dataclasses.replace(task.target, profile=None))
    with pytest.raises(ModelError, match="do not open round 90 mm"):
        tip_height(blind)


def test_a_lying_box_is_as_wide_as_it_is_across_and_not_as_it_is_high():
    task = _profiled("box:x_mm=140,y_mm=40,z_mm=66,mass_g=100", LEVEL, "lying")
    assert task.target.width == pytest.approx(0.066)
    assert upper_width(task) == pytest.approx(0.040, rel=1e-6)
    assert is_wide(task)
    assert tip_height(task) > GROUND + 0.066


def test_fingers_press_below_the_middle_of_a_wide_lying_cylinder_or_refuse_it():
    """Their ends reach below it, and they pass its round top nearer than that of a box as wide."""
    length = PAPER.gripper.finger_length
    for width in (0.022, 0.028, 0.033):
        height = tip_height(announce(width=width, length=0.1, axis=LEVEL, design=PAPER)) - GROUND
        box = tip_height(announce(kind="box", width=width, length=0.1, axis=LEVEL, design=PAPER)) - GROUND
        assert height - width / 2 <= 0.85 * length < box - width / 2
    with pytest.raises(ModelError, match="too wide to lie between the fingers: they do not reach round 35 mm"):
        tip_height(announce(width=0.035, length=0.1, axis=LEVEL, design=PAPER))


def announce_mug(body=0.058, angle=0.4, **changed):
    """A mug of 100 mm, its body at the offset that its handle of 0.4 widths makes."""
    way = np.array([math.cos(angle), math.sin(angle), 0.0])
    handle = Handle(direction=way, body_width=body, body_offset=-0.2 * body * way)
    task = announce(kind="solid", width=1.4 * body, length=0.1, **changed)
    return dataclasses.replace(task, target=dataclasses.replace(task.target, handle=handle))


@pytest.mark.parametrize("angle", np.radians([-179.0, -100.0, -31.0, 0.0, 44.0, 89.0, 150.0]))
def test_a_handle_comes_between_two_fingers_by_the_least_turn(angle):
    task = announce_mug(angle=angle)
    rotation = turned_across(HANGING, UP, task)
    turns = 2 * np.pi * np.arange(3) / 3
    fingers = np.cos(turns)[:, None] * rotation[:, 1] + np.sin(turns)[:, None] * rotation[:, 2]
    along = np.sort(fingers @ task.target.handle.direction)
    np.testing.assert_allclose(along, [-1.0, 0.5, 0.5], atol=1e-9)
    assert math.acos(np.clip((np.trace(HANGING.T @ rotation) - 1) / 2, -1, 1)) <= math.radians(60.0) + 1e-9
    np.testing.assert_array_equal(set_aside(task, rotation, UP), task.target.handle.body_offset)


def test_fingers_grip_the_body_of_what_has_a_handle():
    """As the cylinder of its body: 81 mm with its handle are too wide for fingers that open 70 mm."""
    mug, body = announce_mug(), announce(kind="cylinder", width=0.058, length=0.1)
    assert (tip_height(mug), opening(mug), closing(mug)) == (tip_height(body), opening(body), closing(body))
    assert assess(strategies.get("tip-grip"), mug) == assess(strategies.get("tip-grip"), body)
    whole = dataclasses.replace(mug, target=dataclasses.replace(mug.target, handle=None))
    assert not assess(strategies.get("tip-grip"), whole).feasible


def test_a_mug_that_has_fallen_over_is_planned_without_its_handle():
    mug = announce_mug()
    assert find_seen_task(mug, mug.target.position - [0.0, 0.0, 0.01], LEVEL).target.handle is None
    assert find_seen_task(mug, mug.target.position - [0.0, 0.0, 0.02], UP).target.handle is mug.target.handle
