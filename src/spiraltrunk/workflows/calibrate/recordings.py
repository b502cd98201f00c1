"""Recordings of a calibration: which are fitted, which are held out, and the static shapes read from them."""

from __future__ import annotations

import filecmp
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import TakeError
from spiraltrunk.mocap.protocol.protocol import Protocol
from spiraltrunk.mocap.session.session import SessionSettings, build_session, note_takes
from spiraltrunk.mocap.signal.registration import Alignment
from spiraltrunk.model.kinematics.measured_shapes import MeasuredShapes


@final
@dataclass(frozen=True, kw_only=True)
class Recordings:
    """Which recordings are fitted, which are held out, and how they are read."""

    protocol: Protocol
    """The protocol that was recorded."""
    design: TrunkDesign
    """The trunk as it was built."""
    fitted: Mapping[str, Sequence[str]]
    """Files by run."""
    held_out: Mapping[str, Sequence[str]] = field(default_factory=dict)
    """Files by run; held-out takes are not averaged with fitted ones."""
    axes: str | None = None
    """Axis convention; None takes the protocol's."""


@final
@dataclass(frozen=True, kw_only=True)
class RecordedShapes:
    """Static shapes of all recordings."""

    shapes: MeasuredShapes
    """Fitted shapes, then held-out shapes."""
    is_fitted: np.ndarray
    """Which shapes are fitted, shape (n,) [bool]."""
    notes: tuple[str, ...]
    """Irregularities of the recordings."""
    synthetic: tuple[str, ...]
    """Recordings that were computed from a model."""


def list_files(takes: Mapping[str, Sequence[str]]) -> list[str]:
    """Files of all runs."""
    return [str(file) for files in takes.values() for file in files]


def split_takes(takes: Mapping[str, Sequence[str]]) -> tuple[dict[str, list[str]], dict[str, list[str]]]:
    """Fitted and held-out takes: of each run with several takes, the last one is held out."""
    fitted = {run: list(files[:-1]) if len(files) > 1 else list(files) for run, files in takes.items()}
    return fitted, {run: [files[-1]] for run, files in takes.items() if len(files) > 1}


def leave_out(takes: Mapping[str, Sequence[str]], held_out: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
    """The takes that are not held out.

    Raises:
        TakeError: where none is left.
    """
    away = {(run, Path(file).resolve()) for run, files in held_out.items() for file in files}
    left = {run: [file for file in files if (run, Path(file).resolve()) not in away] for run, files in takes.items()}
    if not any(left.values()):
        raise TakeError("every take is held out; allowed: one or more that are fitted")
    return {run: files for run, files in left.items() if files}


def read_recordings(recordings: Recordings) -> RecordedShapes:
    """Read all shapes, registered by the rigid body at the base.

    A registration to a model's shapes would absorb part of what is fitted.

    Raises:
        TakeError: for recordings that cannot be read or do not match the protocol.
    """
    _refuse_copies(recordings)
    settings = SessionSettings(
        design=recordings.design, axes=recordings.axes, alignment=Alignment(kind="base"), is_part=True
    )
    sessions = [
        build_session(recordings.protocol, takes, settings)
        for takes in (recordings.fitted, recordings.held_out)
        if any(takes.values())
    ]
    parts = [session.shapes for session in sessions]
    count = [len(part.kind) for part in parts]
    return RecordedShapes(
        shapes=_join_shapes(parts), is_fitted=np.arange(sum(count)) < count[0],
        notes=(
            *(note for session in sessions for run in session.runs for note in run.notes),
            *_note_all_takes(recordings),
        ),
        synthetic=tuple(source for session in sessions for source in session.synthetic),
    )  # fmt: skip


def _note_all_takes(recordings: Recordings) -> list[str]:
    """A line for each run whose takes, fitted and held out, are not as many as the protocol asks for."""
    counts = [
        (run, sum(len(part.get(run.name, ())) for part in (recordings.fitted, recordings.held_out)))
        for run in recordings.protocol.runs
    ]
    return [note for run, count in counts if count for note in note_takes(run, count)]


def _refuse_copies(recordings: Recordings) -> None:
    """Refuse a held-out file that is a copy of a fitted one.

    Raises:
        TakeError: names both.
    """
    for held in list_files(recordings.held_out):
        for fitted in list_files(recordings.fitted):
            with suppress(OSError):  # A file that cannot be read is reported when it is read.
                if filecmp.cmp(held, fitted, shallow=False):
                    reason = f"it is held out and the same file as {fitted!r}, which is fitted"
                    raise TakeError(f"{reason}; allowed: each recording once", file=held)


def _join_shapes(parts: Sequence[MeasuredShapes]) -> MeasuredShapes:
    """Shapes of several sessions of one trunk, one after the other."""
    firsts = np.cumsum([0, *(len(part.kind) for part in parts[:-1])])
    follows = [np.where(part.follows < 0, -1, part.follows + first) for part, first in zip(parts, firsts, strict=True)]
    arrays = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in ("theta_0", "pull", "points", "rotation")
    }
    return MeasuredShapes(
        kind=tuple(kind for part in parts for kind in part.kind), marker_offset=parts[0].marker_offset,
        take=tuple(take for part in parts for take in part.take), follows=np.concatenate(follows), **arrays,
    )  # fmt: skip
