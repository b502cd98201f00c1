"""Observations as vectors of numbers in finite boxes: the robot's own, and what is known of object and goal."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from spiraltrunk.control.loop import LONGEST
from spiraltrunk.control.messages import Command, Observation, Task
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.model.identity_cache import IdentityKey

KINDS = ("cylinder", "sphere", "box", "cone", "ring", "bottle")
"""Kinds of object with a number of their own; every other is "other"."""

Row = tuple[str, float, float]
"""Name of a number, and its least and its largest value."""

_XYZ = ("x", "y", "z")

_WIDE = 5.0
"""Bound of the coordinates of places in the world [m] (ours)."""

_POSITION = 10.0
"""Bound of the arm's joint positions [rad] (ours)."""

_SPEED = 10.0
"""Bound of the arm's joint speeds [rad/s] (ours)."""

_FORCE, _TORQUE = 200.0, 100.0
"""Bounds of force [N] and torque [N m] on the base along one axis (ours)."""

_PULL = 1.5
"""Bound of measured pulls over the cable stroke [-] (ours)."""

_TENSION = 2.0
"""Bound of measured tensions over the design's largest [-] (ours): estimates are noisy."""

_EXTENT, _MASS = 1.0, 20.0
"""Largest extent [m] and mass [kg] of an object."""


def agent_names(design: TrunkDesign, n_arm: int = 7) -> tuple[str, ...]:
    """Name of each number of `encode_agent`, in order."""
    return tuple(name for name, _, _ in _agent_rows(n_arm, *_measure(design)))


def agent_bounds(design: TrunkDesign, n_arm: int = 7) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest values of `encode_agent`, two of shape (n,), float32, finite and read-only."""
    return _find_agent_bounds(IdentityKey(design), n_arm)


def encode_agent(observation: Observation, command: Command | None = None) -> np.ndarray:
    """What the robot measures of itself, in SI units, clipped to `agent_bounds`, float32.

    Joint positions and velocities of the arm, position of the base and the first two columns of its rotation, cable
    pulls and tensions, force and torque on the base, how far the commanded base leads the measured one, the commanded
    gripper, and the time over `LONGEST`.

    Args:
        observation: the observation.
        command: the last command; None before the first, when the base is where it is and the gripper slack.
    """
    T = observation.T_world_base
    lead = np.zeros(3) if command is None else command.T_world_base[:3, 3] - T[:3, 3]
    values = np.concatenate([
        observation.arm_position, observation.arm_velocity, T[:3, 3], T[:3, 0], T[:3, 1], observation.cable_pull,
        observation.cable_tension, observation.base_force, observation.base_torque, lead,
        (0.0 if command is None else command.gripper, observation.time / LONGEST),
    ])  # fmt: skip
    low, high = _find_wide_bounds(IdentityKey(observation.task.design), len(observation.arm_position))
    return np.minimum(np.maximum(values, low), high).astype(np.float32)


def environment_names() -> tuple[str, ...]:
    """Name of each number of `encode_environment`, in order."""
    return tuple(name for name, _, _ in _environment_rows())


@lru_cache(maxsize=1)
def environment_bounds() -> tuple[np.ndarray, np.ndarray]:
    """Least and largest values of `encode_environment`, two of shape (n,), float32, finite and read-only."""
    return _read_bounds(_environment_rows())


def encode_environment(observation: Observation) -> np.ndarray:
    """What the robot knows of object and goal, in SI units, clipped to `environment_bounds`, float32.

    The announced object and the goal, which are constant in a run, and the camera's latest observation: whether there
    is one, its age over `LONGEST`, position and axis. Where nothing was seen, these are the announced ones, of age 0.
    """
    values, camera = _encode_task(IdentityKey(observation.task)).copy(), observation.camera
    if camera is not None:
        age = (observation.time - camera.time) / LONGEST
        look = np.array((1.0, age, *camera.position.tolist(), *camera.axis.tolist()))
        low, high = environment_bounds()
        values[-look.size :] = np.minimum(np.maximum(look, low[-look.size :]), high[-look.size :])
    return values


@lru_cache(maxsize=8)
def _encode_task(key: IdentityKey[Task]) -> np.ndarray:
    """`encode_environment` where nothing was seen, which is constant in a run, float32 and read-only."""
    target = key.value.target
    look = (0.0, 0.0, *target.position.tolist(), *target.axis.tolist())
    known = np.clip((*_describe_task(key.value), *look), *environment_bounds()).astype(np.float32)
    known.flags.writeable = False
    return known


def _describe_task(task: Task) -> tuple[float, ...]:
    target, goal = task.target, task.goal
    kind = target.kind if target.kind in KINDS else "other"
    profile = target.profile
    measures = (
        (target.length, target.width, 0.0, 0.0)
        if profile is None
        else (profile.total_height, profile.grip_width, profile.grip_height, profile.center_height)
    )
    return (
        *target.position.tolist(), *target.axis.tolist(), target.width, target.length, target.mass, *measures,
        *(float(kind == one) for one in (*KINDS, "other")),
        goal.lift, *goal.aside.tolist(), *goal.place.tolist(),
        0.0 if goal.ground is None else 1.0, 0.0 if goal.ground is None else goal.ground,
    )  # fmt: skip


def _rows(name: str, parts: Sequence[str | int], least: float, most: float) -> list[Row]:
    return [(f"{name}_{part}", least, most) for part in parts]


def _measure(design: TrunkDesign) -> tuple[int, float, float]:
    """Number of cables, and the bounds of pull [m] and tension [N]."""
    return design.n_cable, _PULL * design.cable_stroke, _TENSION * design.cable.tension_max


@lru_cache(maxsize=16)
def _find_agent_bounds(design: IdentityKey[TrunkDesign], n_arm: int) -> tuple[np.ndarray, np.ndarray]:
    return _read_bounds(_agent_rows(n_arm, *_measure(design.value)))


@lru_cache(maxsize=16)
def _find_wide_bounds(design: IdentityKey[TrunkDesign], n_arm: int) -> tuple[np.ndarray, np.ndarray]:
    """The same bounds in float64, with which NumPy compares numbers of float64 without converting them each time."""
    low, high = _find_agent_bounds(design, n_arm)
    return low.astype(float), high.astype(float)


def _agent_rows(n_arm: int, n_cable: int, pull: float, tension: float) -> list[Row]:
    joints, cables = range(1, n_arm + 1), range(1, n_cable + 1)
    return [
        *_rows("arm_position", joints, -_POSITION, _POSITION),
        *_rows("arm_velocity", joints, -_SPEED, _SPEED),
        *_rows("base", _XYZ, -_WIDE, _WIDE),
        *_rows("base_along", _XYZ, -1.0, 1.0),
        *_rows("base_dorsal", _XYZ, -1.0, 1.0),
        *_rows("cable_pull", cables, -pull, pull),
        *_rows("cable_tension", cables, -tension, tension),
        *_rows("base_force", _XYZ, -_FORCE, _FORCE),
        *_rows("base_torque", _XYZ, -_TORQUE, _TORQUE),
        *_rows("base_lead", _XYZ, -1.0, 1.0),
        ("gripper", -1.0, 1.0),
        ("time_share", 0.0, 1.0),
    ]


def _environment_rows() -> list[Row]:
    return [
        *_rows("target", _XYZ, -_WIDE, _WIDE),
        *_rows("target_axis", _XYZ, -1.0, 1.0),
        ("target_width", 0.0, _EXTENT),
        ("target_length", 0.0, _EXTENT),
        ("target_mass", 0.0, _MASS),
        ("target_height", 0.0, 2 * _EXTENT),
        ("target_grip_width", 0.0, _EXTENT),
        ("target_grip_height", 0.0, 2 * _EXTENT),
        ("target_center_height", 0.0, 2 * _EXTENT),
        *_rows("target_is", (*KINDS, "other"), 0.0, 1.0),
        ("goal_lift", 0.0, 1.0),
        *_rows("goal_aside", _XYZ, -_WIDE, _WIDE),
        *_rows("goal_place", _XYZ, -_WIDE, _WIDE),
        ("goal_has_ground", 0.0, 1.0),
        ("goal_ground", -_WIDE, _WIDE),
        ("seen", 0.0, 1.0),
        ("seen_age_share", 0.0, 1.0),
        *_rows("seen", _XYZ, -_WIDE, _WIDE),
        *_rows("seen_axis", _XYZ, -1.0, 1.0),
    ]


def _read_bounds(rows: Sequence[Row]) -> tuple[np.ndarray, np.ndarray]:
    low, high = (np.array([row[i] for row in rows], dtype=np.float32) for i in (1, 2))
    low.flags.writeable = high.flags.writeable = False
    return low, high
