"""Ground truth of a trial, read from the simulator's state; for verdicts and plots, not available to strategies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, final

import mujoco
import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.robot.arm import PREFIX
from spiraltrunk.sim.robot.trunk import cable_name, hinge_names

OBJECT, TRUNK, ROBOT, GROUND, OTHER = 1, 2, 4, 8, 16
"""Kinds of geoms, as bits; the sum of two identifies a pair."""

_STRING_LIMIT = int(mujoco.mjtConstraint.mjCNSTR_LIMIT_TENDON)

_NO_FORCE = np.zeros(0)

Motion = tuple[list[float], list[float]]
"""Angular and linear velocity of a body [rad/s, m/s], about the centre of mass of its kinematic tree, and that centre
[m]: MuJoCo's ``cvel`` and ``subtree_com``."""


@final
@dataclass(frozen=True, kw_only=True)
class Sample:
    """Ground truth at one control step; extremes are over the preceding control period."""

    time: float
    """Simulated time [s]."""
    qpos: np.ndarray
    """MuJoCo's generalised positions, shape (n_q,) [m, rad]."""
    object_position: np.ndarray
    """Centre of the object, shape (3,) [m]."""
    object_axis: np.ndarray
    """Unit vector along the object, shape (3,) [-]."""
    joint_bend: np.ndarray
    """Angle between neighbouring axes, shape (n_joint,) [rad]."""
    cable_pull: np.ndarray
    """Cable pulled in, shape (n_cable,) [m]."""
    cable_tension: np.ndarray
    """Tension, shape (n_cable,) [N]."""
    grip_force: float
    """Sum of the normal forces between trunk and object [N]."""
    slip_velocity: np.ndarray
    """Mean sliding velocity of the object along the trunk's surface, weighted by normal force, shape (3,) [m/s]."""
    string_tension: float
    """Sum of the tensions of the object's strings [N]."""
    penetration: float
    """Largest penetration of two bodies in the period [m]."""
    bend_most: float
    """Largest joint bend in the period [rad]."""
    touches_robot: bool
    """Whether the object touched housing or arm in the period."""
    touches_table: bool
    """Whether the object touches table, ground or floor at this time."""
    arm_touches_ground: bool
    """Whether housing or arm touched table, ground or floor in the period."""
    arm_torque: np.ndarray
    """Actuator torques of the arm, shape (n_arm,) [N m]."""
    arm_position: np.ndarray
    """Joint positions of the arm, shape (n_arm,) [rad]."""
    arm_velocity: np.ndarray
    """Joint velocities of the arm, shape (n_arm,) [rad/s]."""
    arm_command: np.ndarray
    """Commanded joint positions of the arm, shape (n_arm,) [rad]."""


@final
class TruthRecorder:
    """Reads samples from the state of a scene's ``model``; it holds the indices and the extremes of the period."""

    def __init__(self, model: mujoco.MjModel, design: TrunkDesign, arm_joints: tuple[str, ...]) -> None:
        self._kind = _geom_kinds(model).tolist()
        names = zip(*(hinge_names(i) for i in range(design.n_joint)), strict=True)
        self._hinges = np.array([[model.joint(name).qposadr[0] for name in axis] for axis in names])
        self._cables = as_slice([model.tendon(cable_name(c)).id for c in range(design.n_cable)])
        self._strings = {t for t in range(model.ntendon) if model.tendon(t).name.startswith("string_")}
        self._object = model.body("object").id
        self._body, self._root = model.geom_bodyid.tolist(), model.body_rootid.tolist()
        self.motors = as_slice([model.actuator(cable_name(c)).id for c in range(design.n_cable)])
        """Actuators of the cables."""
        self.arm_q = as_slice([int(model.joint(name).qposadr[0]) for name in arm_joints])
        """Addresses of the arm's joints in qpos."""
        self.arm_v = as_slice([int(model.joint(name).dofadr[0]) for name in arm_joints])
        """The same in qvel."""
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        self.straight_length = data.ten_length[self._cables].copy()
        """Length of each cable of the straight trunk, shape (n_cable,) [m]."""
        self.reset()

    def reset(self) -> None:
        """Reset the extremes."""
        self._penetration, self._bend = 0.0, 0.0
        self._touches_robot = self._arm_touches_ground = False

    def get_extremes(self) -> tuple[float, float, bool, bool]:
        """Extremes since the last sample: penetration [m], bend [rad], touches of the robot and of the ground."""
        return self._penetration, self._bend, self._touches_robot, self._arm_touches_ground

    def set_extremes(self, extremes: tuple[float, float, bool, bool]) -> None:
        """Restore the extremes."""
        self._penetration, self._bend, self._touches_robot, self._arm_touches_ground = extremes

    def update_extremes(self, data: mujoco.MjData) -> None:
        """Update the extremes with the present state."""
        self._widen_extremes(joint_bends(data.qpos, self._hinges), data.contact)

    def _widen_extremes(self, bend: np.ndarray, contact: Any) -> bool:
        """Update the extremes with joint bends and MuJoCo's contacts; whether the object touches a support."""
        self._bend = max(self._bend, *bend.tolist())
        penetration, on_robot, touches_table, arm_on_ground = read_contacts(contact.geom, contact.dist, self._kind)
        self._penetration = max(self._penetration, penetration)
        self._touches_robot |= on_robot
        self._arm_touches_ground |= arm_on_ground
        return touches_table

    def sample(self, data: mujoco.MjData, arm_command: np.ndarray) -> Sample:
        """Ground truth of the present state, which its extremes include; resets the extremes.

        Args:
            data: the state.
            arm_command: commanded positions of the arm's joints, shape (n_arm,) [rad].
        """
        bend, contact = joint_bends(data.qpos, self._hinges), data.contact
        touches_table = self._widen_extremes(bend, contact)
        grip = self._find_grip(contact)
        force = data.efc_force[[row for _, _, row in grip]] if grip else _NO_FORCE
        sample = Sample(
            time=data.time,
            qpos=data.qpos.copy(),
            object_position=data.xpos[self._object].copy(),
            object_axis=data.xmat[self._object, 0:9:3].copy(),
            joint_bend=bend,
            cable_pull=self.straight_length - data.ten_length[self._cables],
            cable_tension=-data.actuator_force[self.motors],
            grip_force=sum(force.tolist()),
            slip_velocity=self._slip_velocity(data, contact, grip, force),
            string_tension=self._string_tension(data),
            penetration=self._penetration,
            bend_most=self._bend,
            touches_robot=self._touches_robot,
            touches_table=touches_table,
            arm_touches_ground=self._arm_touches_ground,
            arm_torque=data.qfrc_actuator[self.arm_v].copy(),
            arm_position=data.qpos[self.arm_q].copy(),
            arm_velocity=data.qvel[self.arm_v].copy(),
            arm_command=arm_command.copy(),
        )
        self.reset()
        return sample

    def _find_grip(self, contact: Any) -> list[tuple[int, int, int]]:
        """Index, body of the trunk and first constraint row of each contact between trunk and object that has a force.

        That row's force is the normal force.
        """
        kind, body, found = self._kind, self._body, []
        for i, ((a, b), row) in enumerate(zip(contact.geom.tolist(), contact.efc_address.tolist(), strict=True)):
            if kind[a] + kind[b] == OBJECT + TRUNK and row >= 0:
                found.append((i, body[b if kind[a] == OBJECT else a], row))
        return found

    def _slip_velocity(
        self, data: mujoco.MjData, contact: Any, grip: list[tuple[int, int, int]], force: np.ndarray
    ) -> np.ndarray:
        r"""Mean of the contacts' sliding velocities, :math:`\sum_i N_i P_i (v_o - v_t) / \sum_i N_i`, shape (3,) [m/s].

        :math:`v_o` and :math:`v_t` are the velocities of object and trunk at the contact, :math:`P_i` projects onto its
        tangential plane. The mean of an object that turns in a loop is small, as its surface slides both ways. In plain
        numbers: on a few contacts, arrays take twice as long.

        Args:
            data: the state.
            contact: its contacts.
            grip: contacts between trunk and object, as of `_find_grip`.
            force: their normal forces [N].
        """
        total = force.sum()
        if not total > 0.0:
            return np.zeros(3)
        position, frame, slips = contact.pos, contact.frame, []
        motion, center, root = data.cvel, data.subtree_com, self._root
        held = motion[self._object].tolist(), center[root[self._object]].tolist()
        for index, body, _ in grip:
            point = position[index].tolist()
            u, v, w = _velocity(held, point)
            a, b, c = _velocity((motion[body].tolist(), center[root[body]].tolist()), point)
            u, v, w = u - a, v - b, w - c
            x, y, z = frame[index, :3].tolist()
            along = u * x + v * y + w * z
            slips.append((u - along * x, v - along * y, w - along * z))
        return np.asarray(force @ np.array(slips) / total)

    def _string_tension(self, data: mujoco.MjData) -> float:
        if not self._strings:
            return 0.0
        first = data.ne + data.nf  # Rows of limits follow those of equalities and of dry friction.
        end = first + data.nl
        kinds, tendons = data.efc_type[first:end].tolist(), data.efc_id[first:end].tolist()
        pairs = enumerate(zip(kinds, tendons, strict=True), first)
        rows = [row for row, (kind, tendon) in pairs if kind == _STRING_LIMIT and tendon in self._strings]
        return sum(data.efc_force[rows].tolist()) if rows else 0


def _velocity(motion: Motion, point: list[float]) -> tuple[float, float, float]:
    """Velocity of a point that moves with a body [m/s]."""
    (a, b, c, u, v, w), (x, y, z), (i, j, k) = *motion, point
    x, y, z = i - x, j - y, k - z
    return u + (b * z - c * y), v + (c * x - a * z), w + (a * y - b * x)


def as_slice(indices: Sequence[int]) -> slice | np.ndarray:
    """The part of an array at some indices: a slice where they are consecutive, which NumPy reads and writes sooner.

    A part that is kept has to be copied.
    """
    first, last = indices[0], indices[-1]
    return slice(first, last + 1) if list(indices) == list(range(first, last + 1)) else np.array(indices)


def joint_bends(qpos: np.ndarray, hinges: np.ndarray) -> np.ndarray:
    """Angle between neighbouring axes, cos(angle) = cos(q_1) cos(q_2), shape (n_joint,) [rad].

    Args:
        qpos: generalised positions, shape (n_q,).
        hinges: addresses of the two perpendicular hinges of each joint, in either order, shape (2, n_joint).
    """
    cosines = np.cos(qpos[hinges])
    return np.asarray(np.arccos(cosines[0] * cosines[1]))


def read_contacts(geom: np.ndarray, dist: np.ndarray, kind: Sequence[int]) -> tuple[float, bool, bool, bool]:
    """Largest penetration [m], and whether object and robot, object and ground, robot and ground touch.

    Args:
        geom: the two geoms of each contact, shape (n_contact, 2).
        dist: distance between them, negative where they penetrate, shape (n_contact,) [m].
        kind: kind of each geom, n_geom of them.
    """
    pairs = {kind[a] + kind[b] for a, b in geom.tolist()}
    penetration = max(0.0, -min(dist.tolist(), default=0.0))
    return penetration, OBJECT + ROBOT in pairs, OBJECT + GROUND in pairs, ROBOT + GROUND in pairs


def _geom_kinds(model: mujoco.MjModel) -> np.ndarray:
    """Kind of each geom, shape (n_geom,)."""
    kinds = np.full(model.ngeom, OTHER)
    for g in range(model.ngeom):
        name, body = model.geom(g).name, model.body(model.geom_bodyid[g]).name
        if body == "object":
            kinds[g] = OBJECT
        elif body.startswith(("section_", "finger_", "neck")):
            kinds[g] = TRUNK
        elif body == "housing" or body.startswith(PREFIX):
            kinds[g] = ROBOT
        elif name.startswith(("table", "ground", "floor")):
            kinds[g] = GROUND
    return kinds
