"""An episode: everything between plant and strategy in one trial, as arrays, with the world and the verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, final

import numpy as np

from spiraltrunk.control.messages import CameraObservation, Command, Goal, Observation, Target, Task
from spiraltrunk.control.object_handle import Handle
from spiraltrunk.control.object_profile import ObjectProfile
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.design.toml import parse_design
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.files.results import to_json
from spiraltrunk.strategies.moves import PHASES
from spiraltrunk.workflows.demos.options import CONTROL_RATE
from spiraltrunk.workflows.demos.recording.frames import Frames, choose_steps

PHASE_NAMES = PHASES
"""Names of the phases, by their numbers in episodes."""

MILESTONE_NAMES = ("none", *(milestone.value for milestone in Milestone))
"""Names of the milestones, by their numbers in episodes; 0 between milestones."""


_SECTIONS, _FIGURES = (
    ("height", "width_least", "width_most", "girth"), ("center_height", "topple_angle", "support_radius"),
)  # fmt: skip
"""What is stored of an object's profile."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Episode:
    """A recorded trial of n commands; the arrays of observations have n + 1 rows, those of commands n."""

    about: Mapping[str, Any]
    """Provenance, ready for JSON: strategy, object, seed, verdict, world, versions, design, task."""
    time: np.ndarray
    """Times of the observations, shape (n + 1,) [s]."""
    T_world_base: np.ndarray
    """Measured pose of the trunk's base, shape (n + 1, 4, 4) [-, m]."""
    arm_position: np.ndarray
    """Joint positions of the arm, shape (n + 1, n_arm) [rad]."""
    arm_velocity: np.ndarray
    """Joint velocities of the arm, shape (n + 1, n_arm) [rad/s]."""
    cable_pull: np.ndarray
    """Measured cable pulled in, shape (n + 1, n_cable) [m]."""
    cable_tension: np.ndarray
    """Estimated tension, shape (n + 1, n_cable) [N]."""
    base_force: np.ndarray
    """Force on the trunk's base, in the world, shape (n + 1, 3) [N]."""
    base_torque: np.ndarray
    """Torque about the trunk's base, in the world, shape (n + 1, 3) [N m]."""
    camera: np.ndarray
    """Latest camera observation: time, position and axis of the object, shape (n + 1, 7) [s, m, -]; NaN without."""
    T_world_base_command: np.ndarray
    """Desired pose of the trunk's base, shape (n, 4, 4) [-, m]."""
    command_arm_position: np.ndarray
    """Joint positions of the arm that inverse kinematics makes of it, shape (n, n_arm) [rad]."""
    command_tension: np.ndarray
    """Upper limit of each cable's tension, shape (n, n_cable) [N]."""
    command_pull: np.ndarray
    """Upper limit of the cable pulled in, shape (n, n_cable) [m]; infinite where the command sets none."""
    command_gripper: np.ndarray
    """Tip gripper from -1 (open) to 1 (closed), shape (n,) [-]."""
    phase: np.ndarray
    """Phase at each command, a number in PHASE_NAMES, shape (n,)."""
    milestone: np.ndarray
    """What each command works towards, a number in MILESTONE_NAMES, shape (n,)."""
    action: np.ndarray
    """What the strategy says that it does at each command, shape (n,)."""
    state: np.ndarray
    """MuJoCo's time, generalised positions and velocities, shape (n + 1, 1 + n_q + n_v)."""
    frames: Frames
    """What a policy sees and does, at the rate and in the control mode that were asked for."""
    scene: str = ""
    """MJCF of the scene."""
    videos: Mapping[str, bytes] = field(default_factory=dict)
    """Pictures of each camera as a lossless video, one at every frame and one of the last observation."""

    def __len__(self) -> int:
        return len(self.phase)

    @property
    def steps(self) -> np.ndarray:
        """Observations that are frames, and the last one, shape (m + 1,)."""
        return choose_steps(len(self), CONTROL_RATE // int(self.about["recording"]["fps"]))


OF_OBSERVATIONS = (
    "time", "T_world_base", "arm_position", "arm_velocity", "cable_pull", "cable_tension", "base_force", "base_torque",
    "camera", "state",
)  # fmt: skip
"""Arrays with a row for each observation."""

OF_COMMANDS = (
    "T_world_base_command", "command_arm_position", "command_tension", "command_pull", "command_gripper", "phase",
    "milestone", "action",
)  # fmt: skip
"""Arrays with a row for each command."""

ARRAYS = (*OF_OBSERVATIONS, *OF_COMMANDS)
"""Names of all arrays of an episode."""


def stack_observations(seen: Sequence[Observation]) -> dict[str, np.ndarray]:
    """Arrays of observations, by their names in an episode."""
    names = ("time", "T_world_base", "arm_position", "arm_velocity", "cable_pull", "cable_tension", "base_force")
    columns = {name: np.array([getattr(each, name) for each in seen]) for name in (*names, "base_torque")}
    nothing = np.full(7, np.nan)
    looks = [each.camera for each in seen]
    camera = [nothing if look is None else np.array([look.time, *look.position, *look.axis]) for look in looks]
    return columns | {"camera": np.stack(camera)}


def stack_commands(commands: Sequence[Command]) -> dict[str, np.ndarray]:
    """Arrays of commands, by their names in an episode."""
    free = np.full_like(commands[0].cable_tension, np.inf)
    return {
        "T_world_base_command": np.stack([each.T_world_base for each in commands]),
        "command_tension": np.stack([each.cable_tension for each in commands]),
        "command_pull": np.stack([free if each.cable_pull is None else each.cable_pull for each in commands]),
        "command_gripper": np.array([each.gripper for each in commands]),
    }


def describe_task(task: Task) -> dict[str, Any]:
    """Target and goal of a task, ready for JSON; of the object's profile all but its stable poses."""
    target = {each.name: getattr(task.target, each.name) for each in fields(Target)}
    if task.target.profile is not None:
        profile = task.target.profile
        target["profile"] = {name: getattr(profile, name) for name in (*_SECTIONS, *_FIGURES)}
    if task.target.handle is not None:
        target["handle"] = {each.name: getattr(task.target.handle, each.name) for each in fields(Handle)}
    goal = {each.name: getattr(task.goal, each.name) for each in fields(Goal)}
    return {"target": to_json(target), "goal": to_json(goal)}


def restore_task(episode: Episode) -> Task:
    """The task of an episode; the object's profile is without stable poses."""
    told = episode.about["task"]
    target = {**told["target"], **{key: np.array(told["target"][key]) for key in ("position", "axis")}}
    goal = {**told["goal"], **{key: np.array(told["goal"][key]) for key in ("aside", "place")}}
    if target["profile"] is not None:
        sections = {key: np.array(target["profile"][key]) for key in _SECTIONS}
        target["profile"] = ObjectProfile(**{**target["profile"], **sections})
    if target.get("handle") is not None:
        told_handle = target["handle"]
        target["handle"] = Handle(
            direction=np.array(told_handle["direction"]), body_width=told_handle["body_width"],
            body_offset=np.array(told_handle["body_offset"]),
        )  # fmt: skip
    design = parse_design(episode.about["design"].encode(), "design")
    return Task(design=design, target=Target(**target), goal=Goal(**goal))


def restore_observations(episode: Episode) -> list[Observation]:
    """The observations of an episode, n + 1 of them."""
    task = restore_task(episode)
    names = OF_OBSERVATIONS[1:8]
    return [
        Observation(
            time=float(time), task=task, camera=_restore_camera(seen),
            **dict(zip(names, values, strict=True)),
        )
        for time, seen, *values in zip(
            episode.time, episode.camera, *(getattr(episode, name) for name in names), strict=True
        )
    ]  # fmt: skip


def restore_commands(episode: Episode) -> list[Command]:
    """The commands of an episode, n of them."""
    columns = zip(
        episode.T_world_base_command, episode.command_tension, episode.command_pull, episode.command_gripper,
        strict=True,
    )  # fmt: skip
    return [
        Command(
            T_world_base=frame, cable_tension=tension, gripper=float(grip),
            cable_pull=None if np.isinf(pull).all() else pull,
        )
        for frame, tension, pull, grip in columns
    ]  # fmt: skip


def _restore_camera(seen: np.ndarray) -> CameraObservation | None:
    if np.isnan(seen[0]):
        return None
    return CameraObservation(time=float(seen[0]), position=seen[1:4], axis=seen[4:7])
