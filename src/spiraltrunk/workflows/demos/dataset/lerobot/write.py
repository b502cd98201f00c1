"""Writing of a LeRobotDataset v3.0 with PyArrow and PyAV alone.

The format is the one of lerobot 0.4.4 and 0.6.1. Its reader needs the names of tasks as a pandas index, the pictures at
a constant rate, and no slash in the names of features.
"""

from __future__ import annotations

import json
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from spiraltrunk.workflows.demos.dataset.columns import (
    compute_reward,
    describe_provenance,
    mark_last,
    number_phases,
    read_pictures,
)
from spiraltrunk.workflows.demos.dataset.layout import Episodes, Layout
from spiraltrunk.workflows.demos.dataset.lerobot import features
from spiraltrunk.workflows.demos.dataset.lerobot.statistics import (
    Statistics,
    Total,
    compute_picture_statistics,
    compute_statistics,
)
from spiraltrunk.workflows.demos.dataset.lerobot.table_files import TableFiles
from spiraltrunk.workflows.demos.dataset.lerobot.video_files import VideoFiles
from spiraltrunk.workflows.demos.dataset.task_text import describe_episode
from spiraltrunk.workflows.demos.recording.episode import MILESTONE_NAMES, PHASE_NAMES, Episode


def write_lerobot(episodes: Episodes, layout: Layout, folder: Path) -> None:
    """Write a data set into a folder, one episode in memory at a time.

    Raises:
        OSError: where a file cannot be written.
        OutputError: where an episode is gone or damaged.
    """
    tasks: dict[str, int] = {}
    total, frames = Total(), 0
    with ExitStack() as stack:
        data = stack.enter_context(TableFiles(folder, features.DATA_PATH, features.build_data_schema(layout)))
        rows = stack.enter_context(TableFiles(folder, features.EPISODES_PATH, features.build_episodes_schema(layout)))
        videos = {
            key: stack.enter_context(VideoFiles(folder, key, layout.size, layout.fps))
            for key in map(features.name_camera, layout.cameras)
        }
        for number, episode in enumerate(episodes):
            task = tasks.setdefault(describe_episode(episode), len(tasks))
            columns = _build_columns(episode, layout.fps, number, frames, task)
            statistics = {key: compute_statistics(values) for key, values in columns.items()}
            row = _build_row(episode, number, frames, data.place)
            data.add({key: _to_column(values) for key, values in columns.items()})
            for camera, (key, video) in zip(layout.cameras, videos.items(), strict=True):
                pictures = list(read_pictures(episode, camera))[:-1]
                row |= {f"videos/{key}/{name}": value for name, value in video.add(pictures).items()}
                statistics[key] = compute_picture_statistics(pictures)
            total.add(statistics)
            row |= dict(zip(("meta/episodes/chunk_index", "meta/episodes/file_index"), rows.place, strict=True))
            rows.add({key: [value] for key, value in (row | _flatten(statistics)).items()})
            frames += len(episode.frames)
    _write_meta(folder, layout, tasks, total.compute(), {"episodes": len(episodes), "frames": frames})


def _build_columns(episode: Episode, fps: int, number: int, first: int, task: int) -> dict[str, np.ndarray]:
    """Values of all features but videos, shape (m, ...) each; ``first`` is the number of frames before."""
    count = np.arange(len(episode.frames))
    phase, milestone = number_phases(episode)
    return {
        "observation.state": episode.frames.agent[:-1],
        "observation.environment_state": episode.frames.environment[:-1],
        "action": episode.frames.action,
        "next.reward": compute_reward(episode),
        "next.done": mark_last(episode),
        "next.success": compute_reward(episode) > 0,
        "phase": phase,
        "milestone": milestone,
        "timestamp": (count / fps).astype(np.float32),
        "frame_index": count,
        "episode_index": np.full_like(count, number),
        "index": first + count,
        "task_index": np.full_like(count, task),
    }


def _build_row(episode: Episode, number: int, first: int, place: tuple[int, int]) -> dict[str, Any]:
    length = len(episode.frames)
    return {
        "episode_index": number, "tasks": [describe_episode(episode)], "length": length,
        "data/chunk_index": place[0], "data/file_index": place[1],
        "dataset_from_index": first, "dataset_to_index": first + length, **describe_provenance(episode),
    }  # fmt: skip


def _to_column(values: np.ndarray) -> Any:
    import pyarrow as pa

    if values.ndim == 1:
        return values
    return pa.FixedSizeListArray.from_arrays(pa.array(values.ravel()), values.shape[1])


def _flatten(statistics: dict[str, Statistics]) -> dict[str, Any]:
    return {f"stats/{key}/{name}": value.tolist() for key, found in statistics.items() for name, value in found.items()}


def _write_meta(
    folder: Path, layout: Layout, tasks: dict[str, int], total: dict[str, Statistics], counts: dict[str, int]
) -> None:
    """Write tasks, statistics and the description of the data set, and what its numbers stand for."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    told = features.build_info(layout, **counts, tasks=len(tasks))
    names = {"phase": list(PHASE_NAMES), "milestone": list(MILESTONE_NAMES), "control_mode": layout.mode.value}
    statistics = {key: {name: value.tolist() for name, value in found.items()} for key, found in total.items()}
    for name, content in (("info", told), ("stats", statistics), ("spiraltrunk", names)):
        (folder / "meta" / f"{name}.json").write_text(json.dumps(content, indent=4, allow_nan=False) + "\n")
    index = "__index_level_0__"
    table = pa.table({"task_index": pa.array(tasks.values(), pa.int64()), index: pa.array(tasks, pa.string())})
    columns = [
        {"name": name, "field_name": field, "pandas_type": kind, "numpy_type": stored, "metadata": None}
        for name, field, kind, stored in (
            ("task_index", "task_index", "int64", "int64"), (None, index, "unicode", "object"),
        )
    ]  # fmt: skip
    about = {"index_columns": [index], "column_indexes": [], "columns": columns, "pandas_version": "2.2.0"}
    table = table.replace_schema_metadata({"pandas": json.dumps(about)})
    pq.write_table(table, folder / "meta" / "tasks.parquet", compression="snappy")
