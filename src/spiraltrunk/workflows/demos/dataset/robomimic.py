"""Data set in robomimic's layout: one HDF5 file with a group for each demonstration."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from spiraltrunk.design import presets
from spiraltrunk.workflows.demos.dataset.columns import (
    compute_reward,
    describe_provenance,
    mark_last,
    number_phases,
    read_pictures,
)
from spiraltrunk.workflows.demos.dataset.layout import Episodes, Layout
from spiraltrunk.workflows.demos.dataset.task_text import describe_episode
from spiraltrunk.workflows.demos.recording.episode import MILESTONE_NAMES, PHASE_NAMES, Episode

FILE = "demos.hdf5"
"""Name of the file."""

GYM = 2
"""Number of Gymnasium's environments in robomimic's ``EnvType``."""

DESIGN_FILE = "trunk.toml"
"""File of the robot's design, beside `FILE` in a folder of demonstrations."""

HELD_OUT = 0.1
"""Share of the demonstrations in ``mask/valid`` [-]; the others are in ``mask/train``."""

_ENVIRONMENTS = {"grasp": "spiraltrunk/Grasp-v0", "kick": "spiraltrunk/Kick-v0", "sweep": "spiraltrunk/Sweep-v0"}


def write_robomimic(episodes: Episodes, layout: Layout, folder: Path) -> None:
    """Write ``demos.hdf5`` into a folder, one episode in memory at a time.

    Raises:
        OSError: where the file cannot be written.
        OutputError: where an episode is gone or damaged.
    """
    import h5py

    total, worlds = 0, dict[str, dict[str, Any]]()
    with h5py.File(folder / FILE, "w") as file:
        data = file.create_group("data")
        for number, episode in enumerate(episodes):
            _add_demonstration(data.create_group(f"demo_{number}"), episode, layout)
            total += len(episode.frames)
            _collect_world(worlds, episode)
        data.attrs["total"] = total
        data.attrs["env_args"] = json.dumps(_describe_environment(worlds, layout))
        for key, names in _describe_names(layout).items():
            data.attrs[key] = json.dumps(names)
        _add_masks(file.create_group("mask"), len(episodes))


def _add_demonstration(group: Any, episode: Episode, layout: Layout) -> None:
    steps, (phase, milestone) = episode.steps, number_phases(episode)
    columns = {
        "actions": episode.frames.action, "states": episode.state[steps[:-1]], "rewards": compute_reward(episode),
        "dones": mark_last(episode).astype(np.int64), "phase": phase, "milestone": milestone,
        "timestamp": np.arange(len(episode.frames)) / layout.fps,
    }  # fmt: skip
    seen = {"agent_pos": episode.frames.agent, "environment_state": episode.frames.environment}
    seen |= {f"{camera}_image": np.stack(list(read_pictures(episode, camera))) for camera in layout.cameras}
    for key, values in seen.items():
        columns |= {f"obs/{key}": values[:-1], f"next_obs/{key}": values[1:]}
    for key, values in columns.items():
        group.create_dataset(key, data=values, compression="gzip", compression_opts=4, shuffle=True)
    about = {"seed": episode.about["seed"], "success": episode.about["success"], "task": describe_episode(episode)}
    told = {"num_samples": len(episode.frames), "model_file": episode.scene, **about, **describe_provenance(episode)}
    for key, value in told.items():
        group.attrs[key] = value


def _add_masks(group: Any, count: int) -> None:
    """Names of the demonstrations to train with and to validate with: every tenth is held out."""
    import h5py

    names = [f"demo_{number}" for number in range(count)]
    spacing = round(1 / HELD_OUT)
    held = set(names[spacing - 1 :: spacing] or names[1:][-1:])  # One of a few; none where there is only one.
    for key, chosen in (("train", [n for n in names if n not in held]), ("valid", [n for n in names if n in held])):
        group.create_dataset(key, data=np.array(chosen, dtype=object), dtype=h5py.string_dtype())


def _collect_world(worlds: dict[str, dict[str, Any]], episode: Episode) -> None:
    """Add an episode to the worlds of each job: arguments of `TrunkEnv`, those of the job's first strategy."""
    about = episode.about
    first = {"stage": about["world"]["support"], "strategy": about["strategy"], "object": list[str]()}
    world = worlds.setdefault(about["job"], {**first, "timestep": about["verdict"]["timestep_s"]})
    if world["strategy"] == about["strategy"] and about["object"] not in world["object"]:
        world["object"].append(about["object"])


def _describe_environment(worlds: Mapping[str, dict[str, Any]], layout: Layout) -> dict[str, Any]:
    """robomimic's ``env_args``: the environment of the demonstrations, of the first job where they have several.

    Its ``env_kwargs`` are arguments of `TrunkEnv`. Randomisation and camera are its defaults, the survey's.

    Args:
        worlds: arguments of `TrunkEnv` that say the worlds of each job.
        layout: the robot, and control mode and rate of the actions.
    """
    job = next(job for job in _ENVIRONMENTS if job in worlds)
    actions = {"control_mode": layout.mode.value, "control_hz": layout.fps}
    arguments = {**worlds[job], "design": presets.find_name(layout.design) or DESIGN_FILE, **actions}
    return {"env_name": _ENVIRONMENTS[job], "type": GYM, "env_kwargs": arguments}


def _describe_names(layout: Layout) -> dict[str, tuple[str, ...]]:
    return {
        "agent_names": layout.agent_names, "environment_names": layout.environment_names,
        "action_names": layout.action_names, "phase_names": PHASE_NAMES, "milestone_names": MILESTONE_NAMES,
    }  # fmt: skip
