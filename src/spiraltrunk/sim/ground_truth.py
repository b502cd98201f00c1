"""Ground truth of a trial, read from the simulator's state; for verdicts and plots, not available to strategies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.robot.arm import PREFIX
from spiraltrunk.sim.robot.trunk import cable_name, hinge_names
from spiraltrunk.sim.truth_kernel import (
    GROUND,
    OBJECT,
    OTHER,
    ROBOT,
    TRUNK,
    Contacts,
    Motions,
    Places,
    find_extremes,
    measure_grip,
)

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
        names = zip(*(hinge_names(i) for i in range(design.n_joint)), strict=True)
        self._places = Places(
            hinges=np.array([[model.joint(name).qposadr[0] for name in axis] for axis in names]),
            kind=_geom_kinds(model), body=model.geom_bodyid.copy(), root=model.body_rootid.copy(),
            target=model.body("object").id,
        )  # fmt: skip
        self._joint_bend = np.zeros(design.n_joint)
        self._cables = as_slice([model.tendon(cable_name(c)).id for c in range(design.n_cable)])
        self._strings = {t for t in range(model.ntendon) if model.tendon(t).name.startswith("string_")}
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

    def update_extremes(self, data: mujoco.MjData) -> bool:
        """Update the extremes with the present state; whether the object touches a support in it."""
        contact = data.contact
        bend, seen = find_extremes(self._places, data.qpos, contact.geom, contact.dist, self._joint_bend)
        penetration, on_robot, touches_table, arm_on_ground = seen
        self._bend, self._penetration = max(self._bend, bend), max(self._penetration, penetration)
        self._touches_robot |= on_robot
        self._arm_touches_ground |= arm_on_ground
        return bool(touches_table)

    def sample(self, data: mujoco.MjData, arm_command: np.ndarray) -> Sample:
        """Ground truth of the present state, which its extremes include; resets the extremes.

        Args:
            data: the state.
            arm_command: commanded positions of the arm's joints, shape (n_arm,) [rad].
        """
        touches_table, slip = self.update_extremes(data), np.zeros(3)
        sample = Sample(
            time=data.time,
            qpos=data.qpos.copy(),
            object_position=data.xpos[self._places.target].copy(),
            object_axis=data.xmat[self._places.target, 0:9:3].copy(),
            joint_bend=self._joint_bend.copy(),
            cable_pull=self.straight_length - data.ten_length[self._cables],
            cable_tension=-data.actuator_force[self.motors],
            grip_force=self._measure_grip(data, slip),
            slip_velocity=slip,
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

    def _measure_grip(self, data: mujoco.MjData, slip: np.ndarray) -> float:
        """Sum of the normal forces between trunk and object [N]; ``slip`` becomes their mean sliding velocity."""
        contact = data.contact
        contacts = Contacts(contact.geom, contact.dist, contact.efc_address, contact.pos, contact.frame)
        return measure_grip(self._places, contacts, Motions(data.cvel, data.subtree_com), data.efc_force, slip)

    def _string_tension(self, data: mujoco.MjData) -> float:
        if not self._strings:
            return 0.0
        first = data.ne + data.nf  # Rows of limits follow those of equalities and of dry friction.
        end = first + data.nl
        kinds, tendons = data.efc_type[first:end].tolist(), data.efc_id[first:end].tolist()
        pairs = enumerate(zip(kinds, tendons, strict=True), first)
        rows = [row for row, (kind, tendon) in pairs if kind == _STRING_LIMIT and tendon in self._strings]
        return sum(data.efc_force[rows].tolist()) if rows else 0


def as_slice(indices: Sequence[int]) -> slice | np.ndarray:
    """The part of an array at some indices: a slice where they are consecutive, which NumPy reads and writes sooner.

    A part that is kept has to be copied.
    """
    first, last = indices[0], indices[-1]
    return slice(first, last + 1) if list(indices) == list(range(first, last + 1)) else np.array(indices)


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
