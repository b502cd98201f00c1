"""Data set of Minari, written by its own interface, below a folder that takes the place of the user's own."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from spiraltrunk.workflows.demos.dataset.columns import (
    compute_reward,
    describe_provenance,
    mark_last,
    number_phases,
    read_pictures,
)
from spiraltrunk.workflows.demos.dataset.layout import Episodes, Layout
from spiraltrunk.workflows.demos.dataset.task_text import describe_episode
from spiraltrunk.workflows.demos.recording.episode import Episode

if TYPE_CHECKING:
    from gymnasium import spaces
    from minari.data_collector import EpisodeBuffer

DATASET_ID = "spiraltrunk-demos-v0"
"""Name of the data set."""

FILES = (f"{DATASET_ID}/data/main_data.hdf5", f"{DATASET_ID}/data/metadata.json")
"""Its files, below a folder of Minari data sets."""

_ROOT = "MINARI_DATASETS_PATH"
"""Variable by which Minari finds its folder."""


def write_minari(episodes: Episodes, layout: Layout, folder: Path) -> None:
    """Write a data set into a folder of Minari data sets, one episode in memory at a time.

    Raises:
        OSError: where a file cannot be written.
        OutputError: where an episode is gone or damaged.
    """
    import minari
    from gymnasium import spaces

    with _in_folder(folder), warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # It asks for an author, an address and an environment.
        remaining = iter(episodes)
        first = next(remaining)
        dataset = minari.create_dataset_from_buffers(
            DATASET_ID,
            [_build_buffer(first, layout)],
            observation_space=_build_observation_space(layout),
            action_space=spaces.Box(-1.0, 1.0, (len(layout.action_names),), np.float32),
            algorithm_name="strategies of spiraltrunk",
            description=f"Trials of a spiral trunk; actions: {layout.mode.value}; {layout.fps} frames per second",
            data_format="hdf5",
            jpeg_encoding=False,
        )
        storage = dataset.storage
        storage.update_episode_metadata([_describe(first)], [0])
        for number, episode in enumerate(remaining, start=1):
            storage.update_episodes([_build_buffer(episode, layout)])
            storage.update_episode_metadata([_describe(episode)], [number])


def _build_buffer(episode: Episode, layout: Layout) -> EpisodeBuffer:
    from minari.data_collector import EpisodeBuffer

    seen = {"agent_pos": episode.frames.agent, "environment_state": episode.frames.environment}
    pictures = {camera: np.stack(list(read_pictures(episode, camera))) for camera in layout.cameras}
    phase, milestone = (np.append(numbers, numbers[-1]) for numbers in number_phases(episode))
    success = np.append(False, compute_reward(episode) > 0)
    return EpisodeBuffer(
        seed=episode.about["seed"],
        observations=seen | ({"pixels": pictures} if pictures else {}),
        actions=episode.frames.action,
        rewards=compute_reward(episode),
        terminations=mark_last(episode),
        truncations=np.zeros(len(episode.frames), bool),
        infos={"phase": phase, "milestone": milestone, "success": success},
    )


def _describe(episode: Episode) -> dict[str, Any]:
    return {"task": describe_episode(episode), "success": episode.about["success"], **describe_provenance(episode)}


def _build_observation_space(layout: Layout) -> spaces.Dict:
    from gymnasium import spaces

    seen: dict[str, spaces.Space[Any]] = {
        "agent_pos": spaces.Box(*layout.agent_bounds, dtype=np.float32),
        "environment_state": spaces.Box(*layout.environment_bounds, dtype=np.float32),
    }
    picture = spaces.Box(0, 255, (layout.size, layout.size, 3), np.uint8)
    if layout.cameras:
        seen["pixels"] = spaces.Dict(dict.fromkeys(layout.cameras, picture))
    return spaces.Dict(seen)


@contextmanager
def _in_folder(folder: Path) -> Iterator[None]:
    """Let Minari find and write its data sets in a folder."""
    before = os.environ.get(_ROOT)
    os.environ[_ROOT] = str(folder.resolve())  # Minari joins a relative path to itself.
    try:
        yield
    finally:
        if before is None:
            del os.environ[_ROOT]
        else:
            os.environ[_ROOT] = before
