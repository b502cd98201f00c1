"""C3D files by the package ezc3d: labelled markers, no rigid bodies."""

from __future__ import annotations

import io
import math
import struct
from itertools import takewhile
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from spiraltrunk.errors import MissingPackage, TakeError
from spiraltrunk.files.text_lines import open_take
from spiraltrunk.mocap.recordings.axes import read_axes
from spiraltrunk.mocap.recordings.take import Marker, Take

_UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
_FARTHEST = 1e4
_MOST_FRAMES = 2**16 - 1
_BLOCK, _KEY = 512, 0x50


def load_c3d(path: str | Path, *, axes: str) -> Take:
    """`load_take` of a C3D file, which has markers only.

    A marker with a negative residual (as the format specifies) or a missing coordinate was not seen. The axes are
    given, as exporters store them in different places.
    """
    turn = read_axes(axes)
    with open_take(path) as file:
        first, last = _read_frame_numbers(file, str(path))
    content = _read(path)
    rate, unit = _read_scale(content["parameters"]["POINT"], str(path))
    position = _read_points(content["data"], unit, str(path))
    labels = _labels(content["parameters"])
    if len(labels) < len(position):
        raise TakeError(f"{len(position)} markers and {len(labels)} labels; allowed: a label each", file=str(path))
    placed = position @ turn.T
    frame = int(content["header"]["points"]["first_frame"]) + np.arange(position.shape[1])
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


def _read_scale(point: Any, source: str) -> tuple[float, float]:
    """Rate [Hz] and unit [m]."""
    rate, unit = float(_first(point, "RATE", math.nan)), str(_first(point, "UNITS", "")).strip()
    if not (math.isfinite(rate) and 0.01 <= rate <= 1e5):
        raise TakeError(f"POINT:RATE is {rate:g}; allowed: a rate in Hz", file=source)
    if unit.lower() not in _UNITS:
        raise TakeError(f"POINT:UNITS are {unit[:40]!r}; allowed: {', '.join(_UNITS)}", file=source)
    return rate, _UNITS[unit.lower()]


def _read_points(data: Any, unit: float, source: str) -> np.ndarray:
    """Positions in the file's axes, not a number where a marker was not seen, shape (n_marker, n, 3) [m]."""
    raw = np.asarray(data["points"], float)
    if raw.ndim != 3 or not raw.shape[1] or not raw.shape[2]:
        raise TakeError(f"there are {raw.shape[1:]} markers and frames; allowed: at least one of each", file=source)
    position = np.moveaxis(raw[:3], 0, -1) * unit
    residual = np.asarray(data["meta_points"]["residuals"], float).reshape(raw.shape[1:])
    position[~np.isfinite(position).all(axis=-1) | (residual < 0)] = np.nan
    if np.nanmax(np.abs(position), initial=0.0) > _FARTHEST:
        raise TakeError(f"a marker is farther than {_FARTHEST:g} m; allowed: nearer: is the unit right?", file=source)
    return position


def _read(path: str | Path) -> Any:
    try:
        import ezc3d  # type: ignore[import-untyped]
    except ImportError:
        raise MissingPackage("C3D needs the package ezc3d: pip install 'spiraltrunk[mocap]', or export CSV") from None
    try:
        return ezc3d.c3d(str(path))
    except Exception as error:  # ezc3d raises whatever C++ throws.
        reason = " ".join(str(error).split())[:200]
        raise TakeError(f"{reason}; allowed: a C3D file that ezc3d reads", file=str(path)) from None


def _first(group: Any, key: str, default: object) -> Any:
    values = np.ravel(group[key]["value"]) if key in group else np.empty(0)
    return values[0] if len(values) else default


def _labels(parameters: Any) -> list[str]:
    """All labels, those of LABELS2 and so on included."""
    group = parameters["POINT"]
    keys = takewhile(group.__contains__, ("LABELS", *(f"LABELS{i}" for i in range(2, 100))))
    return [str(name).strip() for key in keys for name in group[key]["value"]]
