"""Measured and predicted shapes of each run, ready to be drawn over each other at any moment of a take."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.mocap.session.sections import find_sections
from spiraltrunk.mocap.session.session import RunShapes
from spiraltrunk.mocap.session.take_registration import TakeShapes, find_motions
from spiraltrunk.mocap.signal.deviation import Deviation
from spiraltrunk.mocap.signal.registration import Motion
from spiraltrunk.workflows.validate.comparison import Comparison, compute_tilt_deg

MOST_MOMENTS = 6000
"""Moments of a take that are kept; of longer takes every second frame, every third and so on [-]."""

_STEPS = {"bend-dorsal": "cable 1 in by", "bend-ventral": "cable 1 out by", "twist": "cable 2 in by"}


@final
@dataclass(frozen=True, kw_only=True)
class TakeOverlay:
    """One take over time."""

    source: str
    """Its file."""
    time: np.ndarray
    """Moments, shape (m,) [s]."""
    points: np.ndarray
    """Measured points in the model's frame, not a number in gaps, shape (m, n_section, 3) [m]."""
    shape: np.ndarray
    """Index of the shape that is held, or the nearest one in time while the trunk moves, shape (m,) [-]."""
    is_held: np.ndarray
    """Whether the shape is held, shape (m,) [bool]."""
    recorded: np.ndarray
    """Which sections were recorded at all, shape (n_section,) [bool]."""

    def list_gaps(self, moment: int) -> list[int]:
        """Recorded sections that were not seen at a moment, from 1."""
        is_seen = np.isfinite(self.points[moment]).all(axis=-1)
        return [int(section) + 1 for section in np.flatnonzero(self.recorded & ~is_seen)]


@final
@dataclass(frozen=True, kw_only=True)
class RunOverlay:
    """One run; frame of `Shape`."""

    name: str
    """Its name."""
    labels: tuple[str, ...]
    """What was done for each of its n shapes."""
    theta_0: float
    """Angle of the base axis below the horizontal [rad]."""
    predicted: np.ndarray
    """Points by the model, shape (n, n_section, 3) [m]."""
    rotation: np.ndarray
    """Axes of the sections by the model, shape (n, n_section, 3, 3) [-]."""
    deviation: Deviation
    """Distances of the held shapes, means of the takes, from the model."""
    takes: tuple[TakeOverlay, ...]
    """Its takes."""

    def compute_distance(self, take: int) -> np.ndarray:
        """Distances of a take's points from the model's shape at each moment, not a number in gaps, (m, n_section) [m].

        While the trunk moves from shape to shape, the model's is the nearest in time.
        """
        one = self.takes[take]
        return np.asarray(np.linalg.norm(one.points - self.predicted[one.shape], axis=-1))


def build_overlays(comparison: Comparison) -> tuple[RunOverlay, ...]:
    """The runs of a comparison, in the protocol's order."""
    return tuple(
        _build_run(comparison, run, deviation)
        for run, deviation in zip(comparison.session.runs, comparison.deviations, strict=True)
    )


def _build_run(comparison: Comparison, run: RunShapes, deviation: Deviation) -> RunOverlay:
    kind, planned = run.schedule.run.kind, run.schedule.run
    if kind == "rest":
        labels = [f"rest, tilt {compute_tilt_deg(run):g} deg"] * len(run.points)
    else:
        labels = [f"{_STEPS[kind]} {1e3 * amount:g} mm" for amount in run.schedule.amount]
    motions, _ = find_motions(planned, run.predicted, run.takes, comparison.session.alignment)
    takes = tuple(_build_take(comparison, take, own) for take, own in zip(run.takes, motions, strict=True))
    return RunOverlay(
        name=planned.name, labels=tuple(labels), theta_0=planned.theta_0, predicted=run.predicted.points,
        rotation=run.predicted.rotation, deviation=deviation, takes=takes,
    )  # fmt: skip


def _build_take(comparison: Comparison, take: TakeShapes, motions: list[Motion]) -> TakeOverlay:
    points = find_sections(take.take, comparison.settings.design, comparison.protocol).points
    step = max(1, -(-len(points) // MOST_MOMENTS))
    time, points = take.take.time[::step], points[::step]
    begin, end = (np.array([getattr(shape, name) for shape in take.held]) for name in ("begin", "end"))
    outside = np.maximum(begin - time[:, None], time[:, None] - end)
    shape = outside.argmin(axis=1)
    moved = np.full(points.shape, np.nan)
    for index, motion in enumerate(motions):
        own = shape == index
        moved[own] = motion.move(points[own])
    return TakeOverlay(
        source=take.take.source, time=time, points=moved, shape=shape, is_held=outside.min(axis=1) <= 0.0,
        recorded=np.isfinite(points).all(axis=-1).any(axis=0),
    )  # fmt: skip
