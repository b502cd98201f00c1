"""Static shapes from recordings, in the model's frame: segmented, registered and averaged."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from spiraltrunk.checks import check_number
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError, TakeError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.files.results import Progress, ignore_progress
from spiraltrunk.mocap.protocol.protocol import Protocol, Run
from spiraltrunk.mocap.protocol.schedule import Schedule, build_schedule
from spiraltrunk.mocap.recordings.axes import read_axes
from spiraltrunk.mocap.recordings.load import load_take
from spiraltrunk.mocap.recordings.take import Take
from spiraltrunk.mocap.session.plausibility import check_base, check_order, check_scale, check_trunk
from spiraltrunk.mocap.session.prediction import MODELS, Prediction, predict
from spiraltrunk.mocap.session.sections import average_still, find_sections
from spiraltrunk.mocap.session.take_registration import TakeShapes, average_takes, register
from spiraltrunk.mocap.signal.registration import Alignment, mean_rotation
from spiraltrunk.mocap.signal.segmentation import describe_slowest, find_stills, find_timed, summarise_gaps
from spiraltrunk.model.kinematics.measured_shapes import MeasuredShapes, compute_marker_offset


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class SessionSettings:
    """How a session is read."""

    design: TrunkDesign
    """Trunk that was recorded."""
    axes: str | None = None
    """Axis convention of the recordings; None takes the protocol's."""
    alignment: Alignment | None = None
    """How recordings are registered; None takes the protocol's."""
    model: str = "reference"
    """Model that ``run`` and ``shape`` register to, one of `prediction.MODELS`."""
    friction: float | None = None
    """Coefficient between cables and holes, for statics [-]; None takes the design's."""
    rotations: str | None = None
    """"quaternion" or "ignore"; None takes the protocol's."""
    is_part: bool = False
    """Whether other takes of the session are read apart: then nothing is noted where the protocol asks for more."""

    def __post_init__(self) -> None:
        if self.model not in MODELS:
            raise ModelError(f"model is {self.model!r}; allowed: {', '.join(MODELS)}")
        if self.friction is not None:
            if self.model == "reference":
                raise ModelError("friction given with the model reference; allowed: with statics, reference has none")
            check_number("friction", self.friction, least=0.0, below=2.0)
        if self.axes is not None:
            read_axes(self.axes)


@final
@dataclass(frozen=True, kw_only=True)
class RunShapes:
    """Shapes of one run, averaged over its recordings."""

    schedule: Schedule
    predicted: Prediction
    takes: tuple[TakeShapes, ...]
    points: np.ndarray
    """Measured, in the model's frame, not a number where no take saw them, shape (n, n_section, 3) [m]."""
    rotation: np.ndarray
    """Measured axes, shape (n, n_section, 3, 3) [-]."""
    spread: float
    """Root mean square distance of a take's points from the mean of the takes, not a number for one take [m]."""
    notes: tuple[str, ...]


@final
@dataclass(frozen=True, kw_only=True)
class Session:
    """All runs, and their shapes for calibration."""

    runs: tuple[RunShapes, ...]
    """In the protocol's order."""
    alignment: Alignment
    shapes: MeasuredShapes
    """All shapes, run after run."""

    @property
    def synthetic(self) -> list[str]:
        """Sources of the recordings that were computed from a model."""
        return [take.take.source for run in self.runs for take in run.takes if take.take.is_synthetic]


def read_session(
    protocol: Protocol, takes: Mapping[str, Sequence[str | Path | Take]], settings: SessionSettings
) -> MeasuredShapes:
    """`build_session`, of which only the shapes in the model's frame are returned."""
    return build_session(protocol, takes, settings).shapes


def build_session(
    protocol: Protocol, takes: Mapping[str, Sequence[str | Path | Take]], settings: SessionSettings,
    progress: Progress = ignore_progress,
) -> Session:  # fmt: skip
    """Static shapes of recordings, or their files, by the name of the run, and all intermediate results.

    Raises:
        TakeError: for recordings that cannot be read or do not match the protocol.
    """
    if not any(takes.values()):
        raise TakeError("no recordings given; allowed: one or more, RUN=FILE or named as the run")
    alignment, runs = settings.alignment or protocol.alignment, []
    for run in sorted(map(protocol.run, takes), key=protocol.runs.index):
        schedule = build_schedule(settings.design, protocol, run)
        held: list[TakeShapes] = []
        for file in takes[run.name]:
            progress(f"reading {run.name}", len(held), len(takes[run.name]))
            held.append(_read_take(file, run, protocol, settings))
        _refuse_copies(run, held)
        predicted = predict(
            settings.design, schedule, model=settings.model, friction=settings.friction, progress=progress
        )
        notes = [] if settings.is_part else note_takes(schedule.run, len(held))
        runs.append(_average_run(schedule, predicted, tuple(held), alignment, notes))
    return Session(runs=tuple(runs), alignment=alignment, shapes=_join_runs(runs, settings.design))


def _read_take(file: str | Path | Take, run: Run, protocol: Protocol, settings: SessionSettings) -> TakeShapes:
    """Shapes of one recording, as many as the run has."""
    take = file if isinstance(file, Take) else _load(file, protocol, settings)
    tracks = find_sections(take, settings.design, protocol)
    stills = _find_run_stills(take, tracks.points, run, protocol)
    held = [average_still(tracks, frames, protocol.orientation) for frames in stills]
    for i, shape in enumerate(held):
        if not np.isfinite(shape.points).all(axis=1).any():
            what = f"shape {i + 1} of run {run.name!r}, from {shape.begin:.2f} to {shape.end:.2f} s"
            raise TakeError(f"{what}, shows no section; allowed: at least one", file=take.source)
    check_trunk(held, settings.design, take.source)
    if protocol.orientation == "markers":
        check_order(held, take.source)
    seen = np.isfinite(tracks.points).all(axis=2)
    gaps = summarise_gaps({f"section {i + 1}": seen[:, i] for i in np.flatnonzero(seen.any(axis=0))}, take.time)
    notes = (*take.notes, *check_scale(held, settings.design), *check_base(held, run, take.source), *gaps)
    return TakeShapes(take=take, held=tuple(held), notes=notes)


def _load(file: str | Path, protocol: Protocol, settings: SessionSettings) -> Take:
    axes = settings.axes or protocol.axes
    if axes is None:
        reason = "the axis convention of the recordings is not given, and files do not contain it"
        raise TakeError(f"{reason}; allowed: --axes, or axes in the protocol: y-up, z-up, x-up, or three axes")
    return load_take(file, axes=axes, rotations=settings.rotations or protocol.rotations)


def _refuse_copies(run: Run, takes: Sequence[TakeShapes]) -> None:
    """Refuse two recordings that are equal to the last digit."""
    for i, one in enumerate(takes):
        for other in takes[:i]:
            pairs = zip(one.held, other.held, strict=True)
            if all(np.array_equal(a.points, b.points, equal_nan=True) for a, b in pairs):
                what = f"the same data as {other.take.source!r}, to the last digit, in run {run.name!r}"
                raise TakeError(f"{what}; allowed: each recording once", file=one.take.source)


def _find_run_stills(take: Take, points: np.ndarray, run: Run, protocol: Protocol) -> list[np.ndarray]:
    """Frames of the stills, one for each shape of the run; where there are more or fewer, the error names them."""
    begin = -math.inf if run.begin is None else run.begin
    end = math.inf if run.end is None else run.end
    inside = np.flatnonzero((take.time >= begin) & (take.time <= end))
    if not len(inside):
        what = f"it lasts from {take.time[0]:.2f} to {take.time[-1]:.2f} s"
        raise TakeError(f"{what}; allowed: something between begin_s and end_s of {run.name!r}", file=take.source)
    signal = (take.time[inside], points[inside], take.rate, protocol.still)
    if run.period is None:
        stills = find_stills(*signal)
        if len(stills) != run.n_shape:
            spans = [take.time[inside[frames[[0, -1]]]] for frames in stills[:40]]
            times = ", ".join(f"{first:.1f}-{last:.1f}" for first, last in spans)
            found = f"{len(stills)} static shapes found ({times} s)" if stills else describe_slowest(*signal)
            allowed = f"{run.n_shape}, as run {run.name!r} has: see begin_s, end_s, period_s, [still] of the protocol"
            raise TakeError(f"{found}; allowed: {allowed}", file=take.source)
    else:
        try:
            stills = find_timed(*signal, (begin, run.period, run.n_shape))
        except TakeError as error:
            raise TakeError(f"run {run.name!r}: {error}", file=take.source) from None
    return [inside[frames] for frames in stills]


def note_takes(run: Run, count: int) -> list[str]:
    """A line where the run has another number of takes than the protocol asks for, else none."""
    return [] if count == run.takes else [f"takes of run {run.name!r}: {count}; the protocol asks for {run.takes}"]


def _average_run(
    schedule: Schedule,
    predicted: Prediction,
    takes: tuple[TakeShapes, ...],
    alignment: Alignment,
    told: Sequence[str] = (),
) -> RunShapes:
    """Registered shapes, averaged over the takes."""
    run = schedule.run
    notes = [f"{take.take.source}: {note}" for take in takes for note in take.notes]
    points, rotation, moved = register(run, predicted, takes, alignment)
    notes += [*moved, *told]
    mean, seen = average_takes(points), np.isfinite(points).all(axis=-1)
    count = seen.sum(axis=0)
    squares = ((points - mean) ** 2).sum(axis=-1)[seen & (count > 1)]
    partly = int(((count > 0) & (count < len(takes))).sum())
    if partly:
        notes.append(f"{partly} of {count.size} points of run {run.name!r} were seen in some takes only")
    mean_axes = np.array([[mean_rotation(rotation[:, i, j]) for j in range(count.shape[1])] for i in range(len(count))])
    return RunShapes(
        schedule=schedule, predicted=predicted, takes=takes, points=mean, rotation=mean_axes,
        spread=float(np.sqrt(squares.mean())) if len(squares) else math.nan, notes=(*notes, *predicted.warnings),
    )  # fmt: skip


def _join_runs(runs: Sequence[RunShapes], design: TrunkDesign) -> MeasuredShapes:
    """All shapes, run after run; within a run each follows the one before."""
    counts = [len(run.points) for run in runs]
    firsts = np.cumsum([0, *counts[:-1]])
    follows = [np.concatenate([[-1], np.arange(first, first + n - 1)]) for first, n in zip(firsts, counts, strict=True)]
    names = ["+".join(Path(take.take.source).name for take in run.takes) for run in runs]
    return MeasuredShapes(
        kind=tuple(run.schedule.run.kind for run, n in zip(runs, counts, strict=True) for _ in range(n)),
        take=tuple(name for name, n in zip(names, counts, strict=True) for _ in range(n)),
        theta_0=np.repeat([run.schedule.run.theta_0 for run in runs], counts),
        pull=np.concatenate([run.schedule.pull for run in runs]), follows=np.concatenate(follows),
        marker_offset=compute_marker_offset(design), points=np.concatenate([run.points for run in runs]),
        rotation=np.concatenate([run.rotation for run in runs]),
    )  # fmt: skip
