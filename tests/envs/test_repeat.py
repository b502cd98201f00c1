"""Episodes repeat bit for bit: by their seed, from a saved state, and as the survey's trials."""

import multiprocessing
from dataclasses import fields

import gymnasium
import numpy as np
import pytest

from spiraltrunk import strategies
from spiraltrunk.design import presets
from spiraltrunk.envs import StrategyAgent, drive
from spiraltrunk.errors import DesignError
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.workflows.grasp.choice.ground import set_ground
from spiraltrunk.workflows.grasp.trial import run_trial
from spiraltrunk.workflows.grasp.world import draw_scene

NAME = "spiraltrunk/Grasp-v0"


def make(name=NAME, **given):
    return gymnasium.make(name, disable_env_checker=True, **given).unwrapped


def roll(env, steps, seed=None, *, start=True):
    """Observations and rewards of an episode of random actions."""
    out = []
    if start:
        seen, _ = env.reset(seed=seed)
        out = [seen["agent_pos"], seen["environment_state"]]
    generator = np.random.default_rng(9)
    for _ in range(steps):
        action = generator.uniform(-1, 1, env.action_space.shape).astype(np.float32)
        seen, reward, *_ = env.step(action)
        out += [seen["agent_pos"], seen["environment_state"], np.array(reward)]
    return out


def assert_same(one, other):
    assert len(one) == len(other)
    for a, b in zip(one, other, strict=True):
        assert np.array_equal(a, b)


def roll_elsewhere(queue):
    """In another process."""
    queue.put(roll(make(), 5, seed=4))


def test_the_same_seed_gives_the_same_episode_and_another_one_another():
    env = make()
    first = roll(env, 5, seed=4)
    assert_same(first, roll(env, 5, seed=4))
    assert_same(first, roll(make(), 5, seed=4))
    assert not np.array_equal(first[0], roll(env, 0, seed=5)[0])


@pytest.mark.slow
def test_the_same_seed_gives_the_same_episode_in_another_process():
    context = multiprocessing.get_context("spawn")
    queue = context.Queue()
    process = context.Process(target=roll_elsewhere, args=(queue,))
    process.start()
    elsewhere = queue.get(timeout=120)
    process.join()
    assert_same(roll(make(), 5, seed=4), elsewhere)


@pytest.mark.parametrize("mode", ["delta-pose-tension", "joint-tension", "pose-tension-pull"])
def test_a_saved_state_goes_on_bit_for_bit_here_and_in_another_environment(mode):
    env = make(control_mode=mode, control_hz=25.0, ends=False)
    roll(env, 5, seed=1)
    state = env.get_state()
    went_on = roll(env, 5, start=False)
    after = env.np_random.integers(10**9)
    env.set_state(state)
    assert_same(went_on, roll(env, 5, start=False))
    other = make(control_mode=mode, control_hz=25.0, ends=False)
    other.set_state(state)
    assert_same(went_on, roll(other, 5, start=False))
    assert other.np_random.integers(10**9) == after
    assert other.world == env.world


def test_a_state_of_another_environment_is_refused():
    env, kick = make(), make("spiraltrunk/Kick-v0")
    env.reset(seed=1)
    kick.reset(seed=1)
    with pytest.raises(DesignError, match=r"of an environment with job 'kick'; allowed: one with job 'grasp'"):
        env.set_state(kick.get_state())
    with pytest.raises(DesignError, match="control_mode 'delta-pose-tension'; allowed: one with control_mode 'joint"):
        make(control_mode="joint-tension").set_state(env.get_state())
    with pytest.raises(DesignError, match="state is None; allowed: EnvState"):
        env.set_state(None)
    env.step(np.zeros(10))


def test_a_state_tells_every_part_of_the_plant():
    env = make()
    roll(env, 3, seed=1)
    state = env.get_state().episode.plant
    assert state.pending  # A command that is under way: sensors' delay.
    env.step(np.zeros(10))
    assert state.sensors.generator["state"] != env.get_state().episode.plant.sensors.generator["state"]
    assert len(state.trace) == 4
    assert all(getattr(state, field.name) is not None for field in fields(state))


@pytest.mark.parametrize(
    ("name", "env_name", "stage", "shape"),
    [
        ("wrap-vertical", NAME, "hung", "cylinder-60"), ("tip-grip", NAME, "ground", "cube-28"),
        ("kick", "spiraltrunk/Kick-v0", "ground", "box-80"),
    ],
)  # fmt: skip
def test_a_named_world_is_that_of_the_survey(name, env_name, stage, shape):
    env = make(env_name, stage=stage)
    _, info = env.reset(seed=0, options={"object": shape, "seed_world": 77, "strategy": name})
    strategy = strategies.get(name)
    scene = set_ground(presets.PAPER, draw_scene(parse_object(shape), 77, strategy=strategy), strategy)
    assert env.plant.options.offset == scene.offset
    assert env.plant.options.sensors == scene.sensors
    assert env.plant.options.ground == scene.ground
    world = info["world"]
    assert world["mass_kg"] == scene.shape.mass
    assert world["friction"] == scene.shape.friction
    assert world["seed_world"] == 77


def test_a_strategys_commands_pass_as_they_are():
    env, strategy = make(), strategies.get("wrap-vertical")
    env.reset(seed=0, options={"object": "cylinder-60", "seed_world": 101})
    agent = StrategyAgent(env, strategy)
    agent.reset()
    commands = []
    for _ in range(5):
        commands.append(agent.command())
        env.step_command(commands[-1])
    assert np.array_equal(env.setpoint.command.T_world_base, commands[-1].T_world_base)
    assert env.plant.trace[-1].time == pytest.approx(0.1)


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    ("name", "env_name", "stage", "shape", "seed"),
    [("kick", "spiraltrunk/Kick-v0", "ground", "box-80", 5), ("tip-grip", NAME, "ground", "ball-30", 7)],
)
def test_a_strategys_commands_end_as_in_its_trial(name, env_name, stage, shape, seed):
    strategy = strategies.get(name)
    trial = run_trial(presets.PAPER, parse_object(shape), strategy=strategy, seed=seed)
    options = {"object": shape, "seed_world": seed, "strategy": name}
    env = make(env_name, stage=stage, ends=False, episode_s=120.0)
    env.reset(options=options)
    agent = StrategyAgent(env, strategy)
    agent.reset()
    while True:
        command = agent.command()
        if agent.is_done:
            break
        env.step_command(command)
    last, wanted = env.plant.trace[-1], trial.plant.trace[-1]
    assert np.array_equal(last.qpos, wanted.qpos)
    assert last.time == wanted.time
    assert env.verdict().success == trial.verdict.success
    env = make(env_name, stage=stage, ends=False, episode_s=120.0, control_mode="delta-pose-tension-pull")
    drive(env, strategy, options=options)
    assert env.verdict().success == trial.verdict.success
