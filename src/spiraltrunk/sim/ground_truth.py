"""Ground truth of a trial, read from the simulator's state; for verdicts and plots, not available to strategies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.robot.arm import PREFIX
from spiraltrunk.sim.robot.trunk import cable_name, hinge_names

OBJECT, TRUNK, ROBOT, GROUND, OTHER = 1, 2, 4, 8, 16
"""Kinds of geoms, as bits; the sum of two identifies a pair."""


_STRING_LIMIT = int(mujoco.mjtConstraint.mjCNSTR_LIMIT_TENDON)


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
        self._kind = _geom_kinds(model)
        names = zip(*(hinge_names(i) for i in range(design.n_joint)), strict=True)
        self._hinges = np.array([[model.joint(name).qposadr[0] for name in axis] for axis in names])
        self._cables = np.array([model.tendon(cable_name(c)).id for c in range(design.n_cable)])
        self._is_string = np.array([model.tendon(t).name.startswith("string_") for t in range(model.ntendon)], bool)
        self._object = model.body("object").id
        self._body, self._root = model.geom_bodyid.copy(), model.body_rootid.copy()
        self.motors = np.array([model.actuator(cable_name(c)).id for c in range(design.n_cable)])
        """Actuators of the cables."""
        self.arm_q = np.array([model.joint(name).qposadr[0] for name in arm_joints])
        """Addresses of the arm's joints in qpos."""
        self.arm_v = np.array([model.joint(name).dofadr[0] for name in arm_joints])
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
        first, second = np.cos(data.qpos[self._hinges])
        self._bend = max(self._bend, float(np.arccos((first * second).min())))  # The largest angle.
        if data.ncon == 0:
            return
        penetration, on_robot, _, arm_on_ground = read_contacts(data.contact.geom, data.contact.dist, self._kind)
        self._penetration = max(self._penetration, penetration)
        self._touches_robot |= on_robot
        self._arm_touches_ground |= arm_on_ground

    def sample(self, data: mujoco.MjData, arm_command: np.ndarray) -> Sample:
        """Ground truth of the present state; resets the extremes. ``arm_command`` has shape (n_arm,) [rad]."""
        contact, force = self._find_grip(data)
        sample = Sample(
            time=data.time,
            qpos=data.qpos.copy(),
            object_position=data.xpos[self._object].copy(),
            object_axis=data.xmat[self._object, [0, 3, 6]],
            joint_bend=joint_bends(data.qpos, self._hinges),
            cable_pull=self.straight_length - data.ten_length[self._cables],
            cable_tension=-data.actuator_force[self.motors],
            grip_force=sum(force.tolist()),
            slip_velocity=self._slip_velocity(data, contact, force),
            string_tension=self._string_tension(data),
            penetration=self._penetration,
            bend_most=self._bend,
            touches_robot=self._touches_robot,
            touches_table=read_contacts(data.contact.geom, data.contact.dist, self._kind)[2],
            arm_touches_ground=self._arm_touches_ground,
            arm_torque=data.qfrc_actuator[self.arm_v],
            arm_position=data.qpos[self.arm_q],
            arm_velocity=data.qvel[self.arm_v],
            arm_command=arm_command.copy(),
        )
        self.reset()
        return sample

    def _find_grip(self, data: mujoco.MjData) -> tuple[np.ndarray, np.ndarray]:
        """Contacts between trunk and object, and their normal forces [N]: a contact's first constraint row."""
        if data.ncon == 0:
            return np.zeros(0, int), np.zeros(0)
        row = data.contact.efc_address
        geom = data.contact.geom
        pairs = self._kind[geom[:, 0]] + self._kind[geom[:, 1]]
        contact = np.flatnonzero((pairs == OBJECT + TRUNK) & (row >= 0))
        return contact, data.efc_force[row[contact]]

    def _slip_velocity(self, data: mujoco.MjData, contact: np.ndarray, force: np.ndarray) -> np.ndarray:
        r"""Mean of the contacts' sliding velocities, :math:`\sum_i N_i P_i (v_o - v_t) / \sum_i N_i`, shape (3,) [m/s].

        :math:`v_o` and :math:`v_t` are the velocities of object and trunk at the contact, :math:`P_i` projects onto its
        tangential plane. The mean of an object that turns in a loop is small, as its surface slides both ways.
        """
        total = force.sum()
        if not total > 0.0:
            return np.zeros(3)
        geom, point = data.contact.geom[contact], data.contact.pos[contact]
        is_first = self._kind[geom[:, :1]] == OBJECT
        body = self._body[np.where(is_first, geom, geom[:, ::-1])]
        moved = _velocities(data, body, self._root, point)
        relative = moved[:, 0] - moved[:, 1]
        normal = data.contact.frame[contact, :3]
        relative -= (relative * normal).sum(axis=1, keepdims=True) * normal
        return np.asarray(force @ relative / total)

    def _string_tension(self, data: mujoco.MjData) -> float:
        if not self._is_string.any():
            return 0.0
        first = data.ne + data.nf  # Rows of limits follow those of equalities and of dry friction.
        limits = slice(first, first + data.nl)
        return sum(
            force
            for kind, tendon, force in zip(
                data.efc_type[limits].tolist(), data.efc_id[limits].tolist(), data.efc_force[limits].tolist(),
                strict=True,
            )
            if kind == _STRING_LIMIT and self._is_string[tendon]
        )  # fmt: skip


def joint_bends(qpos: np.ndarray, hinges: np.ndarray) -> np.ndarray:
    """Angle between neighbouring axes, cos(angle) = cos(q_1) cos(q_2), shape (n_joint,) [rad].

    Args:
        qpos: generalised positions, shape (n_q,).
        hinges: addresses of the two perpendicular hinges of each joint, in either order, shape (2, n_joint).
    """
    first, second = np.cos(qpos[hinges])
    return np.asarray(np.arccos(first * second))


def _velocities(data: mujoco.MjData, body: np.ndarray, root: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Velocity of each point as it moves with either of two bodies, shape (n, 2, 3) [m/s].

    MuJoCo's ``cvel`` is the velocity about the centre of mass of the body's kinematic tree.
    """
    velocity = data.cvel[body]
    a, b, c = velocity[..., 0], velocity[..., 1], velocity[..., 2]
    arm = point[:, None] - data.subtree_com[root[body]]
    x, y, z = arm[..., 0], arm[..., 1], arm[..., 2]
    moved = velocity[..., 3:]  # Of a copy; np.cross takes five times as long.
    moved[..., 0] += b * z - c * y
    moved[..., 1] += c * x - a * z
    moved[..., 2] += a * y - b * x
    return np.asarray(moved)


def read_contacts(geom: np.ndarray, dist: np.ndarray, kind: np.ndarray) -> tuple[float, bool, bool, bool]:
    """Largest penetration [m], and whether object and robot, object and ground, robot and ground touch.

    Args:
        geom: the two geoms of each contact, shape (n_contact, 2).
        dist: distance between them, negative where they penetrate, shape (n_contact,) [m].
        kind: kind of each geom, shape (n_geom,).
    """
    pairs = set((kind[geom[:, 0]] + kind[geom[:, 1]]).tolist())
    on_robot, on_ground, arm_on_ground = (pair in pairs for pair in (OBJECT + ROBOT, OBJECT + GROUND, ROBOT + GROUND))
    return -min([0.0, *dist.tolist()]), on_robot, on_ground, arm_on_ground


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
