"""Compiled entry point of the reference model: rest, dorsal, ventral or twist, single or batched."""

from __future__ import annotations

import math
from typing import NamedTuple, final

import numpy as np

from spiraltrunk.model.reference.algorithm_1 import bend_joints, lengthen, rest_gap, shorten
from spiraltrunk.model.reference.algorithm_2 import pull_second
from spiraltrunk.model.reference.constants import Table, compiled, unpack
from spiraltrunk.model.reference.gravity_rest import cos_sin, solve_rest

REST, DORSAL, VENTRAL, TWIST = range(4)
"""Laws of `solve`."""

_LEFT_OVER = 1e-4
"""Unused pull over the stroke above which a shape counts as ALL_SHUT: twice the authors' rounding [-]."""

_NEARLY = 1.0 - 1e-9
"""Bend over the joint limit from which the faces count as touching [-]."""


@final
class Results(NamedTuple):
    """Results of n shapes: the arrays of `Shape` with one leading axis."""

    points: np.ndarray
    rotation: np.ndarray
    angle: np.ndarray
    gap: np.ndarray
    change: np.ndarray
    shut: np.ndarray
    status: np.ndarray


@compiled
def _split(n: int, numbers: np.ndarray, n_joint: int, n_cable: int) -> Results:
    """The arrays of n results, one after the other in ``numbers``: those of `Prepared.layout`, then the flags."""
    a = 3 * n * (n_joint + 1)
    b = a + 9 * n * n_joint
    c = b + n * n_joint
    d = c + n * n_joint * n_cable
    flags = numbers[d + n * n_cable :].view(np.uint8)
    return Results(
        numbers[0:a].reshape(n, n_joint + 1, 3), numbers[a:b].reshape(n, n_joint, 3, 3),
        numbers[b:c].reshape(n, n_joint), numbers[c:d].reshape(n, n_joint, n_cable),
        numbers[d : d + n * n_cable].reshape(n, n_cable), flags[0 : n * n_joint].reshape(n, n_joint),
        flags[n * n_joint : n * n_joint + n],
    )  # fmt: skip


@compiled
def solve(law: int, inputs: np.ndarray, workspace: np.ndarray, constants: np.ndarray, numbers: np.ndarray) -> None:
    """Solve shapes one after the other; neighbours at the same theta_0 share their rest.

    No argument is a tuple and no array is allocated: for a single shape each takes as long as bending the joints.

    Args:
        law: one of REST, DORSAL, VENTRAL, TWIST.
        inputs: first pull [m], second pull [m] and theta_0 [rad], shape (n, 3).
        workspace: first shape and one beyond the last; the rest kept from one shape to the next: its theta_0 [rad], NaN
            at first, whether it converged, the sags [rad]; work arrays.
        constants: `Prepared.constants`.
        numbers: filled with the arrays of `Prepared.layout`, then, byte by byte, which faces touch and the status.
    """
    t = unpack(constants)
    n_joint, results = t.portion.size, _split(inputs.shape[0], numbers, t.beyond.shape[0], t.beyond.shape[1])
    kept, work = workspace[2 : 4 + n_joint], workspace[4 + n_joint :].reshape(11, n_joint)
    for k in range(int(workspace[0]), int(workspace[1])):
        theta_0 = inputs[k, 2]
        if theta_0 != kept[0]:
            kept[1] = 1.0 if solve_rest(theta_0, t, kept[2:], work[5:]) else 0.0
            kept[0] = theta_0
        for i in range(n_joint):
            work[0, i] = kept[2 + i]
        if law == TWIST:
            left = _bend(DORSAL, inputs[k, 0], t, work)
            left = max(left, pull_second(inputs[k, 1], t, work, results.rotation[k]))
            _finish_in_space(theta_0, t, results, k)
        else:
            left = _bend(law, inputs[k, 0], t, work)
            _finish_in_plane(theta_0, t, work, results, k)
        results.status[k] = (1 if left > _LEFT_OVER * t.total else 0) if kept[1] > 0.0 else 3


@compiled
def _bend(law: int, pull: float, t: Table, work: np.ndarray) -> float:
    """Planar bends with their cos and sin into ``work[2:5]``, gaps into ``work[1]``; returns the unused pull [m]."""
    sag, gap, bend, cos, sin = work[0], work[1], work[2], work[3], work[4]
    if law == REST:
        for i in range(sag.size):
            bend[i] = -sag[i]
        cos_sin(bend, t.limit, cos, sin)
        return 0.0
    rest_gap(t, sag, gap)
    left = lengthen(pull, t, gap) if law == VENTRAL else shorten(pull, t, gap)
    bend_joints(t, gap, bend, cos, sin)
    return left


@compiled
def _finish_in_plane(theta_0: float, t: Table, work: np.ndarray, results: Results, k: int) -> None:
    """Forward kinematics of planar shape ``k``: section ends, rotations, angles, contacts and cable lengths."""
    bend, cos, sin = work[2], work[3], work[4]
    points, rotation = results.points[k], results.rotation[k]
    c, s = math.cos(theta_0), -math.sin(theta_0)
    x, y = c * t.section_length[0], s * t.section_length[0]
    points[0, 0], points[0, 1], points[0, 2] = x, y, 0.0
    for i in range(bend.size):
        a, b = cos[i], sin[i]
        c, s = c * a - s * b, s * a + c * b
        x += c * t.section_length[i + 1]
        y += s * t.section_length[i + 1]
        points[i + 1, 0], points[i + 1, 1], points[i + 1, 2] = x, y, 0.0
        rotation[i, 0, 0], rotation[i, 0, 1], rotation[i, 0, 2] = a, -b, 0.0
        rotation[i, 1, 0], rotation[i, 1, 1], rotation[i, 1, 2] = b, a, 0.0
        rotation[i, 2, 0], rotation[i, 2, 1], rotation[i, 2, 2] = 0.0, 0.0, 1.0
        results.angle[k, i] = abs(bend[i])
        results.shut[k, i] = abs(bend[i]) >= _NEARLY * t.limit
    _cables(t, rotation, results.gap[k], results.change[k])


@compiled
def _finish_in_space(theta_0: float, t: Table, results: Results, k: int) -> None:
    """Forward kinematics of shape ``k`` from the rotations of its joints, as `_finish_in_plane`."""
    points, rotation = results.points[k], results.rotation[k]
    c, s = math.cos(theta_0), math.sin(theta_0)
    for a in range(3):
        x, y, z = (c, s, 0.0) if a == 0 else ((-s, c, 0.0) if a == 1 else (0.0, 0.0, 1.0))
        points[0, a] = x * t.section_length[0]
        for i in range(rotation.shape[0]):
            r = rotation[i]
            x, y, z = (
                x * r[0, 0] + y * r[1, 0] + z * r[2, 0],
                x * r[0, 1] + y * r[1, 1] + z * r[2, 1],
                x * r[0, 2] + y * r[1, 2] + z * r[2, 2],
            )
            points[i + 1, a] = points[i, a] + x * t.section_length[i + 1]
    for i in range(rotation.shape[0]):
        r = rotation[i]
        results.angle[k, i] = math.atan2(math.hypot(r[1, 0], r[2, 0]), r[0, 0])
        results.shut[k, i] = results.angle[k, i] >= _NEARLY * t.limit
    _cables(t, rotation, results.gap[k], results.change[k])


@compiled
def _cables(t: Table, rotation: np.ndarray, gap: np.ndarray, change: np.ndarray) -> None:
    """Lengths of the gaps and changes of the cables' lengths, from the rotations of the joints."""
    for j in range(change.size):
        change[j] = t.total
    for i in range(gap.shape[0]):
        r = rotation[i]
        for j in range(gap.shape[1]):
            to, back = t.beyond[i, j], t.before[i, j]
            x = r[0, 0] * to[0] + r[0, 1] * to[1] + r[0, 2] * to[2] - back[0]
            y = r[1, 0] * to[0] + r[1, 1] * to[1] + r[1, 2] * to[2] - back[1]
            z = r[2, 0] * to[0] + r[2, 1] * to[1] + r[2, 2] * to[2] - back[2]
            gap[i, j] = math.sqrt(x * x + y * y + z * z)
            change[j] -= gap[i, j]
