"""A strategy drives an environment, and an environment's policy is a strategy."""

import gymnasium
import numpy as np
import pytest

import spiraltrunk.envs  # noqa: F401
from spiraltrunk import strategies
from spiraltrunk.control.loop import run
from spiraltrunk.design import presets
from spiraltrunk.envs import StrategyAgent
from spiraltrunk.errors import DesignError, RunError
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.strategies.action_policy import ActionPolicy
from spiraltrunk.workflows.grasp.trial import run_trial

KICK = "spiraltrunk/Kick-v0"
WEIGHTS = np.random.default_rng(1).normal(size=(10, 20)) / 10


def policy(seen):
    """Some function of the observation."""
    return np.tanh(WEIGHTS @ np.tanh(seen["agent_pos"][:20] - seen["environment_state"][:20])).astype(np.float32)


def make(name=KICK, **given):
    return gymnasium.make(name, disable_env_checker=True, **given).unwrapped


@pytest.mark.parametrize("hz", [50.0, 10.0])
@pytest.mark.parametrize("mode", ["delta-pose-tension", "pose-tension"])
def test_a_policy_does_on_a_plant_what_it_does_in_its_environment(mode, hz):
    env = make(control_mode=mode, control_hz=hz, ends=False)
    seen, _ = env.reset(options={"object": "box-80", "seed_world": 5})
    for _ in range(round(0.6 * hz)):
        seen, *_ = env.step(policy(seen))
    strategy = ActionPolicy(policy, strategies.get("kick"), control_mode=mode, control_hz=hz, duration=0.6)
    trial = run_trial(presets.PAPER, parse_object("box-80"), strategy=strategy, seed=5)
    assert len(trial.plant.trace) == len(env.plant.trace) == 31
    assert np.array_equal(trial.plant.trace[-1].qpos, env.plant.trace[-1].qpos)
    assert trial.verdict.reason == env.verdict().reason


def test_a_policy_without_a_lift_is_told_so_by_the_survey():
    still = ActionPolicy(lambda seen: np.zeros(10), strategies.get("wrap-vertical"), duration=0.4)
    trial = run_trial(presets.PAPER, parse_object("cylinder-60"), strategy=still, seed=1)
    assert trial.verdict.reason == "the strategy reported no lift"
    assert trial.verdict.failure is not None


def test_joints_cannot_be_commanded_by_a_strategy():
    with pytest.raises(DesignError, match="a mode that sets the base"):
        ActionPolicy(policy, strategies.get("kick"), control_mode="joint-tension")


def test_a_policy_acts_at_rates_of_its_environment_alone():
    with pytest.raises(DesignError, match=r"control_hz is 30\.0; allowed: 50 over a whole number"):
        ActionPolicy(policy, strategies.get("kick"), control_hz=30.0)


def test_a_strategys_actions_follow_its_commands():
    env = make(control_mode="delta-pose-tension-pull")
    env.reset(options={"object": "box-80", "seed_world": 5})
    agent, strategy = StrategyAgent(env, strategies.get("kick")), strategies.get("kick")
    with pytest.raises(RunError, match="no plan"):
        agent.act()
    agent.reset()
    for _ in range(20):
        env.step(agent.act())
    assert agent.clipped == 0.0
    assert agent.dropped == set()
    assert agent.status.phase == "reach"
    trial_commands = []

    class Stop(Exception):
        pass

    def watch(seen, status):
        trial_commands.append(seen)
        if len(trial_commands) == 20:
            raise Stop

    plant = env.plant
    with pytest.raises(Stop):
        run(plant, strategy, watch=watch)
    wanted = trial_commands[-1].T_world_base
    assert np.abs(env.observation.T_world_base - wanted).max() < 1e-6


def test_an_agent_needs_an_environment_of_ours():
    with pytest.raises(DesignError, match=r"an environment of spiraltrunk\.envs"):
        StrategyAgent(gymnasium.make("CartPole-v1"), strategies.get("kick"))
