"""Layout of a data set: names of its numbers, rate and cameras, equal in all its episodes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import final

import numpy as np

from spiraltrunk.control.encoding import (
    ControlMode,
    action_names,
    agent_bounds,
    agent_names,
    environment_bounds,
    environment_names,
    parse_control_mode,
)
from spiraltrunk.design.toml import parse_design
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.workflows.demos.recording.episode import Episode
from spiraltrunk.workflows.demos.recording.episode_file import load_episode


@final
@dataclass(frozen=True)
class Episodes:
    """Episodes in files; each iteration reads them, one at a time."""

    files: tuple[Path, ...]
    """Their files, in the order of the data set."""

    def __len__(self) -> int:
        return len(self.files)

    def __iter__(self) -> Iterator[Episode]:
        """The episodes.

        Raises:
            OutputError: where a file is gone or damaged.
        """
        return map(load_episode, self.files)


@final
@dataclass(frozen=True, kw_only=True)
class Layout:
    """Layout of a data set."""

    design: TrunkDesign
    """The trunk."""
    n_arm: int
    """Joints of the arm."""
    mode: ControlMode
    """What an action sets."""
    fps: int
    """Frames per second [1/s]."""
    cameras: tuple[str, ...]
    """Cameras, by their names."""
    size: int
    """Width and height of the pictures [pixels]."""

    @staticmethod
    def from_episode(episode: Episode) -> Layout:
        """The layout of the data set that an episode belongs to."""
        recording = episode.about["recording"]
        return Layout(
            design=parse_design(episode.about["design"].encode(), "design"), n_arm=episode.arm_position.shape[1],
            mode=parse_control_mode(recording["mode"]), fps=recording["fps"], cameras=tuple(recording["cameras"]),
            size=recording["size"],
        )  # fmt: skip

    @cached_property
    def agent_names(self) -> tuple[str, ...]:
        """Names of the numbers that the robot measures of itself."""
        return agent_names(self.design, self.n_arm)

    @cached_property
    def environment_names(self) -> tuple[str, ...]:
        """Names of the numbers that it knows of object and goal."""
        return environment_names()

    @cached_property
    def action_names(self) -> tuple[str, ...]:
        """Names of the numbers of an action."""
        return action_names(self.mode, self.design, self.n_arm)

    @property
    def agent_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Least and largest values of what the robot measures of itself."""
        return agent_bounds(self.design, self.n_arm)

    @property
    def environment_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Least and largest values of what it knows of object and goal."""
        return environment_bounds()
