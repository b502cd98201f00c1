"""Recorded episodes for cloning: observations, commands, and the actions and milestones that the strategy reported."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import final

from spiraltrunk.control.messages import Command, Observation, Task
from spiraltrunk.errors import DesignError, Unquoted
from spiraltrunk.workflows.demos.recording import episode as recording
from spiraltrunk.workflows.demos.recording.episode_file import FOLDER, load_episode, name_episode


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
    reported: tuple[tuple[str, str, str], ...]
    """Phase, action and milestone of each step; an empty milestone between milestones."""
    is_success: bool
    """Whether the verdict was a success."""
    object: str
    """Name of the object."""
    seed: int
    """Seed of its scene."""


def list_episodes(folder: str | Path, strategy: str) -> list[Path]:
    """Files of a strategy's episodes in a folder of `spiraltrunk demos`, in the order of the trials.

    Raises:
        DesignError: where there is none.
    """
    files = sorted((Path(folder) / FOLDER).glob(name_episode(strategy, "*")))
    if not files:
        allowed = f"a folder of `spiraltrunk demos {strategy}` with episodes"
        raise DesignError("demos", got=Unquoted(f"{str(folder)!r}, without episodes of {strategy}"), allowed=allowed)
    return files


def read_episode(path: Path) -> Episode:
    """One episode of `spiraltrunk demos`.

    Raises:
        OutputError: where there is none, or it is damaged.
    """
    recorded = load_episode(path)
    phases = [recording.PHASE_NAMES[i] for i in recorded.phase]
    milestones = ["" if i == 0 else recording.MILESTONE_NAMES[i] for i in recorded.milestone]
    return Episode(
        task=recording.restore_task(recorded),
        observations=tuple(recording.restore_observations(recorded)),
        commands=tuple(recording.restore_commands(recorded)),
        reported=tuple(zip(phases, recorded.action.tolist(), milestones, strict=True)),
        is_success=bool(recorded.about["success"]),
        object=str(recorded.about["object"]),
        seed=int(recorded.about["seed"]),
    )
