"""Recordings by file format."""

from __future__ import annotations

from pathlib import Path

from spiraltrunk.errors import TakeError
from spiraltrunk.mocap.recordings.c3d import load_c3d
from spiraltrunk.mocap.recordings.motive_csv import load_motive
from spiraltrunk.mocap.recordings.take import Take


def load_take(path: str | Path, *, axes: str, rotations: str = "quaternion") -> Take:
    """Read a recording: Motive's CSV, or C3D by the ending ``.c3d``.

    Args:
        path: the file.
        axes: axis convention of the export (`axes.NAMED`, or three signed axes), which a file does not contain.
        rotations: for CSV, "quaternion", or "ignore" to read positions only, also from exports with Euler angles.

    Raises:
        TakeError: where it cannot be read, with file, line and column.
        MissingPackage: for C3D without its package.
    """
    ending = Path(path).suffix.lower()
    if ending == ".c3d":
        return load_c3d(path, axes=axes)
    if ending == ".tak":
        raise TakeError("Motive's own format is closed; allowed: CSV or C3D: export the take", file=str(path))
    return load_motive(path, axes=axes, rotations=rotations)
