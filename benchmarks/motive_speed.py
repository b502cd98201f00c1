"""How fast a Motive CSV is read, against the csv module with one `float` a cell, in one run on one core.

Claim: 10 MB/s or more. The file is one of 18 sections with their markers, made up here, with occlusions, in memory.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import math
import os
import sys
import time
from collections.abc import Callable

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from spiraltrunk.mocap.recordings.motive_csv import read_motive
from spiraltrunk.mocap.recordings.motive_write import format_motive
from spiraltrunk.mocap.recordings.take import Body, Marker, Take

BAR = 10.0
"""Megabytes a second that are claimed."""


def build_file(frames: int, seed: int = 0) -> bytes:
    """A recording of 18 rigid bodies and 54 markers, a tenth of them unseen."""
    draw = np.random.default_rng(seed)

    def place() -> np.ndarray:
        position = draw.normal(0.0, 1.0, (frames, 3))
        position[draw.random(frames) < 0.1] = np.nan
        return position

    bodies, markers = [], []
    for number in range(1, 19):
        position, turn = place(), draw.normal(size=(frames, 4))
        turn = np.where(np.isnan(position[:, :1]), np.nan, turn / np.linalg.norm(turn, axis=1, keepdims=True))
        name, error = f"section_{number:02d}", np.abs(position[:, 0]) * 1e-4
        bodies.append(
            Body(name=name, id=str(number), position=position, quaternion_wxyz=turn, marker_error=error)
        )  # fmt: skip
        for k in range(1, 4):
            markers.append(Marker(name=f"{name}:Marker{k}", id=f"{number}{k}", is_solved=False, position=place()))
    frame = np.arange(frames)
    return format_motive(
        Take(
            source="", name="speed", started="", rate=100.0, frame=frame, time=frame / 100.0, bodies=tuple(bodies),
            markers=tuple(markers),
        )
    )  # fmt: skip


def read_plainly(data: bytes) -> np.ndarray:
    """The numbers by the csv module."""
    rows = csv.reader(io.StringIO(data.decode()))
    return np.array([[float(cell) if cell else math.nan for cell in row] for row in list(rows)[7:]])


def measure(work: Callable[[], object], rounds: int) -> float:
    """Shortest time of some rounds [s]."""
    best = math.inf
    for _ in range(rounds):
        began = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - began)
    return best


def main() -> int:
    """Measure and print the figures as JSON; 1 where the bar is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=10_000)
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    data = build_file(arguments.frames)
    size = len(data) / 1e6
    ours = size / measure(lambda: read_motive(io.BytesIO(data), source="", axes="y-up"), arguments.rounds)
    plain = size / measure(lambda: read_plainly(data), arguments.rounds)
    figures = {
        "megabytes": size, "read_mb_s": ours, "csv_module_mb_s": plain, "ratio": ours / plain, "bar_mb_s": BAR,
        "holds": ours >= BAR,
    }  # fmt: skip
    print(json.dumps(figures, indent=2))
    return 0 if ours >= BAR or arguments.rounds < 2 else 1


if __name__ == "__main__":
    sys.exit(main())
