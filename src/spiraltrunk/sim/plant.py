"""The simulated robot, with the commands and observations of the real one."""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from typing import final

import mujoco
import numpy as np

from spiraltrunk.control.arm_limits import ArmLimits
from spiraltrunk.control.command_check import read_command
from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.plant import Plant
from spiraltrunk.design import presets
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import RunError
from spiraltrunk.sim.ground_truth import Probe, Sample
from spiraltrunk.sim.robot.arm_ik import ArmReach
from spiraltrunk.sim.robot.cable_friction import CableFriction
from spiraltrunk.sim.robot.gripper import GROUPS
from spiraltrunk.sim.robot.trunk import cable_name
from spiraltrunk.sim.scene.build import build_model, build_task
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.sim.sensors import Sensors

CONTROL_PERIOD = 0.02
"""Time between commands [s]: 50 Hz, as for a Franka controller commanded from Python."""

TENSION_SLEW = 240.0
"""Largest rate of a winder's tension [N/s]: a step to full tension would bend joints past their limit (ours)."""

GRIPPER_TIME = 0.4
"""Time of the gripper's servo from slack to full tension [s] (ours): a step would slam the fingers."""

WATCH_PERIOD = 0.01
"""Time between two checks of contacts and limits [s]."""


_DIVERGED = tuple(
    int(kind)
    for kind in (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)
)


@final
class SimPlant(Plant):
    """A trunk on an arm in MuJoCo, with an object.

    Args:
        design: the robot as designed; the paper's by default.
        options: the scene.
    """

    def __init__(self, design: TrunkDesign | None = None, options: SceneOptions | None = None) -> None:
        self.design = presets.PAPER if design is None else design
        self.options = SceneOptions() if options is None else options
        self.task = build_task(self.design, self.options)
        self.model = build_model(self.design, self.options)
        self.data = mujoco.MjData(self.model)
        self.trace: list[Sample] = []
        self._reach = ArmReach(self.design)
        names = self._reach.joint_names
        has_friction = self.design.cable.friction > 0
        self._friction = CableFriction(self.model, self.design, self.options.trunk) if has_friction else None
        self._probe = Probe(model=self.model, design=self.design, arm_joints=names)
        self._arm_q = np.array([self.model.joint(name).qposadr[0] for name in names])
        self._arm_v = np.array([self.model.joint(name).dofadr[0] for name in names])
        self._arm_motors = _actuators_of(self.model, names)
        self._motors = np.array([self.model.actuator(cable_name(c)).id for c in range(self.design.n_cable)])
        self._watch_steps = max(1, round(WATCH_PERIOD / self.model.opt.timestep))
        self._watches = max(1, round(CONTROL_PERIOD / self.model.opt.timestep / self._watch_steps))
        self._sensors = Sensors(self.options.sensors)
        self._object = self.model.body("object").id
        self._underway: deque[Command] = deque()
        self._arm_stiffness = _stiffness(self.model, self._arm_motors)
        self._arm_command, self._arm_lead = np.zeros(len(names)), np.zeros(len(names))
        self._ceiling = np.zeros(self.design.n_cable)
        self._grip = 0.0
        self._grippers = [self.model.actuator(name).id for name in GROUPS] if self.design.gripper else []

    @property
    def control_period(self) -> float:
        """Time between two commands [s]."""
        return CONTROL_PERIOD

    @property
    def arm_limits(self) -> ArmLimits:
        """Known limits of the arm."""
        return self._reach.limits

    @property
    def warnings(self) -> int:
        """Warnings of the solver since reset."""
        return int(sum(warning.number for warning in self.data.warning))

    def reset(self) -> Observation:
        """Object at rest, trunk straight and slack, arm still in its home posture."""
        mujoco.mj_resetData(self.model, self.data)
        self.trace.clear()
        self._sensors.reset()
        self._underway.clear()
        self._arm_command = self._reach.home.copy()
        self.data.qpos[self._arm_q] = self._arm_command
        self._ceiling, self._grip = np.zeros(self.design.n_cable), 0.0
        self.model.actuator_forcerange[self._motors] = 0.0
        self._arm_lead = self._find_lead()
        self.data.ctrl[self._arm_motors] = self._arm_command + self._arm_lead
        if self._friction is not None:
            self._friction.reset(self.data)
        mujoco.mj_forward(self.model, self.data)
        self.trace.append(self._probe.sample(self.data, self._arm_command))
        return self._observe()

    def step(self, command: Command) -> Observation:
        """Advance one control period; arm targets go through inverse kinematics, cables through their winders."""
        if not self.trace:
            raise RunError("the plant was stepped before its first reset; allowed: reset, then step")
        command = self._delayed(read_command(command, self.design.n_cable))
        self._arm_command = self._reach.follow(self._arm_command, command.T_world_base, CONTROL_PERIOD)
        self.data.ctrl[self._arm_motors] = self._arm_command + self._arm_lead
        self._pull(command)
        for _ in range(self._watches):
            self._advance(self._watch_steps)
            self._probe.watch(self.data)
        if self._has_diverged():
            raise RunError(f"the simulation diverged after {self.trace[-1].time:.2f} s; reset it, and ask for less")
        self.trace.append(self._probe.sample(self.data, self._arm_command))
        return self._observe()

    def _has_diverged(self) -> bool:
        """Whether numbers became infinite or huge, on which MuJoCo resets itself with a warning."""
        warning = self.data.warning
        return any(warning[kind].number for kind in _DIVERGED) or not np.isfinite(self.data.qpos).all()

    def _find_lead(self) -> np.ndarray:
        """Offset of the servos' targets from the posture that compensates the trunk's weight [rad].

        The arm's controller knows the load (Franka: set_load); without it, the arm would sink at the start.
        """
        data = self.data
        data.ctrl[self._arm_motors] = self._arm_command
        mujoco.mj_forward(self.model, data)
        held = data.qfrc_actuator[self._arm_v].copy()
        data.qacc[:] = 0.0
        mujoco.mj_inverse(self.model, data)
        return np.asarray((data.qfrc_inverse[self._arm_v] - held) / self._arm_stiffness)

    def _delayed(self, command: Command) -> Command:
        """The command that takes effect now; until the first one does, the arm holds its posture."""
        late = round(self.options.sensors.delay / CONTROL_PERIOD)
        self._underway.append(_copied(command) if late else command)  # Callers may change their arrays.
        if len(self._underway) <= late:
            return replace(command, T_world_base=self._reach.T_base(self._arm_command), cable_tension=self._ceiling)
        return self._underway.popleft()

    def _advance(self, steps: int) -> None:
        if self._friction is None:
            mujoco.mj_step(self.model, self.data, steps)
        else:
            self._friction.step(self.data, steps)

    def _pull(self, command: Command) -> None:
        """Command the winders: length control limited by the tension, without pushing."""
        wanted = np.minimum(np.maximum(command.cable_tension, 0.0), self.design.cable.tension_max)
        step = TENSION_SLEW * CONTROL_PERIOD
        self._ceiling = np.minimum(np.maximum(wanted, self._ceiling - step), self._ceiling + step)
        self.model.actuator_forcerange[self._motors, 0] = -self._ceiling
        pull = np.inf if command.cable_pull is None else command.cable_pull
        straight = self._probe.straight_length
        self.data.ctrl[self._motors] = np.maximum(straight - np.minimum(pull, straight), 0.0)
        if self.design.gripper is not None:
            step, tension = CONTROL_PERIOD / GRIPPER_TIME, self.design.gripper.tension_max
            wish = max(-1.0, min(1.0, command.gripper))
            self._grip = max(self._grip - step, min(self._grip + step, wish))
            self.data.ctrl[self._grippers] = max(0.0, tension * self._grip), max(0.0, -tension * self._grip)

    def _observe(self) -> Observation:
        data, sensors = self.data, self._sensors
        position, velocity = data.qpos[self._arm_q], data.qvel[self._arm_v]
        torque = sensors.read_torque(data.qfrc_actuator[self._arm_v])
        T_base, wrench = self._reach.feel_base(position, velocity, data.qacc[self._arm_v], torque)
        truth = self.trace[-1]
        return Observation(
            time=float(data.time),
            task=self.task,
            T_world_base=T_base,
            arm_position=position,
            arm_velocity=velocity,
            cable_pull=sensors.read_pull(truth.cable_pull),
            cable_tension=sensors.read_tension(truth.cable_tension),
            base_force=wrench[:3],
            base_torque=wrench[3:],
            camera=sensors.look(float(data.time), data.xpos[self._object], data.xquat[self._object]),
        )


def _copied(command: Command) -> Command:
    frame, tension, pull = command.T_world_base, command.cable_tension, command.cable_pull
    kept = None if pull is None else pull.copy()
    return replace(command, T_world_base=frame.copy(), cable_tension=tension.copy(), cable_pull=kept)


def _actuators_of(model: mujoco.MjModel, joints: tuple[str, ...]) -> np.ndarray:
    """The position actuator on each joint, in the joints' order."""
    driven = {int(model.actuator_trnid[i, 0]): i for i in range(model.nu) if model.actuator_trntype[i] == 0}
    return np.array([driven[model.joint(name).id] for name in joints])


def _stiffness(model: mujoco.MjModel, motors: np.ndarray) -> np.ndarray:
    """Stiffness of position actuators at their joints [N m/rad]."""
    return np.asarray(model.actuator_gainprm[motors, 0] * model.actuator_gear[motors, 0] ** 2)
