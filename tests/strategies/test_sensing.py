"""What is felt: a load's place by its torque, and how an object that touched with one end will come to lie."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.control.messages import Goal, Observation, Target, Task
from spiraltrunk.design.presets import PAPER
from spiraltrunk.strategies.sensing import LAG, lever, limit_ventral_lead, tipping_displacement, weight


def _observe(force, place, axis):
    """A force at a place beside the base, as the arm's torques tell it."""
    target = Target(kind="cylinder", width=0.06, length=0.24, mass=0.25, position=np.zeros(3), axis=axis)
    return Observation(
        time=0.0, task=Task(design=PAPER, target=target, goal=Goal(aside=np.zeros(3), place=np.zeros(3))),
        T_world_base=np.eye(4), arm_position=np.zeros(7), arm_velocity=np.zeros(7), cable_pull=np.zeros(3),
        cable_tension=np.zeros(3), base_force=force, base_torque=np.cross(place, force),
    )  # fmt: skip


@given(st.floats(0.5, 10), st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.floats(-0.4, 0.0), st.floats(0, math.pi))
def test_a_hanging_load_is_felt_where_it_is(load, along, across, height, angle):
    axis = np.array([math.cos(angle), math.sin(angle), 0.0])
    place = along * axis + across * np.array([-axis[1], axis[0], 0.0]) + [0.0, 0.0, height]
    seen = _observe(np.array([0.0, 0.0, -load]), place, axis)
    assert weight(seen) == load
    assert lever(seen) == pytest.approx(along, abs=1e-12)


@given(st.floats(0.02, 0.3), st.floats(0.02, 0.12), st.floats(0.0, 1.0))
def test_turning_flat_moves_the_centre_by_what_turning_its_corners_does(length, width, part):
    """Independently: corners turned by a matrix about the low one, for tilts up to standing on that corner."""
    tilt = part * (math.pi / 2 - math.atan2(width, length))
    turn = np.array([[math.cos(tilt), math.sin(tilt)], [-math.sin(tilt), math.cos(tilt)]])
    corner = turn @ [length / 2, -width / 2]
    height = -corner[1] - width / 2
    way = length / 2 - corner[0]
    assert tipping_displacement(length, width, height) == pytest.approx(way, abs=1e-6)


@given(st.floats(0.02, 0.12), st.floats(0.0, 0.5))
def test_what_seems_to_touch_higher_than_any_tilt_is_tilted_as_far_as_it_hangs_beside(width, tilt):
    """By r sin t; heights that a tilt can explain count alone."""
    way = 0.12 * (1 - math.cos(tilt)) + width / 2 * math.sin(tilt)
    beside, possible = width / 2 * math.sin(tilt), 0.9 * (math.hypot(0.12, width / 2) - width / 2)
    for side in (beside, -beside):
        assert tipping_displacement(0.24, width, 0.5, side) == pytest.approx(way, abs=1e-9)
    assert tipping_displacement(0.24, width, possible, 0.0) == tipping_displacement(0.24, width, possible) > 0.0


@pytest.mark.parametrize("height", [0.0, -0.01, -1.0])
def test_what_touches_level_or_lower_does_not_move(height):
    assert tipping_displacement(0.24, 0.06, height) == pytest.approx(0.0, abs=1e-12)


def test_what_touches_higher_than_its_diagonal_stands_on_its_corner():
    """The centre above the corner moves by half the length; there is no steeper tilt."""
    assert tipping_displacement(0.24, 0.06, 0.5) == pytest.approx(0.12)


@given(st.floats(-0.1, 0.1), st.floats(0.0, 0.05), st.floats(0.0, 30.0))
def test_a_ventral_cable_is_bounded_unless_the_bound_holds_the_other_one_back(pull, ahead, tension):
    stroke, lead, wanted = PAPER.cable_stroke, 0.04, np.array([0.0, 20.0, 20.0])
    seen = replace(
        _observe(np.zeros(3), np.zeros(3), np.eye(3)[0]),
        cable_pull=np.array([-0.3, pull, pull + ahead * stroke]), cable_tension=np.array([0.0, tension, 20.0]),
    )  # fmt: skip
    usual = limit_ventral_lead(seen, lead)
    assert usual[0] == math.inf
    assert usual[1:] == pytest.approx(pull + lead * stroke)
    bound = limit_ventral_lead(seen, lead, wanted)
    if 20.0 - tension <= LAG:
        np.testing.assert_array_equal(bound, usual)
    else:
        assert bound[1] == math.inf
        is_near = seen.cable_pull[2] - pull < lead * stroke / 2
        assert bound[2] == (math.inf if is_near else usual[2])
