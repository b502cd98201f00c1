"""A recording: rigid bodies and markers over time, in metres, y up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.errors import TakeError

SYNTHETIC = "synthetic, not a measurement"
"""Take Notes of a recording that was computed from a model."""

HELD = 3
"""Frames with the very same coordinates from which on a pose is not measured but held [-] (ours).

Cameras jitter by tens of micrometres and files have a resolution of one: a point at rest repeats all its coordinates in
two further frames by chance once in many million.
"""


@final
@dataclass(frozen=True, kw_only=True)
class Body:
    """A rigid body as the cameras saw it."""

    name: str
    """What Motive's user called it."""
    id: str
    """Motive's identifier; tells bodies of one name apart."""
    position: np.ndarray
    """Pivot, not a number where occluded, shape (n, 3) [m]."""
    quaternion_wxyz: np.ndarray
    """Unit quaternions, not a number where occluded or not recorded, shape (n, 4) [-]."""
    marker_error: np.ndarray
    """Mean distance of its markers from where they should be, not a number where not recorded, shape (n,) [m]."""
    is_stale: np.ndarray
    """Frames that repeat the pose before them to the last digit: held, not measured, shape (n,) [bool]."""

    @property
    def is_seen(self) -> np.ndarray:
        """Frames in which it was measured, shape (n,) [bool]."""
        return np.isfinite(self.position).all(axis=1) & ~self.is_stale


@final
@dataclass(frozen=True, kw_only=True)
class Marker:
    """A marker as the cameras saw it."""

    name: str
    """Label, such as ``base:Marker1``."""
    id: str
    """Motive's identifier; tells markers of one name apart."""
    is_solved: bool
    """Whether it lies where the rigid body's solution puts it (Rigid Body Marker), not where cameras saw it."""
    position: np.ndarray
    """Centre, not a number where occluded, shape (n, 3) [m]."""
    is_stale: np.ndarray
    """Frames that repeat the position before them to the last digit, shape (n,) [bool]."""

    @property
    def is_seen(self) -> np.ndarray:
        """Frames in which it was measured, shape (n,) [bool]."""
        return np.isfinite(self.position).all(axis=1) & ~self.is_stale


@final
@dataclass(frozen=True, kw_only=True)
class Take:
    """One recording; y is up, lengths in metres, whatever the file had."""

    source: str
    """File or address that it comes from."""
    name: str
    """The take's name as recorded."""
    started: str
    """When it was recorded, as the file says it: the format depends on the computer's language."""
    rate: float
    """Frames per second [Hz]."""
    frame: np.ndarray
    """Frame numbers, increasing, shape (n,) [-]."""
    time: np.ndarray
    """Times of the frames by number and rate, shape (n,) [s]."""
    bodies: tuple[Body, ...]
    """Rigid bodies in the order of the file."""
    markers: tuple[Marker, ...]
    """Markers in the order of the file."""
    comment: str = ""
    """What the header says under Take Notes."""
    notes: tuple[str, ...] = ()
    """What was odd about the recording and how it was read."""

    @property
    def is_synthetic(self) -> bool:
        """Whether it was computed from a model: the header's Take Notes say so, whatever take and file are called."""
        return self.comment.startswith(SYNTHETIC)

    def body(self, name: str) -> Body:
        """The rigid body of that name.

        Raises:
            TakeError: where there is none, or more than one.
        """
        found = _find(self.bodies, name, f"rigid body {name!r}", self.source)
        return self.bodies[found]

    def marker(self, name: str) -> Marker:
        """The marker of that name; one that was seen before one that was solved.

        Raises:
            TakeError: where there is none, or more than one.
        """
        seen = [marker for marker in self.markers if not marker.is_solved and marker.name == name]
        among = seen or list(self.markers)
        return among[_find(among, name, f"marker {name!r}", self.source)]


def _find(tracks: Sequence[Body | Marker], name: str, what: str, source: str) -> int:
    found = [i for i, track in enumerate(tracks) if track.name == name]
    if len(found) > 1:
        ids = ", ".join(tracks[i].id or "without one" for i in found[:6])
        raise TakeError(
            f"{what} is there {len(found)} times, with the IDs {ids}; allowed: names of one each", file=source
        )
    if not found:
        names = [track.name for track in tracks]
        told = ", ".join(map(repr, names[:12])) + (f" and {len(names) - 12} more" if len(names) > 12 else "")
        raise TakeError(f"there is no {what}; allowed: {told or 'nothing, as there is none'}", file=source)
    return found[0]


def find_stale(pose: np.ndarray) -> np.ndarray:
    """Which frames repeat the one before to the last digit, in runs of at least `HELD`, shape (n,) [bool].

    The first of a run was measured; the others were held.

    Args:
        pose: coordinates, shape (n, k).
    """
    again = np.zeros(len(pose) + 1, bool)
    again[1:-1] = (pose[1:] == pose[:-1]).all(axis=1)
    if not again.any():
        return again[:-1]
    edges = np.flatnonzero(np.diff(again.astype(np.int8)))
    for begin, end in zip(edges[::2] + 1, edges[1::2] + 1, strict=True):
        if end - begin < HELD - 1:
            again[begin:end] = False
    return again[:-1]
