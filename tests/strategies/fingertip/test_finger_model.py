"""Fingers bent by their cables alone: as in the simulation, scaled laws, and room round what they open for."""

import numpy as np
import pytest

from spiraltrunk.control.messages import Command
from spiraltrunk.design.presets import PAPER
from spiraltrunk.sim import SimPlant
from spiraltrunk.sim.robot.gripper import phalanx_name
from spiraltrunk.strategies.fingertip.finger_model import closing_tension, finger_bend, finger_points, opening_tension

GRIPPER = PAPER.gripper


def test_a_straight_finger_reaches_its_length():
    points = finger_points(GRIPPER, np.zeros(GRIPPER.n_phalanx))
    np.testing.assert_allclose(points[-1], [GRIPPER.mount_radius, GRIPPER.finger_length], rtol=1e-12)


def test_the_last_joint_bends_first_by_the_spirals_ratio_squared():
    """Torque falls with the width, stiffness with its cube."""
    bend = finger_bend(GRIPPER, 0.5)
    assert bend[1] / bend[0] == pytest.approx(GRIPPER.k_p**-2, rel=1e-9)


def test_a_gripper_twice_as_large_bends_alike_under_four_times_the_tension():
    large = GRIPPER.scaled(2.0)
    np.testing.assert_allclose(finger_bend(large, 2.0), finger_bend(GRIPPER, 0.5), rtol=1e-12)
    np.testing.assert_allclose(
        finger_points(large, finger_bend(large, 2.0)), 2 * finger_points(GRIPPER, finger_bend(GRIPPER, 0.5)), rtol=1e-12
    )


@pytest.mark.parametrize("grip", [-0.1, -0.3, -0.6])
def test_open_fingers_stand_in_the_simulation_where_the_model_says(grip):
    plant = SimPlant(PAPER)
    seen = plant.reset()
    for _ in range(75):
        plant.step(Command(T_world_base=seen.T_world_base, cable_tension=np.zeros(3), gripper=grip))
    bend = [plant.data.qpos[plant.model.joint(phalanx_name(0, j)).qposadr[0]] for j in range(GRIPPER.n_phalanx)]
    np.testing.assert_allclose(bend, finger_bend(GRIPPER, grip * GRIPPER.tension_max), rtol=0, atol=np.radians(1.0))


def test_opening_clears_what_it_is_for_and_no_more():
    def outline(depth, skin):
        return np.where(depth > 0.015, 0.015 + skin, 0.0)

    def room(tension):
        points = finger_points(GRIPPER, finger_bend(GRIPPER, -tension))
        return (points[-1, 0] >= 0.015 + GRIPPER.phalanx_width[-1] / 2) and points[1, 0] >= 0.015

    tension = opening_tension(GRIPPER, outline)
    assert room(tension)
    assert opening_tension(GRIPPER, lambda depth, skin: np.where(depth > 0.015, 0.012 + skin, 0.0)) < tension


def test_a_width_beyond_the_fingers_is_answered_with_none():
    assert opening_tension(GRIPPER, lambda depth, skin: np.full(depth.shape, 0.1)) is None


def test_without_a_load_closing_takes_what_holds_the_finger_there():
    """Straight fingers need no tension; pressing harder takes more, wide things less."""
    assert closing_tension(GRIPPER, GRIPPER.mount_radius, 0.0) == 0.0
    soft, firm = (closing_tension(GRIPPER, 0.015, force) for force in (0.3, 0.6))
    assert firm > soft > closing_tension(GRIPPER, 0.018, 0.3)
