"""The tip gripper as bodies: fingers stop at each other, stand still, and pass through nothing."""

import itertools
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from spiraltrunk.control.messages import Command
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.rules import design_from_rules
from spiraltrunk.sim import SimPlant
from spiraltrunk.sim.machine import GRIPPER_TIME
from spiraltrunk.sim.robot.gripper import GROUPS, phalanx_name
from spiraltrunk.sim.robot.trunk import hinge_names, trunk_spec


@pytest.fixture(scope="module")
def plant():
    return SimPlant()


def _hold(plant, grip, seconds=1.0, seen=None):
    """Angles of the finger joints over time [rad] and deepest overlap [m] while the servo is commanded so."""
    seen = plant.reset() if seen is None else seen
    command = Command(T_world_base=seen.T_world_base.copy(), cable_tension=np.zeros(3), gripper=grip)
    gripper = plant.design.gripper
    names = [phalanx_name(f, j) for f in range(gripper.n_finger) for j in range(gripper.n_phalanx)]
    address = [plant.model.joint(name).qposadr[0] for name in names]
    angles = []
    for _ in range(round(seconds / plant.control_period)):
        plant.step(command)
        angles.append(plant.data.qpos[address].copy())
    return np.array(angles), max(sample.penetration for sample in plant.trace)


def _bodies_in_contact(plant):
    return {
        tuple(sorted(plant.model.body(plant.model.geom_bodyid[geom]).name for geom in contact.geom))
        for contact in plant.data.contact
    }


@pytest.mark.parametrize("grip", [1.0, 0.5, 0.1])
def test_a_closed_gripper_stops_at_itself_and_stands_still(plant, grip):
    _hold(plant, grip)
    held, overlap = _hold(plant, grip, seen=plant._observe())
    assert overlap < 1e-3
    assert plant.warnings == 0
    assert np.ptp(held, axis=0).max() < np.radians(0.05)
    ends = [phalanx_name(finger, 1) for finger in range(3)]
    assert _bodies_in_contact(plant) >= set(itertools.combinations(ends, 2))


def test_a_phalanx_has_the_inertia_of_a_solid_cylinder(plant):
    """As MuJoCo integrates it over a cylinder of the phalanx's length, width and mass."""
    gripper = plant.design.gripper
    for j in range(gripper.n_phalanx):
        phalanx = plant.model.body(phalanx_name(0, j))
        spec = mujoco.MjSpec()
        size = [gripper.phalanx_width[j] / 2, gripper.phalanx_length[j] / 2, 0.0]
        spec.worldbody.add_body(name="phalanx").add_geom(
            type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=size, mass=float(phalanx.mass[0])
        )
        cylinder = spec.compile().body("phalanx")
        np.testing.assert_allclose(np.sort(phalanx.inertia), np.sort(cylinder.inertia), rtol=1e-9)
        np.testing.assert_allclose(phalanx.ipos, [gripper.phalanx_length[j] / 2, 0.0, 0.0], atol=1e-12)


def test_fingers_never_change_sides(plant):
    """Fully closed, each finger's end is still on its own side of the axis."""
    _hold(plant, 1.0)
    tip = plant.data.body("section_18")
    for finger in range(3):
        end = plant.data.body(phalanx_name(finger, 1))
        point = end.xpos + PAPER.gripper.phalanx_length[1] * end.xmat.reshape(3, 3)[:, 0]
        local, side = tip.xmat.reshape(3, 3).T @ (point - tip.xpos), 2 * np.pi * finger / 3
        assert local[1] * np.cos(side) + local[2] * np.sin(side) > 0


@pytest.mark.parametrize("grip", [0.0, -0.1, -0.4, -1.0])
def test_an_open_gripper_touches_nothing(plant, grip):
    _, overlap = _hold(plant, grip, 2.0)
    assert overlap == 0.0
    assert plant.data.ncon == 0


def test_a_wide_open_gripper_stands_at_its_joints_limits(plant):
    angles, _ = _hold(plant, -1.0, 2.0)
    np.testing.assert_allclose(angles[-1], -PAPER.gripper.delta_theta, rtol=0, atol=np.radians(0.5))


@pytest.mark.parametrize("towards", range(0, 360, 30))
def test_a_bent_last_joint_brings_no_finger_to_the_trunk(plant, towards):
    """At its limit too, the section before the tip stays clear of straight and of opened fingers."""
    model, data, limit = plant.model, plant.data, PAPER.joint_limit
    plant.reset()
    about_y = limit * np.cos(np.radians(towards))
    about_z = np.arccos(min(1.0, np.cos(limit) / np.cos(about_y))) * (1 if towards < 180 else -1)
    for name, angle in zip(hinge_names(PAPER.n_joint - 1), (about_y, about_z), strict=True):
        data.qpos[model.joint(name).qposadr[0]] = angle
    for opened in (0.0, -PAPER.gripper.delta_theta):
        for finger in range(3):
            data.qpos[model.joint(phalanx_name(finger, 0)).qposadr[0]] = opened
        mujoco.mj_kinematics(model, data)
        for finger in range(3):
            pair = model.geom("skin_17").id, model.geom(phalanx_name(finger, 0)).id
            assert mujoco.mj_geomDistance(model, data, *pair, 1.0, None) > 5e-4


def test_fingers_collide_with_each_other_and_with_the_trunk(plant):
    """All pairs but those that are mounted on each other."""
    model, finger = plant.model, [[phalanx_name(f, j) for j in range(2)] for f in range(3)]
    excluded = {frozenset((int(pair) >> 16, int(pair) & 0xFFFF)) for pair in model.exclude_signature}
    fingers = {model.body(name).id for names in finger for name in names}
    assert not any(pair & fingers for pair in excluded)
    for body in fingers:
        for geom in range(model.body_geomadr[body], model.body_geomadr[body] + model.body_geomnum[body]):
            assert model.geom_contype[geom]
            assert model.geom_conaffinity[geom]


@pytest.mark.parametrize("n_phalanx", [1, 3])
@pytest.mark.parametrize("grip", [1.0, -1.0])
def test_other_fingers_do_not_pass_through_themselves_either(n_phalanx, grip):
    plant = SimPlant(replace(PAPER, gripper=replace(PAPER.gripper, n_phalanx=n_phalanx)))
    _, overlap = _hold(plant, grip)
    assert overlap < 1.5e-3  # 1.2 mm at 2 ms with three phalanges, below 1 mm at 1 ms; a finger is 10 mm wide.
    assert plant.warnings == 0


def test_phalanges_too_short_to_keep_the_others_apart_do_not_overlap_at_rest():
    plant = SimPlant(replace(PAPER, gripper=replace(PAPER.gripper, n_phalanx=8)))
    _, overlap = _hold(plant, 0.0, 0.2)
    assert overlap == 0.0


def test_the_servo_takes_its_time(plant):
    seen = plant.reset()
    motors = [plant.model.actuator(name).id for name in GROUPS]
    forces = []
    for grip in (1.0,) * 5 + (-1.0,) * 10:
        command = Command(T_world_base=seen.T_world_base, cable_tension=np.zeros(3), gripper=grip)
        plant.step(command)
        forces.append(plant.data.ctrl[motors].copy())
    net = np.diff([close - loosen for close, loosen in forces])
    step = PAPER.gripper.tension_max * CONTROL_PERIOD / GRIPPER_TIME
    np.testing.assert_allclose(np.abs(net), step, rtol=1e-9)
    assert (np.min(forces, axis=1) == 0.0).all()


@pytest.mark.parametrize("angle", [12.0, 15.0, 20.0, 22.5, 30.0])
def test_no_finger_touches_the_trunk_of_short_sections(angle):
    """The capsule of a short section ends in a ball that reaches past the next one."""
    model = trunk_spec(design_from_rules(delta_theta=np.radians(angle))).compile()
    data = mujoco.MjData(model)
    for bend in (-0.8, -0.3, 0.0, 0.1):
        for finger in range(3):
            data.joint(phalanx_name(finger, 0)).qpos[0] = bend
        mujoco.mj_forward(model, data)
        touched = {
            frozenset(model.body(int(model.geom_bodyid[geom])).name.split("_")[0] for geom in contact.geom)
            for contact in data.contact
        }
        assert {"section", "finger"} not in touched
