"""Replay: the run of a log, as the control loop would have returned it."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from spiraltrunk.checks import read_numbers
from spiraltrunk.control.loop import RunLog
from spiraltrunk.control.messages import CameraObservation, Command, Goal, Observation, Target, Task
from spiraltrunk.control.strategy import Milestone, Status
from spiraltrunk.design.toml import load_design
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, DriveError, ModelError, describe
from spiraltrunk.files.results import to_json
from spiraltrunk.hardware.log.channels import CameraLog, CommandLog, EndLog, ObservationLog, StatusLog
from spiraltrunk.hardware.log.metadata import LogMetadata
from spiraltrunk.hardware.log.reader import Log

_Part = TypeVar("_Part", Target, Goal)


DERIVED = {"profile", "longer_side", "side_yaw", "handle"}
"""Fields of a target that follow from the object and are not logged."""


def describe_task(task: Task) -> dict[str, Any]:
    """Target and goal for `LogMetadata.task`; the design is logged as its file."""
    return {
        name: {field.name: to_json(getattr(part, field.name)) for field in fields(part) if field.name not in DERIVED}
        for name, part in (("target", task.target), ("goal", task.goal))
    }


def build_run_log(log: Log) -> RunLog:
    """The run of a log: its steps of which command, status and both observations were logged.

    A run that was cut off ends with its last whole step. A limit of the cable pulled in that is infinite for all cables
    becomes None, which means the same.

    Raises:
        DriveError: where the log holds no run, more than one, or a task that is none.
    """
    seen, told, status = log[ObservationLog], log[CommandLog], log[StatusLog]
    if not seen.step.size:
        raise DriveError("the log holds no run; allowed: one of `spiraltrunk drive run`")
    for steps in (seen.step, told.step, status.step):
        if np.any(np.diff(steps) <= 0):
            raise DriveError("the log holds more than one run; allowed: one")
    task = _read_task(log.metadata)
    rows = _match_steps(seen.step, told.step, status.step)
    ends = log[EndLog]
    n_end = ends.step.size
    statuses = [_build_status(status, row[2]) for row in rows]
    if n_end and rows and told.step[rows[-1][1]] == ends.step[-1]:  # As the loop does where a strategy gives up.
        statuses[-1] = _build_status(ends, n_end - 1)
    return RunLog(
        observations=tuple(_build_observation(log, row, task) for row in (0, *(row[0] for row in rows))),
        commands=tuple(_build_command(told, row[1]) for row in rows),
        statuses=tuple(statuses),
        gave_up=ends.gave_up[-1] if n_end else None,
        planning=float(ends.planning[-1]) if n_end else 0.0,
    )


def read_design(metadata: LogMetadata) -> TrunkDesign:
    """The design of a log.

    Raises:
        DriveError: where it is none.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "trunk.toml")
        file.write_text(metadata.design, encoding="utf-8", errors="replace")
        try:
            return load_design(file)
        except DesignError as error:
            raise DriveError(f"design of the log: {error.name} is {describe(error.got)}") from None


def _match_steps(seen: np.ndarray, told: np.ndarray, status: np.ndarray) -> list[tuple[int, int, int]]:
    """Rows of observation, command and status of each whole step k: observation k + 1, command k and status k."""
    row_seen, row_told = ({int(step): row for row, step in enumerate(steps)} for steps in (seen, told))
    return [
        (row_seen[step + 1], row_told[step], row)
        for row, step in enumerate(status.tolist())
        if step + 1 in row_seen and step in row_told
    ]


def _build_observation(log: Log, row: int, task: Task) -> Observation:
    seen, cameras = log[ObservationLog], log[CameraLog]
    found = np.flatnonzero(cameras.run_time == seen.camera_time[row])
    camera = None
    if found.size:
        i = int(found[-1])
        time = float(cameras.run_time[i])
        camera = CameraObservation(time=time, position=cameras.position[i], axis=cameras.axis[i])
    names = ("T_world_base", "arm_position", "arm_velocity", "cable_pull", "cable_tension", "base_force", "base_torque")
    arrays = {name: getattr(seen, name)[row] for name in names}
    return Observation(time=float(seen.run_time[row]), task=task, camera=camera, **arrays)


def _build_command(told: CommandLog, row: int) -> Command:
    pull = told.cable_pull[row]
    is_limited = bool(np.isfinite(pull).any())
    return Command(
        T_world_base=told.T_world_base[row], cable_tension=told.cable_tension[row], gripper=float(told.gripper[row]),
        cable_pull=np.where(np.isnan(pull), np.inf, pull) if is_limited else None,
    )  # fmt: skip


def _build_status(status: StatusLog | EndLog, row: int) -> Status:
    name = status.milestone[row]
    try:
        milestone = None if name is None else Milestone(name)
    except ValueError:
        allowed = ", ".join(one.value for one in Milestone)
        raise DriveError(f"milestone of the log is {describe(name)}; allowed: {allowed}") from None
    phase, action = status.phase[row] or "", status.action[row] or ""
    is_done, gave_up = bool(status.is_done[row]), status.gave_up[row]
    return Status(phase=phase, action=action, milestone=milestone, is_done=is_done, gave_up=gave_up)


def _read_task(metadata: LogMetadata) -> Task:
    """Task of the run.

    Raises:
        DriveError: where there is none, or it is none.
    """
    task = metadata.task or {}
    target = _read_part(Target, "target", task.get("target"))
    goal = _read_part(Goal, "goal", task.get("goal"))
    return Task(design=read_design(metadata), target=target, goal=goal)


_VECTORS = ("position", "axis", "aside", "place")
_MAYBE = ("ground",)


def _read_part(kind: type[_Part], name: str, values: Any) -> _Part:
    names = {field.name for field in fields(kind)} - DERIVED
    if not isinstance(values, Mapping) or values.keys() != names:
        raise DriveError(f"{name} of the log is {describe(values)}; allowed: {', '.join(sorted(names))}")
    read: dict[str, Any] = {}
    for key, value in values.items():
        if key == "kind" or (key in _MAYBE and value is None):
            read[key] = value
            continue
        shape = (3,) if key in _VECTORS else ()
        try:
            numbers = read_numbers(f"{name}.{key} of the log", value, shape=shape, error=DriveError)
        except ModelError as error:
            raise DriveError(str(error)) from None
        read[key] = numbers if key in _VECTORS else float(numbers)
    return kind(**read)
