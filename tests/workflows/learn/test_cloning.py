"""Cloning of made-up episodes: stages and their times, samples, and a training that learns, where PyTorch is there."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from spiraltrunk import strategies
from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.design import presets
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, MissingPackage
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.strategies.policy.network import Network, forward
from spiraltrunk.strategies.policy.policy_strategy import END, PolicyStrategy
from spiraltrunk.workflows.grasp.world import draw_scene
from spiraltrunk.workflows.learn import clone_policy as clone_module
from spiraltrunk.workflows.learn.clone_policy import clone_policy
from spiraltrunk.workflows.learn.cloning import CloningOptions, import_torch, split_episodes
from spiraltrunk.workflows.learn.episodes import Episode
from spiraltrunk.workflows.learn.samples import Timing, list_stages, sample_episode

UP, KEEP = ("transport", "lift", "lifted"), ("transport", "hold", "held")


def make_episode(
    seed: int, up: int = 40, keep: int = 30, *, design: TrunkDesign = presets.PAPER, n_arm: int = 7
) -> Episode:
    """The base rises by 0.1 m at constant speed, then rests."""
    task = build_task(design, draw_scene(parse_object("cylinder-60"), seed))
    frame = np.eye(4)
    frame[:3, :3] = [[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]]
    frame[:3, 3] = 0.3 + 0.01 * seed, 0.1, 1.0
    observations, commands = [], []
    for i in range(up + keep + 1):
        T = frame.copy()
        T[2, 3] += 0.1 * min(1.0, i / up)
        commands.append(Command(T_world_base=T, cable_tension=np.full(3, 10.0 * min(1.0, i / up))))
        observations.append(Observation(
            time=0.02 * i, task=task, T_world_base=T, arm_position=np.zeros(n_arm), arm_velocity=np.zeros(n_arm),
            cable_pull=np.full(3, 1e-4 * i), cable_tension=np.zeros(3), base_force=np.array([0.0, 0.0, -2.0]),
            base_torque=np.zeros(3),
        ))  # fmt: skip
    reported = (UP,) * up + (KEEP,) * keep
    return Episode(
        task=task, observations=tuple(observations), commands=tuple(commands[:-1]), reported=reported, is_success=True,
        object="cylinder-60", seed=seed,
    )  # fmt: skip


def test_stages_with_their_times_and_order() -> None:
    up, keep, end = list_stages([make_episode(0), make_episode(1, up=50)])
    assert (up.name, up.milestone, up.least, up.after) == ("transport: lift (lifted)", "lifted", 0.8, (keep.name,))
    assert up.most == pytest.approx(1.2 * 1.0 + 0.3)
    assert (up.visits, keep.visits) == (1, 1)
    assert (keep.after, end.name, end.milestone) == ((END,), END, "held")


def test_samples_ask_for_later_set_points_of_the_same_stage() -> None:
    episode = make_episode(0)
    stages = list_stages([episode])
    samples = sample_episode(episode, stages, (), Timing(period=0.1, smoothing=0.1))
    assert samples.stage.tolist() == [0] * 20 + [1] * 15 + [2]
    rise = samples.goal[:, 2] - samples.goal[0, 2]
    assert np.all(np.diff(rise) >= 0.0)
    lag = Timing(period=0.1).ahead
    assert lag == 12
    shared = (samples.goal[1, 2] - samples.goal[0, 2]) / 2
    assert samples.goal[0, 2] - sample_episode(episode, stages, (), Timing(period=0.02, smoothing=0.01)).goal[0, 2] == (
        pytest.approx((lag - Timing(period=0.02, smoothing=0.01).ahead) * shared, rel=1e-3)
    )
    n_known = samples.now.shape[1] - (3 + 5 + 10 + 3 + 2 + 5)
    assert samples.now[20, n_known : n_known + 3].tolist() == [0.0, 1.0, 0.0]
    assert samples.before[20, n_known : n_known + 3].tolist() == [1.0, 0.0, 0.0]  # The stage of the last decision.
    assert samples.before[20, n_known + 3 + 1] == pytest.approx(0.8)


def test_split_is_by_episode_and_seed() -> None:
    train, valid = split_episodes(20, 0.15, 3)
    assert sorted([*train, *valid]) == list(range(20))
    assert len(valid) == 3
    assert split_episodes(20, 0.15, 3) == (train, valid)
    assert split_episodes(20, 0.15, 4) != (train, valid)
    assert split_episodes(1, 0.15, 0) == ([0], [0])


def test_nothing_to_clone() -> None:
    with pytest.raises(DesignError, match="one success or more"):
        clone_policy([replace(make_episode(0), is_success=False)], strategies.get("wrap-vertical"))


def build_network(n_input: int, n_output: int) -> Network:
    return Network(
        weights=(np.zeros((n_output, n_input)),), biases=(np.zeros(n_output),), activation="relu", output="linear",
        input_mean=np.zeros(n_input), input_scale=np.ones(n_input), output_mean=np.zeros(n_output),
        output_scale=np.ones(n_output),
    )  # fmt: skip


def test_a_policy_is_of_the_trunk_that_it_was_shown(monkeypatch):
    def fit(samples, names, options, on_check):
        assert {each.now.shape[1] for each in samples} == {len(names)}
        sizes = {"action": 10, "stage": 3}
        return SimpleNamespace(**{k: SimpleNamespace(network=build_network(len(names), n)) for k, n in sizes.items()})

    monkeypatch.setattr(clone_module, "fit_clone", fit)
    monkeypatch.setattr(clone_module, "read_versions", lambda *packages: {})  # PyTorch may be missing.
    design, strategy = replace(presets.get("spirob-1m"), name="mine"), strategies.get("wrap-vertical")
    shown = [make_episode(seed, design=design, n_arm=6) for seed in range(2)]
    description = clone_policy(shown, strategy).description
    assert description.provenance["design"] == "mine"
    assert description.widths == strategy.widths(design) != strategy.widths(presets.PAPER)
    assert "arm_position_6" in description.inputs
    assert "arm_position_7" not in description.inputs


@pytest.mark.parametrize(
    ("other", "told"),
    [
        ({"design": presets.get("paper-large-grip")}, "trunks 'paper' and 'paper-large-grip', which differ; allowed"),
        ({"n_arm": 6}, "arms of 7 and of 6 joints; allowed: demonstrations of one trunk"),
    ],
)
def test_a_mix_of_robots_is_refused(other, told):
    with pytest.raises(DesignError, match=told):
        clone_policy([make_episode(0), make_episode(1, **other)], strategies.get("wrap-vertical"))


def test_training_reduces_the_loss() -> None:
    try:
        import_torch()
    except MissingPackage as missing:
        pytest.skip(str(missing))
    episodes = [make_episode(seed) for seed in range(6)]
    options = CloningOptions(hidden=(32,), steps=400, batch=64, check=50, seed=1)
    cloned = clone_policy(episodes, strategies.get("wrap-vertical"), options=options)
    for fit in (cloned.clone.action, cloned.clone.stage):
        assert fit.valid[-1] < 0.5 * fit.valid[0]
    again = clone_policy(episodes, strategies.get("wrap-vertical"), options=options)
    inputs = np.ones(len(cloned.description.inputs))
    assert np.array_equal(forward(cloned.networks["action"], inputs), forward(again.networks["action"], inputs))
    swinging = inputs.copy()
    swinging[cloned.description.inputs.index("arm_velocity_1")] = 3.0
    swinging[cloned.description.inputs.index("base_force_z")] = -50.0
    for network in cloned.networks.values():  # Neither depends on the motion of the arm or the forces of the moment.
        assert np.array_equal(forward(network, inputs), forward(network, swinging))
    told = follow(PolicyStrategy("policy:small", cloned.description, cloned.networks), episodes[0])
    up, keep = (told.count(name) for name in dict.fromkeys(told))
    assert up == pytest.approx(40, abs=6)
    assert 30 <= keep <= 1.2 * 30 + 15 + 6  # At the latest when the stage's time is over.


def follow(policy: PolicyStrategy, episode: Episode) -> list[str]:
    """Stages of a policy that sees what the episode's robot saw."""
    state, told = policy.init(episode.observations[0]), []
    last = episode.observations[-1]
    for i in range(200):
        seen = episode.observations[i] if i < len(episode.observations) else replace(last, time=0.02 * i)
        state, _ = policy.step(state, seen)
        if policy.status(state).is_done:
            break
        told.append(policy.status(state).action)
    return told


@pytest.mark.parametrize(
    "options",
    [
        {"check": 0}, {"steps": 0}, {"batch": 0}, {"patience": 0}, {"hidden": (0,)}, {"hidden": 8}, {"rate": 0.0},
        {"noise": -0.1}, {"validation": 1.0}, {"seed": -1},
    ],
)  # fmt: skip
def test_options_that_train_nothing_are_refused(options):
    with pytest.raises(DesignError, match=rf"cloning\.{next(iter(options))} is "):
        CloningOptions(**options)
