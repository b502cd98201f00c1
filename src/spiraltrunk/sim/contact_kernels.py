"""Compiled readings of MuJoCo's arrays between physics steps: contacts by kind of body, forces, and joint bends."""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numba import njit

OBJECT, TRUNK, ROBOT, GROUND, OTHER = 1, 2, 4, 8, 16
"""Kinds of geoms; the sum of two identifies a pair."""

_LIMIT_TENDON = int(mujoco.mjtConstraint.mjCNSTR_LIMIT_TENDON)


@njit(cache=True)
def least_cosine(qpos: np.ndarray, hinges: np.ndarray) -> float:
    """Smallest cosine of the angle between neighbouring axes: the product of the two hinges', in either order.

    Args:
        qpos: generalised positions, shape (n_q,).
        hinges: indices of the two hinges of each joint, shape (2, n_joint).
    """
    least = 1.0
    for i in range(hinges.shape[1]):
        least = min(least, math.cos(qpos[hinges[0, i]]) * math.cos(qpos[hinges[1, i]]))
    return least


@njit(cache=True)
def joint_bends(qpos: np.ndarray, hinges: np.ndarray) -> np.ndarray:
    """Angle between neighbouring axes, shape (n_joint,) [rad]; arguments as of `least_cosine`."""
    bend = np.empty(hinges.shape[1])
    for i in range(bend.size):
        bend[i] = math.acos(math.cos(qpos[hinges[0, i]]) * math.cos(qpos[hinges[1, i]]))
    return bend


@njit(cache=True)
def read_contacts(geom: np.ndarray, dist: np.ndarray, kind: np.ndarray) -> tuple[float, bool, bool, bool]:
    """Deepest overlap [m], and whether object and robot, object and ground, robot and ground touch.

    Args:
        geom: the two geoms of each contact, shape (n_contact, 2).
        dist: distance between them, negative where they overlap, shape (n_contact,) [m].
        kind: kind of each geom, shape (n_geom,).
    """
    overlap, on_robot, on_ground, robot_on_ground = 0.0, False, False, False
    for i in range(dist.size):
        overlap = max(overlap, -dist[i])
        pair = kind[geom[i, 0]] + kind[geom[i, 1]]
        on_robot = on_robot or pair == OBJECT + ROBOT
        on_ground = on_ground or pair == OBJECT + GROUND
        robot_on_ground = robot_on_ground or pair == ROBOT + GROUND
    return overlap, on_robot, on_ground, robot_on_ground


@njit(cache=True)
def grip_force(geom: np.ndarray, row: np.ndarray, kind: np.ndarray, force: np.ndarray) -> float:
    """Sum of the normal forces between trunk and object, in elliptic friction cones [N].

    Args:
        geom: the two geoms of each contact, shape (n_contact, 2).
        row: its first row among the constraints, the normal's; negative where it has none, shape (n_contact,).
        kind: kind of each geom, shape (n_geom,).
        force: force of each row, shape (n_row,) [N].
    """
    total = 0.0
    for i in range(row.size):
        if row[i] >= 0 and kind[geom[i, 0]] + kind[geom[i, 1]] == OBJECT + TRUNK:
            total += force[row[i]]
    return total


@njit(cache=True)
def string_force(family: np.ndarray, member: np.ndarray, is_string: np.ndarray, force: np.ndarray) -> float:
    """Sum of the tensions of the object's strings [N].

    Args:
        family: type of each constraint's row, shape (n_row,).
        member: what it limits, shape (n_row,).
        is_string: whether each tendon is a string, shape (n_tendon,).
        force: force of each row, shape (n_row,) [N].
    """
    total = 0.0
    for i in range(family.size):
        if family[i] == _LIMIT_TENDON and is_string[member[i]]:
            total += force[i]
    return total
