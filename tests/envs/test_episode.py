"""Rewards, ends and control modes."""

from dataclasses import replace

import gymnasium
import numpy as np
import pytest

import spiraltrunk.envs  # noqa: F401
from spiraltrunk.control.encoding import ControlMode, action_size, decode_joints
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.design import presets
from spiraltrunk.envs.evaluator import QUIET
from spiraltrunk.envs.rewards import PROGRESS
from spiraltrunk.workflows.demos.recording.frames import encode_frames
from spiraltrunk.workflows.grasp.verdict.arm_conditions import arm_conditions
from spiraltrunk.workflows.grasp.verdict.evidence import Evidence
from spiraltrunk.workflows.grasp.verdict.moments import Moments

NAMES = {"grasp": "spiraltrunk/Grasp-v0", "kick": "spiraltrunk/Kick-v0", "sweep": "spiraltrunk/Sweep-v0"}


def make(name="spiraltrunk/Grasp-v0", **given):
    return gymnasium.make(name, disable_env_checker=True, **given).unwrapped


@pytest.mark.parametrize("job", NAMES)
def test_each_term_is_told_and_the_dense_reward_is_their_change(job):
    env = make(NAMES[job], ends=False)
    env.reset(seed=1)
    potential, before = PROGRESS[job](env.plant), None
    generator = np.random.default_rng(0)
    for _ in range(4):
        _, reward, terminated, truncated, info = env.step(generator.uniform(-1, 1, env.action_space.shape))
        terms = info["reward_terms"]
        assert set(potential.weights) | {"success", "fault"} == set(terms)
        assert all(0.0 <= value <= 1.0 for value in terms.values())
        now = potential.potential(terms)
        if before is not None:
            assert reward == pytest.approx(now - before)
        before = now
        assert (terminated, truncated) == (False, False)
        assert info["is_success"] is info["success"] is False


def test_the_sparse_reward_is_nothing_without_success():
    env = make(reward_mode="sparse")
    env.reset(seed=1)
    assert [env.step(env.action_space.sample())[1] for _ in range(3)] == [0.0, 0.0, 0.0]


def test_a_truncated_episode_tells_the_verdicts_reason_and_the_world():
    env = make(episode_s=0.04)
    _, first = env.reset(seed=1)
    env.step(np.zeros(10))
    _, _, terminated, truncated, info = env.step(np.zeros(10))
    assert (terminated, truncated) == (False, True)
    assert info["reason"] == "the strategy reported no lift"
    assert info["world"] == first["world"]


def test_an_object_that_fell_ends_the_episode_with_a_penalty():
    env = make(stage="ground")
    env.reset(seed=1)
    joint = env.plant.model.joint("object")
    env.plant.data.qpos[joint.qposadr[0] : joint.qposadr[0] + 3] = [2.0, 0.0, 0.2]  # Beside the platform.
    _, reward, terminated, truncated, info = env.step(np.zeros(10))
    assert (terminated, truncated) == (True, False)
    assert info["reason"] == "the object fell"
    assert info["reward_terms"]["fault"] == 1.0
    assert reward < -0.3


def test_a_simulation_that_diverges_ends_the_episode():
    env = make()
    env.reset(seed=1)
    env.plant.data.qvel[:] = 1e12
    seen, _, terminated, _, info = env.step(np.zeros(10))
    assert terminated
    assert info["reason"] == "the simulation diverged"
    assert np.isfinite(seen["agent_pos"]).all()
    env.reset()
    assert not env.step(np.zeros(10))[2]


@pytest.mark.parametrize("mode", ControlMode)
def test_wild_actions_keep_the_arm_within_its_limits(mode):
    env = make(control_mode=mode.value, ends=False)
    env.reset(seed=1)
    assert env.action_space.shape == (action_size(mode, presets.PAPER),)
    generator = np.random.default_rng(0)
    for i in range(60):
        if i % 10 == 0:
            wild = generator.uniform(-1, 1, env.action_space.shape)
            near = env.encode_command(env.setpoint.command).action + 0.2 * wild
            action = near if mode.value.startswith("pose") else wild
        env.step(np.clip(action, -1, 1))
    plant = env.plant
    evidence = Evidence(
        trace=plant.trace, task=plant.task, moments=Moments(), gave_up=None, warnings=0, limits=plant.arm_limits
    )
    broken = [text for holds, text in arm_conditions(evidence) if not holds]
    assert not [text for text in broken if "torque" not in text]  # Of a collision.
    assert np.ptp([sample.arm_position for sample in plant.trace], axis=0).max() > 0.05


def test_joint_targets_are_reached():
    env = make(control_mode="joint-tension", randomization="none", episode_s=10.0)
    env.reset(seed=0)
    arm = env._rules.arm
    target = env.observation.arm_position + 0.1
    action = np.zeros(env.action_space.shape)
    action[:7] = 2 * (target - arm.low) / (arm.high - arm.low) - 1
    action[7:10] = -1.0
    for _ in range(80):
        env.step(action)
    assert np.abs(env.observation.arm_position - target).max() < 0.01


def test_a_delta_moves_the_base_at_its_speed():
    env = make(randomization="none", control_hz=10.0)
    env.reset(seed=0)
    start = env.observation.T_world_base[:3, 3].copy()
    action = np.zeros(10)
    action[1], action[6:9] = 0.2, -1.0
    for _ in range(10):
        env.step(action)
    moved = env.setpoint.command.T_world_base[:3, 3] - start
    assert moved[1] == pytest.approx(0.2 * 0.6 * 1.0, rel=0.06)  # Less the way of the acceleration.
    assert abs(moved[[0, 2]]).max() < 1e-9


@pytest.mark.parametrize("control_hz", [50.0, 25.0, 10.0, 5.0])
def test_the_end_of_a_job_is_seen_once_at_every_control_rate(control_hz, monkeypatch):
    env = make(stage="ground", randomization="none", control_hz=control_hz, ends=False)
    env.reset(seed=0)
    evaluator = env._episode._evaluator
    evaluator.referee.reached[Milestone.RELEASED] = 0.0  # The object rests untouched from here on.
    verdict = replace(evaluator.verdict(), success=True)
    monkeypatch.setattr(type(evaluator), "verdict", lambda self: verdict)
    wins = [env.step(np.zeros(10))[4]["is_success"] for _ in range(round(2.0 * control_hz))]
    assert evaluator.quiet > QUIET
    assert wins.count(True) == 1


def test_a_success_is_rewarded_once(monkeypatch):
    env = make(
        stage="ground", randomization="none", control_hz=10.0, ends=False, reward_mode="sparse", episode_s=1.5
    )  # fmt: skip
    env.reset(seed=0)
    evaluator = env._episode._evaluator
    evaluator.referee.reached[Milestone.RELEASED] = 0.0  # The object rests untouched from here on.
    verdict = replace(evaluator.verdict(), success=True)
    monkeypatch.setattr(type(evaluator), "verdict", lambda self: verdict)
    state, told = None, []
    while len(told) < 15:
        _, reward, _, _, info = env.step(np.zeros(10))
        told.append((reward, info["reward_terms"]["success"], info["is_success"]))
        if reward and state is None:
            state, place = env.get_state(), len(told)
    rewards, terms, successes = zip(*told, strict=True)
    assert sum(rewards) == sum(terms) == 1.0
    assert sum(successes) == 2  # At rest, and when time is over.
    env.set_state(state)
    again = [env.step(np.zeros(10)) for _ in range(15 - place)]
    assert [each[1] for each in again] == list(rewards[place:])
    assert again[-1][4]["is_success"]
    env.reset(seed=0)
    assert not env.get_state().episode.is_rewarded


def test_recorded_joint_actions_lead_to_the_same_positions_in_the_environment():
    env = make(control_mode="joint-tension")
    env.reset(seed=0)
    seen, reach = env.observation, env.plant.reach
    positions = list(np.random.default_rng(0).uniform(reach.home - 0.3, reach.home + 0.3, (5, reach.home.size)))
    frames = encode_frames([seen] * 6, [env.setpoint.command] * 5, positions, mode=ControlMode.JOINT_TENSION)
    for action, position in zip(frames.action, positions, strict=True):
        np.testing.assert_allclose(decode_joints(action, env._rules.arm), position, atol=1e-6)
