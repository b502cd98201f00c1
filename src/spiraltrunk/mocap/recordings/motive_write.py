"""Takes as Motive CSV 1.23, y up, in metres."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from spiraltrunk.files.atomic import write_file
from spiraltrunk.mocap.recordings.take import Body, Marker, Take

_BODY = (("Rotation", "XYZW"), ("Position", "XYZ"), ("Mean Marker Error", " "))


def write_motive(take: Take, path: str | Path) -> Path:
    """Write a take atomically; positions read back with ``axes="y-up"`` agree within 1 um.

    Raises:
        OSError: where the file cannot be written.
    """
    target = Path(path)
    write_file(target, format_motive(take))
    return target


def format_motive(take: Take) -> bytes:
    """The take as the bytes of a Motive CSV 1.23."""
    tracks: list[Body | Marker] = [*take.bodies, *take.markers]
    labels = [label for track in tracks for label in _label(track)]
    values = np.column_stack([take.frame, take.time, *map(_values, tracks)])
    rows = io.BytesIO()
    np.savetxt(rows, values, ["%d", *["%.6f"] * (values.shape[1] - 1)], delimiter=",", newline="\r\n")
    return _header(take, labels) + rows.getvalue().replace(b"nan", b"")


def _header(take: Take, labels: Sequence[tuple[str, ...]]) -> bytes:
    rate, count = f"{take.rate:.6f}", str(len(take.frame))
    pairs = (
        ("Format Version", "1.23"), ("Take Name", take.name), ("Take Notes", take.comment),
        ("Capture Frame Rate", rate), ("Export Frame Rate", rate), ("Capture Start Time", take.started),
        ("Total Frames in Take", count), ("Total Exported Frames", count), ("Rotation Type", "Quaternion"),
        ("Length Units", "Meters"), ("Coordinate Space", "Global"),
    )  # fmt: skip
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\r\n")
    writer.writerow([cell for pair in pairs for cell in pair])
    writer.writerow([])
    for i, label in enumerate(("Type", "Name", "ID", "")):
        writer.writerow(["", label, *(column[i] for column in labels)])
    writer.writerow(["Frame", "Time (Seconds)", *(column[4] for column in labels)])
    return text.getvalue().encode()


def _label(track: Body | Marker) -> list[tuple[str, ...]]:
    if isinstance(track, Body):
        return [
            ("Rigid Body", track.name, track.id, quantity, axis.strip()) for quantity, axes in _BODY for axis in axes
        ]
    kind = "Rigid Body Marker" if track.is_solved else "Marker"
    return [(kind, track.name, track.id, "Position", axis) for axis in "XYZ"]


def _values(track: Body | Marker) -> np.ndarray:
    if isinstance(track, Body):
        turn = track.quaternion_wxyz[:, [1, 2, 3, 0]]
        return np.hstack([turn, track.position, track.marker_error[:, None]])
    return track.position
