"""Reader of Motive's CSV exports, versions 1.21 to 1.24: any bytes give a `Take` or a `TakeError` with line and column.

Blank cells are occlusions and become not a number. Poses that repeat to the last digit are marked as stale. Times are
computed from frame numbers and rate, as the file's are rounded. Columns may have any order. Tracks are distinguished by
type, name and ID, and by the order of columns where all three repeat. Skeletons and devices are skipped with a note.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, final

import numpy as np

from spiraltrunk.errors import TakeError
from spiraltrunk.files.text_lines import Lines, open_take
from spiraltrunk.mocap.recordings.axes import read_axes, turn_quaternions
from spiraltrunk.mocap.recordings.motive_cells import read_cells
from spiraltrunk.mocap.recordings.motive_header import Column, Header, read_header
from spiraltrunk.mocap.recordings.take import Body, Marker, Take, Track

ROTATIONS = ("quaternion", "ignore")
"""Treatment of rotations: read quaternions and refuse all others, or leave rotations out."""

_BODY, _MARKERS = "rigid body", ("marker", "rigid body marker")
_FARTHEST = 1e4
_NORM_ERROR, _NOTED_NORM_ERROR = 0.1, 0.01
"""Largest error of a quaternion's norm, and the error from which it is noted: gaps may be filled linearly [-]."""

_Key = tuple[str, str, str, int]
"""Type, name, ID and count of a track."""

_Group = dict[tuple[str, str], Column]
"""Columns of one track by quantity and axis."""


def load_motive(path: str | Path, *, axes: str, rotations: str = "quaternion") -> Take:
    """`load_take` of a Motive CSV."""
    with open_take(path) as stream:
        return read_motive(stream, source=str(path), axes=axes, rotations=rotations)


def read_motive(stream: BinaryIO, *, source: str, axes: str, rotations: str = "quaternion") -> Take:
    """`load_motive` from a binary stream, which errors call ``source``."""
    turn = read_axes(axes)
    if rotations not in ROTATIONS:
        raise TakeError(f"rotations are {rotations[:40]!r}; allowed: {' or '.join(ROTATIONS)}")
    lines = Lines(stream, source)
    header = read_header(lines)
    groups, skipped = _group_columns(header.columns)
    _check_groups(groups, header, rotations, source)
    used = [column.place for group in groups.values() for column in group.values()]
    wanted = sorted({0, *used, *([] if header.time is None else [header.time])})
    notes = [*header.notes, *skipped]
    data = _read_data(lines, header, wanted, notes)
    frame = _read_frames(data, header, notes)
    time = _read_times(data, header, frame, notes)
    has_rotations = rotations == "quaternion"
    bodies = [_build_body(data, g, turn, has_rotations, notes) for key, g in groups.items() if key[0] == _BODY]
    markers = [_build_marker(data, g, turn) for key, g in groups.items() if key[0] != _BODY]
    _note_stale([*bodies, *markers], notes)
    return Take(
        source=source, name=header.take, started=header.started, rate=header.rate, frame=frame, time=time,
        bodies=tuple(bodies), markers=tuple(markers), comment=header.comment, notes=tuple(notes),
    )  # fmt: skip


@final
@dataclass(frozen=True, kw_only=True)
class _Data:
    """Values by the column's place in the file, the line of each row, shapes (n_row,), and the length unit [m]."""

    columns: dict[int, np.ndarray]
    line: np.ndarray
    unit: float
    source: str

    def stack(self, group: _Group, quantity: str, axes: str) -> tuple[list[int], np.ndarray]:
        """Places and values of some axes of a quantity; rows with blank cells are not a number."""
        places = [group[quantity, axis].place for axis in axes]
        values = np.stack([self.columns[place] for place in places], axis=1)
        values[np.isnan(values).any(axis=1)] = np.nan
        return places, values

    def refuse(self, row: int, column: int, message: str) -> TakeError:
        return TakeError(message, file=self.source, line=int(self.line[row]), column=column + 1)


def _group_columns(columns: Sequence[Column]) -> tuple[dict[_Key, _Group], list[str]]:
    """Tracks with positions, in the order of the file, and notes on skipped columns."""
    groups: dict[_Key, _Group] = {}
    skipped: dict[str, set[str]] = {}
    for column in columns:
        if column.kind != _BODY and column.kind not in _MARKERS:
            skipped.setdefault(column.kind, set()).add(column.name)
            continue
        key = (column.kind, column.name, column.id, column.repeat)
        groups.setdefault(key, {})[column.quantity, column.axis] = column
    notes = [f"{len(names)} of type {kind[:40]!r} skipped" for kind, names in skipped.items()]
    return {key: group for key, group in groups.items() if any(name == "position" for name, _ in group)}, notes


def _check_groups(groups: dict[_Key, _Group], header: Header, rotations: str, source: str) -> None:
    if not groups:
        reason = "there is no position of a rigid body or marker; allowed: an export with them"
        raise TakeError(reason, file=source, line=header.line)
    for (kind, name, _, _), group in groups.items():
        what, reason = f"{kind} {name[:60]!r}", ""
        missing = [axis for axis in "xyz" if ("position", axis) not in group]
        has_rotation = kind == _BODY and rotations != "ignore" and any(quantity == "rotation" for quantity, _ in group)
        if missing:
            reason = f"{what} has no Position {missing[0].upper()}; allowed: X, Y and Z"
        elif has_rotation and any(("rotation", axis) not in group for axis in "xyzw"):
            reason = (
                f"rotations of {what} are no quaternions (Rotation Type: {header.rotation[:40] or 'missing'}), and a "
                "file does not contain the axes of Euler angles; allowed: columns X, Y, Z, W: export with Rotation: "
                "Quaternion, or ignore rotations (--rotations ignore), as markers give the frames of sections too"
            )
        elif has_rotation and header.rotation.lower() not in ("", "quaternion"):
            reason = (
                f"rotations of {what} have columns X, Y, Z, W, and the header says Rotation Type: "
                f"{header.rotation[:40]}; allowed: Quaternion, or ignore rotations (--rotations ignore)"
            )
        if reason:
            first = min(column.place for column in group.values()) + 1
            raise TakeError(reason, file=source, line=header.line, column=first)


def _read_data(lines: Lines, header: Header, wanted: list[int], notes: list[str]) -> _Data:
    """The wanted columns, without rows of blank cells."""
    values, line, cut = read_cells(lines, header.n_column, wanted)
    kept = ~np.isnan(values).all(axis=1)
    values, line = values[kept], line[kept]
    if not len(values):
        why = f" ({cut})" if cut else ""
        raise TakeError(f"there are no rows of data; allowed: at least one{why}", file=lines.source)
    columns = {place: values[:, i] for i, place in enumerate(wanted)}
    data = _Data(columns=columns, line=line, unit=header.unit, source=lines.source)
    if np.isinf(values).any():
        row, column = np.argwhere(np.isinf(values))[0]
        reason = "the cell is infinite; allowed: a finite number or a blank cell"
        raise data.refuse(int(row), wanted[int(column)], reason)
    if cut:
        notes.append(f"the last row is left out: {cut}")
    return data


def _read_frames(data: _Data, header: Header, notes: list[str]) -> np.ndarray:
    """Frame numbers, increasing."""
    frame = data.columns[0]
    bad = np.flatnonzero(~(np.abs(frame) < 2.0**53) | (frame != np.rint(frame)))
    if len(bad):
        raise data.refuse(int(bad[0]), 0, f"the frame is {frame[bad[0]]:g}; allowed: a whole number")
    back = np.flatnonzero(np.diff(frame) <= 0)
    if len(back):
        reason = f"frame {frame[back[0] + 1]:g} comes after {frame[back[0]]:g}; allowed: increasing numbers"
        raise data.refuse(int(back[0]) + 1, 0, reason)
    if header.frames is not None and header.frames != len(frame):
        notes.append(f"the header says {header.frames} frames, the file has {len(frame)}")
    dropped = int(frame[-1] - frame[0]) + 1 - len(frame)
    if dropped:
        notes.append(f"frame numbers missing between {frame[0]:g} and {frame[-1]:g}: {dropped}")
    return frame.astype(np.int64)


def _read_times(data: _Data, header: Header, frame: np.ndarray, notes: list[str]) -> np.ndarray:
    """Frame over rate; if the file's times differ by more than a frame, frame over the cameras' rate, or the file's."""
    time = frame / header.rate
    if header.time is None:
        return time
    given = data.columns[header.time]
    if not np.isfinite(given).all():
        notes.append("some times are blank; times are frame over rate")
        return time
    if _agree(given, time, header.rate):
        return time
    if header.capture_rate is not None and _agree(given, frame / header.capture_rate, header.capture_rate):
        notes.append(f"frames count at {header.capture_rate:g} Hz, the cameras' rate, and so do times")
        return frame / header.capture_rate
    back = np.flatnonzero(np.diff(given) <= 0)
    if len(back):
        row = int(back[0]) + 1
        raise data.refuse(row, header.time, f"the time {given[row]:g} s does not grow; allowed: increasing times")
    notes.append(f"times are the file's, as they are not frame over {header.rate:g} Hz")
    return given


def _agree(given: np.ndarray, time: np.ndarray, rate: float) -> bool:
    """Whether two clocks differ by a constant only, within a frame and rounding to 1 ms."""
    shift = given - time
    return bool(np.abs(shift - shift[0]).max() <= 1.0 / rate + 1e-3)


def _build_body(data: _Data, group: _Group, turn: np.ndarray, has_rotations: bool, notes: list[str]) -> Body:
    first, position = group["position", "x"], _read_positions(data, group, turn)
    quaternion, error = np.full((len(position), 4), np.nan), np.full(len(position), np.nan)
    if has_rotations and ("rotation", "w") in group:
        quaternion = _read_quaternions(data, group, turn, notes)
        half = np.isnan(position).any(axis=1) ^ np.isnan(quaternion).any(axis=1)
        if half.any():
            notes.append(f"rigid body {first.name[:60]!r}: {half.sum()} poses with blank cells are left out")
            position[half], quaternion[half] = np.nan, np.nan
    for (quantity, axis), column in group.items():
        if "error" in quantity and not axis:
            error = data.columns[column.place] * data.unit
    return Body(name=first.name, id=first.id, position=position, quaternion_wxyz=quaternion, marker_error=error)


def _build_marker(data: _Data, group: _Group, turn: np.ndarray) -> Marker:
    first, position = group["position", "x"], _read_positions(data, group, turn)
    return Marker(name=first.name, id=first.id, is_solved=first.kind != "marker", position=position)


def _read_positions(data: _Data, group: _Group, turn: np.ndarray) -> np.ndarray:
    """Positions, y up, complete or not a number, shape (n, 3) [m]."""
    places, raw = data.stack(group, "position", "xyz")
    raw *= data.unit
    if (np.abs(raw) > _FARTHEST).any():
        row, axis = np.argwhere(np.abs(raw) > _FARTHEST)[0]
        reason = f"the position is {raw[row, axis]:g} m; allowed: at most {_FARTHEST:g} m"
        raise data.refuse(int(row), places[int(axis)], reason)
    turned: np.ndarray = raw @ turn.T
    return turned


def _read_quaternions(data: _Data, group: _Group, turn: np.ndarray, notes: list[str]) -> np.ndarray:
    """Unit quaternions wxyz in the take's axes; zeros, which mean occlusion, become not a number."""
    places, raw = data.stack(group, "rotation", "wxyz")
    raw[(raw == 0).all(axis=1)] = np.nan
    norm = np.linalg.norm(np.clip(raw, -1e6, 1e6), axis=1)
    name = group["rotation", "x"].name[:60]
    bad = np.flatnonzero(np.abs(norm - 1.0) > _NORM_ERROR)
    if len(bad):
        reason = f"the quaternion of {name!r} has the length {norm[bad[0]]:.3g}; allowed: 1"
        raise data.refuse(int(bad[0]), min(places), reason)
    off = int((np.abs(norm - 1.0) > _NOTED_NORM_ERROR).sum())
    if off:
        notes.append(f"rigid body {name!r}: {off} quaternions are brought to the length 1")
    return turn_quaternions(raw / norm[:, None], turn)


def _note_stale(tracks: Sequence[Track], notes: list[str]) -> None:
    held = [track for track in tracks if track.is_stale.any()]
    if held:
        worst = max(held, key=lambda track: int(track.is_stale.sum()))
        notes.append(
            f"{len(held)} of {len(tracks)} tracks have poses that are held and not measured, {worst.name[:60]!r} "
            f"the most: {worst.is_stale.sum()} of {len(worst.is_stale)} frames"
        )
