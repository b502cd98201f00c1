"""Compliance matrix of the tip, with cable lengths and the active set of joints held."""

from __future__ import annotations

from spiraltrunk.model.statics.kernels import compiled
from spiraltrunk.model.statics.kernels.cholesky import copy_rows, dot, solve_columns, solve_small
from spiraltrunk.model.statics.kernels.laws.gravity_load import spin
from spiraltrunk.model.statics.kernels.newton_calls import complement, factorise_held, linearise_stuck

HELD = 1e4
"""Penalty on the cables' lengths with which the Hessian is factorised [N/m]; they are then held exactly."""


@compiled
def tip_motion(work, length, out):
    """Motion of the tip per rate of every bend, in the world's axes, shape (3, n_joint x nd) [m]."""
    n_joint, nd = work.first.shape[0], work.first.shape[1]
    lever = work.vectors[0]
    lever[:] = 0.0
    for i in range(n_joint - 1, -1, -1):
        for x in range(3):
            lever[x] += length[i + 1] * work.frames[i + 1, x, 0]
        for a in range(nd):
            w0, w1, w2 = spin(work.first[i, a], work.rotation[i], work.frames[i])
            out[0, i * nd + a] = w1 * lever[2] - w2 * lever[1]
            out[1, i * nd + a] = w2 * lever[0] - w0 * lever[2]
            out[2, i * nd + a] = w0 * lever[1] - w1 * lever[0]


@compiled
def reduce_motion(motion, nd, system):
    """Reduce the motion to the active set: the tangent of a joint at its limit only, in place."""
    for i in range(system.pressed.shape[0]):
        if system.pressed[i]:
            cosine, sine = system.normal[i, 0], system.normal[i, 1]
            y, z = i * nd, i * nd + 1
            for x in range(3):
                motion[x, z] = cosine * motion[x, z] - sine * motion[x, y]
                motion[x, y] = 0.0


@compiled
def tip_compliance(q, tension, case, work, system, out):
    """Displacement of the tip per force on it into ``out`` (3, 3) [m/N], at a solution just found; holes stick."""
    motion, columns = system.motion, system.columns
    if case.friction.stiffness > 0:  # The friction forces were updated after the last linearisation.
        linearise_stuck(q, tension, case, work, system)
    tip_motion(work, case.trunk.length, motion)
    reduce_motion(motion, work.first.shape[1], system)
    factorise_held(q, tension, case, HELD, work, system)
    for row in range(columns.shape[0]):
        for x in range(3):
            columns[row, x] = motion[x, row]
        columns[row, 3] = 0.0
    solve_columns(work.factor, columns)
    for x in range(3):
        for y in range(3):
            out[x, y] = dot(motion[x], columns[:, y])
    _hold_cables(q, motion, case, work, system, out)


@compiled
def _hold_cables(q, motion, case, work, system, out):
    """Subtract the motion that would lengthen the active cables, by their Schur complement."""
    right, count = system.keep, complement(q, case, HELD, work, system)
    for x in range(3):
        for a in range(count):
            right[a] = dot(motion[x], system.response[a])
        copy_rows(system.matrix, system.copied)
        solve_small(system.copied, right, count)
        for y in range(3):
            for a in range(count):
                out[x, y] -= right[a] * dot(motion[y], system.response[a])
