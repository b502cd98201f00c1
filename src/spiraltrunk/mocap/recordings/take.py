"""A recording: rigid bodies and markers over time, in metres, y up."""

from __future__ import annotations

from abc import ABC
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar, final

import numpy as np

from spiraltrunk.errors import TakeError
from spiraltrunk.field_docs import explain_fields

SYNTHETIC = "synthetic, not a measurement"
"""Take Notes of a recording that was computed from a model."""

HELD = 3
"""Consecutive frames with identical coordinates from which a pose counts as held instead of measured [-] (ours).

Cameras have a noise of tens of micrometres and files a resolution of one micrometre. A point at rest repeats all its
coordinates in two further frames by chance once in many million frames.
"""


@dataclass(frozen=True, kw_only=True)
class Track(ABC):
    """A rigid body or marker over time."""

    name: str
    """Name given in Motive."""
    id: str
    """Motive's identifier; distinguishes tracks of the same name."""
    position: np.ndarray
    """Pivot of a body, centre of a marker, not a number where occluded, shape (n, 3) [m]."""

    @cached_property
    def is_stale(self) -> np.ndarray:
        """Frames that repeat the previous pose to the last digit: held, not measured, shape (n,) [bool]."""
        return find_stale(self.position)

    @property
    def is_seen(self) -> np.ndarray:
        """Frames in which it was measured, shape (n,) [bool]."""
        return np.isfinite(self.position).all(axis=1) & ~self.is_stale

    @cached_property
    def seen(self) -> np.ndarray:
        """Measured positions, not a number elsewhere, shape (n, 3) [m]."""
        return np.where(self.is_seen[:, None], self.position, np.nan)


@final
@dataclass(frozen=True, kw_only=True)
class Body(Track):
    """A rigid body."""

    quaternion_wxyz: np.ndarray
    """Unit quaternions, not a number where occluded or not recorded, shape (n, 4) [-]."""
    marker_error: np.ndarray
    """Mean distance of its markers from the body's definition, not a number where not recorded, shape (n,) [m]."""

    @cached_property
    def is_stale(self) -> np.ndarray:
        """Frames that repeat position and orientation, as far as there is one, shape (n,) [bool]."""
        has_axes = np.isfinite(self.quaternion_wxyz).any()
        return find_stale(np.hstack([self.position, self.quaternion_wxyz]) if has_axes else self.position)


@final
@dataclass(frozen=True, kw_only=True)
class Marker(Track):
    """A marker, labelled such as ``base:Marker1``."""

    is_solved: bool
    """Whether the position is the rigid body's solution (Rigid Body Marker) instead of a measurement."""


AnyTrack = TypeVar("AnyTrack", bound=Track)


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Take:
    """One recording; y is up, lengths in metres, whatever the file had."""

    source: str
    """File or address."""
    name: str
    """Name of the take in Motive."""
    started: str
    """Time of recording as in the file; its format depends on the computer's language."""
    rate: float
    """Frames per second [Hz]."""
    frame: np.ndarray
    """Frame numbers, increasing, shape (n,) [-]."""
    time: np.ndarray
    """Times of the frames by number and rate, shape (n,) [s]."""
    bodies: tuple[Body, ...]
    """Rigid bodies, in the order of the file as markers are."""
    markers: tuple[Marker, ...]
    """Markers, labelled or not."""
    comment: str = ""
    """Take Notes of the header."""
    notes: tuple[str, ...] = ()
    """Irregularities of the file and how they were resolved."""

    @property
    def is_synthetic(self) -> bool:
        """Whether it was computed from a model, by the header's Take Notes; names of take and file do not matter."""
        return self.comment.startswith(SYNTHETIC)

    def body(self, name: str) -> Body:
        """The rigid body of that name; a `TakeError` where there is none, or more than one."""
        return _find(self.bodies, name, f"rigid body {name!r}", self.source)

    def marker(self, name: str) -> Marker:
        """The marker of that name, as `body`; a measured one takes precedence over a solved one."""
        measured = [marker for marker in self.markers if not marker.is_solved and marker.name == name]
        return _find(measured or self.markers, name, f"marker {name!r}", self.source)


def _find(tracks: Sequence[AnyTrack], name: str, what: str, source: str) -> AnyTrack:
    found = [track for track in tracks if track.name == name]
    if len(found) > 1:
        ids = ", ".join(track.id or "without one" for track in found[:6])
        reason = f"{what} is there {len(found)} times, with the IDs {ids}; allowed: names of one each"
        raise TakeError(reason, file=source)
    if not found:
        known = format_names([track.name for track in tracks], 12)
        raise TakeError(f"there is no {what}; allowed: {known or 'nothing, as there is none'}", file=source)
    return found[0]


def format_names(names: Sequence[str], most: int) -> str:
    """The first ``most`` names, and how many more there are."""
    rest = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(map(repr, names[:most])) + rest


def find_stale(pose: np.ndarray) -> np.ndarray:
    """Frames of coordinates, shape (n, k), that repeat the previous one in runs of at least `HELD`, shape (n,) [bool].

    The first frame of a run was measured, the others were held.
    """
    is_repeated = np.zeros(len(pose) + 1, bool)
    is_repeated[1:-1] = (pose[1:] == pose[:-1]).all(axis=1)
    edges = np.flatnonzero(np.diff(is_repeated.astype(np.int8)))
    for begin, end in zip(edges[::2] + 1, edges[1::2] + 1, strict=True):
        if end - begin < HELD - 1:
            is_repeated[begin:end] = False
    return is_repeated[:-1]
