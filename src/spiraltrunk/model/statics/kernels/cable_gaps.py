"""A cable across one gap: its length, its derivatives by the joint's bends, and the turns at the two holes.

The gap vector v = R m - p runs from the hole p before the joint to the hole m beyond it, both from the joint's centre.
Its length is taken from the vector itself and not from |p|^2 + |m|^2 - 2 p . R m, which loses every digit where the gap
shuts. It is sqrt(|v|^2 + shut^2), so that a shut gap keeps a direction; ``shut`` is a micrometre, and more while a
solution is sought that lies in the corner of that root.
"""

from __future__ import annotations

import math

from spiraltrunk.model.statics.kernels import compiled

NARROW = 1e-4
"""Length of a gap below which its direction is taken from the sections [m]."""


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
    """Derivatives of the length into ``slope`` (nd) and ``curve`` (nd, nd); half of |v|^2 curves as -p . R m."""
    for a in range(first.shape[0]):
        slope[a] = product(v, first[a], m) / length
        for b in range(a + 1):
            curve[a, b] = (-product(p, second[a, b], m) - slope[a] * slope[b]) / length


@compiled
def hole_turns(rotation, p, m, v):
    """Angles by which the cable turns at the hole before the joint and at the hole beyond it [rad].

    Inside a section the cable runs along the axis. A gap about to shut runs along the mean of the two axes; that
    mean is blended in below `NARROW`, where the gap vector itself loses its direction.
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
