"""Commands as they are, between actions: what is refused leaves no trace, and actions go on from where the base is."""

import gymnasium
import numpy as np
import pytest

import spiraltrunk.envs  # noqa: F401
from spiraltrunk.control.messages import Command
from spiraltrunk.errors import RunError


def make(**given):
    env = gymnasium.make("spiraltrunk/Grasp-v0", disable_env_checker=True, ends=False, **given).unwrapped
    env.reset(seed=1)
    return env


def test_a_refused_command_leaves_the_set_point():
    env = make()
    before = env.setpoint
    wrong = Command(T_world_base=np.full((4, 4), np.nan), cable_tension=np.zeros(3))
    with pytest.raises(RunError, match="T_world_base"):
        env.step_command(wrong)
    assert env.setpoint is before
    seen, *_ = env.step(np.zeros(10))
    assert np.isfinite(seen["agent_pos"]).all()
