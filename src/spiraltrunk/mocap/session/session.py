"""From recordings to static shapes in the model's frame: found, registered, averaged."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ShapeError, TakeError
from spiraltrunk.files.results import Progress, ignore_progress
from spiraltrunk.mocap.protocol.protocol import Protocol, Run
from spiraltrunk.mocap.protocol.schedule import Plan, build_plan
from spiraltrunk.mocap.recordings.load import load_take
from spiraltrunk.mocap.recordings.take import Take
from spiraltrunk.mocap.session.base_tilt import check_base
from spiraltrunk.mocap.session.prediction import Predicted, predict
from spiraltrunk.mocap.session.section_spacing import check_trunk, tell_scale
from spiraltrunk.mocap.session.sections import HeldShape, SectionTracks, check_order, find_sections, hold
from spiraltrunk.mocap.signal.gaps import tell_gaps
from spiraltrunk.mocap.signal.registration import Alignment, Motion, fit_motion, is_straight, mean_rotation
from spiraltrunk.mocap.signal.segmentation import Still, find_stills, find_timed, tell_calmest
from spiraltrunk.model.kinematics.frames import base_orientation
from spiraltrunk.model.kinematics.measured_shapes import MeasuredShapes, compute_marker_offset

_BASE_MOVED = 2e-3
"""Way of the base over a take from which on it is told [m] (ours)."""

_LEVER = 1e-3
"""How far beside a section's point its axes are drawn on, where they decide a turn [m]: too near to move the points."""


@final
@dataclass(frozen=True, kw_only=True)
class SessionSettings:
    """What a session is read with."""

    design: TrunkDesign
    """The trunk."""
    axes: str | None = None
    """Axis convention of the recordings; None takes the protocol's, which must then have one."""
    alignment: Alignment | None = None
    """How they are registered; None takes the protocol's."""
    model: str = "reference"
    """Model that ``run`` and ``shape`` register to, one of `predict.MODELS`."""
    friction: float | None = None
    """Coefficient between cables and holes, statics alone [-]; None takes the design's."""
    rotations: str | None = None
    """"quaternion" or "ignore"; None takes the protocol's."""


@final
@dataclass(frozen=True, kw_only=True)
class TakeShapes:
    """The shapes of one recording."""

    take: Take
    """The recording."""
    held: tuple[HeldShape, ...]
    """Its shapes in its own frame."""
    notes: tuple[str, ...]
    """What was odd."""


@final
@dataclass(frozen=True, kw_only=True)
class RunShapes:
    """The shapes of one run, averaged over its recordings."""

    plan: Plan
    """What was done."""
    predicted: Predicted
    """What the model says."""
    takes: tuple[TakeShapes, ...]
    """The recordings."""
    points: np.ndarray
    """Measured, in the model's frame, not a number where no take saw them, shape (n, n_section, 3) [m]."""
    rotation: np.ndarray
    """Measured axes, shape (n, n_section, 3, 3) [-]."""
    spread: float
    """Root mean square distance of a take's points from the mean of the takes, not a number for one take [m]."""
    notes: tuple[str, ...]
    """What was odd."""


@final
@dataclass(frozen=True, kw_only=True)
class Session:
    """All runs, and their shapes for calibration."""

    runs: tuple[RunShapes, ...]
    """Runs, in the protocol's order."""
    alignment: Alignment
    """How they were registered."""
    shapes: MeasuredShapes
    """All shapes, run after run."""

    @property
    def synthetic(self) -> list[str]:
        """Sources of the recordings that were computed from a model."""
        return [take.take.source for run in self.runs for take in run.takes if take.take.is_synthetic]


def read_session(
    protocol: Protocol, takes: Mapping[str, Sequence[str | Path | Take]], settings: SessionSettings
) -> MeasuredShapes:
    """Static shapes of recordings, in the model's frame.

    Args:
        protocol: what was done.
        takes: recordings, or their files, by the name of the run.
        settings: trunk, axes and registration.

    Raises:
        TakeError: for recordings that cannot be read or do not hold what the protocol says.
    """
    return build_session(protocol, takes, settings).shapes


def build_session(
    protocol: Protocol, takes: Mapping[str, Sequence[str | Path | Take]], settings: SessionSettings,
    progress: Progress = ignore_progress,
) -> Session:  # fmt: skip
    """As `read_session`, with everything on the way.

    Raises:
        TakeError: for recordings that cannot be read or do not hold what the protocol says.
    """
    if not any(takes.values()):
        raise TakeError("no recordings given; allowed: one or more, RUN=FILE or named as the run")
    runs = []
    order = [run.name for run in protocol.runs]
    for name in sorted(takes, key=lambda name: order.index(protocol.run(name).name)):
        run, files = protocol.run(name), takes[name]
        plan = build_plan(settings.design, protocol, run)
        held: list[TakeShapes] = []
        for file in files:
            progress(f"reading {run.name}", len(held), len(files))
            held.append(_read_take(file, run, protocol, settings))
        _refuse_copies(run, held)
        predicted = predict(
            settings.design, plan, model=settings.model, friction=settings.friction,
            watch=partial(progress, f"{settings.model}, {run.name}"),
        )  # fmt: skip
        runs.append(_average(plan, predicted, tuple(held), settings.alignment or protocol.alignment))
    return Session(
        runs=tuple(runs), alignment=settings.alignment or protocol.alignment, shapes=_gather(runs, settings.design)
    )


def _read_take(file: str | Path | Take, run: Run, protocol: Protocol, settings: SessionSettings) -> TakeShapes:
    """The shapes of one recording, as many as the run has."""
    axes = settings.axes or protocol.axes
    if axes is None and not isinstance(file, Take):
        told = "the axis convention of the recordings is not told, and files do not say it"
        raise TakeError(f"{told}; allowed: --axes, or axes in the protocol: y-up, z-up, x-up, or three axes")
    take = file if isinstance(file, Take) else load_take(
        file, axes=axes or "", rotations=settings.rotations or protocol.rotations
    )  # fmt: skip
    tracks = find_sections(take, settings.design, protocol)
    stills = _find_shapes(tracks, run, protocol)
    held = [hold(tracks, still, protocol.orientation) for still in stills]
    for i, shape in enumerate(held):
        if np.isfinite(shape.points).all(axis=1).sum() < 1:
            told = f"shape {i + 1} of run {run.name!r}, from {stills[i].begin:.2f} to {stills[i].end:.2f} s"
            raise TakeError(f"{told}, shows no section; allowed: at least one", file=take.source)
    check_trunk(held, settings.design, take.source)
    if protocol.orientation == "markers":
        check_order(held, take.source)
    notes = [*take.notes, *tell_scale(held, settings.design), *check_base(held, run, take.source)]
    seen = np.isfinite(tracks.points).all(axis=2)
    gaps = tell_gaps({f"section {i + 1}": seen[:, i] for i in np.flatnonzero(seen.any(axis=0))}, take.time)
    return TakeShapes(take=take, held=tuple(held), notes=(*notes, *gaps))


def _refuse_copies(run: Run, takes: Sequence[TakeShapes]) -> None:
    """Two recordings are never alike to the last digit.

    Raises:
        TakeError: names both.
    """
    for i, one in enumerate(takes):
        for other in takes[:i]:
            pairs = zip(one.held, other.held, strict=True)
            if all(np.array_equal(a.points, b.points, equal_nan=True) for a, b in pairs):
                told = f"the same data as {other.take.source!r}, to the last digit, in run {run.name!r}"
                raise TakeError(f"{told}; allowed: each recording once", file=one.take.source)


def _find_shapes(tracks: SectionTracks, run: Run, protocol: Protocol) -> list[Still]:
    """Stills, one a shape.

    Raises:
        TakeError: where there are more or fewer than the run has; it tells their times.
    """
    take = tracks.take
    begin = -math.inf if run.begin is None else run.begin
    end = math.inf if run.end is None else run.end
    inside = np.flatnonzero((take.time >= begin) & (take.time <= end))
    if not len(inside):
        told = f"it lasts from {take.time[0]:.2f} to {take.time[-1]:.2f} s"
        raise TakeError(f"{told}; allowed: something between begin_s and end_s of {run.name!r}", file=take.source)
    time, points = take.time[inside], tracks.points[inside]
    if run.period is not None:
        try:
            stills = find_timed(time, points, take.rate, protocol.still, (begin, run.period, run.n_shape))
        except TakeError as error:
            raise TakeError(f"run {run.name!r}: {error}", file=take.source) from None
    else:
        stills = find_stills(time, points, take.rate, protocol.still)
        if len(stills) != run.n_shape:
            _refuse_count(stills, run, take, tell_calmest(time, points, take.rate, protocol.still))
    return [Still(frames=inside[still.frames], begin=still.begin, end=still.end) for still in stills]


def _refuse_count(stills: list[Still], run: Run, take: Take, calmest: str) -> None:
    times = ", ".join(f"{still.begin:.1f}-{still.end:.1f}" for still in stills[:40])
    told = f"{len(stills)} static shapes found ({times} s)" if stills else calmest
    allowed = f"{run.n_shape}, as run {run.name!r} has: see begin_s, end_s, period_s and [still] of the protocol"
    raise TakeError(f"{told}; allowed: {allowed}", file=take.source)


def _average(plan: Plan, predicted: Predicted, takes: tuple[TakeShapes, ...], alignment: Alignment) -> RunShapes:
    """Registered shapes, averaged over the takes."""
    notes = [f"{take.take.source}: {note}" for take in takes for note in take.notes]
    points, rotation = register(plan, predicted, takes, alignment, notes)
    if len(takes) != plan.run.takes:
        notes.append(f"run {plan.run.name!r} has {len(takes)} takes; the protocol asks for {plan.run.takes}")
    mean, seen = average_takes(points), np.isfinite(points).all(axis=-1)
    count = seen.sum(axis=0)
    away = ((points - mean) ** 2).sum(axis=-1)[seen & (count > 1)]
    once = int(((count > 0) & (count < len(takes))).sum())
    if once:
        notes.append(f"{once} of {count.size} points of run {plan.run.name!r} were seen in some takes alone")
    shape = rotation.shape[1:3]
    turned = np.array([[mean_rotation(rotation[:, i, j]) for j in range(shape[1])] for i in range(shape[0])])
    return RunShapes(
        plan=plan, predicted=predicted, takes=takes, points=mean, rotation=turned,
        spread=float(np.sqrt(away.mean())) if len(away) else math.nan, notes=(*notes, *predicted.troubles),
    )  # fmt: skip


def average_takes(points: np.ndarray) -> np.ndarray:
    """Mean over the takes that saw a point, not a number where none did, shape (n, n_section, 3) [m].

    Args:
        points: registered points of all takes, shape (n_take, n, n_section, 3) [m].
    """
    seen = np.isfinite(points).all(axis=-1)
    count = seen.sum(axis=0)
    mean: np.ndarray = np.where(seen[..., None], points, 0.0).sum(axis=0)
    return mean / np.where(count > 0, count, np.nan)[..., None]


def register(
    plan: Plan, predicted: Predicted, takes: Sequence[TakeShapes], alignment: Alignment, notes: list[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Points and axes of all takes in the model's frame, shapes (n_take, n, n_section, 3 [, 3]) [m], [-].

    Raises:
        TakeError: where an alignment lacks what it needs.
    """
    points, rotation = [], []
    for take in takes:
        motions = _find_motions(plan, predicted, take, alignment, notes)
        points.append([motion.move(shape.points) for motion, shape in zip(motions, take.held, strict=True)])
        rotation.append([motion.rotation @ shape.rotation for motion, shape in zip(motions, take.held, strict=True)])
    return np.array(points), np.array(rotation)


def _find_motions(
    plan: Plan, predicted: Predicted, take: TakeShapes, alignment: Alignment, notes: list[str]
) -> list[Motion]:
    """The motion of each shape into the model's frame."""
    if alignment.kind == "base":
        return [_put_base(plan.run, take, notes)] * len(take.held)
    chosen = np.array(alignment.sections or range(1, predicted.points.shape[1] + 1)) - 1
    if chosen.max() >= predicted.points.shape[1]:
        told = f"alignment is {alignment.told}; allowed: sections 1 to {predicted.points.shape[1]}, as the design has"
        raise TakeError(told)
    measured = np.array([shape.points[chosen] for shape in take.held])
    axes = np.array([shape.rotation[chosen] for shape in take.held])
    target, target_axes = predicted.points[:, chosen], predicted.rotation[:, chosen]
    try:
        if alignment.kind == "run":
            return [_fit(measured, target, axes, target_axes)] * len(take.held)
        return [_fit(*parts) for parts in zip(measured, target, axes, target_axes, strict=True)]
    except ShapeError as error:
        raise TakeError(f"alignment {alignment}: {error}", file=take.take.source) from None


def _fit(measured: np.ndarray, target: np.ndarray, axes: np.ndarray, target_axes: np.ndarray) -> Motion:
    """The motion that fits points; where they lie on a line, the sections' axes say how far to turn about it."""
    motion = fit_motion(measured, target)
    seen = np.isfinite(measured).all(axis=-1)
    if not is_straight(target[seen]) or not np.isfinite(axes[seen]).all(axis=(-2, -1)).any():
        return motion
    ends = (
        np.stack([m + _LEVER * a[..., 1], m + _LEVER * a[..., 2], m])
        for m, a in ((measured, axes), (target, target_axes))
    )
    return fit_motion(*ends)


def _put_base(run: Run, take: TakeShapes, notes: list[str]) -> Motion:
    """The motion that puts the base's rigid body where the model's base is."""
    points = np.array([shape.base_point for shape in take.held])
    rotation = mean_rotation(np.array([shape.base_rotation for shape in take.held]))
    seen = np.isfinite(points).all(axis=1)
    if not seen.any() or not np.isfinite(rotation).all():
        told = "alignment base: no rigid body with orientation at the trunk's base was seen in a held shape"
        allowed = "one named as base in the protocol, or alignment run or shape"
        raise TakeError(f"{told}; allowed: {allowed}", file=take.take.source)
    place = np.median(points[seen], axis=0)
    moved = float(np.linalg.norm(points[seen] - place, axis=1).max())
    if moved > _BASE_MOVED:
        notes.append(f"{take.take.source}: the base moved by {1e3 * moved:.1f} mm")
    turn = base_orientation(run.theta_0) @ rotation.T
    return Motion(rotation=turn, shift=-turn @ place)


def _gather(runs: Sequence[RunShapes], design: TrunkDesign) -> MeasuredShapes:
    """All shapes, run after run; within a run each follows the one before."""
    counts = [len(run.points) for run in runs]
    firsts = np.cumsum([0, *counts[:-1]])
    follows = [np.concatenate([[-1], np.arange(first, first + n - 1)]) for first, n in zip(firsts, counts, strict=True)]
    names = ["+".join(Path(take.take.source).name for take in run.takes) for run in runs]
    return MeasuredShapes(
        kind=tuple(run.plan.run.kind for run, n in zip(runs, counts, strict=True) for _ in range(n)),
        take=tuple(name for name, n in zip(names, counts, strict=True) for _ in range(n)),
        theta_0=np.repeat([run.plan.run.theta_0 for run in runs], counts),
        pull=np.concatenate([run.plan.pull for run in runs]), follows=np.concatenate(follows),
        marker_offset=compute_marker_offset(design), points=np.concatenate([run.points for run in runs]),
        rotation=np.concatenate([run.rotation for run in runs]),
    )  # fmt: skip
