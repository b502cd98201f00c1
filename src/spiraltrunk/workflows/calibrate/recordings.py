"""A calibration from recordings to files: read, fitted, judged, and written all together or not at all."""

from __future__ import annotations

import filecmp
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import final

import numpy as np

from spiraltrunk.calibration.calibrate import Calibration, Settings, calibrate
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import TakeError
from spiraltrunk.mocap.protocol.protocol import Protocol
from spiraltrunk.mocap.session.session import SessionSettings, build_session
from spiraltrunk.mocap.signal.registration import Alignment
from spiraltrunk.model.kinematics.measured_shapes import MeasuredShapes

_VIRTUAL = ("virtual", "rehearsal", "simulat")


@final
@dataclass(frozen=True, kw_only=True)
class Recordings:
    """Which recordings are fitted, which are held out, and how they are read."""

    protocol: Protocol
    """What was done."""
    design: TrunkDesign
    """The trunk as it was built."""
    fitted: Mapping[str, Sequence[str]]
    """Files by run."""
    held_out: Mapping[str, Sequence[str]] = field(default_factory=dict)
    """Files by run; each is a take of its own here, never averaged with what is fitted."""
    axes: str | None = None
    """Axis convention; None takes the protocol's."""


def split_takes(takes: Mapping[str, Sequence[str]]) -> tuple[dict[str, list[str]], dict[str, list[str]]]:
    """The last take of every run that has several is held out, the others are fitted."""
    fitted = {run: list(files[:-1]) if len(files) > 1 else list(files) for run, files in takes.items()}
    return fitted, {run: [files[-1]] for run, files in takes.items() if len(files) > 1}


def read_recordings(recordings: Recordings) -> tuple[MeasuredShapes, np.ndarray, tuple[str, ...]]:
    """All shapes, registered by the base's rigid body, which are fitted, and what was odd in the recordings.

    The base alone is no model's word: a registration to a model would hide what is to be fitted.

    Raises:
        TakeError: for recordings that cannot be read or do not hold what the protocol says.
    """
    _refuse_copies(recordings)
    settings = SessionSettings(design=recordings.design, axes=recordings.axes, alignment=Alignment(kind="base"))
    sessions = [
        build_session(recordings.protocol, takes, settings)
        for takes in (recordings.fitted, recordings.held_out)
        if any(takes.values())
    ]
    parts = [session.shapes for session in sessions]
    count = [len(part.kind) for part in parts]
    odd = tuple(note for session in sessions for run in session.runs for note in run.notes)
    return join_shapes(parts), np.arange(sum(count)) < count[0], odd


def _refuse_copies(recordings: Recordings) -> None:
    """A copy of what is fitted judges nothing.

    Raises:
        TakeError: names both.
    """
    for held in _list(recordings.held_out):
        for fitted in _list(recordings.fitted):
            with suppress(OSError):  # What cannot be read is told where it is read.
                if filecmp.cmp(held, fitted, shallow=False):
                    told = f"it is held out and the same file as {fitted!r}, which is fitted"
                    raise TakeError(f"{told}; allowed: each recording once", file=held)


def join_shapes(parts: Sequence[MeasuredShapes]) -> MeasuredShapes:
    """Shapes of several sessions of one trunk, one after the other."""
    firsts = np.cumsum([0, *(len(part.kind) for part in parts[:-1])])
    follows = [np.where(part.follows < 0, -1, part.follows + first) for part, first in zip(parts, firsts, strict=True)]
    arrays = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in ("theta_0", "pull", "points", "rotation")
    }
    return MeasuredShapes(
        kind=tuple(kind for part in parts for kind in part.kind), seat=parts[0].seat,
        take=tuple(take for part in parts for take in part.take), follows=np.concatenate(follows), **arrays,
    )  # fmt: skip


def run_calibration(
    recordings: Recordings, settings: Settings, *, tell: Callable[[str, int, int], None] | None = None
) -> tuple[Calibration, MeasuredShapes, tuple[str, ...]]:
    """Read, fit and judge; beside the fit the shapes and what was odd in the recordings.

    Raises:
        TakeError: for recordings that cannot be read.
        ModelError: for shapes that cannot be fitted.
    """
    if tell is not None:
        tell("reading", 0, 1)
    shapes, is_fitted, odd = read_recordings(recordings)
    return calibrate(recordings.design, shapes, is_fitted, settings, tell=tell), shapes, odd


_MODELS = ("calibrated", "uncalibrated", "reference")


def _mean(values: np.ndarray) -> float | None:
    return float(np.nanmean(values)) if np.isfinite(values).any() else None


def _list(takes: Mapping[str, Sequence[str]]) -> list[str]:
    return [str(file) for files in takes.values() for file in files]


def _is_virtual(file: str) -> bool:
    """Whether a take's first line says that it is made up."""
    try:
        with Path(file).open("rb") as stream:
            head = stream.read(600).lower()
    except OSError:
        return False
    return any(word.encode() in head for word in _VIRTUAL)
