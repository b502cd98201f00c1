"""Registration of takes into the model's frame, and their average."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.errors import ShapeError, TakeError
from spiraltrunk.mocap.protocol.protocol import Run
from spiraltrunk.mocap.recordings.take import Take
from spiraltrunk.mocap.session.prediction import Prediction
from spiraltrunk.mocap.session.sections import HeldShape
from spiraltrunk.mocap.signal.registration import Alignment, Motion, fit_motion, is_straight, mean_rotation
from spiraltrunk.model.kinematics.frames import base_orientation

_BASE_MOTION = 2e-3
"""Motion of the base over a take from which it is noted [m] (ours)."""

_LEVER = 1e-3
"""Distance from a section's point of the points that stand for its axes [m]: too small to change the fit of the points
where they determine the rotation."""


@final
@dataclass(frozen=True, kw_only=True)
class TakeShapes:
    """Shapes of one recording, in its own frame, and its irregularities."""

    take: Take
    held: tuple[HeldShape, ...]
    notes: tuple[str, ...]


def average_takes(points: np.ndarray) -> np.ndarray:
    """Mean over the takes that saw a point, not a number where none did, shape (n, n_section, 3) [m]."""
    with np.errstate(invalid="ignore"):
        mean: np.ndarray = np.nansum(points, axis=0) / np.isfinite(points).sum(axis=0)
    return mean


def register(
    run: Run, predicted: Prediction, takes: Sequence[TakeShapes], alignment: Alignment
) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Points and axes of all takes in the model's frame, shapes (n_take, n, n_section, 3 [, 3]) [m], [-], and notes."""
    points, rotation = [], []
    motions, notes = find_motions(run, predicted, takes, alignment)
    for take, own in zip(takes, motions, strict=True):
        points.append([motion.move(shape.points) for motion, shape in zip(own, take.held, strict=True)])
        rotation.append([motion.rotation @ shape.rotation for motion, shape in zip(own, take.held, strict=True)])
    return np.array(points), np.array(rotation), notes


def find_motions(
    run: Run, predicted: Prediction, takes: Sequence[TakeShapes], alignment: Alignment
) -> tuple[list[list[Motion]], list[str]]:
    """Motion of each shape of each take into the model's frame, and notes."""
    found: list[list[Motion]] = []
    notes: list[str] = []
    for take in takes:
        if alignment.kind == "base":
            motion, moved = _place_base(run, take)
            found, notes = [*found, [motion] * len(take.held)], notes + moved
        else:
            found.append(_fit_shapes(predicted, take, alignment))
    return found, notes


def _fit_shapes(predicted: Prediction, take: TakeShapes, alignment: Alignment) -> list[Motion]:
    """The motion of each shape into the model's frame, fitted to the prediction."""
    chosen = np.array(alignment.sections or range(1, predicted.points.shape[1] + 1)) - 1
    if chosen.max() >= predicted.points.shape[1]:
        allowed = f"sections 1 to {predicted.points.shape[1]}, as the design has"
        raise TakeError(f"alignment has section {chosen.max() + 1}; allowed: {allowed}")
    parts = (
        np.array([shape.points[chosen] for shape in take.held]), predicted.points[:, chosen],
        np.array([shape.rotation[chosen] for shape in take.held]), predicted.rotation[:, chosen],
    )  # fmt: skip
    try:
        if alignment.kind == "run":
            return [_fit(*parts)] * len(take.held)
        return [_fit(*each) for each in zip(*parts, strict=True)]
    except ShapeError as error:
        raise TakeError(f"alignment {alignment}: {error}", file=take.take.source) from None


def _fit(measured: np.ndarray, target: np.ndarray, axes: np.ndarray, target_axes: np.ndarray) -> Motion:
    """The motion that fits points; for collinear points the sections' axes determine the rotation about their line."""
    motion = fit_motion(measured, target)
    seen = np.isfinite(measured).all(axis=-1)
    if not is_straight(target[seen]) or not np.isfinite(axes[seen]).all(axis=(-2, -1)).any():
        return motion
    ends = (
        np.stack([m + _LEVER * a[..., 1], m + _LEVER * a[..., 2], m])
        for m, a in ((measured, axes), (target, target_axes))
    )
    return fit_motion(*ends)


def _place_base(run: Run, take: TakeShapes) -> tuple[Motion, list[str]]:
    """The motion that moves the base's rigid body to the model's base, and a note where the base moved in the take."""
    points = np.array([shape.base_point for shape in take.held])
    rotation = mean_rotation(np.array([shape.base_rotation for shape in take.held]))
    seen = np.isfinite(points).all(axis=1)
    if not seen.any() or not np.isfinite(rotation).all():
        reason = "alignment base: no rigid body with orientation at the trunk's base was seen in a held shape"
        allowed = "one named as base in the protocol, or alignment run or shape"
        raise TakeError(f"{reason}; allowed: {allowed}", file=take.take.source)
    place = np.median(points[seen], axis=0)
    moved = float(np.linalg.norm(points[seen] - place, axis=1).max())
    notes = [f"{take.take.source}: the base moved by {1e3 * moved:.1f} mm"] if moved > _BASE_MOTION else []
    turn = base_orientation(run.theta_0) @ rotation.T
    return Motion(rotation=turn, shift=-turn @ place), notes
