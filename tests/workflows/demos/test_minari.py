"""A data set of Minari, read back by it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from spiraltrunk.workflows.demos.dataset.layout import Episodes, Layout
from spiraltrunk.workflows.demos.dataset.minari_format import DATASET_ID, FILES, write_minari
from spiraltrunk.workflows.demos.recording.pictures import decode


def test_minari_reads_the_episodes(
    stored: Episodes, layout: Layout, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import minari

    home = tmp_path / "home"
    home.mkdir()
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.delenv("MINARI_DATASETS_PATH", raising=False)
    folder = tmp_path / "sets"
    folder.mkdir()
    monkeypatch.chdir(tmp_path)
    write_minari(stored, layout, Path("sets"))  # A relative path, as `--out sets` gives it.
    assert list(home.iterdir()) == []
    assert {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()} == set(FILES)
    assert str(tmp_path) not in (folder / FILES[1]).read_text()
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(folder))
    assert list(minari.list_local_datasets()) == [DATASET_ID]
    dataset = minari.load_dataset(DATASET_ID)
    assert (dataset.total_episodes, dataset.total_steps) == (3, 17)
    told = list(dataset.storage.get_episode_metadata(range(3)))
    for number, (episode, found) in enumerate(zip(stored, dataset.iterate_episodes(), strict=True)):
        np.testing.assert_array_equal(found.observations["agent_pos"], episode.frames.agent)
        np.testing.assert_array_equal(found.observations["environment_state"], episode.frames.environment)
        np.testing.assert_array_equal(found.observations["pixels"]["front"], list(decode(episode.videos["front"])))
        np.testing.assert_array_equal(found.actions, episode.frames.action)
        assert found.terminations.tolist() == [False] * (len(episode.frames) - 1) + [True]
        assert not found.truncations.any()
        assert found.rewards.sum() == found.rewards[-1] == float(number != 1)
        assert found.infos["success"].tolist() == [False] * len(episode.frames) + [number != 1]
        assert len(found.infos["phase"]) == len(episode.frames) + 1
        first = {key: value[0] for key, value in found.observations.items() if key != "pixels"}
        pixels = {key: value[0] for key, value in found.observations["pixels"].items()}
        assert dataset.observation_space.contains({**first, "pixels": pixels})
        assert all(dataset.action_space.contains(action) for action in found.actions)
        assert told[number]["seed"] == episode.about["seed"]
        about = json.loads(told[number]["provenance"]) | {"design": told[number]["design"]}
        assert about.pop("task_text") == told[number]["task"]
        assert about == episode.about
