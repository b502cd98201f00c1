"""robomimic's layout, read back with h5py."""

from __future__ import annotations

import importlib
import json
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import gymnasium
import h5py
import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.design.toml import write_design
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.workflows.demos.dataset.layout import Episodes, Layout
from spiraltrunk.workflows.demos.dataset.robomimic import write_robomimic
from spiraltrunk.workflows.demos.recording.episode_file import load_episode, write_episode
from spiraltrunk.workflows.demos.recording.pictures import decode


def test_demonstrations_are_the_episodes(stored: Episodes, layout: Layout, tmp_path: Path) -> None:
    write_robomimic(stored, layout, tmp_path)
    with h5py.File(tmp_path / "demos.hdf5") as file:
        data = file["data"]
        assert list(data) == ["demo_0", "demo_1", "demo_2"]
        assert data.attrs["total"] == 17
        assert json.loads(data.attrs["env_args"]) == {
            "env_name": "spiraltrunk/Grasp-v0",
            "type": 2,
            "env_kwargs": {
                "stage": "ground",
                "strategy": "wrap-vertical",
                "object": ["cylinder-60", "ball-80"],
                "timestep": 0.002,
                "design": "paper",
                "control_mode": "delta-pose-tension-pull",
                "control_hz": 10,
            },
        }
        assert json.loads(data.attrs["action_names"]) == list(layout.action_names)
        for number, episode in enumerate(stored):
            demo, frames = data[f"demo_{number}"], episode.frames
            steps = episode.steps
            assert demo.attrs["num_samples"] == len(frames)
            assert demo.attrs["model_file"] == "<mujoco/>"
            assert (demo.attrs["seed"], demo.attrs["success"]) == (episode.about["seed"], number != 1)
            about = json.loads(demo.attrs["provenance"]) | {"design": demo.attrs["design"]}
            assert about.pop("task_text") == demo.attrs["task"]
            assert about == episode.about
            np.testing.assert_array_equal(demo["actions"], frames.action)
            np.testing.assert_array_equal(demo["states"], episode.state[steps[:-1]])
            np.testing.assert_array_equal(demo["obs/agent_pos"], frames.agent[:-1])
            np.testing.assert_array_equal(demo["next_obs/agent_pos"], frames.agent[1:])
            np.testing.assert_array_equal(demo["obs/environment_state"], frames.environment[:-1])
            np.testing.assert_array_equal(demo["next_obs/environment_state"], frames.environment[1:])
            pictures = list(decode(episode.videos["top"]))
            np.testing.assert_array_equal(demo["obs/top_image"], pictures[:-1])
            np.testing.assert_array_equal(demo["next_obs/top_image"], pictures[1:])
            assert demo["dones"][()].tolist() == [0] * (len(frames) - 1) + [1]
            assert demo["rewards"][()].sum() == demo["rewards"][-1] == float(number != 1)
            np.testing.assert_allclose(demo["timestamp"], np.arange(len(frames)) / 10)


@pytest.mark.parametrize(
    ("count", "held"), [(1, []), (2, [1]), (9, [8]), (10, [9]), (31, [9, 19, 29]), (300, list(range(9, 300, 10)))]
)
def test_every_tenth_demonstration_is_held_out(tmp_path: Path, count: int, held: list[int]) -> None:
    from spiraltrunk.workflows.demos.dataset.robomimic import _add_masks

    with h5py.File(tmp_path / "masks.hdf5", "w") as file:
        _add_masks(file.create_group("mask"), count)
        train, valid = ([name.decode() for name in file["mask"][key][()]] for key in ("train", "valid"))
    assert valid == [f"demo_{number}" for number in held]
    assert sorted([*train, *valid]) == sorted(f"demo_{number}" for number in range(count))


@pytest.mark.parametrize("design", [presets.PAPER, replace(presets.PAPER, name="mine")])
def test_the_environment_is_that_of_the_demonstrations(
    design: TrunkDesign, fakes: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn = [
        ("kick", "ball-80"),
        ("wrap-horizontal", "cylinder-60"),
        ("wrap-horizontal", "box-80"),
        ("pinch", "ring-90"),
    ]
    files = tuple(tmp_path / f"{number}.npz" for number in range(len(drawn)))
    for file, (strategy, name) in zip(files, drawn, strict=True):
        write_episode(fakes.build_episode(5, strategy=strategy, name=name), file)
    layout = replace(Layout.from_episode(load_episode(files[0])), design=design)
    write_robomimic(Episodes(files), layout, tmp_path)
    write_design(design, tmp_path / "trunk.toml")
    with h5py.File(tmp_path / "demos.hdf5") as file:
        told = json.loads(file["data"].attrs["env_args"])
        size = file["data"]["demo_0"]["actions"].shape[1]
    importlib.import_module("spiraltrunk.envs")
    monkeypatch.chdir(tmp_path)  # The design's file is named as it is in the folder.
    env = gymnasium.make(told["env_name"], **told["env_kwargs"]).unwrapped
    assert env.action_space.shape == (size,)
    assert env.metadata["render_fps"] == layout.fps
    assert env.design == design
    assert (env.job, env._stage, env._strategy) == ("grasp", "ground", "wrap-horizontal")
    assert env._objects == ("cylinder-60", "box-80")
    assert env._timestep == 0.002
