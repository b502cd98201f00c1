"""Features of a LeRobotDataset: its ``info.json``, and the columns of its Parquet files."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from spiraltrunk.workflows.demos.dataset.layout import Layout

if TYPE_CHECKING:
    import pyarrow as pa

VERSION = "v3.0"
"""Version of the format."""

CHUNK = 1000
"""Most files in a folder [-]."""

DATA_MB, VIDEO_MB = 100, 200
"""Size at which a new file is begun [MB]."""

DATA_PATH = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
VIDEO_PATH = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
EPISODES_PATH = "meta/episodes/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"

STATISTICS = ("min", "max", "mean", "std", "count", "q01", "q10", "q50", "q90", "q99")
"""Statistics of each feature."""

ROBOT = "spiraltrunk"
"""Name of the type of robot."""


def name_camera(camera: str) -> str:
    """Name of the feature of a camera."""
    return f"observation.images.{camera}"


def list_features(layout: Layout) -> dict[str, dict[str, Any]]:
    """Features of the data set, by their names."""
    vectors = {
        "observation.state": layout.agent_names,
        "observation.environment_state": layout.environment_names,
        "action": layout.action_names,
    }
    single = {
        "next.reward": "float32", "next.done": "bool", "next.success": "bool", "phase": "int64", "milestone": "int64",
        "timestamp": "float32", "frame_index": "int64", "episode_index": "int64", "index": "int64",
        "task_index": "int64",
    }  # fmt: skip
    return {
        **{name_camera(camera): _describe_video(layout) for camera in layout.cameras},
        **{key: {"dtype": "float32", "shape": [len(names)], "names": list(names)} for key, names in vectors.items()},
        **{key: {"dtype": dtype, "shape": [1], "names": None} for key, dtype in single.items()},
    }


def build_info(layout: Layout, *, episodes: int, frames: int, tasks: int) -> dict[str, Any]:
    """Content of ``meta/info.json``."""
    return {
        "codebase_version": VERSION,
        "robot_type": ROBOT,
        "total_episodes": episodes,
        "total_frames": frames,
        "total_tasks": tasks,
        "chunks_size": CHUNK,
        "data_files_size_in_mb": DATA_MB,
        "video_files_size_in_mb": VIDEO_MB,
        "fps": layout.fps,
        "splits": {"train": f"0:{episodes}"},
        "data_path": DATA_PATH,
        "video_path": VIDEO_PATH if layout.cameras else None,
        "features": list_features(layout),
    }


def build_data_schema(layout: Layout) -> pa.Schema:
    """Columns of the frames' files; videos have none."""
    import pyarrow as pa

    types = {"float32": pa.float32(), "int64": pa.int64(), "bool": pa.bool_()}
    return pa.schema([
        (key, types[told["dtype"]] if told["shape"] == [1] else pa.list_(types[told["dtype"]], told["shape"][0]))
        for key, told in list_features(layout).items()
        if told["dtype"] != "video"
    ])  # fmt: skip


def build_episodes_schema(layout: Layout) -> pa.Schema:
    """Columns of the episodes' file; ``provenance`` and ``design`` are ours."""
    import pyarrow as pa

    places = ["data/chunk_index", "data/file_index", "dataset_from_index", "dataset_to_index"]
    videos = [name_camera(camera) for camera in layout.cameras]
    counts, numbers = pa.list_(pa.int64()), pa.list_(pa.float64())
    per_channel = pa.list_(pa.list_(pa.list_(pa.float64())))
    return pa.schema([
        ("episode_index", pa.int64()), ("tasks", pa.list_(pa.string())), ("length", pa.int64()),
        *((name, pa.int64()) for name in places),
        *(
            (f"videos/{key}/{name}", pa.float64() if "timestamp" in name else pa.int64())
            for key in videos
            for name in ("chunk_index", "file_index", "from_timestamp", "to_timestamp")
        ),
        *(
            (f"stats/{key}/{name}", counts if name == "count" else per_channel if key in videos else numbers)
            for key in list_features(layout)
            for name in STATISTICS
        ),
        ("meta/episodes/chunk_index", pa.int64()), ("meta/episodes/file_index", pa.int64()),
        ("provenance", pa.string()), ("design", pa.string()),
    ])  # fmt: skip


def _describe_video(layout: Layout) -> dict[str, Any]:
    size = layout.size
    return {
        "dtype": "video",
        "shape": [size, size, 3],
        "names": ["height", "width", "channels"],
        "info": {
            "video.height": size, "video.width": size, "video.codec": "h264", "video.pix_fmt": "yuv420p",
            "video.is_depth_map": False, "video.fps": layout.fps, "video.channels": 3, "has_audio": False,
        },
    }  # fmt: skip
