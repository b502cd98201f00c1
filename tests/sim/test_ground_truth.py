"""What the record reads off MuJoCo's arrays, against MuJoCo's own functions, in the middle of a grasp."""

from copy import copy

import mujoco
import numpy as np
import pytest

from spiraltrunk import strategies
from spiraltrunk.control.loop import run
from spiraltrunk.design.presets import PAPER
from spiraltrunk.sim import SimPlant, truth_kernel
from spiraltrunk.sim.objects.catalogue import DEFAULT_OBJECT, parse_object
from spiraltrunk.sim.sensors import SensorOptions, Sensors
from spiraltrunk.workflows.grasp.world import draw_scene


class _Tight(Exception):
    """The trunk is wrapped round the object, which still hangs on its strings."""


@pytest.fixture(scope="module")
def plant():
    plant = SimPlant(PAPER, draw_scene(parse_object(DEFAULT_OBJECT), 0))

    def watch(observation, status):
        if status.action == "heft":
            raise _Tight

    with pytest.raises(_Tight):
        run(plant, strategies.get("wrap-vertical"), watch=watch)
    return plant


def _names(plant, contact):
    return {plant.model.body(int(plant.model.geom_bodyid[g])).name.split("_")[0] for g in contact.geom}


def test_the_grip_is_the_sum_of_the_normal_forces(plant):
    model, data, force, total, count = plant.model, plant.data, np.zeros(6), 0.0, 0
    for i, contact in enumerate(data.contact):
        names = _names(plant, contact)
        if "object" in names and names & {"section", "finger", "neck"}:
            mujoco.mj_contactForce(model, data, i, force)
            total, count = total + force[0], count + 1
    assert count > 2
    assert total > 1.0
    assert plant.trace[-1].grip_force == pytest.approx(total, rel=1e-12)


def test_the_slip_is_the_mean_sliding_velocity_by_normal_force(plant):
    """With points' velocities from Jacobians. After a step, forces and contacts are those before it: computed anew."""
    model, data, force, total, slid = plant.model, copy(plant.data), np.zeros(6), 0.0, np.zeros(3)
    mujoco.mj_forward(model, data)
    for i, contact in enumerate(data.contact):
        if "object" not in (names := _names(plant, contact)) or not names & {"section", "finger", "neck"}:
            continue
        bodies = sorted((int(model.geom_bodyid[g]) for g in contact.geom), key=lambda b: model.body(b).name != "object")
        jacobian = np.zeros((2, 3, model.nv))
        for body, rows in zip(bodies, jacobian, strict=True):
            mujoco.mj_jac(model, data, rows, None, contact.pos, body)
        velocity, normal = (jacobian[0] - jacobian[1]) @ data.qvel, contact.frame[:3]
        mujoco.mj_contactForce(model, data, i, force)
        total, slid = total + force[0], slid + force[0] * (velocity - normal * (normal @ velocity))
    assert np.linalg.norm(slid / total) > 1e-4
    seen = plant._truth.sample(data, plant._arm_command).slip_velocity
    np.testing.assert_allclose(seen, slid / total, rtol=1e-9, atol=1e-12)


def test_the_axis_is_the_objects_own(plant):
    np.testing.assert_array_equal(plant.trace[-1].object_axis, plant.data.body("object").xmat.reshape(3, 3)[:, 0])


def test_the_overlap_is_that_of_the_deepest_contact(plant):
    deepest = max(-contact.dist for contact in plant.data.contact)
    assert 0 < deepest <= plant.trace[-1].penetration


def test_strings_bear_what_the_trunk_does_not(plant):
    model, data, borne = plant.model, plant.data, 0.0
    for row in np.flatnonzero(data.efc_type == mujoco.mjtConstraint.mjCNSTR_LIMIT_TENDON):
        if model.tendon(int(data.efc_id[row])).name.startswith("string_"):
            borne += data.efc_force[row]
    weight = 9.81 * model.body("object").mass[0]
    assert 0.1 * weight < borne < 2 * weight
    assert plant.trace[-1].string_tension == pytest.approx(borne, rel=1e-12)


def test_bends_are_the_angles_between_the_sections_axes(plant):
    data, sample = plant.data, plant.trace[-1]
    axes = np.array([data.body(f"section_{n + 1:02d}").xmat.reshape(3, 3)[:, 0] for n in range(PAPER.n_section)])
    bend = np.arccos(np.clip((axes[1:] * axes[:-1]).sum(axis=-1), -1, 1))
    np.testing.assert_allclose(sample.joint_bend, bend, atol=1e-3)  # The axes are those before the last step.
    assert sample.joint_bend.max() <= sample.bend_most
    assert sample.joint_bend.max() > 0.3


@pytest.mark.parametrize(
    ("pair", "seen"),
    [
        ((truth_kernel.OBJECT, truth_kernel.ROBOT), (True, False, False)),
        ((truth_kernel.GROUND, truth_kernel.OBJECT), (False, True, False)),
        ((truth_kernel.ROBOT, truth_kernel.GROUND), (False, False, True)),
        ((truth_kernel.TRUNK, truth_kernel.GROUND), (False, False, False)),
        ((truth_kernel.OBJECT, truth_kernel.TRUNK), (False, False, False)),
        ((truth_kernel.ROBOT, truth_kernel.TRUNK), (False, False, False)),
        ((truth_kernel.OTHER, truth_kernel.OBJECT), (False, False, False)),
    ],
)
def test_a_pair_is_told_by_its_two_kinds(pair, seen):
    kind = np.array([truth_kernel.OTHER, *pair])
    for count in (1, 2):
        geom = np.tile(np.array([1, 2], np.int32), (count, 1))
        assert truth_kernel.read_contacts(kind, geom, np.full(count, -1e-3)) == (1e-3, *seen)


def test_readings_without_error_are_copies_and_draw_nothing():
    sensors, truth = Sensors(SensorOptions()), np.array([1.0, 2.0])
    for read in (sensors.read_pull, sensors.read_tension, sensors.read_torque):
        seen = read(truth)
        np.testing.assert_array_equal(seen, truth)
        seen[0] = 5.0
    np.testing.assert_array_equal(truth, [1.0, 2.0])


def test_what_is_read_scatters_as_it_says():
    options = SensorOptions(pull_noise=1e-3, tension_noise=0.5, tension_share=0.1, torque_noise=0.2, seed=3)
    sensors = Sensors(options)
    for read, truth, deviation in (
        (sensors.read_pull, 0.02, 1e-3), (sensors.read_tension, -5.0, 1.0), (sensors.read_torque, 3.0, 0.2),
    ):  # fmt: skip
        seen = np.array([read(np.full(7, truth)) for _ in range(500)])
        assert seen.mean() == pytest.approx(truth, abs=5 * deviation / seen.size**0.5)
        assert seen.std() == pytest.approx(deviation, rel=0.05)
