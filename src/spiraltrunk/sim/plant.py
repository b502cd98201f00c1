"""The simulated plant: commands and observations as of the real robot."""

from __future__ import annotations

from collections import deque
from copy import deepcopy
from dataclasses import replace
from typing import final

import numpy as np

from spiraltrunk.control.command_check import read_command
from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.plant import CONTROL_PERIOD, TENSION_SLEW, Plant
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import RunError
from spiraltrunk.sim.machine import GRIPPER_TIME, SimMachine
from spiraltrunk.sim.scene.options import EXTREMES_PERIOD, SceneOptions


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
        self._pending: deque[Command] = deque()

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
        if not self.trace:
            raise RunError("the plant was stepped before its first reset; allowed: reset, then step")
        command = self._delayed(read_command(command, self.design.n_cable, self.design.cable.tension_max))
        self.set_arm(self.reach.follow(self._arm_command, command.T_world_base, CONTROL_PERIOD))
        self._pull(command)
        for _ in range(round(CONTROL_PERIOD / EXTREMES_PERIOD)):
            self.advance(EXTREMES_PERIOD)
            self.update_extremes()
        self.record()
        return self._observe()

    def _delayed(self, command: Command) -> Command:
        """The command that takes effect now, after the delay; before the first, the initial state is held."""
        late = round(self.options.sensors.delay / CONTROL_PERIOD)
        self._pending.append(deepcopy(command) if late else command)  # Callers may reuse their arrays.
        if len(self._pending) <= late:
            frame = self.reach.T_base(self._arm_command)
            return replace(command, T_world_base=frame, cable_tension=self._tension_limit)
        return self._pending.popleft()

    def _pull(self, command: Command) -> None:
        """Set lengths and tension limits of the winders, which never push, and the gripper's tensions."""
        wanted = np.minimum(np.maximum(command.cable_tension, 0.0), self.design.cable.tension_max)
        step = TENSION_SLEW * CONTROL_PERIOD
        self._tension_limit = np.minimum(np.maximum(wanted, self._tension_limit - step), self._tension_limit + step)
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
