"""Recording: the driver's messages as they are logged."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, final

import numpy as np

from spiraltrunk.control.loop import RunLog
from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.plant import Plant
from spiraltrunk.control.strategy import Status
from spiraltrunk.hardware.arm.arm_port import ArmState
from spiraltrunk.hardware.clock import Clock
from spiraltrunk.hardware.log.writer import LogWriter
from spiraltrunk.hardware.motors.motor_port import MotorState
from spiraltrunk.hardware.safety.fault import Fault

_SILENT = MotorState(time=np.nan, angle=np.nan, speed=np.nan, torque=np.nan, temperature=np.nan)
"""A motor without feedback."""


def log_motors(
    log: LogWriter,
    time: float,
    states: Sequence[MotorState | None],
    *,
    sent: Any,
    pull: Any,
    tension: Any,
    target: Any,
    felt: Any = None,
) -> None:
    """Log the feedback of all motors, one per cable.

    Args:
        log: the log.
        time: time on the driver's clock [s].
        states: latest feedback of each motor.
        sent: torque that was sent last, shape (n_cable,) [N m].
        pull: cable pulled in since the straight trunk, shape (n_cable,) [m].
        tension: tension by load cells, or as it is estimated, shape (n_cable,) [N].
        target: tension that the winder is told to hold, shape (n_cable,) [N].
        felt: tension by load cells, shape (n_cable,) [N], NaN for a cable without; None for no load cells.
    """
    known = [_SILENT if state is None else state for state in states]
    values = {name: [getattr(state, name) for state in known] for name in _MOTOR_FIELDS}
    values["feedback_time"] = [state.time for state in known]
    felt = [None] * len(known) if felt is None else felt
    told = {"torque_sent": sent, "pull": pull, "tension": tension, "felt": felt, "target": target}
    log.write("/motors", time, values | told)


_MOTOR_FIELDS = ("angle", "speed", "torque", "temperature", "voltage")


def log_arm(log: LogWriter, state: ArmState) -> None:
    """Log a measured state of the arm at its own time."""
    names = ("position", "velocity", "acceleration", "torque", "error")
    log.write("/arm", state.time, {name: getattr(state, name) for name in names})


def log_state(log: LogWriter, time: float, mode: str, cause: str | None = None) -> None:
    """Log that the driver entered a state."""
    log.write("/state", time, {"mode": mode, "cause": cause})


def log_fault(log: LogWriter, fault: Fault, reaction: str | None = None) -> None:
    """Log a fault at its own time, and what was done."""
    values = {"kind": fault.kind.value, "cable": fault.cable, "text": fault.text, "reaction": reaction}
    log.write("/fault", fault.time, values)


def log_warning(log: LogWriter, time: float, text: str) -> None:
    """Log a warning of one line."""
    log.write("/warning", time, {"text": text})


@final
class LoggedPlant(Plant):
    """A plant whose messages are logged; pass `watch` to `control.run` to log the strategy's statuses."""

    def __init__(self, plant: Plant, log: LogWriter, clock: Clock) -> None:
        self._plant, self._log, self._clock = plant, log, clock
        self._step, self._camera_time = 0, np.nan

    @property
    def control_period(self) -> float:
        """Time between two commands [s]."""
        return self._plant.control_period

    def reset(self) -> Observation:
        """Reset the plant and log the first observation."""
        self._step, self._camera_time = 0, np.nan
        return self._log_observation(self._plant.reset())

    def step(self, command: Command) -> Observation:
        """Log a command and the observation that follows it."""
        pull = command.cable_pull
        self._log.write("/command", self._clock.now(), {
            "step": self._step, "T_world_base": _copy(command.T_world_base),
            "cable_tension": _copy(command.cable_tension), "cable_pull": None if pull is None else _copy(pull),
            "gripper": command.gripper,
        })  # fmt: skip
        observation = self._plant.step(command)
        self._step += 1
        return self._log_observation(observation)

    def watch(self, observation: Observation, status: Status) -> None:
        """Log the status of the last command."""
        self._log.write("/status", self._clock.now(), _list_status(self._step - 1, status))

    def end(self, run: RunLog) -> None:
        """Log how the run ended."""
        last = run.statuses[-1] if run.statuses else Status(phase="", action="", gave_up=run.gave_up)
        values = _list_status(self._step - 1, last) | {"planning": run.planning}
        self._log.write("/end", self._clock.now(), values)

    def _log_observation(self, seen: Observation) -> Observation:
        now, camera = self._clock.now(), seen.camera
        if camera is not None and camera.time != self._camera_time:
            self._camera_time = camera.time
            position, axis = _copy(camera.position), _copy(camera.axis)
            self._log.write("/camera", now, {"run_time": camera.time, "position": position, "axis": axis})
        values: dict[str, Any] = {name: _copy(getattr(seen, name)) for name in _SEEN}
        values |= {"step": self._step, "run_time": seen.time, "camera_time": None if camera is None else camera.time}
        self._log.write("/observation", now, values)
        return seen


_SEEN = (
    "T_world_base", "arm_position", "arm_velocity", "cable_pull", "cable_tension", "base_force", "base_torque",
)  # fmt: skip
"""Arrays of an observation."""


def _list_status(step: int, status: Status) -> dict[str, Any]:
    milestone = None if status.milestone is None else status.milestone.value
    names = ("phase", "action", "is_done", "gave_up")
    return {name: getattr(status, name) for name in names} | {"step": step, "milestone": milestone}


def _copy(values: np.ndarray) -> list[Any]:
    """Numbers that nobody can change any more."""
    return np.asarray(values).tolist()
