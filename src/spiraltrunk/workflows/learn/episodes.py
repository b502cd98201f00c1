"""Recorded episodes: every observation, command and status of a trial, in one file of arrays each."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np

from spiraltrunk.control.messages import Command, Observation, Task
from spiraltrunk.design import presets
from spiraltrunk.errors import DesignError, Unquoted
from spiraltrunk.files.atomic import atomic_file
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.workflows.grasp.choice.auto import get_strategy
from spiraltrunk.workflows.grasp.trial import Trial
from spiraltrunk.workflows.grasp.world import draw_scene

_OBSERVED = (
    "time", "T_world_base", "arm_position", "arm_velocity", "cable_pull", "cable_tension", "base_force", "base_torque",
)  # fmt: skip
_COMMANDED = {"cmd_T": "T_world_base", "cmd_tension": "cable_tension", "cmd_grip": "gripper"}
_TOLD = ("phase", "action", "milestone")


@final
@dataclass(frozen=True, kw_only=True)
class Episode:
    """One recorded trial."""

    task: Task
    """The task as it was announced."""
    observations: tuple[Observation, ...]
    """Observations, one more than commands."""
    commands: tuple[Command, ...]
    """Commands."""
    told: tuple[tuple[str, str, str], ...]
    """Phase, action and milestone of each step; an empty milestone between milestones."""
    is_success: bool
    """Whether the verdict was a success."""
    object: str
    """Name of the object."""
    seed: int
    """Seed of its scene."""


def write_episode(path: str | Path, trial: Trial, object_name: str) -> None:
    """Write a trial's messages, without pickle.

    Raises:
        OSError: where the file cannot be written.
    """
    log = trial.log
    arrays: dict[str, Any] = {
        name: np.array([getattr(each, name) for each in log.observations], dtype=np.float32) for name in _OBSERVED
    }
    for key, name in _COMMANDED.items():
        arrays[key] = np.array([getattr(each, name) for each in log.commands], dtype=np.float32)
    arrays["phase"] = np.array([status.phase for status in log.statuses])
    arrays["action"] = np.array([status.action for status in log.statuses])
    arrays["milestone"] = np.array(["" if each.milestone is None else each.milestone.value for each in log.statuses])
    arrays |= {"success": trial.verdict.success, "seed": trial.seed, "object": np.array(object_name)}
    with atomic_file(path) as draft:
        np.savez_compressed(draft, **arrays)


def load_episode(path: str | Path, strategy: str) -> Episode:
    """An episode of a strategy of the paper's trunk; its task is drawn anew from object and seed.

    Raises:
        DesignError: where the file cannot be read or lacks an array.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        task = _draw_task(strategy, str(arrays["object"]), int(arrays["seed"]))
        return Episode(
            task=task, observations=_read_observations(arrays, task), commands=_read_commands(arrays),
            told=tuple(zip(*(arrays[name].tolist() for name in _TOLD), strict=True)),
            is_success=bool(arrays["success"]), object=str(arrays["object"]), seed=int(arrays["seed"]),
        )  # fmt: skip
    except (OSError, KeyError, ValueError) as error:
        raise DesignError("episode", got=str(path), allowed=f"a recorded episode; {Unquoted(error)}") from None


def _draw_task(strategy: str, object_name: str, seed: int) -> Task:
    shape, design = parse_object(object_name), presets.PAPER
    return build_task(design, draw_scene(shape, seed, strategy=get_strategy(strategy, design, shape)))


def _read_observations(arrays: dict[str, Any], task: Task) -> tuple[Observation, ...]:
    columns = [arrays[name].astype(float) for name in _OBSERVED]
    return tuple(
        Observation(task=task, **dict(zip(_OBSERVED, (float(row[0]), *row[1:]), strict=True)))
        for row in zip(*columns, strict=True)
    )


def _read_commands(arrays: dict[str, Any]) -> tuple[Command, ...]:
    frames, tensions, grips = (arrays[key].astype(float) for key in _COMMANDED)
    return tuple(
        Command(T_world_base=frame, cable_tension=tension, gripper=float(grip))
        for frame, tension, grip in zip(frames, tensions, grips, strict=True)
    )
