"""Columns of an episode that all formats have: rewards, ends, numbers of phases, and its provenance as text."""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np

from spiraltrunk.workflows.demos.dataset.task_text import describe_episode
from spiraltrunk.workflows.demos.recording.episode import Episode
from spiraltrunk.workflows.demos.recording.pictures import decode


def compute_reward(episode: Episode) -> np.ndarray:
    """Sparse reward of each frame, shape (m,), float32: 1 for the last of a success, else 0 [-]."""
    return (mark_last(episode) & episode.about["success"]).astype(np.float32)


def mark_last(episode: Episode) -> np.ndarray:
    """Whether each frame is the last, shape (m,)."""
    return np.arange(len(episode.frames)) == len(episode.frames) - 1


def number_phases(episode: Episode) -> tuple[np.ndarray, np.ndarray]:
    """Phase and milestone of each frame, two of shape (m,): those of the first command after it."""
    first = episode.steps[:-1]
    return episode.phase[first].astype(np.int64), episode.milestone[first].astype(np.int64)


def read_pictures(episode: Episode, camera: str) -> Iterator[np.ndarray]:
    """Pictures at the frames and one at the end, each of shape (size, size, 3), 0 to 255."""
    return decode(episode.videos[camera])


def describe_provenance(episode: Episode) -> dict[str, str]:
    """Where an episode comes from: the robot's design as TOML, and all else as JSON."""
    about = dict(episode.about)
    return {"design": about.pop("design"), "provenance": json.dumps(about | {"task_text": describe_episode(episode)})}
