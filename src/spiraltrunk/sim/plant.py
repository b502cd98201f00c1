"""The simulated plant: commands and observations as of the real robot."""

from __future__ import annotations

from collections import deque
from copy import deepcopy
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
from spiraltrunk.sim.ground_truth import Sample, TruthRecorder
from spiraltrunk.sim.robot.arm_ik import ArmReach
from spiraltrunk.sim.robot.cable_friction import CableFriction
from spiraltrunk.sim.robot.gripper import GROUPS
from spiraltrunk.sim.scene.build import build_model, build_task
from spiraltrunk.sim.scene.options import TIMESTEP, SceneOptions
from spiraltrunk.sim.sensors import Sensors

CONTROL_PERIOD = 0.02
"""Time between commands [s]: the 50 Hz at which a Python program can feed a Franka controller."""

TENSION_SLEW = 240.0
"""Largest rate of change of a winder's tension [N/s] (ours); a jump to full tension bends joints past their limit."""

GRIPPER_TIME = 0.4
"""Time of the gripper's servo from slack to full tension [s] (ours)."""

EXTREMES_PERIOD = 0.01
"""Sampling period of contacts and joint bends [s]."""

_DIVERGED = tuple(
    int(kind)
    for kind in (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)
)


@final
class SimPlant(Plant):
    """A trunk on an arm and an object in MuJoCo.

    Args:
        design: the design of the robot; the paper's by default.
        options: the scene of the trial.

    Raises:
        DesignError: for a value of another type, and where MuJoCo cannot compile the scene.
    """

    control_period = CONTROL_PERIOD

    def __init__(self, design: TrunkDesign | None = None, options: SceneOptions | None = None) -> None:
        self.design = presets.PAPER if design is None else design
        self.options = SceneOptions() if options is None else options
        self.model = build_model(self.design, self.options)
        self.task = build_task(self.design, self.options)
        self.data = mujoco.MjData(self.model)
        self.trace: list[Sample] = []
        self._reach = ArmReach(self.design)
        names = self._reach.joint_names
        self._friction = CableFriction(self.model, self.design, self.options.trunk)
        self._truth = TruthRecorder(self.model, self.design, names)
        self._arm_motors = _actuators_of(self.model, names)
        self._sensors = Sensors(self.options.sensors)
        self._object = self.model.body("object").id
        self._pending: deque[Command] = deque()
        gain, gear = self.model.actuator_gainprm[self._arm_motors, 0], self.model.actuator_gear[self._arm_motors, 0]
        self._arm_stiffness = gain * gear**2
        self._grippers = [self.model.actuator(name).id for name in GROUPS] if self.design.gripper else []

    @property
    def arm_limits(self) -> ArmLimits:
        """Limits of the arm, those that are known."""
        return self._reach.limits

    @property
    def warnings(self) -> int:
        """Number of warnings of the solver since the last reset."""
        return int(sum(warning.number for warning in self.data.warning))

    def reset(self) -> Observation:
        """Reset to the initial state: object at rest, trunk straight and slack, arm at rest in its home posture."""
        mujoco.mj_resetData(self.model, self.data)
        self.trace.clear()
        self._sensors.reset()
        self._pending.clear()
        self._arm_command = self._reach.home.copy()
        self.data.qpos[self._truth.arm_q] = self._arm_command
        self._tension_limit, self._grip = np.zeros(self.design.n_cable), 0.0
        self.model.actuator_forcerange[self._truth.motors] = 0.0
        self._servo_offset = self._find_servo_offset()
        self.data.ctrl[self._arm_motors] = self._arm_command + self._servo_offset
        self._friction.reset(self.data)
        mujoco.mj_forward(self.model, self.data)
        self.trace.append(self._truth.sample(self.data, self._arm_command))
        return self._observe()

    def step(self, command: Command) -> Observation:
        """Advance by one control period: the arm by inverse kinematics, the winders with at most their tension.

        Raises:
            RunError: before the first reset, for a command that is refused, and where the simulation diverged.
        """
        if not self.trace:
            raise RunError("the plant was stepped before its first reset; allowed: reset, then step")
        command = self._delayed(read_command(command, self.design.n_cable, self.design.cable.tension_max))
        self._arm_command = self._reach.follow(self._arm_command, command.T_world_base, CONTROL_PERIOD)
        self.data.ctrl[self._arm_motors] = self._arm_command + self._servo_offset
        self._pull(command)
        for _ in range(round(CONTROL_PERIOD / EXTREMES_PERIOD)):
            self._friction.step(self.data, round(EXTREMES_PERIOD / TIMESTEP))
            self._truth.update_extremes(self.data)
        if self._has_diverged():
            raise RunError(f"the simulation diverged after {self.trace[-1].time:.2f} s; reset it, and ask for less")
        self.trace.append(self._truth.sample(self.data, self._arm_command))
        return self._observe()

    def _has_diverged(self) -> bool:
        """Whether MuJoCo warned of a state that is not finite or too large; it resets the state then and goes on."""
        warning = self.data.warning
        return any(warning[kind].number for kind in _DIVERGED) or not np.isfinite(self.data.qpos).all()

    def _find_servo_offset(self) -> np.ndarray:
        """Offset of the servos' targets by which they hold the trunk's weight at rest, shape (n_arm,) [rad].

        The arm's controller compensates a known load (Franka: set_load).
        """
        data = self.data
        data.ctrl[self._arm_motors] = self._arm_command
        mujoco.mj_forward(self.model, data)
        held = data.qfrc_actuator[self._truth.arm_v].copy()
        data.qacc[:] = 0.0
        mujoco.mj_inverse(self.model, data)
        return np.asarray((data.qfrc_inverse[self._truth.arm_v] - held) / self._arm_stiffness)

    def _delayed(self, command: Command) -> Command:
        """The command that takes effect now, after the delay; before the first, the initial state is held."""
        late = round(self.options.sensors.delay / CONTROL_PERIOD)
        self._pending.append(deepcopy(command) if late else command)  # Callers may reuse their arrays.
        if len(self._pending) <= late:
            frame = self._reach.T_base(self._arm_command)
            return replace(command, T_world_base=frame, cable_tension=self._tension_limit)
        return self._pending.popleft()

    def _pull(self, command: Command) -> None:
        """Set lengths and tension limits of the winders, which never push, and the gripper's tensions."""
        wanted = np.minimum(np.maximum(command.cable_tension, 0.0), self.design.cable.tension_max)
        step = TENSION_SLEW * CONTROL_PERIOD
        self._tension_limit = np.minimum(np.maximum(wanted, self._tension_limit - step), self._tension_limit + step)
        self.model.actuator_forcerange[self._truth.motors, 0] = -self._tension_limit
        pull = np.inf if command.cable_pull is None else command.cable_pull
        straight = self._truth.straight_length
        self.data.ctrl[self._truth.motors] = np.maximum(straight - np.minimum(pull, straight), 0.0)
        if self.design.gripper is not None:
            step, tension = CONTROL_PERIOD / GRIPPER_TIME, self.design.gripper.tension_max
            wish = max(-1.0, min(1.0, command.gripper))
            self._grip = max(self._grip - step, min(self._grip + step, wish))
            self.data.ctrl[self._grippers] = max(0.0, tension * self._grip), max(0.0, -tension * self._grip)

    def _observe(self) -> Observation:
        data, sensors = self.data, self._sensors
        position, velocity = data.qpos[self._truth.arm_q], data.qvel[self._truth.arm_v]
        torque = sensors.read_torque(data.qfrc_actuator[self._truth.arm_v])
        T_base, wrench = self._reach.estimate_wrench(position, velocity, data.qacc[self._truth.arm_v], torque)
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
            camera=sensors.read_camera(float(data.time), data.xpos[self._object], data.xquat[self._object]),
        )


def _actuators_of(model: mujoco.MjModel, joints: tuple[str, ...]) -> np.ndarray:
    """Position actuator of each joint, in the order of ``joints``."""
    driven = {int(model.actuator_trnid[i, 0]): i for i in range(model.nu) if model.actuator_trntype[i] == 0}
    return np.array([driven[model.joint(name).id] for name in joints])
