"""The wrap's planning model: limits, signs and monotony, scaling, and the balance that it claims."""

import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.trunk import ventral_cables
from spiraltrunk.errors import DesignError
from spiraltrunk.model.kinematics import cables
from spiraltrunk.strategies.wrap.hung_model import free_curl, predict_wrap, unrolled_center, wrap_tension


def test_cables_two_and_three_of_the_papers_are_ventral():
    np.testing.assert_array_equal(ventral_cables(PAPER), [False, True, True])
    np.testing.assert_array_equal(ventral_cables(presets.get("spirob-15")), [False, True])


@pytest.mark.parametrize(("mass", "tension"), [(0.0, 2.0), (0.1, 12.0), (0.25, 20.0), (0.25, 40.0)])
def test_the_part_before_the_object_balances_moment_by_moment(mass, tension):
    """At every joint off its limits: springs, cables and the weights beyond it, summed body by body.

    Thirty rounds of the iteration leave a thousandth of the base's moment.
    """
    wrap = predict_wrap(PAPER, 0.06, mass, tension)
    heading = np.concatenate([[0.0], np.cumsum(wrap.bend)])
    joint, centers = np.zeros(2), []
    joints = []
    for n, angle in enumerate(heading):
        joints.append(joint)
        way = np.array([math.cos(angle), math.sin(angle)])
        centers.append(joint + PAPER.section_center[n] * way)
        joint = joint + PAPER.section_length[n] * way
    free = np.flatnonzero(np.abs(wrap.bend[: wrap.first]) < PAPER.joint_limit - 1e-6)
    assert free.size > 0
    for i in free:
        weight = sum(9.81 * PAPER.section_mass[n] * (centers[n][1] - joints[i + 1][1]) for n in range(i + 1, 18))
        load = 9.81 * mass * (wrap.center[1] - joints[i + 1][1])
        lever = _ventral_slope(wrap.bend, i)
        assert PAPER.joint_stiffness[i] * wrap.bend[i] == pytest.approx(tension * lever - weight - load, abs=1e-4)


def _ventral_slope(bend, i):
    """Cable that both ventral cables take in per bend of joint ``i``, from the cables in space [m/rad]."""
    ends = []
    for step in (-1e-6, 1e-6):
        shape = np.stack([0 * bend, -bend], axis=-1)
        shape[i, 1] -= step
        ends.append(cables.lengths(PAPER, shape).change[1:].sum())
    return (ends[1] - ends[0]) / 2e-6


def test_the_pull_is_that_of_the_cables_in_space():
    for wrap in (predict_wrap(PAPER, 0.1, 0.0, 2.0), predict_wrap(PAPER, 0.06, 0.25, 15.0)):
        shape = np.stack([0 * wrap.bend, -wrap.bend], axis=-1)
        np.testing.assert_allclose(wrap.pull, cables.lengths(PAPER, shape).change, rtol=0, atol=1e-12)


@pytest.mark.parametrize(("width", "mass"), [(0.04, 0.2), (0.06, 0.25), (0.09, 0.3), (0.12, 0.4)])
def test_the_base_bends_more_with_more_tension(width, mass):
    bend = [predict_wrap(PAPER, width, mass, tension).bend[0] for tension in np.linspace(12, 60, 12)]
    assert (np.diff(bend) > -1e-6).all()
    assert bend[-1] > bend[0] + 0.05


@pytest.mark.parametrize("width", [0.04, 0.06, 0.09, 0.12])
def test_a_heavier_object_takes_more_tension(width):
    tension = [wrap_tension(PAPER, width, mass, 0.2) for mass in (0.05, 0.1, 0.2, 0.3, 0.4)]
    assert (np.diff(tension) > 0).all()
    assert tension[-1] <= PAPER.cable.tension_max


def test_the_tension_gives_the_bend_that_was_asked_for():
    tension = wrap_tension(PAPER, 0.06, 0.25, 0.2)
    assert predict_wrap(PAPER, 0.06, 0.25, tension).bend[0] == pytest.approx(0.2, abs=0.01)
    assert predict_wrap(PAPER, 0.06, 0.25, 0.95 * tension).bend[0] < 0.2


def test_what_no_motor_can_lift_takes_all_that_they_have():
    assert wrap_tension(PAPER, 0.06, 50.0, 0.3) == pytest.approx(PAPER.cable.tension_max, rel=1e-3)


@pytest.mark.parametrize("width", [0.033, 0.06, 0.12])
def test_the_wrapped_part_turns_round_the_object(width):
    wrap = predict_wrap(PAPER, width, 0.2, 20.0)
    assert 0 < wrap.first < PAPER.n_joint
    assert math.radians(180) < wrap.bend[wrap.first :].sum() <= math.radians(250)
    assert (np.abs(wrap.bend) <= PAPER.joint_limit + 1e-12).all()
    assert wrap.center[1] > 0  # Ventral.
    assert 0 < wrap.center[0] < PAPER.length


def test_a_wider_object_takes_more_of_the_trunk():
    first = [predict_wrap(PAPER, width, 0.2, 20.0).first for width in (0.03, 0.06, 0.09, 0.12, 0.15)]
    assert (np.diff(first) <= 0).all()
    assert first[-1] < first[0]


def test_the_prediction_scales_with_trunk_and_object():
    """Twice as large and weightless, elastic moments grow as lengths cubed: tension four times, lengths twice."""
    small = replace(PAPER, mass=replace(PAPER.mass, sections=(1e-9,) * 18), gripper=None)
    spiral = replace(small.spiral, a=2 * small.spiral.a)
    joint = replace(small.joint, radius=2 * small.joint.radius, length=2 * small.joint.length)
    large = replace(small, spiral=spiral, joint=joint)
    one, two = predict_wrap(small, 0.06, 0.0, 10.0), predict_wrap(large, 0.12, 0.0, 40.0)
    np.testing.assert_allclose(two.bend, one.bend, rtol=1e-6)
    np.testing.assert_allclose(two.center, 2 * one.center, rtol=1e-6)
    np.testing.assert_allclose(two.pull, 2 * one.pull, rtol=1e-6)


def test_an_empty_trunk_takes_in_more_cable_with_more_tension_until_all_is_shut():
    pull = np.array([free_curl(PAPER, tension) for tension in np.linspace(0, 60, 13)])
    assert pull[0] == pytest.approx(0.0, abs=1e-12)
    assert (np.diff(pull) > -1e-9).all()
    shut = np.stack([0 * PAPER.joint_stiffness, -PAPER.joint_limit + 0 * PAPER.joint_stiffness], axis=-1)
    assert pull[-1] == pytest.approx(cables.lengths(PAPER, shut).change[1], rel=1e-3)


def test_a_little_tension_bends_a_weightless_trunk_as_its_springs_let_it():
    """Joint by joint: moment over stiffness, by the levers of the cables in space."""
    light = replace(PAPER, mass=replace(PAPER.mass, sections=(1e-9,) * 18), gripper=None)
    tension = 1e-3
    slope = np.array([_ventral_slope(np.zeros(17), i) for i in range(17)])
    taken = tension * (slope**2 / light.joint_stiffness).sum() / 2
    assert free_curl(light, tension) == pytest.approx(taken, rel=1e-3)


@pytest.mark.parametrize("width", [0.033, 0.06, 0.09, 0.12])
def test_what_is_wrapped_keeps_cable_out(width):
    """By more than the share from which the strategy speaks of contact."""
    assert predict_wrap(PAPER, width, 0.25, 12.0).pull[1] < 0.85 * free_curl(PAPER, 12.0)


@pytest.mark.parametrize(("width", "mass"), [(0.0, 0.1), (-0.1, 0.1), (math.nan, 0.1), (0.1, -0.1), (0.1, math.nan)])
def test_impossible_objects_are_refused(width, mass):
    with pytest.raises(DesignError, match=r"width|mass"):
        predict_wrap(PAPER, width, mass, 10.0)


def test_a_trunk_without_pull_hangs_straight_beside_its_object():
    """The object then touches the middle of the last section, or, if thinner, the tightest circle that joints allow."""
    last, radius = PAPER.section_length[-1], PAPER.section_radius[-1]
    room = last / 2 / math.tan(PAPER.joint_limit / 2)
    for width in (0.01, 0.09):
        center = unrolled_center(PAPER, width, 0.0)
        np.testing.assert_allclose(center, [PAPER.length - last / 2, max(width / 2 + radius, room)], atol=1e-12)


@pytest.mark.parametrize("width", [0.033, 0.06, 0.12])
def test_an_object_hangs_lower_the_more_of_the_trunk_it_unrolls(width):
    down = [unrolled_center(PAPER, width, pull)[0] for pull in np.linspace(0.0, 0.05, 26)]
    assert (np.diff(down) < 1e-12).all()
    assert down[0] - down[-1] > 0.2


@pytest.mark.parametrize("width", [0.033, 0.06])
def test_an_object_that_unrolls_the_base_hangs_where_the_balance_says(width):
    """Two models of one sag: moments about each joint, and geometry with the cable that these bends take in."""
    wrap = predict_wrap(PAPER, width, 1.5, PAPER.cable.tension_max)
    center = unrolled_center(PAPER, width, float(wrap.pull[1:].mean()))
    assert wrap.center[0] > 0.13  # With the base shut it would be at half of that.
    assert center[0] == pytest.approx(wrap.center[0], abs=0.010)
