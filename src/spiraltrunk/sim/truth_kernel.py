"""Kernels of the ground truth: joint bends, and what a scene's contacts tell."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NamedTuple, final

import numpy as np

from spiraltrunk.model.jit import compiler, hash_files

OBJECT, TRUNK, ROBOT, GROUND, OTHER = 1, 2, 4, 8, 16
"""Kinds of geoms, as bits; the sum of two identifies a pair."""

_compiled = compiler(hash_files([Path(__file__)]), owns_arrays=False)


@final
class Places(NamedTuple):
    """Where a scene's model has what the kernels read."""

    hinges: np.ndarray
    """Addresses in qpos of the two perpendicular hinges of each joint, in either order, shape (2, n_joint)."""
    kind: np.ndarray
    """Kind of each geom, shape (n_geom,)."""
    body: np.ndarray
    """Body of each geom, shape (n_geom,)."""
    root: np.ndarray
    """Root of each body's kinematic tree, shape (n_body,)."""
    target: int
    """Body of the object."""


@final
class Contacts(NamedTuple):
    """MuJoCo's contacts, in its own names."""

    geom: np.ndarray
    """The two geoms of each, shape (n_contact, 2)."""
    dist: np.ndarray
    """Distance between them, negative where they penetrate, shape (n_contact,) [m]."""
    efc_address: np.ndarray
    """Its first constraint row, negative for none, shape (n_contact,); that row's force is the normal force."""
    pos: np.ndarray
    """Point, shape (n_contact, 3) [m]."""
    frame: np.ndarray
    """Normal, then two tangents, shape (n_contact, 9) [-]."""


@final
class Motions(NamedTuple):
    """Motions of the bodies, in MuJoCo's names."""

    cvel: np.ndarray
    """Angular and linear velocity about the centre of mass of its kinematic tree, shape (n_body, 6) [rad/s, m/s]."""
    subtree_com: np.ndarray
    """Those centres, by the trees' roots, shape (n_body, 3) [m]."""


@_compiled
def joint_bends(hinges: Any, qpos: Any, bend: Any) -> float:
    """Fill the angle between neighbouring axes, cos(angle) = cos(q_1) cos(q_2), and return the largest [rad].

    Args:
        hinges: as in `Places`.
        qpos: generalised positions, shape (n_q,).
        bend: angles, shape (n_joint,) [rad].
    """
    most = 0.0
    for j in range(bend.size):
        bend[j] = math.acos(math.cos(qpos[hinges[0, j]]) * math.cos(qpos[hinges[1, j]]))
        most = max(most, bend[j])
    return most


@_compiled
def read_contacts(kind: Any, geom: Any, dist: Any) -> Any:
    """Largest penetration [m], and whether object and robot, object and ground, robot and ground touch.

    Args:
        kind: as in `Places`.
        geom: as in `Contacts`.
        dist: likewise.
    """
    penetration, on_robot, on_ground, robot_on_ground = 0.0, False, False, False
    for i in range(dist.size):
        pair = kind[geom[i, 0]] + kind[geom[i, 1]]
        penetration = max(penetration, -dist[i])
        on_robot |= pair == OBJECT + ROBOT
        on_ground |= pair == OBJECT + GROUND
        robot_on_ground |= pair == ROBOT + GROUND
    return penetration, on_robot, on_ground, robot_on_ground


@_compiled
def find_extremes(places: Places, qpos: Any, geom: Any, dist: Any, bend: Any) -> Any:
    """Largest bend as `joint_bends`, which are filled in, and what `read_contacts` returns."""
    return joint_bends(places.hinges, qpos, bend), read_contacts(places.kind, geom, dist)


@_compiled
def measure_grip(places: Places, contacts: Contacts, motions: Motions, force: Any, slip: Any) -> float:
    r"""Sum of the normal forces between trunk and object [N], and the mean of their sliding velocities.

    The mean is :math:`\sum_i N_i P_i (v_o - v_t) / \sum_i N_i`: :math:`v_o` and :math:`v_t` are the velocities of
    object and trunk at the contact, :math:`P_i` projects onto its tangential plane. That of an object which turns in a
    loop is small, as its surface slides both ways.

    Args:
        places: `Places`.
        contacts: `Contacts`.
        motions: `Motions`.
        force: force of each constraint row, shape (n_row,) [N].
        slip: the mean, which is filled in, shape (3,) [m/s].
    """
    total = u = v = w = 0.0
    for i in range(contacts.dist.size):
        a, b, row = contacts.geom[i, 0], contacts.geom[i, 1], contacts.efc_address[i]
        if row < 0 or places.kind[a] + places.kind[b] != OBJECT + TRUNK:
            continue
        body = places.body[b] if places.kind[a] == OBJECT else places.body[a]
        p, q, r = velocity_of(places, motions, places.target, contacts.pos[i])
        d, e, f = velocity_of(places, motions, body, contacts.pos[i])
        p, q, r = p - d, q - e, r - f
        x, y, z = contacts.frame[i, 0], contacts.frame[i, 1], contacts.frame[i, 2]
        along = p * x + q * y + r * z
        total += force[row]
        u += force[row] * (p - along * x)
        v += force[row] * (q - along * y)
        w += force[row] * (r - along * z)
    scale = 1.0 / total if total > 0.0 else 0.0
    slip[0], slip[1], slip[2] = scale * u, scale * v, scale * w
    return total


@_compiled
def velocity_of(places: Places, motions: Motions, body: int, point: Any) -> Any:
    """Velocity of a point that moves with a body [m/s]."""
    center, m = motions.subtree_com[places.root[body]], motions.cvel[body]
    a, b, c, u, v, w = m[0], m[1], m[2], m[3], m[4], m[5]
    x, y, z = point[0] - center[0], point[1] - center[1], point[2] - center[2]
    return u + (b * z - c * y), v + (c * x - a * z), w + (a * y - b * x)
