"""Where a model says that the markers of a planned run are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.mocap.protocol.schedule import Plan, solve_reference
from spiraltrunk.model.kinematics.frames import base_orientation, section_frames
from spiraltrunk.model.kinematics.measured_shapes import compute_marker_offset
from spiraltrunk.model.kinematics.shape import Shape, Status
from spiraltrunk.model.statics import pull_sequences

MODELS = ("reference", "statics")
"""The paper's forward model, and the equilibrium of joints, weight and cables."""

Watch = Callable[[int, int], None]
"""Called with how many shapes are solved and how many there are."""


@final
@dataclass(frozen=True, kw_only=True)
class Predicted:
    """Where a model says that the measured points are, in the frame of `Shape`."""

    points: np.ndarray
    """Shape (n, n_section, 3) [m]."""
    rotation: np.ndarray
    """Axes of the sections, shape (n, n_section, 3, 3) [-]."""
    troubles: tuple[str, ...]
    """Shapes that the model did not settle, in words."""


def predict(
    design: TrunkDesign, plan: Plan, *, model: str = "reference", friction: float | None = None,
    watch: Watch | None = None,
) -> Predicted:  # fmt: skip
    """Places and axes of the sections in a run's shapes.

    Both models are given what the trunk feels, slack made up for: the theoretical lengths. With friction each shape is
    loaded from rest through all that comes before it.

    Args:
        design: the trunk.
        plan: what the winders do.
        model: one of `MODELS`.
        friction: coefficient between cables and holes [-], statics alone; None takes the design's.
        watch: told how far the work has come.

    Raises:
        ModelError: for an unknown model, friction with the reference, or a trunk that the model does not know.
    """
    if model not in MODELS:
        raise ModelError(f"model is {model!r}; allowed: {', '.join(MODELS)}")
    if model == "reference" and friction is not None:
        raise ModelError("friction given with the model reference; allowed: with statics, reference knows none")
    if model == "reference":
        shape = solve_reference(design, plan.run, plan.amount)
        rotations, status = shape.joint_rotation, np.asarray(shape.status)
    else:
        rotations, status = _solve_steps(design, plan, friction, watch)
    frames = base_orientation(plan.run.theta_0) @ section_frames(design, rotations)[..., :3, :]
    axes, origin = frames[..., :3], frames[..., 3]
    points = origin + compute_marker_offset(design)[:, None] * axes[..., 0]
    troubles = tuple(
        f"{plan.run.name}, shape {i + 1}: {Status(int(code)).advice}"
        for i, code in enumerate(status)
        if code not in (Status.CONVERGED, Status.ALL_SHUT)
    )
    return Predicted(points=points, rotation=axes, troubles=troubles)


def _solve_steps(
    design: TrunkDesign, plan: Plan, friction: float | None, watch: Watch | None
) -> tuple[np.ndarray, np.ndarray]:
    """Turns of the joints in equilibrium, shape by shape, and how each ended."""
    shapes = []
    for i in range(len(plan.amount)):
        shapes.append(_solve_statics(design, plan, i, friction))
        if watch is not None:
            watch(i + 1, len(plan.amount))
    return np.stack([shape.joint_rotation for shape in shapes]), np.array([int(shape.status) for shape in shapes])


def _solve_statics(design: TrunkDesign, plan: Plan, i: int, friction: float | None) -> Shape:
    run, amount = plan.run, float(plan.amount[i])
    if run.kind == "bend-dorsal":
        return pull_sequences.pull_dorsal(design, amount, run.theta_0, friction=friction)
    if run.kind == "bend-ventral":
        return pull_sequences.pull_ventral(design, amount, run.theta_0, friction=friction)
    if run.kind == "twist":
        return pull_sequences.pull_twist(design, run.first, amount, run.theta_0, friction=friction)
    return pull_sequences.rest(design, run.theta_0, friction=friction)
