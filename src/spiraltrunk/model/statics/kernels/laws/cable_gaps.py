"""A cable across one gap: its length, the derivatives by the joint's bends, and the turns at the two holes.

The gap vector v = R m - p runs from the hole p before the joint to the hole m beyond it, both from the joint's centre.
The length is sqrt(|v|^2 + shut^2), which is smooth where the gap closes; ``shut`` is a micrometre, and more while a
solution near that kink is sought. |v|^2 is summed from the vector, since |p|^2 + |m|^2 - 2 p . R m cancels there.
"""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.model.statics.kernels import compiled, owning

NARROW = 1e-4
"""Length of a gap below which the direction of its cable is blended into that of the sections [m]."""


@compiled
def product(p, matrix, m):
    """p . ``matrix`` m."""
    total = 0.0
    for i in range(3):
        total += p[i] * (matrix[i, 0] * m[0] + matrix[i, 1] * m[1] + matrix[i, 2] * m[2])
    return total


@compiled
def gap_length(rotation, p, m, shut, v):
    """Length of the gap [m]; ``v`` receives the gap vector."""
    total = shut * shut
    for i in range(3):
        v[i] = rotation[i, 0] * m[0] + rotation[i, 1] * m[1] + rotation[i, 2] * m[2] - p[i]
        total += v[i] * v[i]
    return math.sqrt(total)


@compiled
def differentiate_gap(first, second, p, m, length, v, slope, curve):
    """First and second derivatives of the length into ``slope`` (nd) and ``curve`` (nd, nd), of pairs a >= b alone."""
    for a in range(first.shape[0]):
        slope[a] = product(v, first[a], m) / length
        for b in range(a + 1):
            curve[a, b] = (-product(p, second[a, b], m) - slope[a] * slope[b]) / length


@compiled
def hole_turns(rotation, p, m, v):
    """Angles by which the cable turns at the hole before the joint and at the hole beyond it [rad].

    Inside a section the cable runs along the axis. Below `NARROW`, where the gap vector loses its direction, the mean
    of the two axes is blended in.
    """
    size = gap_length(rotation, p, m, 0.0, v)
    x, y, z = rotation[0, 0], rotation[1, 0], rotation[2, 0]
    share = NARROW * math.exp(-((size / NARROW) ** 2)) / math.sqrt((1 + x) ** 2 + y * y + z * z)
    v[0] += share * (1 + x)
    v[1] += share * y
    v[2] += share * z
    length = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    return _angle(v, 1.0, 0.0, 0.0, length), _angle(v, x, y, z, length)


@compiled
def _angle(v, x, y, z, length):
    """Angle between v and the unit vector (x, y, z): 2 atan2(|a - b|, |a + b|) of vectors of one length."""
    less = math.sqrt((v[0] - length * x) ** 2 + (v[1] - length * y) ** 2 + (v[2] - length * z) ** 2)
    more = math.sqrt((v[0] + length * x) ** 2 + (v[1] + length * y) ** 2 + (v[2] + length * z) ** 2)
    return 2 * math.atan2(less, more)


@compiled
def measure_turns(trunk, work):
    """Turn w_k of every cable before each gap, the sum of the turns at two holes, into ``work.turn`` [rad]."""
    turns, v = work.turn, work.vectors[0]
    for c in range(turns.shape[1]):
        last = 0.0
        for i in range(turns.shape[0]):
            before, beyond = hole_turns(work.rotation[i], trunk.rub_before[i, c], trunk.rub_beyond[i, c], v)
            turns[i, c] = last + before
            last = beyond


@owning
def find_hole_turns(rotation, before, beyond):
    """`hole_turns` of all joints and cables, two arrays of shape (n_joint, n_cable) [rad]."""
    near, far, v = np.empty(before.shape[:2]), np.empty(before.shape[:2]), np.empty(3)
    for i in range(near.shape[0]):
        for c in range(near.shape[1]):
            near[i, c], far[i, c] = hole_turns(rotation[i], before[i, c], beyond[i, c], v)
    return near, far
