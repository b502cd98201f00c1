"""Reads a data set with lerobot itself and prints what it finds as JSON; run by a Python that has lerobot.

python read_with_lerobot.py FOLDER
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

os.environ["HF_HUB_OFFLINE"] = "1"


import numpy as np
import torch


def prepare() -> None:
    """Make up for what builds of PyTorch for processors alone lack.

    torchvision registers functions for an operator that its own compiled part defines, which does not load there;
    lerobot uses none of these.
    """
    try:
        import torchvision  # noqa: F401
    except RuntimeError:
        for name in [name for name in sys.modules if name.partition(".")[0] == "torchvision"]:
            del sys.modules[name]
        library = torch.library.Library("torchvision", "DEF")
        for name in ("nms", "qnms"):
            library.define(f"{name}(Tensor dets, Tensor scores, float iou_threshold) -> Tensor")
        globals()["_library"] = library


def decode(path: str, timestamps: list[float], tolerance: float, backend: str | None = None) -> torch.Tensor:
    """Frames of a video at these times, for machines without the shared libraries of FFmpeg that torchcodec needs."""
    import av

    with av.open(str(path)) as container:
        frames = [(float(frame.pts * frame.time_base), frame) for frame in container.decode(video=0)]
    found = [min(frames, key=lambda pair: abs(pair[0] - time)) for time in timestamps]
    assert all(abs(time - seen) < tolerance for time, (seen, _) in zip(timestamps, found, strict=True))
    pictures = np.stack([frame.to_ndarray(format="rgb24") for _, frame in found])
    return torch.from_numpy(pictures).permute(0, 3, 1, 2).float() / 255


def main(folder: str) -> None:
    prepare()
    import lerobot
    from lerobot.datasets import lerobot_dataset
    from lerobot.datasets.utils import dataset_to_policy_features

    lerobot_dataset.decode_video_frames = decode
    step = 1 / json.loads(Path(folder, "meta", "info.json").read_text())["fps"]
    deltas = {"observation.state": [-step, 0.0], "action": [0.0, step]}
    data = lerobot_dataset.LeRobotDataset("local/demos", root=folder, delta_timestamps=deltas)
    kinds = {key: told.type.name for key, told in dataset_to_policy_features(data.meta.features).items()}
    loader = torch.utils.data.DataLoader(data, batch_size=4)
    plain = lerobot_dataset.LeRobotDataset("local/demos", root=folder)
    items = [plain[i] for i in range(len(plain))]
    cameras = list(data.meta.camera_keys)
    print(
        json.dumps({
            "version": lerobot.__version__,
            "frames": len(data),
            "episodes": data.meta.total_episodes,
            "kinds": kinds,
            "cameras": cameras,
            "batch": {key: list(value.shape) for key, value in next(iter(loader)).items() if hasattr(value, "shape")},
            "state": [item["observation.state"].tolist() for item in items],
            "action": [item["action"].tolist() for item in items],
            "task": [item["task"] for item in items],
            "success": [bool(item["next.success"]) for item in items],
            "colour": {key: [item[key].mean(dim=(1, 2)).tolist() for item in items] for key in cameras},
            "mean": data.meta.stats["action"]["mean"].tolist(),
        })
    )  # fmt: skip


if __name__ == "__main__":
    main(sys.argv[1])
