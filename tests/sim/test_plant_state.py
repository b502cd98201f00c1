"""A saved state of the plant restores it bit for bit; joints go where they are told."""

from dataclasses import fields, replace

import numpy as np
import pytest

from spiraltrunk.control.messages import Command
from spiraltrunk.design import presets
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import RunError
from spiraltrunk.sim import SceneOptions, SimPlant
from spiraltrunk.sim.sensors import SensorOptions

NOISY = SceneOptions(
    sensors=SensorOptions(pull_noise=2e-4, tension_noise=0.2, torque_noise=0.02, delay=0.04, has_camera=True, seed=7)
)


def moves(start, first, count):
    """Commands that move the base, pull cables and close the gripper."""
    for i in range(first, first + count):
        T = start.copy()
        T[:3, 3] += [0.0, 5e-4 * i, -1e-3 * i]
        yield Command(
            T_world_base=T, cable_tension=np.array([0.0, 25.0, 20.0]), cable_pull=np.array([np.inf, 0.05, 0.05]),
            gripper=0.5,
        )  # fmt: skip


def roll(plant, start, first, count=6):
    seen = [plant.step(command) for command in moves(start, first, count)]
    return [
        value for each in seen for value in (each.cable_pull, each.base_force, each.arm_position, each.T_world_base)
    ]


def test_a_state_restores_everything_here_and_in_another_plant():
    plant = SimPlant(options=NOISY)
    start = plant.reset().T_world_base
    roll(plant, start, 0)
    state = plant.get_state()
    went_on, last = roll(plant, start, 6), plant.trace[-1]
    for again in (plant, SimPlant(options=NOISY)):
        again.set_state(state)
        assert all(np.array_equal(a, b) for a, b in zip(went_on, roll(again, start, 6), strict=True))
        assert len(again.trace) == 13
        assert all(np.array_equal(getattr(last, f.name), getattr(again.trace[-1], f.name)) for f in fields(last))


@pytest.mark.parametrize("part", ["sensors", "friction", "pending", "arm_command", "tension_limit"])
def test_no_part_of_the_state_is_idle(part):
    plant = SimPlant(replace(PAPER, cable=replace(PAPER.cable, friction=0.1)), NOISY)
    start = plant.reset().T_world_base
    empty = plant.get_state()
    roll(plant, start, 0)
    state = plant.get_state()
    went_on = roll(plant, start, 6)
    plant.set_state(replace(state, **{part: getattr(empty, part)}))
    goes_on = roll(plant, start, 6)
    is_same = all(np.array_equal(a, b) for a, b in zip(went_on, goes_on, strict=True))
    assert not is_same


def test_the_state_of_another_scene_is_refused():
    plant, other = SimPlant(), SimPlant(presets.get("spirob-15"))
    plant.reset()
    other.reset()
    with pytest.raises(RunError, match="of the same scene"):
        other.set_state(plant.get_state())
    with pytest.raises(RunError, match="before its first reset"):
        SimPlant().get_state()


def test_joints_go_where_they_are_told_at_their_speed():
    plant = SimPlant()
    seen = plant.reset()
    hold = next(moves(seen.T_world_base, 0, 1))
    target = seen.arm_position + np.array([0.2, 0.1, -0.1, 0.1, 0.1, 0.1, 0.3])
    before = plant.trace[-1].arm_command
    for _ in range(60):
        seen = plant.step_joints(target, hold)
        moved = plant.trace[-1].arm_command - before
        assert (np.abs(moved) <= 0.8 * 0.02 * plant.arm_limits.velocity * (1 + 1e-9)).all()
        before = plant.trace[-1].arm_command
    assert np.abs(seen.arm_position - target).max() < 0.01
    with pytest.raises(RunError, match="arm_position"):
        plant.step_joints(np.zeros(3), hold)
