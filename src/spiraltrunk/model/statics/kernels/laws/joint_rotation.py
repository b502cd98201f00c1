"""Rotation matrix of a joint from its bends, with first and second derivatives.

Three kinds of joint: ``VECTOR`` rotates by the vector b = (0, q_y, q_z) without torsion, R = C I + S [b] + D b b^T
(Rodrigues), with C = cos(sqrt u), S = sin(sqrt u) / sqrt u, D = (1 - C) / u, smooth functions of u = |b|^2; a third
bend q_x, if any, follows as torsion about the distal section's axis. ``Z_FIRST`` and ``Y_FIRST`` are two hinges in
series, as in the simulation.
"""

from __future__ import annotations

import math

from spiraltrunk.model.statics.kernels import compiled

VECTOR, Z_FIRST, Y_FIRST = 0, 1, 2

_SERIES_BELOW = 0.05
"""Below this u the coefficients are summed as series, since their closed forms cancel [rad^2]."""


@compiled
def coefficients(u):
    """C, S, D and their first and second derivatives by u: (C, S, D, S', D', S'', D''); C' = -S / 2, C'' = -S' / 2."""
    if u < _SERIES_BELOW:
        c = 1.0 - u / 2 * (1.0 - u / 12 * (1.0 - u / 30 * (1.0 - u / 56 * (1.0 - u / 90))))
        s = 1.0 - u / 6 * (1.0 - u / 20 * (1.0 - u / 42 * (1.0 - u / 72 * (1.0 - u / 110))))
        d = 0.5 * (1.0 - u / 12 * (1.0 - u / 30 * (1.0 - u / 56 * (1.0 - u / 90 * (1.0 - u / 132)))))
        s1 = -1 / 6 + u * (1 / 60 + u * (-1 / 1680 + u * (1 / 90720 - u / 7983360)))
        d1 = -1 / 24 + u * (1 / 360 + u * (-1 / 13440 + u * (1 / 907200 - u / 95800320)))
        s2 = 1 / 60 + u * (-1 / 840 + u * (1 / 30240 - u / 1995840))
        d2 = 1 / 360 + u * (-1 / 6720 + u * (1 / 302400 - u / 23950080))
        return c, s, d, s1, d1, s2, d2
    t = math.sqrt(u)
    c, s = math.cos(t), math.sin(t) / t
    d = (1.0 - c) / u
    s1, d1 = (c - s) / (2 * u), (s - 2 * d) / (2 * u)
    return c, s, d, s1, d1, (-s / 2 - 3 * s1) / (2 * u), (s1 - 4 * d1) / (2 * u)


@compiled
def rotate(q, kind, nd, out):
    """Rotation of one joint into ``out`` (3, 3)."""
    y, z = q[0], q[1]
    if kind == VECTOR:
        k = coefficients(y * y + z * z)
        _fill(y, z, k[0], k[1], k[2], out)
        if nd == 3:
            _twist(q[2], out)
    else:
        _hinges(kind, math.cos(y), math.sin(y), math.cos(z), math.sin(z), 1.0, 1.0, out)


@compiled
def differentiate(q, kind, nd, first, second):
    """First (nd, 3, 3) and second (nd, nd, 3, 3) derivatives of one joint's rotation; pairs a >= b only."""
    if kind == VECTOR:
        _differentiate_vector(q[0], q[1], first, second)
        if nd == 3:
            _differentiate_torsion(q, first, second)
    else:
        _differentiate_hinges(kind, q[0], q[1], first, second)


@compiled
def _fill(y, z, c, s, d, out):
    """c I + s [b] + d b b^T."""
    out[0, 0], out[0, 1], out[0, 2] = c, -s * z, s * y
    out[1, 0], out[1, 1], out[1, 2] = s * z, c + d * y * y, d * y * z
    out[2, 0], out[2, 1], out[2, 2] = -s * y, d * y * z, c + d * z * z


@compiled
def _add_mixed(y, z, a, s, d, share, out):
    """Add ``share`` times s [e_a] + d (e_a b^T + b e_a^T), a = 0 for y and 1 for z."""
    if a == 0:
        out[0, 2] += share * s
        out[2, 0] -= share * s
        out[1, 1] += share * 2 * d * y
        out[1, 2] += share * d * z
        out[2, 1] += share * d * z
    else:
        out[0, 1] -= share * s
        out[1, 0] += share * s
        out[2, 2] += share * 2 * d * z
        out[1, 2] += share * d * y
        out[2, 1] += share * d * y


@compiled
def _differentiate_vector(y, z, first, second):
    _, s, d, s1, d1, s2, d2 = coefficients(y * y + z * z)
    c1, c2 = -s / 2, -s1 / 2
    for a in range(2):
        qa = y if a == 0 else z
        _fill(y, z, 2 * qa * c1, 2 * qa * s1, 2 * qa * d1, first[a])
        _add_mixed(y, z, a, s, d, 1.0, first[a])
        for b in range(a + 1):
            qb = y if b == 0 else z
            same = 2.0 if a == b else 0.0
            _fill(
                y, z, same * c1 + 4 * qa * qb * c2, same * s1 + 4 * qa * qb * s2, same * d1 + 4 * qa * qb * d2,
                second[a, b],
            )  # fmt: skip
            _add_mixed(y, z, b, s1, d1, 2 * qa, second[a, b])
            _add_mixed(y, z, a, s1, d1, 2 * qb, second[a, b])
            second[a, b, 1 + a, 1 + b] += d
            second[a, b, 1 + b, 1 + a] += d


@compiled
def _twist(angle, out):
    """Rotate ``out`` about its own x axis."""
    c, s = math.cos(angle), math.sin(angle)
    for i in range(3):
        dorsal, side = out[i, 1], out[i, 2]
        out[i, 1], out[i, 2] = c * dorsal + s * side, c * side - s * dorsal


@compiled
def _by_torsion(matrix, out):
    """Derivative of ``matrix`` by the torsion after it: ``out`` = ``matrix`` [e_x]."""
    for i in range(3):
        out[i, 0], out[i, 1], out[i, 2] = 0.0, matrix[i, 2], -matrix[i, 1]


@compiled
def _differentiate_torsion(q, first, second):
    k = coefficients(q[0] * q[0] + q[1] * q[1])
    _fill(q[0], q[1], k[0], k[1], k[2], second[2, 2])
    _twist(q[2], second[2, 2])
    _by_torsion(second[2, 2], first[2])
    _by_torsion(first[2], second[2, 2])
    for a in range(2):
        _twist(q[2], first[a])
        _by_torsion(first[a], second[2, a])
        for b in range(a + 1):
            _twist(q[2], second[a, b])


@compiled
def _hinges(kind, cy, sy, cz, sz, keep_y, keep_z, out):
    """Rotation about z then y, or y then z; in a derivative by y, ``keep_y`` = 0 drops the constant entries, so z."""
    out[0, 0] = cy * cz
    if kind == Z_FIRST:
        out[0, 1], out[0, 2] = -sz * keep_y, cz * sy
        out[1, 0], out[1, 1], out[1, 2] = sz * cy, cz * keep_y, sz * sy
        out[2, 0], out[2, 1], out[2, 2] = -sy * keep_z, 0.0, cy * keep_z
    else:
        out[0, 1], out[0, 2] = -cy * sz, sy * keep_z
        out[1, 0], out[1, 1], out[1, 2] = sz * keep_y, cz * keep_y, 0.0
        out[2, 0], out[2, 1], out[2, 2] = -sy * cz, sy * sz, cy * keep_z


@compiled
def _differentiate_hinges(kind, y, z, first, second):
    """By the chain rule: (cos, sin) of the angle become (-sin, cos), and constant entries 0."""
    cy, sy, cz, sz = math.cos(y), math.sin(y), math.cos(z), math.sin(z)
    _hinges(kind, -sy, cy, cz, sz, 0.0, 1.0, first[0])
    _hinges(kind, cy, sy, -sz, cz, 1.0, 0.0, first[1])
    _hinges(kind, -cy, -sy, cz, sz, 0.0, 1.0, second[0, 0])
    _hinges(kind, -sy, cy, -sz, cz, 0.0, 0.0, second[1, 0])
    _hinges(kind, cy, sy, -cz, -sz, 1.0, 0.0, second[1, 1])


@compiled
def bend_size(q, kind, rim):
    """Angle between the axes of the two sections [rad], not 0.

    ``rim`` receives its derivatives by y and z and its second derivative along the rim.
    """
    y, z = q[0], q[1]
    if kind == VECTOR:
        size = math.sqrt(y * y + z * z)
        rim[0], rim[1], rim[2] = y / size, z / size, 1 / size
        return size
    cosine = math.cos(y) * math.cos(z)
    size = math.acos(min(cosine, 1.0))
    sine = math.sin(size)
    by_y, by_z = math.sin(y) * math.cos(z) / sine, math.cos(y) * math.sin(z) / sine
    yy, yz = (cosine - cosine * by_y * by_y) / sine, (-math.sin(y) * math.sin(z) - cosine * by_y * by_z) / sine
    zz = (cosine - cosine * by_z * by_z) / sine
    rim[0], rim[1] = by_y, by_z
    rim[2] = (yy * by_z * by_z - 2 * yz * by_y * by_z + zz * by_y * by_y) / (by_y * by_y + by_z * by_z)
    return size
