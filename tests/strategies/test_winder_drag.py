"""Drag of the drums is balanced while a trunk closes, and a slack trunk that it keeps bent is pulled straight."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.control.messages import Command, Goal, Observation, Target, Task
from spiraltrunk.design.presets import PAPER
from spiraltrunk.strategies.winder_drag import (
    BENT,
    CLOSING,
    DRAG_LEAST,
    DRAG_MOST,
    STRAIGHTENING,
    balance_drag,
    straighten,
)

STROKE, MOST = PAPER.cable_stroke, PAPER.cable.tension_max


def observe(pull=(0.0, 0.0, 0.0), tension=(0.0, 0.0, 0.0)):
    target = Target(kind="cylinder", width=0.06, length=0.24, mass=0.25, position=np.zeros(3), axis=np.eye(3)[2])
    return Observation(
        time=0.0, task=Task(design=PAPER, target=target, goal=Goal(aside=np.zeros(3), place=np.zeros(3))),
        T_world_base=np.eye(4), arm_position=np.zeros(7), arm_velocity=np.zeros(7), cable_pull=np.array(pull),
        cable_tension=np.array(tension), base_force=np.zeros(3), base_torque=np.zeros(3),
    )  # fmt: skip


def command(tension=(0.0, 0.0, 0.0), pull=None):
    return Command(T_world_base=np.eye(4), cable_tension=np.array(tension), cable_pull=pull)


def moment(tension):
    """Moment of the cables about the neutral axis, over the radius of the holes [N]."""
    return float(PAPER.cable_direction[:, 1] @ tension)


@given(st.floats(DRAG_LEAST, DRAG_MOST), st.floats(0.0, 30.0), st.floats(0.0, 30.0))
def test_the_moment_of_a_closing_trunk_is_the_planned_one(drag, one, other):
    planned = command((0.0, one, other))
    given = balance_drag(planned, observe(tension=(drag, one, other)), "curl")
    pulled = np.array([drag, *given.cable_tension[1:]])
    assert moment(pulled) == pytest.approx(moment(planned.cable_tension), abs=1e-9)
    assert given.cable_tension[0] == 0.0
    assert given.cable_tension[1] - one == pytest.approx(given.cable_tension[2] - other)


def test_a_reading_that_is_no_drag_is_balanced_as_the_largest_drag():
    given = balance_drag(command((0.0, 20.0, 20.0)), observe(tension=(50.0, 20.0, 20.0)), "curl")
    np.testing.assert_allclose(given.cable_tension, [0.0, 20.0 + DRAG_MOST, 20.0 + DRAG_MOST])


def test_no_cable_is_pulled_with_more_than_its_motor_does():
    given = balance_drag(command((0.0, MOST - 1.0, 10.0)), observe(tension=(5.0, 0.0, 0.0)), "tighten")
    np.testing.assert_allclose(given.cable_tension, [0.0, MOST, 15.0])


@given(st.floats(-1.0, 0.99 * DRAG_LEAST), st.floats(0.0, 20.0), st.sampled_from(CLOSING))
def test_a_dorsal_cable_that_has_its_commanded_tension_is_left_alone(noise, counter, action):
    planned = command((counter, 20.0, 20.0))
    assert balance_drag(planned, observe(tension=(counter + noise, 15.0, 25.0)), action) is planned


def test_a_trunk_that_does_not_close_is_left_alone():
    planned = command((0.0, 20.0, 20.0))
    assert balance_drag(planned, observe(tension=(9.0, 20.0, 20.0)), "hold") is planned


@given(st.floats(-0.99 * BENT, 1.0), st.floats(-1.0, 1.0))
def test_a_slack_trunk_that_is_not_bent_ventral_is_left_alone(dorsal, ventral):
    slack = command()
    assert straighten(slack, observe([dorsal * STROKE, ventral * STROKE, ventral * STROKE])) is slack


@given(st.floats(1.01 * BENT, 1.0), st.one_of(st.none(), st.floats(-0.1, 0.1)))
def test_the_dorsal_cable_of_a_bent_one_is_pulled_in_to_its_straight_length(bent, bound):
    slack = command(pull=None if bound is None else np.full(3, bound))
    given = straighten(slack, observe([-bent * STROKE, 0.02, 0.02]))
    np.testing.assert_array_equal(given.cable_tension, [STRAIGHTENING * MOST, 0.0, 0.0])
    most = np.inf if bound is None else bound
    np.testing.assert_array_equal(given.cable_pull, [min(most, 0.0), most, most])
    np.testing.assert_array_equal(slack.cable_tension, np.zeros(3))  # The strategy's own command is as it was.
    if bound is not None:
        np.testing.assert_array_equal(slack.cable_pull, np.full(3, bound))
