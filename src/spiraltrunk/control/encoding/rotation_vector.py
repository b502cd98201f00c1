"""Rotation matrices from rotation vectors and back, in plain numbers.

For one rotation these take a tenth of the time of `scipy.spatial.transform.Rotation`, and give the same numbers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

_SMALL = 1e-3
"""Angle up to which series replace quotients of two small numbers [rad]."""


def rotate_by(turn: Sequence[float]) -> np.ndarray:
    r"""Rotation matrix of a rotation vector, shape (3, 3) [-].

    It is that of the unit quaternion :math:`(v \sin(\alpha / 2) / \alpha, \cos(\alpha / 2))` with the vector :math:`v`
    of length :math:`\alpha`.
    """
    x, y, z = turn
    angle = math.sqrt(x * x + y * y + z * z)
    square = angle * angle
    scale = 0.5 - square / 48 + square * square / 3840 if angle <= _SMALL else math.sin(angle / 2) / angle
    x, y, z, w = scale * x, scale * y, scale * z, math.cos(angle / 2)
    xx, yy, zz, ww, xy, xz, yz = x * x, y * y, z * z, w * w, x * y, x * z, y * z
    xw, yw, zw = x * w, y * w, z * w
    return np.array([
        [xx - yy - zz + ww, 2 * (xy - zw), 2 * (xz + yw)],
        [2 * (xy + zw), -xx + yy - zz + ww, 2 * (yz - xw)],
        [2 * (xz - yw), 2 * (yz + xw), -xx - yy + zz + ww],
    ])  # fmt: skip


def measure_turn(rotation: np.ndarray) -> list[float]:
    r"""Rotation vector of a rotation matrix, of an angle up to :math:`\pi` [rad]: the inverse of `rotate_by`.

    The angle is :math:`\alpha = 2 \operatorname{atan2}(|v|, w)` of the unit quaternion :math:`(v, w)`, whose sign makes
    w positive. It has the matrix's error where the matrix is not orthogonal.
    """
    x, y, z, w = _measure_quaternion(rotation.tolist())
    if w < 0:
        x, y, z, w = -x, -y, -z, -w
    angle = 2 * math.atan2(math.sqrt(x * x + y * y + z * z), w)
    square = angle * angle
    scale = 2 + square / 12 + 7 * square * square / 2880 if angle <= _SMALL else angle / math.sin(angle / 2)
    return [scale * x, scale * y, scale * z]


def _measure_quaternion(rows: list[list[float]]) -> tuple[float, float, float, float]:
    """Unit quaternion of a rotation, from the largest of its four numbers (Markley 2008, J. Guid. Control Dyn. 31)."""
    (a, b, c), (d, e, f), (g, h, i) = rows
    trace = a + e + i
    most = max(a, e, i, trace)
    if most == a:
        x, y, z, w = 1 - trace + 2 * a, d + b, g + c, h - f
    elif most == e:
        x, y, z, w = d + b, 1 - trace + 2 * e, h + f, c - g
    elif most == i:
        x, y, z, w = g + c, h + f, 1 - trace + 2 * i, d - b
    else:
        x, y, z, w = h - f, c - g, d - b, 1 + trace
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    return x / norm, y / norm, z / norm, w / norm
