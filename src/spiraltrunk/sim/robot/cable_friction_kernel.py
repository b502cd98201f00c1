"""Kernels of the cables' friction: from hinge angles to forces on the hinges.

Gap k, of length L_k, lies between sections k and k + 1. S_k is the sum of L_j over j >= k, the cable beyond hole k. T_k
is the tension in gap k, and T_0 the tension at the motor. Arrays count gaps and cables from 0.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NamedTuple, final

import numpy as np

from spiraltrunk.model.jit import compiler, hash_files
from spiraltrunk.model.statics.kernels.laws import capstan_law
from spiraltrunk.model.statics.kernels.laws.capstan_law import ratio, slip_forces

_compiled = compiler(hash_files([Path(__file__), Path(capstan_law.__file__)]))


@final
class CableGeometry(NamedTuple):
    """Constant geometry of the cables, and their addresses in the model."""

    beyond: np.ndarray
    """True hole beyond each joint in the distal section's frame, (axial, radial), shape (n_joint, 2) [m]."""
    before: np.ndarray
    """The same before it in the proximal section's frame, its origin in the joint, shape (n_joint, 2) [m]."""
    back: np.ndarray
    """Distance of the simulated holes behind the true ones, beyond and before, shape (n_joint, 2) [m]."""
    direction: np.ndarray
    """Unit vectors from the axis to the cables, y and z, shape (n_cable, 2) [-]."""
    inside: np.ndarray
    """Length of each cable inside the simulated sections, shape (1,) [m]."""
    z_first: np.ndarray
    """Whether the proximal hinge of each joint is the one about z, shape (n_joint,)."""
    qpos: np.ndarray
    """Addresses in qpos of the proximal and the distal hinge, shape (n_joint, 2)."""
    dof: np.ndarray
    """Addresses in qvel of the same hinges, shape (n_joint, 2)."""
    motor: np.ndarray
    """Actuator of each cable, shape (n_cable,)."""


@final
class FrictionState(NamedTuple):
    """State of the friction, and the results of the last step."""

    is_moving: np.ndarray
    """Whether a step preceded, shape (1,)."""
    beyond: np.ndarray
    """S_k at that step, shape (n_cable, n_joint) [m]."""
    force: np.ndarray
    """Friction force F_k = T_(k-1) - T_k, shape (n_cable, n_joint) [N]."""
    tension: np.ndarray
    """T_k from k = 0, shape (n_cable, n_joint + 1) [N]."""
    turn: np.ndarray
    """Wrap angle between gap k - 1 and gap k, shape (n_cable, n_joint) [rad]."""


@_compiled
def joint_turn(z_first: bool, first: float, second: float) -> Any:
    """Rotation matrix of a joint, row by row, and the distal hinge's axis, in the proximal section's frame."""
    c1, s1, c2, s2 = math.cos(first), math.sin(first), math.cos(second), math.sin(second)
    if z_first:  # Rz(first) Ry(second).
        return (c1 * c2, -s1, c1 * s2, s1 * c2, c1, s1 * s2, -s2, 0.0, c2), (-s1, c1, 0.0)
    return (c1 * c2, -c1 * s2, s1, s2, c2, 0.0, -s1 * c2, s1 * s2, c1), (s1, 0.0, c1)  # Ry(first) Rz(second).


@_compiled
def hole_vectors(turn: Any, beyond: Any, before: Any, direction: Any) -> Any:
    """Vectors from the joint to the true hole beyond it, and across the gap, in the proximal section's frame [m]."""
    u, v, w = beyond[0], beyond[1] * direction[0], beyond[1] * direction[1]
    x = turn[0] * u + turn[1] * v + turn[2] * w
    y = turn[3] * u + turn[4] * v + turn[5] * w
    z = turn[6] * u + turn[7] * v + turn[8] * w
    return (x, y, z), (x - before[0], y - before[1] * direction[0], z - before[1] * direction[1])


@_compiled
def set_back(turn: Any, hole: Any, across: Any, back: Any) -> Any:
    """The vectors of `hole_vectors` for the holes set back by ``back`` [m]."""
    x, y, z = back[0] * turn[0], back[0] * turn[3], back[0] * turn[6]
    return (hole[0] + x, hole[1] + y, hole[2] + z), (across[0] + x + back[1], across[1] + y, across[2] + z)


@_compiled
def gap_gradient(z_first: bool, second_axis: Any, hole: Any, across: Any) -> Any:
    """Length of a gap [m] and its derivatives with respect to the proximal and the distal hinge [m/rad]."""
    x, y, z = hole
    g, h, k = across
    length = max(math.sqrt(g * g + h * h + k * k), 1e-12)
    first = (h * x - g * y) if z_first else (g * z - k * x)
    a, b, c = second_axis
    second = g * (b * z - c * y) + h * (c * x - a * z) + k * (a * y - b * x)
    return length, first / length, second / length


@_compiled
def gap_turns(turn: Any, across: Any) -> Any:
    """Wrap angles at the holes before and beyond a joint: angles between the gap and the sections' axes [rad].

    Past the joint limit, which is soft, the gap's direction is reversed, so that both angles stay continuous.
    """
    x, y, z = across
    along_distal = turn[0] * x + turn[3] * y + turn[6] * z
    length = math.copysign(max(math.sqrt(x * x + y * y + z * z), 1e-12), x + along_distal)
    before = math.acos(min(1.0, max(-1.0, x / length)))
    return before, math.acos(min(1.0, max(-1.0, along_distal / length)))


@_compiled
def measure_gaps(geometry: CableGeometry, qpos: Any, gap: Any, gradient: Any, turn: Any) -> None:
    """Fill lengths and gradients of the simulated gaps and the wrap angles at the true holes.

    Args:
        geometry: geometry of the cables.
        qpos: generalised positions.
        gap: lengths, shape (n_cable, n_joint) [m].
        gradient: derivatives with respect to both hinges, shape (n_cable, n_joint, 2) [m/rad].
        turn: wrap angles, shape (n_cable, n_joint) [rad].
    """
    count = geometry.before.shape[0]
    for j in range(count):
        is_z = geometry.z_first[j]
        rotation, axis = joint_turn(is_z, qpos[geometry.qpos[j, 0]], qpos[geometry.qpos[j, 1]])
        for c in range(geometry.direction.shape[0]):
            hole, across = hole_vectors(rotation, geometry.beyond[j], geometry.before[j], geometry.direction[c])
            before, beyond = gap_turns(rotation, across)
            turn[c, j] = before if j == 0 else turn[c, j] + before
            if j + 1 < count:
                turn[c, j + 1] = beyond
            hole, across = set_back(rotation, hole, across, geometry.back[j])
            gap[c, j], gradient[c, j, 0], gradient[c, j, 1] = gap_gradient(is_z, axis, hole, across)


@_compiled
def slide(c: int, gap: Any, state: FrictionState, slid: Any) -> float:
    """Displacement through each hole since the last step, away from the motor; returns the length of all gaps [m]."""
    beyond = 0.0
    for k in range(gap.shape[1] - 1, -1, -1):
        beyond += gap[c, k]
        slid[k] = beyond - state.beyond[c, k] if state.is_moving[0] else 0.0
        state.beyond[c, k] = beyond
    return beyond


@_compiled
def motor_tension(actuator: int, length: float, motors: Any) -> float:
    """Tension of a cable at its motor, by the actuator's affine law [N]."""
    ctrl, gain, force_range = motors
    force = gain[actuator, 0] * (ctrl[actuator] - length)
    return -min(max(force, force_range[actuator, 0]), force_range[actuator, 1])


@_compiled
def pass_holes(c: int, mu: float, stiffness: float, slid: Any, state: FrictionState) -> None:
    """Friction at each hole, which yields at the slip forces of `capstan_law`, and tension from gap to gap."""
    tension = state.tension[c, 0]
    for k in range(slid.shape[0]):
        kept = ratio(mu, state.turn[c, k])
        lost, gained = slip_forces(tension, kept, 1.0 / kept)
        state.force[c, k] = min(lost, max(-gained, state.force[c, k] - stiffness * slid[k]))
        tension -= state.force[c, k]
        state.tension[c, k + 1] = tension


@_compiled
def apply_friction(geometry: CableGeometry, state: FrictionState, law: Any, motors: Any, forces: Any) -> None:
    """Advance the friction to the present hinge angles, and write its forces on the hinges.

    Args:
        geometry: geometry of the cables.
        state: state of the friction; advanced.
        law: coefficient of friction [-] and stiffness before slip [N/m].
        motors: ctrl, gainprm and forcerange of the actuators.
        forces: qpos, and qfrc_applied, which is written at the hinges.
    """
    qpos, applied = forces
    n_cable, count = state.turn.shape
    gap, gradient, slid = np.empty((n_cable, count)), np.empty((n_cable, count, 2)), np.empty(count)
    measure_gaps(geometry, qpos, gap, gradient, state.turn)
    for j in range(count):
        applied[geometry.dof[j, 0]] = applied[geometry.dof[j, 1]] = 0.0
    for c in range(n_cable):
        length = geometry.inside[0] + slide(c, gap, state, slid)
        state.tension[c, 0] = motor_tension(geometry.motor[c], length, motors)
        pass_holes(c, law[0], law[1], slid, state)
        total = 0.0
        for k in range(count):
            total += state.force[c, k]
            applied[geometry.dof[k, 0]] += total * gradient[c, k, 0]
            applied[geometry.dof[k, 1]] += total * gradient[c, k, 1]
    state.is_moving[0] = True
