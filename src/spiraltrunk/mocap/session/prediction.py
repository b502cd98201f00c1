"""Predicted positions of the markers in a scheduled run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.files.results import Progress, ignore_progress
from spiraltrunk.mocap.protocol.protocol import Run
from spiraltrunk.mocap.protocol.schedule import Schedule, solve_reference
from spiraltrunk.model.kinematics.frames import base_orientation, section_frames
from spiraltrunk.model.kinematics.measured_shapes import compute_marker_offset
from spiraltrunk.model.kinematics.shape import Shape, Status
from spiraltrunk.model.statics import pull_sequences

MODELS = ("reference", "statics")
"""The paper's forward model, and the equilibrium of joints, weight and cables."""


@final
@dataclass(frozen=True, kw_only=True)
class Prediction:
    """Measured points by a model, in the frame of `Shape`."""

    points: np.ndarray
    """Shape (n, n_section, 3) [m]."""
    rotation: np.ndarray
    """Axes of the sections, shape (n, n_section, 3, 3) [-]."""
    warnings: tuple[str, ...]
    """Shapes for which the model did not converge."""


def predict(
    design: TrunkDesign, schedule: Schedule, *, model: str = "reference", friction: float | None = None,
    progress: Progress = ignore_progress,
) -> Prediction:  # fmt: skip
    """Positions and axes of the sections in a run's shapes.

    Both models are given the theoretical cable lengths, without slack compensation. With friction each shape is loaded
    from rest through all shapes before it.

    Args:
        design: the trunk.
        schedule: the winders' lengths.
        model: one of `MODELS`.
        friction: coefficient between cables and holes [-], for statics; None takes the design's.
        progress: called as the work goes on.
    """
    if model == "reference":
        shape = solve_reference(design, schedule.run, schedule.amount)
        rotations, status = shape.joint_rotation, np.asarray(shape.status)
    else:
        shapes, count = [], len(schedule.amount)
        for i, amount in enumerate(schedule.amount.tolist()):
            shapes.append(_solve_statics(design, schedule.run, amount, friction))
            progress(f"{model}, {schedule.run.name}", i + 1, count)
        rotations = np.stack([shape.joint_rotation for shape in shapes])
        status = np.array([int(shape.status) for shape in shapes])
    frames = base_orientation(schedule.run.theta_0) @ section_frames(design, rotations)[..., :3, :]
    axes, origin = frames[..., :3], frames[..., 3]
    warnings = tuple(
        f"{schedule.run.name}, shape {i + 1}: {Status(int(code)).advice}"
        for i, code in enumerate(status)
        if code not in (Status.CONVERGED, Status.ALL_SHUT)
    )
    points = origin + compute_marker_offset(design)[:, None] * axes[..., 0]
    return Prediction(points=points, rotation=axes, warnings=warnings)


def _solve_statics(design: TrunkDesign, run: Run, amount: float, friction: float | None) -> Shape:
    if run.kind == "bend-dorsal":
        return pull_sequences.pull_dorsal(design, amount, run.theta_0, friction=friction)
    if run.kind == "bend-ventral":
        return pull_sequences.pull_ventral(design, amount, run.theta_0, friction=friction)
    if run.kind == "twist":
        return pull_sequences.pull_twist(design, run.first, amount, run.theta_0, friction=friction)
    return pull_sequences.rest(design, run.theta_0, friction=friction)
