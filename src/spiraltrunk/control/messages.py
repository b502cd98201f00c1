"""Messages between a strategy and a plant: the task, what the robot observes, what it shall do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign


@final
@dataclass(frozen=True, kw_only=True)
class Target:
    """The object as it was announced to the robot: its nominal place and size."""

    kind: str
    """Shape, such as cylinder, sphere or box."""
    width: float
    """Extent across its axis, the diameter of a cylinder [m]."""
    length: float
    """Extent along its axis [m]."""
    mass: float
    """Mass [kg]."""
    position: np.ndarray
    """Centre in the world, shape (3,) [m]."""
    axis: np.ndarray
    """Unit vector along the object: horizontal where it hangs or lies, up where it stands, shape (3,) [-]."""
    friction: float = 0.8
    """Coefficient of friction that the robot may count on [-]."""


@final
@dataclass(frozen=True, kw_only=True)
class Goal:
    """Where the object shall go."""

    lift: float = 0.20
    """Height to lift it by [m]."""
    aside: np.ndarray
    """Horizontal carry from where it was, shape (3,) [m]."""
    hold: float = 3.0
    """Time to hold it still up there [s]."""
    place: np.ndarray
    """Where its centre shall rest at the end, shape (3,) [m]."""
    zone: float = 0.05
    """Distance from there within which it shall rest [m]."""
    ground: float | None = None
    """Height of the ground that the object stands or lies on [m]; None where it hangs."""


@final
@dataclass(frozen=True, kw_only=True)
class Task:
    """What is to be done, and with which robot."""

    design: TrunkDesign
    """The robot as designed; the real or simulated one may differ."""
    target: Target
    """The object."""
    goal: Goal
    """Where it shall go."""


@final
@dataclass(frozen=True, kw_only=True)
class Look:
    """Where a camera saw the object; right to a few millimetres."""

    time: float
    """When it looked [s]."""
    position: np.ndarray
    """Centre of the object in the world, shape (3,) [m]."""
    axis: np.ndarray
    """Unit vector along the object in the world, shape (3,) [-]."""


@final
@dataclass(frozen=True, kw_only=True)
class Observation:
    """What the robot knows at one instant."""

    time: float
    """Time since reset [s]."""
    task: Task
    """The task, the same throughout."""
    T_world_base: np.ndarray
    """Frame of the trunk's base from the arm's joints: x along the trunk, y dorsal, shape (4, 4) [-, m]."""
    arm_position: np.ndarray
    """Joint positions of the arm, shape (n_arm,) [rad]."""
    arm_velocity: np.ndarray
    """Joint velocities of the arm, shape (n_arm,) [rad/s]."""
    cable_pull: np.ndarray
    """Cable pulled in since the straight trunk, from the motor angles, shape (n_cable,) [m]."""
    cable_tension: np.ndarray
    """Tension estimates from the motor currents, shape (n_cable,) [N]."""
    base_force: np.ndarray
    """Force of all that hangs on the trunk's base, from the arm's joint torques, in the world, shape (3,) [N]."""
    base_torque: np.ndarray
    """Torque of the same about the trunk's base, in the world, shape (3,) [N m]."""
    look: Look | None = None
    """The camera's last look at the object; None on a plant without a camera, and for strategies that need none."""


@final
@dataclass(frozen=True, kw_only=True)
class Command:
    """What the robot shall do until the next command."""

    T_world_base: np.ndarray
    """Frame that the trunk's base shall reach, shape (4, 4) [-, m]."""
    cable_tension: np.ndarray
    """Ceiling of each cable's tension, shape (n_cable,) [N]."""
    cable_pull: np.ndarray | None = None
    """Cable to pull in at most, shape (n_cable,) [m]; None pulls with the tension whatever the length."""
    gripper: float = 0.0
    """Tip gripper from -1 (open) over 0 (slack) to 1 (closed) [-]."""
