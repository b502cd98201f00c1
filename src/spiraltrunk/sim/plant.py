"""The simulated plant: commands and observations as of the real robot."""

from __future__ import annotations

from collections import deque
from copy import deepcopy
from typing import final

import mujoco
import numpy as np

from spiraltrunk.checks import read_numbers
from spiraltrunk.control.command_check import read_command
from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.plant import CONTROL_PERIOD, TENSION_SLEW, Plant
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import RunError
from spiraltrunk.sim.machine import GRIPPER_TIME, SimMachine
from spiraltrunk.sim.plant_state import Pending, PlantState
from spiraltrunk.sim.scene.options import EXTREMES_PERIOD, SceneOptions

_SPANS = round(CONTROL_PERIOD / EXTREMES_PERIOD)
"""Spans of a control period, at the ends of which extremes are taken: at the last one with the sample [-]."""


@final
class SimPlant(SimMachine, Plant):
    """A trunk on an arm and an object in MuJoCo, with winders that hold tension and length ideally.

    Args:
        design: the design of the robot; the paper's by default.
        options: the scene of the trial.

    Raises:
        DesignError: for a value of another type, and where MuJoCo cannot compile the scene.
    """

    control_period = CONTROL_PERIOD

    def __init__(self, design: TrunkDesign | None = None, options: SceneOptions | None = None) -> None:
        super().__init__(design, options)
        self._pending: deque[Pending] = deque()

    def reset(self) -> Observation:
        """Reset to the initial state: object at rest, trunk straight and slack, arm at rest in its home posture."""
        self._pending.clear()
        self._tension_limit, self._grip = np.zeros(self.design.n_cable), 0.0
        self.restore()
        return self._observe()

    def step(self, command: Command) -> Observation:
        """Advance by one control period: the arm by inverse kinematics, the winders with at most their tension.

        Raises:
            RunError: before the first reset, for a command that is refused, and where the simulation diverged.
        """
        return self._step(command, None)

    def step_joints(self, position: np.ndarray, command: Command) -> Observation:
        """`step` with the arm's joints on the straight way to positions, in place of the base on its way to a frame.

        Args:
            position: joint positions, shape (n_arm,) [rad].
            command: command of cables and gripper; its frame is not used.

        Raises:
            RunError: as `step`, and for positions that are refused.
        """
        shape = self.reach.home.shape
        return self._step(command, read_numbers("arm_position", position, shape=shape, error=RunError).copy())

    def _step(self, command: Command, position: np.ndarray | None) -> Observation:
        if not self.trace:
            raise RunError("the plant was stepped before its first reset; allowed: reset, then step")
        command = read_command(command, self.design.n_cable, self.design.cable.tension_max)
        command, position = self._delayed(command, position)
        start = self._arm_command
        end = self._lead_arm(start, command, position)
        self._pull(command)
        self._move_arm(end, has_arrived=end is start)
        self.record()
        return self._observe()

    def predict_arm(self) -> list[np.ndarray]:
        """Joint positions that the commands under way, which have not taken effect yet, will lead the arm to.

        Returns:
            One for each of these commands, in their order, shape (n_arm,) each [rad]; none where there is no delay.
        """
        arrived, position, ahead = self.reach.arrived, self._arm_command, []
        for command, joints in self._pending:
            position = self._lead_arm(position, command, joints)
            ahead.append(position.copy())
        self.reach.arrived = arrived  # As if nothing had been asked.
        return ahead

    def _lead_arm(self, start: np.ndarray, command: Command, position: np.ndarray | None) -> np.ndarray:
        """Joint positions a control period after others by a command, or by joint positions, shape (n_arm,) [rad]."""
        if position is None:
            return self.reach.follow(start, command.T_world_base, CONTROL_PERIOD)
        return self.reach.approach(start, position, CONTROL_PERIOD)

    def _move_arm(self, end: np.ndarray, *, has_arrived: bool) -> None:
        """Advance by a control period in which the arm's targets go to a position, shape (n_arm,) [rad]."""
        if has_arrived:
            self.set_arm(end)
            for i in range(_SPANS):
                if i > 0:
                    self.update_extremes()
                self.advance(EXTREMES_PERIOD)
            return
        ctrl, motors, period = self.data.ctrl, self._arm_motors, self.arm_period
        targets = self.interpolate_arm(end) + self._servo_offset
        for i, part in enumerate(targets.reshape(_SPANS, -1, end.size)):
            if i > 0:
                self.update_extremes()
            for target in part:
                ctrl[motors] = target
                self.advance(period)
        self._arm_command = end

    def get_state(self) -> PlantState:
        """State of the plant between two steps: what `set_state` restores bit for bit.

        Raises:
            RunError: before the first reset.
        """
        if not self.trace:
            raise RunError("the plant has no state before its first reset; allowed: reset, then get_state")
        integration = np.zeros(mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_INTEGRATION))
        mujoco.mj_getState(self.model, self.data, integration, mujoco.mjtState.mjSTATE_INTEGRATION)
        return PlantState(
            integration=integration, force_range=self.model.actuator_forcerange.copy(),
            warnings=tuple(int(warning.number) for warning in self.data.warning), friction=self._friction.get_state(),
            arm_command=self._arm_command.copy(), servo_offset=self._servo_offset.copy(), arrived=self.reach.arrived,
            tension_limit=self._tension_limit.copy(), grip=self._grip, pending=deepcopy(tuple(self._pending)),
            sensors=self._sensors.get_state(), extremes=self._truth.get_extremes(), trace=tuple(self.trace),
        )  # fmt: skip

    def set_state(self, state: PlantState) -> None:
        """Restore a state of a plant of the same design and scene.

        Raises:
            RunError: for the state of a plant of another size.
        """
        size = mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_INTEGRATION)
        if state.integration.shape != (size,) or state.force_range.shape != self.model.actuator_forcerange.shape:
            raise RunError(f"the state has {state.integration.size} numbers; allowed: {size}, of the same scene")
        mujoco.mj_resetData(self.model, self.data)
        self.model.actuator_forcerange[:] = state.force_range
        mujoco.mj_setState(self.model, self.data, state.integration, mujoco.mjtState.mjSTATE_INTEGRATION)
        mujoco.mj_forward(self.model, self.data)  # For poses and contacts; it changes the warm start.
        mujoco.mj_setState(self.model, self.data, state.integration, mujoco.mjtState.mjSTATE_INTEGRATION)
        for warning, number in zip(self.data.warning, state.warnings, strict=True):
            warning.number = number
        self._friction.set_state(state.friction)
        self._arm_command, self._servo_offset = state.arm_command.copy(), state.servo_offset.copy()
        self.reach.arrived = state.arrived
        self._tension_limit, self._grip = state.tension_limit.copy(), state.grip
        self._pending = deque(deepcopy(state.pending))
        self._sensors.set_state(state.sensors)
        self._truth.set_extremes(state.extremes)
        self.trace[:] = state.trace

    def _delayed(self, command: Command, position: np.ndarray | None) -> Pending:
        """The command that takes effect now, after the delay; before the first, the initial state is held."""
        late = round(self.options.sensors.delay / CONTROL_PERIOD)
        self._pending.append((_copy(command) if late else command, position))  # Callers may reuse their arrays.
        if len(self._pending) <= late:
            frame = self.reach.T_base(self._arm_command)
            held = Command(T_world_base=frame, cable_tension=self._tension_limit, gripper=self._grip)
            return held, None
        return self._pending.popleft()

    def _pull(self, command: Command) -> None:
        """Set lengths and tension limits of the winders, which never push, and the gripper's tensions."""
        most, step = self.design.cable.tension_max, TENSION_SLEW * CONTROL_PERIOD
        pairs = zip(command.cable_tension.tolist(), self._tension_limit.tolist(), strict=True)
        limits = [min(max(min(max(wanted, 0.0), most), last - step), last + step) for wanted, last in pairs]
        self._tension_limit = np.array(limits)  # In plain numbers: on three cables, arrays take twice as long.
        self.set_cables(self._tension_limit, np.inf if command.cable_pull is None else command.cable_pull)
        step = CONTROL_PERIOD / GRIPPER_TIME
        self._grip = max(self._grip - step, min(self._grip + step, max(-1.0, min(1.0, command.gripper))))
        self.set_gripper(self._grip)

    def _observe(self) -> Observation:
        position, velocity, acceleration, torque = self.read_arm()
        T_base, wrench = self.reach.estimate_wrench(position, velocity, acceleration, torque)
        truth, sensors = self.trace[-1], self._sensors
        return Observation(
            time=float(self.data.time),
            task=self.task,
            T_world_base=T_base,
            arm_position=position,
            arm_velocity=velocity,
            cable_pull=sensors.read_pull(truth.cable_pull),
            cable_tension=sensors.read_tension(truth.cable_tension),
            base_force=wrench[:3],
            base_torque=wrench[3:],
            camera=self.read_camera(),
        )


def _copy(command: Command) -> Command:
    pull = None if command.cable_pull is None else command.cable_pull.copy()
    return Command(
        T_world_base=command.T_world_base.copy(), cable_tension=command.cable_tension.copy(), cable_pull=pull,
        gripper=command.gripper,
    )  # fmt: skip
