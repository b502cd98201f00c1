"""Axis conventions of recordings. A Motive export does not contain its own, so that the user must give it.

Takes have y up against gravity, x to the right and z towards the viewer, right-handed, as in Motive. Motive can export
each of its axes as any other, with either sign.
"""

from __future__ import annotations

import re

import numpy as np

from spiraltrunk.errors import TakeError

NAMED = {"y-up": "x,y,z", "z-up": "x,z,-y", "x-up": "-y,x,z"}
"""Conventions by name: the axes of the file that are x (right), y (up) and z (towards the viewer); all right-handed.

z-up keeps Motive's x, x-up its z, as exports usually do. Registered points depend on the up axis and the handedness
alone; the axes of rigid bodies depend on all three.
"""

_AXIS = re.compile(r"([+-]?)([xyz])")

ALLOWED = (
    f"{', '.join(NAMED)}, or three axes of the file that are right, up and towards the viewer, "
    "such as x,-z,y; Motive's own is y-up, and the export's settings say whether it was changed"
)


def read_axes(name: str) -> np.ndarray:
    """Signed permutation from the file's axes to a take's, shape (3, 3) [-]; determinant -1: left-handed file."""
    key = name.strip().lower()
    axes = [match for part in NAMED.get(key, key).split(",") if (match := _AXIS.fullmatch(part.strip()))]
    if len(axes) != 3 or len({axis[2] for axis in axes}) != 3:
        raise TakeError(f"axes are {name[:60]!r}; allowed: {ALLOWED}")
    turn = np.zeros((3, 3))
    for row, axis in enumerate(axes):
        turn[row, "xyz".index(axis[2])] = -1.0 if axis[1] == "-" else 1.0
    return turn


def turn_quaternions(quaternion_wxyz: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """The rotations P R P^T of rotations R, for a signed permutation P, shape (..., 4) [-]."""
    turned = quaternion_wxyz.copy()
    turned[..., 1:] = round(float(np.linalg.det(turn))) * quaternion_wxyz[..., 1:] @ turn.T
    return turned
