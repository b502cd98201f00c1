"""Compiled entry point of the reference model: rest, dorsal, ventral or twist, single or batched."""

from __future__ import annotations

import math
from typing import NamedTuple, final

import numpy as np

from spiraltrunk.model.reference.algorithm_1 import bends, lengthen, rest_gap, shorten
from spiraltrunk.model.reference.algorithm_2 import wind
from spiraltrunk.model.reference.constants import Table, compiled, unpack
from spiraltrunk.model.reference.gravity_rest import settle, turns

REST, DORSAL, VENTRAL, TWIST = range(4)
"""The laws."""

_LEFT_OVER = 1e-4
"""Cable left over, in parts of the stroke, from which a shape counts as all shut: twice the authors' rounding [-]."""

_NEARLY = 1.0 - 1e-9
"""Part of the limit from which the faces at a joint count as meeting [-]."""


@final
class Slots(NamedTuple):
    """Where the answers go: the arrays of `Shape` with one leading axis, n."""

    points: np.ndarray
    rotation: np.ndarray
    angle: np.ndarray
    gap: np.ndarray
    change: np.ndarray
    shut: np.ndarray
    status: np.ndarray


@compiled
def _slots(n: int, numbers: np.ndarray, n_joint: int, n_cable: int) -> Slots:
    """The arrays of `n` answers, one after the other in ``numbers``: those of `Prepared.layout`, then the marks."""
    a = 3 * n * (n_joint + 1)
    b = a + 9 * n * n_joint
    c = b + n * n_joint
    d = c + n * n_joint * n_cable
    marks = numbers[d + n * n_cable :].view(np.uint8)
    return Slots(
        numbers[0:a].reshape(n, n_joint + 1, 3),
        numbers[a:b].reshape(n, n_joint, 3, 3),
        numbers[b:c].reshape(n, n_joint),
        numbers[c:d].reshape(n, n_joint, n_cable),
        numbers[d : d + n * n_cable].reshape(n, n_cable),
        marks[0 : n * n_joint].reshape(n, n_joint),
        marks[n * n_joint : n * n_joint + n],
    )


@compiled
def solve(law: int, asked: np.ndarray, desk: np.ndarray, constants: np.ndarray, answers: np.ndarray) -> None:
    """Solve shapes one after the other; neighbours at the same theta_0 share their rest.

    No tuple among the arguments and no array made: for a single shape each costs as much as bending the joints.

    Args:
        law: one of REST, DORSAL, VENTRAL, TWIST.
        asked: first pull [m], second pull [m] and theta_0 [rad], shape (n, 3).
        desk: the first shape to be solved, one beyond the last; the rest kept from one shape to the next: its theta_0
            [rad], not a number at first, whether it converged, the sags [rad]; room; `Prepared.build_desk`.
        constants: numbers of the design, from `Prepared`.
        answers: filled with the arrays of `Prepared.layout`, then, byte by byte, which faces meet and the status.
    """
    t = unpack(constants)
    slots = _slots(asked.shape[0], answers, t.beyond.shape[0], t.beyond.shape[1])
    n_joint = t.portion.size
    kept, work = desk[2 : 4 + n_joint], desk[4 + n_joint :].reshape(11, n_joint)
    for k in range(int(desk[0]), int(desk[1])):
        theta_0 = asked[k, 2]
        if theta_0 != kept[0]:
            kept[1] = 1.0 if settle(theta_0, t, kept[2:], work[5:]) else 0.0
            kept[0] = theta_0
        for i in range(t.portion.size):
            work[0, i] = kept[2 + i]
        if law == TWIST:
            left = _twist(asked[k, 0], asked[k, 1], t, work, slots.rotation[k])
            _finish_in_space(theta_0, t, slots, k)
        else:
            left = _bend(law, asked[k, 0], t, work)
            _finish_in_plane(theta_0, t, work, slots, k)
        slots.status[k] = (1 if left > _LEFT_OVER * t.total else 0) if kept[1] > 0.0 else 3


@compiled
def _bend(law: int, pull: float, t: Table, work: np.ndarray) -> float:
    """Plane bends into ``work[2]``, cos and sin below it, gaps above; the cable left over [m]."""
    sag, gap, bend, cos, sin = work[0], work[1], work[2], work[3], work[4]
    if law == REST:
        for i in range(sag.size):
            bend[i] = -sag[i]
        turns(bend, t.limit, cos, sin)
        return 0.0
    rest_gap(t, sag, gap)
    left = lengthen(pull, t, gap) if law == VENTRAL else shorten(pull, t, gap)
    bends(t, gap, bend, cos, sin)
    return left


@compiled
def _twist(first: float, second: float, t: Table, work: np.ndarray, rotation: np.ndarray) -> float:
    """Algorithm 2: joint rotations after cable 1, then cable 2; returns the larger unused pull [m]."""
    left = _bend(DORSAL, first, t, work)
    return max(left, wind(second, t, work, rotation))


@compiled
def _finish_in_plane(theta_0: float, t: Table, work: np.ndarray, slots: Slots, k: int) -> None:
    """Forward kinematics of planar shape ``k``: section ends, rotations, angles, contacts and cable lengths."""
    bend, cos, sin = work[2], work[3], work[4]
    points, rotation = slots.points[k], slots.rotation[k]
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
        slots.angle[k, i] = abs(bend[i])
        slots.shut[k, i] = abs(bend[i]) >= _NEARLY * t.limit
    _cables(t, rotation, slots.gap[k], slots.change[k])


@compiled
def _finish_in_space(theta_0: float, t: Table, slots: Slots, k: int) -> None:
    """Everything of shape ``k`` that follows from its joints' rotations."""
    points, rotation = slots.points[k], slots.rotation[k]
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
        slots.angle[k, i] = math.atan2(math.hypot(r[1, 0], r[2, 0]), r[0, 0])
        slots.shut[k, i] = slots.angle[k, i] >= _NEARLY * t.limit
    _cables(t, rotation, slots.gap[k], slots.change[k])


@compiled
def _cables(t: Table, rotation: np.ndarray, gap: np.ndarray, change: np.ndarray) -> None:
    """Distances of the holes across each gap and what each cable gave, from the joints' rotations."""
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
