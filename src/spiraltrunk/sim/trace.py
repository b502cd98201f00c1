"""What truly happened: recorded from the simulator's state, for verdicts and plots, never shown to a strategy."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

import mujoco
import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.trunk_spec import cable_name, hinge_names


@final
@dataclass(frozen=True, kw_only=True)
class Sample:
    """The truth at one control tick; extremes are over the period before it."""

    time: float
    """Simulated time [s]."""
    qpos: np.ndarray
    """MuJoCo's generalised positions, for pictures."""
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
    """Reads the truth off a model; built once, it knows which index is what."""

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

    def watch(self, data: mujoco.MjData) -> None:
        """Take the extremes of this instant into account."""
        self.cosine_least = min(self.cosine_least, float(self._bend_cosine(data).min()))
        if data.ncon == 0:
            return
        contact = data.contact
        self.penetration = max(self.penetration, -float(contact.dist.min()))
        pairs = self._pairs(contact.geom)
        self.touches_robot = self.touches_robot or _OBJECT * _ROBOT in pairs
        self.arm_touches_ground = self.arm_touches_ground or _ROBOT * _GROUND in pairs

    def sample(self, data: mujoco.MjData, arm_command: np.ndarray) -> Sample:
        """The truth now; the extremes begin anew."""
        contact = data.contact
        pairs = self._pairs(contact.geom)
        sample = Sample(
            time=data.time,
            qpos=data.qpos.copy(),
            object_position=data.xpos[self._object].copy(),
            joint_bend=self.joint_bend(data),
            cable_pull=self.cable_pull(data),
            cable_tension=self.cable_tension(data),
            grip_force=self._grip_force(data, contact.efc_address[pairs == _OBJECT * _TRUNK]),
            string_tension=self._string_tension(data),
            penetration=self.penetration,
            bend_most=float(np.arccos(self.cosine_least)),
            touches_robot=self.touches_robot,
            touches_table=_OBJECT * _GROUND in pairs,
            arm_touches_ground=self.arm_touches_ground,
            arm_torque=data.qfrc_actuator[self._arm_v].copy(),
            arm_position=data.qpos[self._arm_q].copy(),
            arm_velocity=data.qvel[self._arm_v].copy(),
            arm_command=arm_command.copy(),
        )
        self.penetration, self.cosine_least = 0.0, 1.0
        self.touches_robot = self.arm_touches_ground = False
        return sample

    def joint_bend(self, data: mujoco.MjData) -> np.ndarray:
        """Angle between neighbouring axes, shape (n_joint,) [rad]."""
        return np.asarray(np.arccos(self._bend_cosine(data)))

    def _bend_cosine(self, data: mujoco.MjData) -> np.ndarray:
        """Cosine of the angle between neighbouring axes: the product of the two hinges', in either order."""
        cosine = np.cos(data.qpos.take(self._hinges))
        return np.asarray(cosine[0] * cosine[1])

    def cable_pull(self, data: mujoco.MjData) -> np.ndarray:
        """Cable pulled in since the straight trunk [m]."""
        return self.straight_length - data.ten_length[self._cables]

    def cable_tension(self, data: mujoco.MjData) -> np.ndarray:
        """Tension at the motors [N]."""
        return np.asarray(-data.actuator_force[self._motors])

    def _pairs(self, geoms: np.ndarray) -> np.ndarray:
        """Product of the two kinds of every contact, shape (n_contact,)."""
        kinds = self._kind.take(geoms)
        return np.asarray(kinds[:, 0] * kinds[:, 1])

    def _grip_force(self, data: mujoco.MjData, rows: np.ndarray) -> float:
        """Sum of the normal forces of contacts, told by their first rows among the constraints."""
        force = data.efc_force
        if self.model.opt.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL:  # A row for each of the pyramid's four edges.
            return float(sum(force[rows + edge].sum() for edge in range(4)))
        return float(force[rows].sum())

    def _string_tension(self, data: mujoco.MjData) -> float:
        if not self._has_strings:
            return 0.0
        limited = np.flatnonzero(data.efc_type == _LIMIT_TENDON)
        return float(data.efc_force[limited[self._is_string[data.efc_id[limited]]]].sum())

    def _straight_lengths(self) -> np.ndarray:
        data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, data)
        return data.ten_length[self._cables].copy()


_LIMIT_TENDON = int(mujoco.mjtConstraint.mjCNSTR_LIMIT_TENDON)

# Primes, so that the product of two kinds names the pair.
_OBJECT, _TRUNK, _ROBOT, _GROUND, _OTHER = 2, 3, 5, 7, 11


def _geom_kinds(model: mujoco.MjModel) -> np.ndarray:
    kinds = np.full(model.ngeom, _OTHER)
    for g in range(model.ngeom):
        name, body = model.geom(g).name, model.body(model.geom_bodyid[g]).name
        if body == "object":
            kinds[g] = _OBJECT
        elif body.startswith(("section_", "finger_", "neck")):
            kinds[g] = _TRUNK
        elif body == "housing" or body.startswith("arm/"):
            kinds[g] = _ROBOT
        elif name.startswith(("table", "ground", "floor")):
            kinds[g] = _GROUND
    return kinds
