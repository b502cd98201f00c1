"""Commands as they are, between actions: what is refused leaves no trace, and actions go on from where the base is."""

import gymnasium
import numpy as np
import pytest

import spiraltrunk.envs  # noqa: F401
from spiraltrunk.control.encoding import restart_setpoint
from spiraltrunk.control.encoding.setpoint import ACCELERATION
from spiraltrunk.control.messages import Command
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.errors import RunError

RISE = 4e-3
"""Rise of the base in a control period [m]."""


def make(**given):
    env = gymnasium.make("spiraltrunk/Grasp-v0", disable_env_checker=True, ends=False, **given).unwrapped
    env.reset(seed=1)
    return env


def raise_base(env, count):
    """Raise the base at constant speed, in one array for all commands; the last command."""
    plant = env.plant
    frame = plant.reach.T_base(plant.trace[-1].arm_command)
    command = Command(T_world_base=frame, cable_tension=np.zeros(3))
    for _ in range(count):
        frame[2, 3] += RISE
        env.step_command(command)
    return command


def test_a_refused_command_leaves_the_set_point():
    env = make()
    before = env.setpoint
    wrong = Command(T_world_base=np.full((4, 4), np.nan), cable_tension=np.zeros(3))
    with pytest.raises(RunError, match="T_world_base"):
        env.step_command(wrong)
    assert env.setpoint is before
    seen, *_ = env.step(np.zeros(10))
    assert np.isfinite(seen["agent_pos"]).all()


def test_joints_hold_still_where_commands_led_them():
    env = make(control_mode="joint-tension")
    assert env.plant.options.sensors.delay > 0.0
    command = raise_base(env, 12)
    for _ in range(8):
        env.step_command(command)
    place = env.plant.reach.T_base
    start = place(env.plant.trace[-1].arm_command)
    for _ in range(6):
        env.step(env.encode_command(env.setpoint.command).action)
        assert np.abs(place(env.plant.trace[-1].arm_command) - start).max() < 1e-4


def test_joints_that_commands_move_brake_with_their_acceleration():
    env = make(control_mode="joint-tension")
    raise_base(env, 12)
    hold = env.encode_command(env.setpoint.command).action
    for _ in range(20):
        env.step(hold)
    arm = np.array([sample.arm_command for sample in env.plant.trace])
    most = env._episode._joints._acceleration * CONTROL_PERIOD**2
    assert (np.abs(np.diff(arm[11:], 2, axis=0)) <= 1.001 * most).all()  # From the last commands on.
    assert np.abs(arm[-1] - arm[13]).max() < 0.01


@pytest.mark.parametrize("mode", ["delta-pose-tension", "pose-tension"])
def test_a_base_that_commands_move_brakes_with_its_acceleration(mode):
    env = make(control_mode=mode)
    raise_base(env, 12)
    height = env.setpoint.command.T_world_base[2, 3]
    heights = [height - RISE, height]
    hold = env.encode_command(env.setpoint.command).action
    for _ in range(40):
        env.step(hold)
        heights.append(env.setpoint.command.T_world_base[2, 3])
    assert np.abs(np.diff(heights, 2)).max() <= 1.001 * ACCELERATION * CONTROL_PERIOD**2
    assert abs(heights[-1] - heights[-2]) < 1e-6


def test_a_command_that_jumps_leaves_the_base_at_rest():
    before, near, far = (Command(T_world_base=np.eye(4), cable_tension=np.zeros(3)) for _ in range(3))
    near.T_world_base[2, 3], far.T_world_base[2, 3] = RISE, 0.05
    assert restart_setpoint(near, before).velocity[0].tolist() == pytest.approx([0.0, 0.0, RISE / CONTROL_PERIOD])
    assert not restart_setpoint(far, before).velocity.any()
    assert not restart_setpoint(near).velocity.any()
