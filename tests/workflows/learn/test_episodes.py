"""Episodes of `spiraltrunk demos` are what a policy is cloned from."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from spiraltrunk.errors import DesignError, OutputError
from spiraltrunk.workflows.demos.recording.episode import MILESTONE_NAMES, PHASE_NAMES
from spiraltrunk.workflows.demos.recording.episode_file import FOLDER, name_episode, write_episode
from spiraltrunk.workflows.learn.episodes import list_episodes, read_episode

FAKES = Path(__file__).parents[1] / "demos" / "fakes" / "demos_fakes.py"


@pytest.fixture(scope="module")
def fakes() -> ModuleType:
    found = importlib.util.spec_from_file_location("demos_fakes_of_learn", FAKES)
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


def test_a_recorded_episode_is_read_whole(fakes: ModuleType, tmp_path: Path) -> None:
    recorded = fakes.build_episode(5, index=2)
    write_episode(recorded, tmp_path / FOLDER / name_episode("wrap-vertical", 2))
    write_episode(fakes.build_episode(6, strategy="kick"), tmp_path / FOLDER / name_episode("kick", 0))
    (file,) = list_episodes(tmp_path, "wrap-vertical")
    episode = read_episode(file)
    seen, commands = fakes.draw_messages(5, 23)
    assert (len(episode.observations), len(episode.commands), len(episode.reported)) == (24, 23, 23)
    assert (episode.is_success, episode.object, episode.seed) == (True, "cylinder-60", 5)
    assert np.array_equal(episode.observations[7].cable_pull, seen[7].cable_pull)
    assert np.array_equal(episode.commands[22].T_world_base, commands[22].T_world_base)
    assert episode.task.target.width == seen[0].task.target.width
    for reported, phase, milestone, action in zip(
        episode.reported, recorded.phase, recorded.milestone, recorded.action, strict=True
    ):
        name = MILESTONE_NAMES[milestone]
        assert reported == (PHASE_NAMES[phase], action, "" if name == "none" else name)


def test_a_strategy_whose_name_begins_with_anothers_is_not_taken_in(tmp_path: Path) -> None:
    names = [("wrap-oblique", 0), ("wrap-oblique-low", 0), ("wrap-oblique", 99_999), ("wrap-oblique-low", 1)]
    files = [tmp_path / FOLDER / name_episode(*each) for each in names]
    (tmp_path / FOLDER).mkdir()
    for file in files:
        file.touch()
    assert list_episodes(tmp_path, "wrap-oblique") == [files[0], files[2]]
    assert list_episodes(tmp_path, "wrap-oblique-low") == [files[1], files[3]]


def test_failed_episodes_are_marked(fakes: ModuleType, tmp_path: Path) -> None:
    write_episode(fakes.build_episode(5, success=False), tmp_path / "one.npz")
    assert not read_episode(tmp_path / "one.npz").is_success


def test_folders_and_files_that_hold_none(tmp_path: Path) -> None:
    with pytest.raises(DesignError, match=r"without episodes of wrap-vertical; allowed: a folder of `spiraltrunk"):
        list_episodes(tmp_path, "wrap-vertical")
    np.savez(tmp_path / "pickled.npz", time=np.array([{}], dtype=object))
    for name in ("pickled.npz", "none.npz"):
        with pytest.raises(OutputError, match=name):
            read_episode(tmp_path / name)
