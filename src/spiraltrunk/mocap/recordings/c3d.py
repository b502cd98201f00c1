"""C3D files by the package ezc3d: labelled markers, no rigid bodies."""

from __future__ import annotations

import io
import json
import math
import os
import struct
from importlib.util import find_spec
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from spiraltrunk.errors import MissingPackage, TakeError
from spiraltrunk.files.limited_process import run_limited
from spiraltrunk.files.text_lines import open_take
from spiraltrunk.mocap.recordings.axes import read_axes
from spiraltrunk.mocap.recordings.take import Marker, Take

_UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
_FARTHEST = 1e4
_MOST_FRAMES = 2**16 - 1
_BLOCK, _KEY = 512, 0x50

_SECONDS, _SECOND_BYTES = 30, 1_000_000
"""Time that a file may take [s], and the bytes that may take a second more (ours: ezc3d reads 9 MB in one)."""

_MEMORY, _MEMORY_SHARE = 2 << 30, 25
"""Address space that a file may take [bytes], and that for each byte of it (ours: ezc3d takes 13)."""

_TASK = Path(__file__).with_name("c3d_task.py")


def load_c3d(path: str | Path, *, axes: str) -> Take:
    """`load_take` of a C3D file, which has markers only.

    A marker with a negative residual (as the format specifies) or a missing coordinate was not seen. The axes are
    given, as exporters store them in different places.
    """
    turn = read_axes(axes)
    with open_take(path) as file:
        first, last = _read_frame_numbers(file, str(path))
        size = file.seek(0, io.SEEK_END)
    head, points, residual = _read(path, size)
    rate, unit = _check_scale(head["rate"], head["unit"], str(path))
    position = _place_points(points, residual, unit, str(path))
    labels = head["labels"]
    if len(labels) < len(position):
        raise TakeError(f"{len(position)} markers and {len(labels)} labels; allowed: a label each", file=str(path))
    placed = position @ turn.T
    frame = head["first_frame"] + np.arange(position.shape[1])
    is_cut = len(frame) < last + 1 - first < _MOST_FRAMES
    notes = (f"the header says {last + 1 - first} frames, the file has {len(frame)}",) if is_cut else ()
    markers = tuple(
        Marker(name=name, id=str(i + 1), is_solved=False, position=place)
        for i, (name, place) in enumerate(zip(labels, placed, strict=False))
    )
    return Take(
        source=str(path), name=Path(path).stem, started="", rate=rate, frame=frame, time=frame / rate, bodies=(),
        markers=markers, notes=notes,
    )  # fmt: skip


def _read_frame_numbers(file: BinaryIO, source: str) -> tuple[int, int]:
    """First and last frame in the header, which ezc3d adapts to a cut-off file.

    The header has the key 0x50 in byte 1, the frames in words 3 and 4, and the first block of the data in word 8 (C3D
    User Guide, "The Header Section"). ezc3d spends minutes on files without key or data.
    """
    head = file.read(_BLOCK)
    if (
        len(head) < _BLOCK
        or head[1] != _KEY
        or file.seek(0, io.SEEK_END) < _BLOCK * struct.unpack_from("<H", head, 16)[0]
    ):
        raise TakeError("it has no header or data of a C3D file; allowed: a C3D file", file=source)
    first, last = struct.unpack_from("<2H", head, 6)
    return first, last


def _check_scale(rate: float, unit: str, source: str) -> tuple[float, float]:
    """Rate [Hz] and unit [m]."""
    if not (math.isfinite(rate) and 0.01 <= rate <= 1e5):
        raise TakeError(f"POINT:RATE is {rate:g}; allowed: a rate in Hz", file=source)
    if unit.lower() not in _UNITS:
        raise TakeError(f"POINT:UNITS are {unit[:40]!r}; allowed: {', '.join(_UNITS)}", file=source)
    return rate, _UNITS[unit.lower()]


def _place_points(raw: np.ndarray, residual: np.ndarray, unit: float, source: str) -> np.ndarray:
    """Positions in the file's axes, not a number where a marker was not seen, shape (n_marker, n, 3) [m]."""
    if raw.ndim != 3 or not raw.shape[1] or not raw.shape[2] or residual.size != raw[0].size:
        raise TakeError(f"there are {raw.shape[1:]} markers and frames; allowed: at least one of each", file=source)
    position = np.moveaxis(raw[:3], 0, -1) * unit
    position[~np.isfinite(position).all(axis=-1) | (residual.reshape(raw.shape[1:]) < 0)] = np.nan
    if np.nanmax(np.abs(position), initial=0.0) > _FARTHEST:
        raise TakeError(f"a marker is farther than {_FARTHEST:g} m; allowed: nearer: is the unit right?", file=source)
    return position


def _read(path: str | Path, size: int) -> tuple[dict[str, Any], np.ndarray, np.ndarray]:
    """Rate, unit, labels and first frame, points and residuals, by ezc3d in a process with limits.

    ezc3d trusts the counts and lengths in a file: on a damaged one it reads beyond its memory, or asks for all of it.
    """
    if find_spec("ezc3d") is None:
        raise MissingPackage("C3D needs the package ezc3d: pip install 'spiraltrunk[mocap]', or export CSV")
    seconds, memory = _SECONDS + size // _SECOND_BYTES, _MEMORY + _MEMORY_SHARE * size
    try:
        stream = io.BytesIO(run_limited(_TASK, "read", os.fsencode(path), seconds=seconds, memory=memory))
    except (TimeoutError, ChildProcessError):
        allowed = f"a C3D file that ezc3d reads in {seconds} s and {memory / 1e9:.1f} GB"
        raise TakeError(f"ezc3d cannot read it: is it damaged?; allowed: {allowed}", file=str(path)) from None
    head = json.loads(stream.readline())
    if "error" in head:
        reason = " ".join(head["error"].split())[:200]
        raise TakeError(f"{reason}; allowed: a C3D file that ezc3d reads", file=str(path))
    return head, np.load(stream), np.load(stream)
