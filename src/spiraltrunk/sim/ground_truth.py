"""Ground truth from the simulator's state, for evaluation and plots, not available to strategies."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import final

import mujoco
import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim import contact_kernels
from spiraltrunk.sim.robot.trunk import cable_name, hinge_names


@final
@dataclass(frozen=True, kw_only=True)
class Sample:
    """Ground truth at one control tick; extremes are over the period before it."""

    time: float
    """Simulated time [s]."""
    qpos: np.ndarray
    """MuJoCo's generalised positions, for rendering."""
    object_position: np.ndarray
    """Centre of the object, shape (3,) [m]."""
    joint_bend: np.ndarray
    """Angle between neighbouring axes, shape (n_joint,) [rad]."""
    cable_pull: np.ndarray
    """Cable pulled in, shape (n_cable,) [m]."""
    cable_tension: np.ndarray
    """Tension, shape (n_cable,) [N]."""
    grip_force: float
    """Sum of the normal forces between trunk and object [N]."""
    string_tension: float
    """Sum of the tensions of the object's strings [N]."""
    penetration: float
    """Deepest overlap of two bodies in the period [m]."""
    bend_most: float
    """Largest joint bend in the period [rad]."""
    touches_robot: bool
    """Whether the object touched housing or arm in the period."""
    touches_table: bool
    """Whether the object touches table, ground or floor now."""
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
@dataclass(kw_only=True)
class Probe:
    """Reads the ground truth from a model's data, with indices looked up once."""

    model: mujoco.MjModel
    design: TrunkDesign
    arm_joints: tuple[str, ...]
    penetration: float = field(default=0.0, init=False)
    cosine_least: float = field(default=1.0, init=False)
    touches_robot: bool = field(default=False, init=False)
    arm_touches_ground: bool = field(default=False, init=False)

    def __post_init__(self) -> None:
        model, design = self.model, self.design
        self._kind = _geom_kinds(model)
        self._hinges = np.array(
            [[model.joint(hinge_names(i)[k]).qposadr[0] for i in range(design.n_joint)] for k in range(2)]
        )
        self._cables = np.array([model.tendon(cable_name(c)).id for c in range(design.n_cable)])
        self._motors = np.array([model.actuator(cable_name(c)).id for c in range(design.n_cable)])
        self._is_string = np.array([model.tendon(t).name.startswith("string_") for t in range(model.ntendon)], bool)
        self._has_strings = bool(self._is_string.any())
        self._object = model.body("object").id
        self._arm_q = np.array([model.joint(name).qposadr[0] for name in self.arm_joints])
        self._arm_v = np.array([model.joint(name).dofadr[0] for name in self.arm_joints])
        self.straight_length = self._straight_lengths()
        self._load_kernels()

    def watch(self, data: mujoco.MjData) -> None:
        """Update the extremes."""
        self.cosine_least = min(self.cosine_least, contact_kernels.least_cosine(data.qpos, self._hinges))
        if data.ncon == 0:
            return
        contact = data.contact
        overlap, on_robot, _, robot_on_ground = contact_kernels.read_contacts(contact.geom, contact.dist, self._kind)
        self.penetration = max(self.penetration, overlap)
        self.touches_robot = self.touches_robot or on_robot
        self.arm_touches_ground = self.arm_touches_ground or robot_on_ground

    def sample(self, data: mujoco.MjData, arm_command: np.ndarray) -> Sample:
        """The present ground truth; resets the extremes."""
        qpos, torque, velocity = data.qpos.copy(), data.qfrc_actuator, data.qvel
        grip, on_ground = self._read_grip(data)
        sample = Sample(
            time=data.time,
            qpos=qpos,
            object_position=data.xpos[self._object].copy(),
            joint_bend=self.joint_bend(data),
            cable_pull=self.cable_pull(data),
            cable_tension=self.cable_tension(data),
            grip_force=grip,
            string_tension=self._string_tension(data),
            penetration=self.penetration,
            bend_most=math.acos(self.cosine_least),
            touches_robot=self.touches_robot,
            touches_table=on_ground,
            arm_touches_ground=self.arm_touches_ground,
            arm_torque=torque[self._arm_v],
            arm_position=qpos[self._arm_q],
            arm_velocity=velocity[self._arm_v],
            arm_command=arm_command.copy(),
        )
        self.penetration, self.cosine_least = 0.0, 1.0
        self.touches_robot = self.arm_touches_ground = False
        return sample

    def joint_bend(self, data: mujoco.MjData) -> np.ndarray:
        """Angle between neighbouring axes, shape (n_joint,) [rad]."""
        return np.asarray(contact_kernels.joint_bends(data.qpos, self._hinges))

    def cable_pull(self, data: mujoco.MjData) -> np.ndarray:
        """Cable pulled in since the straight trunk [m]."""
        return self.straight_length - data.ten_length[self._cables]

    def cable_tension(self, data: mujoco.MjData) -> np.ndarray:
        """Tension at the motors [N]."""
        return np.asarray(-data.actuator_force[self._motors])

    def _read_grip(self, data: mujoco.MjData) -> tuple[float, bool]:
        """Sum of the normal forces between trunk and object [N], and whether the object touches table or ground."""
        if data.ncon == 0:
            return 0.0, False
        contact, kind = data.contact, self._kind
        geom = contact.geom
        force = contact_kernels.grip_force(geom, contact.efc_address, kind, data.efc_force)
        return force, contact_kernels.read_contacts(geom, contact.dist, kind)[2]

    def _string_tension(self, data: mujoco.MjData) -> float:
        if not self._has_strings:
            return 0.0
        return float(contact_kernels.string_force(data.efc_type, data.efc_id, self._is_string, data.efc_force))

    def _straight_lengths(self) -> np.ndarray:
        data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, data)
        return data.ten_length[self._cables].copy()

    def _load_kernels(self) -> None:
        """Compile or load the kernels before a run, for the array layouts of one and of several contacts."""
        data = mujoco.MjData(self.model)
        contact_kernels.least_cosine(data.qpos, self._hinges)
        self.joint_bend(data)
        self._string_tension(data)
        for count in (1, 2):
            geom, number = np.zeros((count, 3), np.int32)[:, :2], np.zeros((count, 2), np.int32)[:, 0]
            contact_kernels.read_contacts(geom, np.zeros((count, 2))[:, 0], self._kind)
            contact_kernels.grip_force(geom, number, self._kind, np.zeros(4))


def _geom_kinds(model: mujoco.MjModel) -> np.ndarray:
    kinds = np.full(model.ngeom, contact_kernels.OTHER)
    for g in range(model.ngeom):
        name, body = model.geom(g).name, model.body(model.geom_bodyid[g]).name
        if body == "object":
            kinds[g] = contact_kernels.OBJECT
        elif body.startswith(("section_", "finger_", "neck")):
            kinds[g] = contact_kernels.TRUNK
        elif body == "housing" or body.startswith("arm/"):
            kinds[g] = contact_kernels.ROBOT
        elif name.startswith(("table", "ground", "floor")):
            kinds[g] = contact_kernels.GROUND
    return kinds
