"""What is felt: a load's place by its torque."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.control.messages import Goal, Observation, Target, Task
from spiraltrunk.design.presets import PAPER
from spiraltrunk.strategies.sensing import lever, weight


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
