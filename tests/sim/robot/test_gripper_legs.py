"""The legs of a large gripper's cables through the trunk: balanced, and where the printed trunk has its holes."""

import mujoco
import numpy as np
import pytest

from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.geometry.csg import compute_bounds
from spiraltrunk.cad.trunk.body import build_body
from spiraltrunk.cad.trunk.gripper import build_gripper, find_seat
from spiraltrunk.control.messages import Command
from spiraltrunk.design import presets
from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.strand_route import find_strand_route
from spiraltrunk.sim import SimPlant
from spiraltrunk.sim.robot.gripper import GROUPS, LEGS
from spiraltrunk.sim.robot.trunk import hinge_names, trunk_spec

LARGE = presets.get("paper-large-grip")


def _leg_torque(bend):
    """Elastic torque of the last joint, and the torque on it of the closing legs at full tension [N m]."""
    model = trunk_spec(LARGE).compile()
    data, name = mujoco.MjData(model), hinge_names(LARGE.n_joint - 1)[0]
    data.qpos[model.joint(name).qposadr[0]] = bend
    mujoco.mj_forward(model, data)
    elastic, others = float(data.qfrc_passive[model.joint(name).dofadr[0]]), data.qfrc_actuator.copy()
    data.ctrl[model.actuator(LEGS[0]).id] = LARGE.gripper.tension_max
    mujoco.mj_forward(model, data)
    return elastic, data.qfrc_actuator - others, int(model.joint(name).dofadr[0])


def test_two_legs_do_not_bend_the_straight_trunk():
    """The torques T a of both legs cancel; of one leg, they would bend the tip to its limit."""
    _, torque, _ = _leg_torque(0.0)
    aside = find_strand_route(LARGE).aside
    assert np.abs(torque).max() < 1e-6 * LARGE.gripper.tension_max * aside
    assert LARGE.gripper.tension_max * aside > LARGE.joint_stiffness[-1] * LARGE.joint_limit


def test_two_legs_soften_a_bent_joint_as_the_closed_form_says():
    """T a tan(delta_theta / 2) / 2 of the stiffness is lost, a quarter to a third at the last joint."""
    bend, route = 0.05, find_strand_route(LARGE)
    elastic, torque, dof = _leg_torque(bend)
    lost = LARGE.gripper.tension_max * route.aside * np.tan(LARGE.delta_theta / 2) / 2
    assert torque[dof] / bend == pytest.approx(lost, rel=0.1)
    assert torque[dof] * elastic < 0.0
    assert lost < LARGE.joint_stiffness[-1]


def test_the_papers_gripper_has_no_legs():
    """Its simulation is that of earlier versions."""
    model = trunk_spec(PAPER).compile()
    names = {model.actuator(i).name for i in range(model.nu)}
    assert not names & set(LEGS)


def test_the_simulated_legs_are_where_the_printed_holes_are():
    options = MakeOptions()
    body, route = build_body(LARGE, options), find_strand_route(LARGE)
    assert body.n_hollow == route.first_solid
    printed = sorted(body.find_legs(2, options))
    both = np.vstack([route.leg_directions(), -route.leg_directions()])
    np.testing.assert_allclose(printed, sorted(map(tuple, 1e3 * route.aside * both)), atol=1e-6)


def test_fingers_and_legs_are_pulled_by_the_same_tension():
    plant = SimPlant(LARGE)
    seen = plant.reset()
    command = Command(T_world_base=seen.T_world_base, cable_tension=np.zeros(3), gripper=0.5)
    for _ in range(30):
        plant.step(command)
    for group, legs in zip(GROUPS, LEGS, strict=True):
        assert plant.data.ctrl[plant.model.actuator(group).id] == plant.data.ctrl[plant.model.actuator(legs).id]
    assert plant.data.ctrl[plant.model.actuator(LEGS[0]).id] == pytest.approx(0.5 * LARGE.gripper.tension_max)


def test_the_plate_is_as_wide_as_the_printed_one():
    """The paper's plate is the end of the last section; a large one is wider than the tip, and touches as such."""
    model = trunk_spec(LARGE).compile()
    radius, half = model.geom("gripper_plate").size[:2]
    low, high = compute_bounds(build_gripper(LARGE, MakeOptions())[0].form)
    assert radius == pytest.approx((high[0] - low[0]) / 2e3, rel=0.05)
    assert radius > LARGE.section_radius[-1]
    assert 2 * half == pytest.approx(find_seat(LARGE, MakeOptions()).plate / 1e3, rel=0.05)
    with pytest.raises(KeyError):
        trunk_spec(PAPER).compile().geom("gripper_plate")
