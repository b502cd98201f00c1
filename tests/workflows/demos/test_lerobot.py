"""LeRobotDataset v3.0: its files hold what the stored description asks for, and the episodes' numbers."""

from __future__ import annotations

import json
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import av
import numpy as np
import pyarrow.parquet as pq
import pytest

from spiraltrunk.workflows.demos.dataset.layout import Episodes, Layout
from spiraltrunk.workflows.demos.dataset.lerobot import table_files, video_files
from spiraltrunk.workflows.demos.dataset.lerobot.statistics import Total, compute_statistics
from spiraltrunk.workflows.demos.dataset.lerobot.write import write_lerobot

EXPECTED = json.loads((Path(__file__).parent / "lerobot_v3.json").read_text())


@pytest.fixture(scope="module")
def written(stored: Episodes, layout: Layout, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("lerobot")
    write_lerobot(stored, layout, folder)
    return folder


def read(folder: Path, pattern: str) -> Any:
    return pq.read_table(sorted(folder.glob(pattern))).to_pydict()


def types(path: Path) -> dict[str, str]:
    schema = pq.read_schema(path)
    return {name: str(schema.field(name).type).replace("item:", "element:") for name in schema.names}


def test_every_column_has_the_described_type(written: Path, layout: Layout) -> None:
    sizes = {"state": layout.agent_names, "environment": layout.environment_names, "action": layout.action_names}
    counts = {key: len(names) for key, names in sizes.items()}
    data = {key: told.format(**counts) for key, told in EXPECTED["data"].items()}
    assert types(written / "data/chunk-000/file-000.parquet") == data
    videos = ["observation.images.front", "observation.images.top"]
    episodes = {**EXPECTED["episodes"]}
    for key in videos:
        episodes |= {f"videos/{key}/{name}": told for name, told in EXPECTED["episodes_of_video"].items()}
    for key in (*data, *videos):
        for name, told in EXPECTED["statistics"].items():
            is_colour = key in videos and name != "count"
            episodes[f"stats/{key}/{name}"] = EXPECTED["statistics_of_video"] if is_colour else told
    assert types(written / "meta/episodes/chunk-000/file-000.parquet") == episodes
    assert types(written / "meta/tasks.parquet") == EXPECTED["tasks"]


def test_info_describes_the_features(written: Path) -> None:
    info = json.loads((written / "meta/info.json").read_text())
    assert {key: type(value).__name__ for key, value in info.items()} == EXPECTED["info"]
    assert (info["codebase_version"], info["fps"], info["total_episodes"]) == ("v3.0", 10, 3)
    assert info["total_frames"] == 5 + 7 + 5
    assert info["splits"] == {"train": "0:3"}
    assert not any("/" in name for name in info["features"])
    for told in info["features"].values():
        assert {"dtype", "shape", "names"} <= told.keys()
        assert told["names"] is None or told["dtype"] == "video" or [len(told["names"])] == told["shape"]
    video = info["features"]["observation.images.front"]
    assert (video["shape"], video["names"]) == ([32, 32, 3], ["height", "width", "channels"])
    assert {key: type(value).__name__ for key, value in video["info"].items()} == EXPECTED["video"]


def test_frames_are_the_episodes(written: Path, stored: Episodes) -> None:
    data = read(written, "data/*/*.parquet")
    rows = read(written, "meta/episodes/*/*.parquet")
    assert data["index"] == list(range(17))
    for number, episode in enumerate(stored):
        first, last = rows["dataset_from_index"][number], rows["dataset_to_index"][number]
        count = last - first
        own = {key: np.array(values[first:last]) for key, values in data.items()}
        assert rows["length"][number] == count == len(episode.frames)
        assert set(own["episode_index"]) == {number}
        np.testing.assert_array_equal(own["observation.state"].astype(np.float32), episode.frames.agent[:-1])
        np.testing.assert_array_equal(
            own["observation.environment_state"].astype(np.float32), episode.frames.environment[:-1]
        )
        np.testing.assert_array_equal(own["action"].astype(np.float32), episode.frames.action)
        np.testing.assert_array_equal(own["frame_index"], np.arange(count))
        np.testing.assert_array_equal(own["timestamp"].astype(np.float32), (np.arange(count) / 10).astype(np.float32))
        np.testing.assert_array_equal(own["phase"], episode.phase[::5][:count])
        np.testing.assert_array_equal(own["milestone"], episode.milestone[::5][:count])
        assert own["next.done"].tolist() == [False] * (count - 1) + [True]
        assert own["next.reward"].tolist() == [0.0] * (count - 1) + [float(number != 1)]
        assert own["next.success"].tolist() == [False] * (count - 1) + [number != 1]


def test_tasks_are_a_pandas_index_in_order(written: Path) -> None:
    table = pq.read_table(written / "meta/tasks.parquet")
    told = json.loads(table.schema.metadata[b"pandas"])
    assert told["index_columns"] == ["__index_level_0__"]
    assert table.column("task_index").to_pylist() == [0, 1]
    first, second = table.column("__index_level_0__").to_pylist()
    assert first == (
        "grasp the standing cylinder, 60 mm wide and 240 mm long, lift it 200 mm, carry it aside, hold it 3 s and set "
        "it down (wrap-vertical)"
    )
    assert second.startswith("grasp the standing sphere, 80 mm wide, lift it 200 mm")
    rows = read(written, "meta/episodes/*/*.parquet")
    assert rows["tasks"] == [[first], [first], [second]]
    assert read(written, "data/*/*.parquet")["task_index"] == [0] * 12 + [1] * 5


def test_videos_have_every_frame_at_its_time(written: Path) -> None:
    rows = read(written, "meta/episodes/*/*.parquet")
    for key in ("observation.images.front", "observation.images.top"):
        with av.open(str(written / f"videos/{key}/chunk-000/file-000.mp4")) as container:
            stream = container.streams.video[0]
            assert (stream.codec_context.name, stream.average_rate) == ("h264", Fraction(10))
            frames = list(container.decode(stream))
        assert [frame.pts * frame.time_base for frame in frames] == [Fraction(k, 10) for k in range(17)]
        assert all(one.key_frame or other.key_frame for one, other in pairwise(frames))
        begins = rows[f"videos/{key}/from_timestamp"]
        assert (begins, rows[f"videos/{key}/to_timestamp"]) == ([0.0, 0.5, 1.2], [0.5, 1.2, 1.7])
        for begin, seed in zip(begins, (5, 6, 7), strict=True):
            shown = frames[round(10 * begin)].to_ndarray(format="rgb24").astype(int)
            assert np.abs(shown[:14, :14] - seed).max() < 12
            assert np.abs(shown[18:, 18:] - [200, 40, 90]).max() < 12


def test_statistics_are_those_of_the_frames(written: Path, stored: Episodes) -> None:
    total = json.loads((written / "meta/stats.json").read_text())
    action = np.concatenate([episode.frames.action for episode in stored]).astype(float)
    told = total["action"]
    np.testing.assert_allclose(told["min"], action.min(0))
    np.testing.assert_allclose(told["max"], action.max(0))
    np.testing.assert_allclose(told["mean"], action.mean(0), atol=1e-12)
    np.testing.assert_allclose(told["std"], action.std(0), atol=1e-9)
    assert told["count"] == [17]
    assert np.all(np.diff([told[name] for name in ("min", "q01", "q10", "q50", "q90", "q99", "max")], axis=0) >= 0)
    colour = np.array(total["observation.images.front"]["mean"])
    assert colour.shape == (3, 1, 1)
    assert (colour > 0).all()
    assert (colour < 1).all()
    rows = read(written, "meta/episodes/*/*.parquet")
    own = next(iter(stored)).frames.action.astype(float)
    np.testing.assert_allclose(rows["stats/action/q90"][0], np.quantile(own, 0.9, axis=0))
    assert np.shape(rows["stats/observation.images.top/q50"][0]) == (3, 1, 1)


def test_statistics_of_parts_are_those_of_the_whole() -> None:
    values = np.random.default_rng(0).normal(3.0, 2.0, (60, 4))
    total = Total()
    for part in np.split(values, [7, 30]):
        total.add({"x": compute_statistics(part)})
    whole, found = compute_statistics(values), total.compute()["x"]
    for name in ("min", "max", "mean", "std", "count"):
        np.testing.assert_allclose(found[name], whole[name], atol=1e-12, err_msg=name)


def test_provenance_is_in_every_episode(written: Path, stored: Episodes) -> None:
    rows = read(written, "meta/episodes/*/*.parquet")
    for episode, told, design in zip(stored, rows["provenance"], rows["design"], strict=True):
        about = json.loads(told)
        assert about.pop("task_text") in rows["tasks"][episode.about["index"]]
        assert {**about, "design": design} == episode.about


def test_large_data_sets_have_several_files(
    stored: Episodes, layout: Layout, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(table_files, "DATA_MB", 1e-3)
    monkeypatch.setattr(table_files, "CHUNK", 2)
    monkeypatch.setattr(video_files, "VIDEO_MB", 1e-5)
    write_lerobot(stored, layout, tmp_path)
    rows = read(tmp_path, "meta/episodes/*/*.parquet")
    places = list(zip(rows["data/chunk_index"], rows["data/file_index"], strict=True))
    assert places == [(0, 0), (0, 1), (1, 0)]
    for number, (chunk, file) in enumerate(places):
        data = read(tmp_path, f"data/chunk-{chunk:03d}/file-{file:03d}.parquet")
        assert set(data["episode_index"]) == {number}
    key = "observation.images.front"
    assert rows[f"videos/{key}/file_index"] == [0, 1, 2]
    assert rows[f"videos/{key}/from_timestamp"] == [0.0, 0.0, 0.0]
