"""Fake recorded trials."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from spiraltrunk.workflows.demos.dataset.layout import Episodes, Layout
from spiraltrunk.workflows.demos.options import RecordingOptions
from spiraltrunk.workflows.demos.recording.episode_file import write_episode

FAKES = Path(__file__).parent / "fakes"

CAMERAS = RecordingOptions(cameras=("front", "top"), size=32, fps=10)
"""Recording with pictures, whose frames are five commands apart."""


@pytest.fixture(scope="session")
def fakes() -> Iterator[ModuleType]:
    """A module that processes find as well, as they start with this one's path."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(FAKES)
        yield importlib.import_module("demos_fakes")


@pytest.fixture(scope="session")
def stored(fakes: ModuleType, tmp_path_factory: pytest.TempPathFactory) -> Episodes:
    """Three episodes in files, with two cameras; the second failed, the third is of another object."""
    folder = tmp_path_factory.mktemp("episodes")
    drawn = [
        fakes.build_episode(5, recording=CAMERAS),
        fakes.build_episode(6, recording=CAMERAS, success=False, count=31, index=1),
        fakes.build_episode(7, recording=CAMERAS, name="ball-80", index=2),
    ]
    for number, episode in enumerate(drawn):
        write_episode(episode, folder / f"{number}.npz")
    return Episodes(tuple(folder / f"{number}.npz" for number in range(len(drawn))))


@pytest.fixture(scope="session")
def layout(stored: Episodes) -> Layout:
    return Layout.from_episode(next(iter(stored)))
