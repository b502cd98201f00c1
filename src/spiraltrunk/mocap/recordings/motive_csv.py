"""Motive's CSV exports, versions 1.21 to 1.24: any bytes give a `Take` or a `TakeError` with line and column.

Blank cells are occlusions and stay not a number. Poses that repeat to the last digit are marked as stale. Times come
from frame numbers and rate, as the file's are rounded. Columns may come in any order; bodies and markers are told apart
by type, name and ID, and by the order of columns where all three repeat. Skeletons and devices are skipped with a note.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO, NamedTuple, final

import numpy as np

from spiraltrunk.errors import TakeError
from spiraltrunk.files.text_lines import Lines, open_take
from spiraltrunk.mocap.recordings.axes import read_axes, turn_quaternions
from spiraltrunk.mocap.recordings.motive_cells import Table, read_cells
from spiraltrunk.mocap.recordings.motive_header import Column, Header, read_header
from spiraltrunk.mocap.recordings.take import Body, Marker, Take, find_stale

ROTATIONS = ("quaternion", "ignore")
"""What to do with rotations: read quaternions and refuse all else, or leave them out."""

_BODY, _MARKERS = "rigid body", ("marker", "rigid body marker")
_FARTHEST = 1e4
_UNIT, _NEAR_UNIT = 0.1, 0.01
"""How far a quaternion's length may be from 1, and from where on that is told: gaps may be filled linearly [-]."""

_FRAME_MOST = 2.0**53

_Group = dict[tuple[str, str], Column]
"""Columns of one track by quantity and axis."""


def load_motive(path: str | Path, *, axes: str, rotations: str = "quaternion") -> Take:
    """Read a Motive CSV.

    Args:
        path: the file.
        axes: axis convention of the export, `axes.NAMED` or three signed axes; a file does not say it.
        rotations: "quaternion", or "ignore" to read positions alone, also from exports with Euler angles.

    Raises:
        TakeError: with file, line and column.
    """
    with open_take(path) as stream:
        return read_motive(stream, source=str(path), axes=axes, rotations=rotations)


def read_motive(stream: BinaryIO, *, source: str, axes: str, rotations: str = "quaternion") -> Take:
    """Read a Motive CSV from an open stream of bytes, which errors call ``source``.

    Raises:
        TakeError: with source, line and column.
    """
    turn = read_axes(axes)
    if rotations not in ROTATIONS:
        raise TakeError(f"rotations are {rotations[:40]!r}; allowed: {' or '.join(ROTATIONS)}")
    lines = Lines(stream, source)
    header = read_header(lines)
    groups, skipped = _sort_columns(header.columns)
    _check_groups(groups, header, rotations, source)
    used = [column.place for group in groups.values() for column in group.values()]
    wanted = sorted({0, *used, *([] if header.time is None else [header.time])})
    data = _Data(read_cells(lines, header.n_column, wanted), {column: i for i, column in enumerate(wanted)}, source)
    notes = [*header.notes, *skipped]
    data = _drop_blank(data)
    frame = _read_frames(data, header, notes)
    time = _read_times(data, header, frame, notes)
    place = _Place(turn, header.unit, rotations == "quaternion")
    bodies = [_build_body(data, group, place, notes) for key, group in groups.items() if key[0] == _BODY]
    markers = [_build_marker(data, group, place, notes) for key, group in groups.items() if key[0] != _BODY]
    _note_stale([*bodies, *markers], notes)
    return Take(
        source=source, name=header.take, started=header.started, rate=header.rate, frame=frame, time=time,
        bodies=tuple(bodies), markers=tuple(markers), comment=header.comment, notes=tuple(notes),
    )  # fmt: skip


@final
class _Data(NamedTuple):
    """The table, where in it a column of the file is, and what the file is called."""

    table: Table
    at: dict[int, int]
    source: str

    def column(self, column: int) -> np.ndarray:
        values: np.ndarray = self.table.values[:, self.at[column]]
        return values

    def refuse(self, row: int, column: int, message: str) -> TakeError:
        return TakeError(message, file=self.source, line=int(self.table.line[row]), column=column + 1)


@final
class _Place(NamedTuple):
    """How numbers of the file become ours."""

    turn: np.ndarray
    unit: float
    has_rotations: bool


def _sort_columns(columns: Sequence[Column]) -> tuple[dict[tuple[str, str, str, int], _Group], list[str]]:
    """Tracks that are read, in the order of the file, and notes on what is not."""
    groups: dict[tuple[str, str, str, int], _Group] = {}
    skipped: dict[str, set[str]] = {}
    for column in columns:
        if column.kind != _BODY and column.kind not in _MARKERS:
            skipped.setdefault(column.kind, set()).add(column.name)
            continue
        key = (column.kind, column.name, column.id, column.turn)
        groups.setdefault(key, {})[column.quantity, column.axis] = column
    notes = [f"{len(names)} of type {kind[:40]!r} skipped" for kind, names in skipped.items()]
    return {key: group for key, group in groups.items() if any(said[0] == "position" for said in group)}, notes


def _check_groups(groups: dict[tuple[str, str, str, int], _Group], header: Header, rotations: str, source: str) -> None:
    if not groups:
        told = "there is no position of a rigid body or marker; allowed: an export with them"
        raise TakeError(told, file=source, line=header.line)
    for (kind, name, _, _), group in groups.items():
        first = min(column.place for column in group.values()) + 1
        what = f"{kind} {name[:60]!r}"
        if missing := [axis for axis in "xyz" if ("position", axis) not in group]:
            told = f"{what} has no Position {missing[0].upper()}; allowed: X, Y and Z"
            raise TakeError(told, file=source, line=header.line, column=first)
        if kind != _BODY or rotations == "ignore" or not any(said == "rotation" for said, _ in group):
            continue
        if any(("rotation", axis) not in group for axis in "xyzw"):
            rotation = header.rotation[:40] or "not said"
            told = (
                f"rotations of {what} are no quaternions (Rotation Type: {rotation}), and a file does not say what "
                "Euler angles turn about; allowed: columns X, Y, Z, W: export with Rotation: Quaternion, or ignore "
                "rotations (--rotations ignore), as markers give the frames of sections too"
            )
            raise TakeError(told, file=source, line=header.line, column=first)


def _drop_blank(data: _Data) -> _Data:
    """Without rows of blank cells."""
    table = data.table
    blank = np.isnan(table.values).all(axis=1)
    if blank.any():
        table = Table(table.values[~blank], table.line[~blank], table.cut)
    if not len(table.values):
        told = "there are no rows of data; allowed: at least one"
        raise TakeError(f"{told} ({table.cut})" if table.cut else told, file=data.source)
    if np.isinf(table.values).any():
        row, column = np.argwhere(np.isinf(table.values))[0]
        at = {there: index for index, there in data.at.items()}[int(column)]
        raise data.refuse(int(row), at, "the cell is infinite; allowed: a finite number or a blank cell")
    return data._replace(table=table)


def _read_frames(data: _Data, header: Header, notes: list[str]) -> np.ndarray:
    """Frame numbers, increasing."""
    frame = data.column(0)
    bad = np.flatnonzero(~(np.abs(frame) < _FRAME_MOST) | (frame != np.rint(frame)))
    if len(bad):
        raise data.refuse(int(bad[0]), 0, f"the frame is {frame[bad[0]]:g}; allowed: a whole number")
    back = np.flatnonzero(np.diff(frame) <= 0)
    if len(back):
        told = f"frame {frame[back[0] + 1]:g} comes after {frame[back[0]]:g}; allowed: increasing numbers"
        raise data.refuse(int(back[0]) + 1, 0, told)
    if data.table.cut:
        notes.append(f"the last row is left out: {data.table.cut}")
    if header.frames is not None and header.frames != len(frame):
        notes.append(f"the header says {header.frames} frames, the file has {len(frame)}")
    dropped = int(frame[-1] - frame[0]) + 1 - len(frame)
    if dropped:
        notes.append(f"{dropped} frame numbers are missing between {frame[0]:g} and {frame[-1]:g}")
    return frame.astype(np.int64)


def _read_times(data: _Data, header: Header, frame: np.ndarray, notes: list[str]) -> np.ndarray:
    """Frame over rate; where the file's times disagree by more than a frame, frame over the cameras' rate, or these."""
    time = frame / header.rate
    if header.time is None:
        return time
    told = data.column(header.time)
    if not np.isfinite(told).all():
        notes.append("some times are blank; times are frame over rate")
        return time
    if _agree(told, time, header.rate):
        return time
    if header.capture_rate is not None and _agree(told, frame / header.capture_rate, header.capture_rate):
        notes.append(f"frames count at {header.capture_rate:g} Hz, the cameras' rate, and so do times")
        return frame / header.capture_rate
    back = np.flatnonzero(np.diff(told) <= 0)
    if len(back):
        row = int(back[0]) + 1
        raise data.refuse(row, header.time, f"the time {told[row]:g} s does not grow; allowed: increasing times")
    notes.append(f"times are the file's, as they are not frame over {header.rate:g} Hz")
    return told.copy()


def _agree(told: np.ndarray, time: np.ndarray, rate: float) -> bool:
    """Whether two clocks differ by a constant alone, within a frame and the rounding to 1 ms."""
    shift = told - time
    return bool(np.abs(shift - shift[0]).max() <= 1.0 / rate + 1e-3)


def _build_body(data: _Data, group: _Group, place: _Place, notes: list[str]) -> Body:
    first = group["position", "x"]
    position = _read_positions(data, group, place)
    quaternion = np.full((len(position), 4), np.nan)
    if place.has_rotations and ("rotation", "w") in group:
        quaternion = _read_quaternions(data, group, place, notes)
        half = np.isnan(position).any(axis=1) ^ np.isnan(quaternion).any(axis=1)
        if half.any():
            notes.append(f"rigid body {first.name[:60]!r}: {half.sum()} poses with blank cells are left out")
            position[half], quaternion[half] = np.nan, np.nan
    error = np.full(len(position), np.nan)
    for (quantity, axis), column in group.items():
        if "error" in quantity and not axis:
            error = data.column(column.place) * place.unit
    pose = np.hstack([position, quaternion]) if np.isfinite(quaternion).any() else position
    return Body(
        name=first.name, id=first.id, position=position, quaternion_wxyz=quaternion, marker_error=error,
        is_stale=find_stale(pose),
    )  # fmt: skip


def _build_marker(data: _Data, group: _Group, place: _Place, notes: list[str]) -> Marker:
    first = group["position", "x"]
    position = _read_positions(data, group, place)
    is_solved = first.kind != "marker"
    return Marker(name=first.name, id=first.id, is_solved=is_solved, position=position, is_stale=find_stale(position))


def _read_positions(data: _Data, group: _Group, place: _Place) -> np.ndarray:
    """Positions, y up, whole or not a number, shape (n, 3) [m]."""
    columns = [group["position", axis].place for axis in "xyz"]
    raw = np.stack([data.column(column) for column in columns], axis=1) * place.unit
    raw[np.isnan(raw).any(axis=1)] = np.nan
    far = np.abs(raw) > _FARTHEST
    if far.any():
        row, axis = np.argwhere(far)[0]
        told = f"the position is {raw[row, axis]:g} m; allowed: at most {_FARTHEST:g} m"
        raise data.refuse(int(row), columns[int(axis)], told)
    turned: np.ndarray = raw @ place.turn.T
    return turned


def _read_quaternions(data: _Data, group: _Group, place: _Place, notes: list[str]) -> np.ndarray:
    """Unit quaternions wxyz in our axes; zeros, which say that nothing was seen, become not a number."""
    columns = [group["rotation", axis].place for axis in "wxyz"]
    raw = np.stack([data.column(column) for column in columns], axis=1)
    raw[np.isnan(raw).any(axis=1) | (raw == 0).all(axis=1)] = np.nan
    size = np.sqrt((np.clip(raw, -1e6, 1e6) ** 2).sum(axis=1))
    bad = np.flatnonzero(np.abs(size - 1.0) > _UNIT)
    if len(bad):
        told = f"the quaternion of {group['rotation', 'x'].name[:60]!r} has the length {size[bad[0]]:.3g}; allowed: 1"
        raise data.refuse(int(bad[0]), min(columns), told)
    off = int((np.abs(size - 1.0) > _NEAR_UNIT).sum())
    if off:
        notes.append(f"rigid body {group['rotation', 'x'].name[:60]!r}: {off} quaternions are brought to the length 1")
    return turn_quaternions(raw / size[:, None], place.turn)


def _note_stale(tracks: Sequence[Body | Marker], notes: list[str]) -> None:
    held = [track for track in tracks if track.is_stale.any()]
    if held:
        worst = max(held, key=lambda track: int(track.is_stale.sum()))
        notes.append(
            f"{len(held)} of {len(tracks)} tracks have poses that are held and not measured, {worst.name[:60]!r} "
            f"the most: {worst.is_stale.sum()} of {len(worst.is_stale)} frames"
        )
