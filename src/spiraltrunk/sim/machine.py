"""The simulated machine below any controller: arm, cables and gripper that are driven directly, and the ground truth.

`SimPlant` drives it with ideal winders; the twin of the hardware drives it through motors, buses and a driver.
"""

from __future__ import annotations

import math
from dataclasses import replace

import mujoco
import numpy as np

from spiraltrunk.control.arm_limits import ArmLimits
from spiraltrunk.control.messages import CameraObservation
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.design import presets
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import RunError
from spiraltrunk.sim.ground_truth import Sample, TruthRecorder, as_slice
from spiraltrunk.sim.robot.arm_ik import ArmReach
from spiraltrunk.sim.robot.cable_friction import CableFriction
from spiraltrunk.sim.robot.gripper import GROUPS, LEGS
from spiraltrunk.sim.robot.trunk import section_name
from spiraltrunk.sim.scene.build import build_model, build_task
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.sim.sensors import Sensors

GRIPPER_TIME = 0.4
"""Time of the gripper's servo from slack to full tension [s] (ours)."""

ARM_PERIOD = 0.002
"""Period of the set points of the arm's joints between two commands [s]: they go there on straight ways, as its
controller interpolates. In one step of a control period, a joint's torque would reach its limit at 0.3 rad/s."""

_DIVERGED = tuple(
    int(kind)
    for kind in (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)
)
"""Warnings of a state that is not finite or too large."""


class SimMachine:
    """A trunk on an arm and an object in MuJoCo.

    Args:
        design: the design of the robot; the paper's by default.
        options: the scene of the trial.

    Raises:
        DesignError: for a value of another type, and where MuJoCo cannot compile the scene.
    """

    control_period = CONTROL_PERIOD
    """Time between two samples of the trace [s]."""

    def __init__(self, design: TrunkDesign | None = None, options: SceneOptions | None = None) -> None:
        self.design = presets.PAPER if design is None else design
        self.options = SceneOptions() if options is None else options
        self.model = build_model(self.design, self.options)
        self.task = build_task(self.design, self.options)
        self.data = mujoco.MjData(self.model)
        self.trace: list[Sample] = []
        """Ground truth at the end of every control period, the initial state first."""
        self.reach = ArmReach(self.design)
        """Inverse kinematics of the arm, as its controller has it."""
        names = self.reach.joint_names
        self._friction = CableFriction(self.model, self.design, self.options.trunk)
        self._truth = TruthRecorder(self.model, self.design, names)
        self._arm_motors = _actuators_of(self.model, names)
        self._sensors = Sensors(self.options.sensors)
        self._object = self.model.body("object").id
        gain, gear = self.model.actuator_gainprm[self._arm_motors, 0], self.model.actuator_gear[self._arm_motors, 0]
        self._arm_stiffness = gain * gear**2
        self._grippers = [] if self.design.gripper is None else _find_grippers(self.model)
        timestep = self.options.timestep
        self.arm_period = ARM_PERIOD if _divides(timestep, ARM_PERIOD) else timestep
        """Time between two set points of the arm on its way to a target [s]: `ARM_PERIOD`, or the time step."""
        n = round(CONTROL_PERIOD / self.arm_period)
        self._shares = np.arange(1, n + 1)[:, None] / n

    @property
    def arm_limits(self) -> ArmLimits:
        """Limits of the arm, those that are known."""
        return self.reach.limits

    @property
    def warnings(self) -> int:
        """Number of warnings of the solver since the last reset."""
        return int(sum(warning.number for warning in self.data.warning))

    def restore(self) -> None:
        """Restore the initial state: object at rest, trunk straight and slack, arm at rest in its home posture."""
        mujoco.mj_resetData(self.model, self.data)
        self.trace.clear()
        self._sensors.reset()
        self._arm_command = self.reach.home.copy()
        self.data.qpos[self._truth.arm_q] = self._arm_command
        self.model.actuator_forcerange[self._truth.motors] = 0.0
        self._servo_offset = self._find_servo_offset()
        self.data.ctrl[self._arm_motors] = self._arm_command + self._servo_offset
        self._friction.reset(self.data)
        mujoco.mj_forward(self.model, self.data)
        first = self._truth.sample(self.data, self._arm_command)
        # No period precedes it, of which there would be extremes.
        self.trace.append(replace(first, penetration=0.0, bend_most=0.0, touches_robot=False, arm_touches_ground=False))

    def restart_trace(self) -> None:
        """Let time and trace begin anew with the present state."""
        self.data.time = 0.0
        self.trace.clear()
        self.trace.append(self._truth.sample(self.data, self._arm_command))

    def hold_arm(self) -> None:
        """Stop the arm at its present target."""
        self.set_arm(self._arm_command)

    def set_arm(self, position: np.ndarray) -> None:
        """Set the targets of the arm's joints, shape (n_arm,) [rad]."""
        self._arm_command = position
        self.data.ctrl[self._arm_motors] = position + self._servo_offset

    def interpolate_arm(self, position: np.ndarray) -> np.ndarray:
        """Set points of the arm's joints on the straight way from the present ones to a target.

        Args:
            position: the target, shape (n_arm,) [rad].

        Returns:
            One set point for every `arm_period` of a control period, the target last, shape (n, n_arm) [rad].
        """
        start = self._arm_command
        targets = start + self._shares * (position - start)
        targets[-1] = position
        return np.asarray(targets)

    def set_cables(self, tension: np.ndarray, pull: np.ndarray | float) -> None:
        """Set the largest tension [N] and the largest pull [m] of each cable, shape (n_cable,), until set again."""
        self.model.actuator_forcerange[self._truth.motors, 0] = -tension
        straight = self._truth.straight_length
        free = 0.0 if pull is np.inf else np.maximum(straight - np.minimum(pull, straight), 0.0)
        self.data.ctrl[self._truth.motors] = free

    def set_cable_stiffness(self, stiffness: np.ndarray) -> None:
        """Set the stiffness between each cable and its winder, shape (n_cable,) [N/m]; 0 for a cable that is broken."""
        self.model.actuator_gainprm[self._truth.motors, 0] = stiffness
        self.model.actuator_biasprm[self._truth.motors, 1] = -stiffness

    def set_gripper(self, share: float) -> None:
        """Set the tension of the gripper's cables over its largest, from -1 (opening) to 1 (closing) [-]."""
        if self.design.gripper is not None:
            tension = self.design.gripper.tension_max
            pulls = max(0.0, tension * share), max(0.0, -tension * share)
            for motors, pull in zip(self._grippers, pulls, strict=True):
                self.data.ctrl[motors] = pull

    def advance(self, duration: float) -> None:
        """Advance the physics by a whole number of time steps [s]."""
        self._friction.step(self.data, round(duration / self.options.timestep))

    def update_extremes(self) -> None:
        """Take the present contacts and joint bends into the extremes of the next sample, besides its own."""
        self._truth.update_extremes(self.data)

    def record(self) -> None:
        """Append a sample to the trace.

        Raises:
            RunError: where the simulation diverged.
        """
        if self.has_diverged():
            raise RunError(f"the simulation diverged after {self.trace[-1].time:.2f} s; reset it, and ask for less")
        self.trace.append(self._truth.sample(self.data, self._arm_command))

    def read_arm(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Measured positions, velocities, accelerations and torques of the arm's joints, each of shape (n_arm,)."""
        data, part = self.data, self._truth.arm_v
        position, velocity, acceleration = data.qpos[self._truth.arm_q], data.qvel[part], data.qacc[part]
        torque = self._sensors.read_torque(data.qfrc_actuator[part])  # A copy.
        return position.copy(), velocity.copy(), acceleration.copy(), torque

    def read_cable_tension(self) -> np.ndarray:
        """True tension of each cable at its motor, shape (n_cable,) [N]."""
        return np.asarray(-self.data.actuator_force[self._truth.motors])

    def read_section_frames(self) -> np.ndarray:
        """True frames of the trunk's sections in that of the first one, shape (n_section, 4, 4) [-, m]."""
        bodies = [self.model.body(section_name(n)).id for n in range(self.design.n_section)]
        turn, place = self.data.xmat[bodies].reshape(-1, 3, 3), self.data.xpos[bodies]
        frames = np.zeros((len(bodies), 4, 4))
        frames[:, :3, :3] = turn[0].T @ turn
        frames[:, :3, 3] = (place - place[0]) @ turn[0]
        frames[:, 3, 3] = 1.0
        return frames

    def read_camera(self) -> CameraObservation | None:
        """The camera's latest observation of the object; None without a camera."""
        data = self.data
        return self._sensors.read_camera(float(data.time), data.xpos[self._object], data.xquat[self._object])

    def has_diverged(self) -> bool:
        """Whether MuJoCo warned of a state that is not finite or too large; it resets the state then and goes on."""
        counts, qpos = self.data.warning.number.tolist(), self.data.qpos
        # MuJoCo warns from 1e10 on: below, squares sum up to a finite number. This takes a fifth of `np.isfinite`.
        return any(counts[kind] for kind in _DIVERGED) or not math.isfinite(qpos.dot(qpos))

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


def _divides(part: float, whole: float) -> bool:
    count = round(whole / part)
    return count >= 1 and abs(count * part - whole) < 1e-9


def _find_grippers(model: mujoco.MjModel) -> list[slice | np.ndarray]:
    """Actuators of the closing and of the opening cable group, on the fingers and, with two legs, on the trunk."""
    known = {model.actuator(i).name: i for i in range(model.nu)}
    groups = ([known[name] for name in names if name in known] for names in zip(GROUPS, LEGS, strict=True))
    return [as_slice(group) for group in groups]


def _actuators_of(model: mujoco.MjModel, joints: tuple[str, ...]) -> slice | np.ndarray:
    """Position actuator of each joint, in the order of ``joints``."""
    driven = {int(model.actuator_trnid[i, 0]): i for i in range(model.nu) if model.actuator_trntype[i] == 0}
    return as_slice([driven[model.joint(name).id] for name in joints])
