"""The simulated robot: what its arm feels, how its winders hold, how its gripper moves."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from spiraltrunk.control.messages import Command
from spiraltrunk.control.plant import CONTROL_PERIOD, TENSION_SLEW
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import RunError
from spiraltrunk.sim import SimPlant
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.sim.sensors import SensorOptions


def _still(plant, seconds, seen=None, **changes):
    """Hold the base where it is for a while."""
    seen = plant.reset() if seen is None else seen
    command = Command(**{"T_world_base": seen.T_world_base.copy(), "cable_tension": np.zeros(3), **changes})
    for _ in range(round(seconds / plant.control_period)):
        seen = plant.step(command)
    return seen


@pytest.fixture(scope="module")
def plant():
    return SimPlant()


def test_at_rest_the_base_carries_the_trunks_weight(plant):
    seen = _still(plant, 2.0)
    weight = 9.81 * PAPER.total_mass
    np.testing.assert_allclose(seen.base_force, [0, 0, -weight], rtol=0, atol=0.02 * weight)


def test_the_weight_is_felt_from_the_first_moment(plant):
    """The arm does not sink under the trunk when the work starts."""
    seen, weight = plant.reset(), 9.81 * PAPER.total_mass
    start = seen.T_world_base.copy()
    for _ in range(50):
        np.testing.assert_allclose(seen.base_force, [0, 0, -weight], rtol=0, atol=1e-3 * weight)
        np.testing.assert_allclose(seen.T_world_base, start, rtol=0, atol=1e-6)
        seen = plant.step(Command(T_world_base=start, cable_tension=np.zeros(3)))


@pytest.mark.parametrize("load", [(0.0, 0.0, -3.0), (0.5, 0.0, -2.0), (0.0, -0.4, 1.0)])
def test_an_added_load_is_felt(plant, load):
    empty = _still(plant, 2.0)
    plant.data.xfrc_applied[plant.model.body("section_12").id, :3] = load
    loaded = _still(plant, 3.0, seen=empty)
    felt = loaded.base_force - empty.base_force
    np.testing.assert_allclose(felt, load, rtol=0, atol=0.05 * np.linalg.norm(load))


def test_what_is_felt_does_not_depend_on_the_pull(plant):
    """Cable tension is inside the trunk: curled, it weighs the same."""
    seen = _still(plant, 4.0, cable_tension=np.array([0.0, 8.0, 8.0]))
    weight = 9.81 * PAPER.total_mass
    assert seen.base_force[2] == pytest.approx(-weight, rel=0.05)


def test_a_winder_holds_its_length(plant):
    """Tension suffices: the cable comes in as far as asked, within a few millimetres, and no further."""
    pull = np.array([np.inf, 0.02, 0.02])
    seen = _still(plant, 3.0, cable_tension=np.array([0.0, 40.0, 40.0]), cable_pull=pull)
    np.testing.assert_allclose(seen.cable_pull[1:], 0.02, rtol=0, atol=0.003)
    assert (seen.cable_tension[1:] < 39.0).all()
    assert (seen.cable_tension[1:] > 0.5).all()


def test_a_winder_pulls_no_harder_than_its_ceiling(plant):
    seen = _still(plant, 2.0, cable_tension=np.array([0.0, 2.0, 5.0]), cable_pull=np.full(3, 0.1))
    np.testing.assert_allclose(seen.cable_tension, [0.0, 2.0, 5.0], atol=1e-9)
    assert (seen.cable_pull < 0.09).all()


@pytest.mark.parametrize("tension", [1e6, 1.001 * PAPER.cable.tension_max, -5.0, -1e-3])
def test_a_command_of_more_than_the_motors_do_is_refused_and_nothing_moves(plant, tension):
    before = plant.reset().time
    with pytest.raises(RunError, match=r"cable_tension is .*allowed: 0 to 60 N"):
        _still(plant, 0.3, cable_tension=np.array([tension, 0.0, 0.0]))
    assert plant.data.time == before
    seen = _still(plant, 0.3, cable_tension=np.array([PAPER.cable.tension_max, 0.0, 0.0]))
    np.testing.assert_allclose(seen.cable_tension, [PAPER.cable.tension_max, 0.0, 0.0], atol=1e-9)


def test_tension_rises_no_faster_than_a_winder_can(plant):
    first = plant.reset()
    command = Command(T_world_base=first.T_world_base, cable_tension=np.array([0.0, 60.0, 60.0]))
    tensions = np.array([plant.step(command).cable_tension[1] for _ in range(5)])
    np.testing.assert_allclose(np.diff(tensions), TENSION_SLEW * CONTROL_PERIOD, rtol=1e-9)


def test_a_paid_out_cable_is_slack(plant):
    seen = _still(plant, 1.0, cable_tension=np.full(3, 40.0), cable_pull=np.full(3, -0.05))
    np.testing.assert_array_equal(seen.cable_tension, 0.0)


def _finger_reach(plant):
    """Distance of each finger's end from the tip section's axis, negative beyond it [m]."""
    tip, out = plant.data.body("section_18"), []
    for finger in range(3):
        end = plant.data.body(f"finger_{finger + 1}_2")
        length = PAPER.gripper.phalanx_length[1]
        point = end.xpos + length * end.xmat.reshape(3, 3)[:, 0]
        local = tip.xmat.reshape(3, 3).T @ (point - tip.xpos)
        side = 2 * np.pi * finger / 3
        out.append(local[1] * np.cos(side) + local[2] * np.sin(side))
    return np.array(out)


def _gripped(plant, gripper):
    _still(plant, 1.0, gripper=gripper)
    return _finger_reach(plant)


def test_the_gripper_opens_and_closes(plant):
    closed, slack, opened = (_gripped(plant, grip) for grip in (1.0, 0.0, -1.0))
    assert (closed < slack - 0.003).all()
    assert (opened > slack + 0.003).all()


@pytest.mark.parametrize("grip", [1.0, 0.3, 0.0, -1.0])
def test_the_fingers_move_alike(plant, grip):
    """The trunk hangs: gravity treats them alike too."""
    reach = _gripped(plant, grip)
    assert np.ptp(reach) < 2e-4


def test_a_stronger_grip_closes_further(plant):
    reach = [_gripped(plant, grip).mean() for grip in (0.0, 0.1, 0.3)]
    assert reach[0] > reach[1] > reach[2]


def test_a_trunk_without_a_gripper_takes_the_same_commands():
    plant = SimPlant(replace(PAPER, gripper=None))
    seen = _still(plant, 0.2, gripper=1.0)
    assert np.isfinite(seen.base_force).all()
    assert plant.model.nu == 7 + 3


def test_nothing_but_contact_holds_the_object(plant):
    """No weld or other equality; no motor, and no tendon but the strings that it hangs on, acts on it."""
    model = plant.model
    assert model.neq == 0
    own = model.body("object").id
    assert model.body_dofnum[own] == 6
    moved = {model.jnt_bodyid[model.actuator_trnid[i, 0]] for i in range(model.nu) if model.actuator_trntype[i] == 0}
    assert own not in moved
    for t in range(model.ntendon):
        start, count = model.tendon_adr[t], model.tendon_num[t]
        kinds, things = model.wrap_type[start : start + count], model.wrap_objid[start : start + count]
        bodies = {int(model.site_bodyid[x]) for kind, x in zip(kinds, things, strict=True)
                  if kind == mujoco.mjtWrap.mjWRAP_SITE}  # fmt: skip
        assert (own in bodies) == model.tendon(t).name.startswith("string_")
    assert (model.body_gravcomp[own] == 0.0).all()


def test_the_object_hangs_still_on_its_strings(plant):
    seen = _still(plant, 1.0)
    sample = plant.trace[-1]
    assert sample.string_tension == pytest.approx(9.81 * seen.task.target.mass, rel=0.01)
    assert np.linalg.norm(sample.object_position - seen.task.target.position) < 0.002
    assert sample.grip_force == 0.0
    assert not sample.touches_table
    assert not sample.touches_robot


def test_nothing_of_a_command_takes_effect_before_the_delay():
    """Cables and fingers stay slack, whatever bounds and gripper the first command has."""
    late = SceneOptions(sensors=SensorOptions(delay=3 * CONTROL_PERIOD))
    plant, still = SimPlant(options=late), SimPlant(options=late)
    seen = plant.reset()
    still.reset()
    pulled = Command(
        T_world_base=seen.T_world_base, cable_tension=np.full(3, 5.0), cable_pull=np.full(3, -0.05), gripper=1.0
    )
    slack = Command(T_world_base=seen.T_world_base, cable_tension=np.zeros(3))
    for _ in range(3):
        plant.step(pulled)
        still.step(slack)
        np.testing.assert_array_equal(plant.trace[-1].qpos, still.trace[-1].qpos)
    plant.step(pulled)
    still.step(slack)
    assert not np.array_equal(plant.trace[-1].qpos, still.trace[-1].qpos)
