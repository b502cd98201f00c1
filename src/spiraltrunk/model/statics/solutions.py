"""Arrays of the solutions that the kernels fill, one row for each equilibrium, and the shapes built from them."""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.model.kinematics.shape import Forces, History, Shape, build
from spiraltrunk.model.statics.kernels.batch import Solution
from spiraltrunk.model.statics.kernels.laws.energy import Trunk


def allocate(trunk: Trunk, rows: int) -> Solution:
    """Arrays for solutions; bends, tensions and anchors are 0, the others are not set."""
    joints, count = trunk.before.shape[:2]
    return Solution(
        np.zeros((rows, joints, 3)), np.zeros((rows, count)), np.zeros((rows, joints, count)),
        np.empty((rows, joints, 3, 3)), np.empty((rows, joints + 1, 3)), np.empty((rows, joints, count)),
        np.empty((rows, joints, count)), np.empty((rows, joints)), np.empty((rows, 3, 3)), np.empty((rows, 3)),
        np.empty((rows, joints)), np.empty((rows, count)), np.empty((rows, joints), np.bool_), np.empty(rows, np.int64),
    )  # fmt: skip


def build_shape(solution: Solution, batch: tuple[int, ...]) -> Shape:
    """Shapes of the solutions; the rows are along the batch axes."""
    residual, status = solution.figures[:, 0].reshape(batch), solution.status.reshape(batch)
    each = [array.reshape((*batch, *array.shape[1:])) if batch else array[0] for array in solution]
    solution = Solution(*each)
    forces = {
        "cable_tension": solution.tension, "gap_tension": solution.gap_tension, "limit_reaction": solution.reaction,
        "tip_compliance": solution.compliance, "residual": residual,
    }  # fmt: skip
    return build(
        Shape,
        {
            "points": solution.points, "joint_rotation": solution.rotation, "joint_angle": solution.angle,
            "gap": solution.gap, "cable_change": solution.change, "is_shut": solution.shut, "status": status,
            "forces": build(Forces, forces),
            "history": build(History, {"bend": solution.bend, "anchor": solution.anchor}),
        },
    )  # fmt: skip


def to_rows(array: np.ndarray, batch: tuple[int, ...], own: int) -> np.ndarray:
    """A copy of an array for each row of the batch; its last ``own`` axes do not belong to the batch.

    Returns:
        Shape (rows, own axes).
    """
    if not batch:
        return array.copy()[None]
    tail = array.shape[array.ndim - own :]
    return np.array(np.broadcast_to(array, (*batch, *tail)), order="C").reshape(math.prod(batch), *tail)
