"""Messages between strategy and plant: task, observation, command."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.checks import check_number
from spiraltrunk.control.object_handle import Handle
from spiraltrunk.control.object_profile import ObjectProfile
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.field_docs import explain_fields


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Target:
    """The object as announced to the robot: nominal position and size."""

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
    """Unit vector along the object: horizontal if it hangs or lies, up if it stands, shape (3,) [-]."""
    friction: float = 0.8
    """Coefficient of friction that strategies may assume [-]."""
    profile: ObjectProfile | None = None
    """Sections, centre of mass and stability in the pose in which it is presented; None where they are unknown."""
    longer_side: float = 0.0
    """Longer side of the least rectangle round an object that stands, seen from above [m]; 0 where it is unknown."""
    side_yaw: float | None = None
    """Angle of that side from the world's x, counterclockwise from above [rad]; None for a round object, and where it
    is unknown."""
    handle: Handle | None = None
    """What projects to one side of an object that stands; None without a handle, and where it is unknown."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Goal:
    """Motion of the object that the task asks for."""

    lift: float = 0.20
    """Height to lift it by [m]."""
    aside: np.ndarray
    """Horizontal displacement from its initial position, shape (3,) [m]."""
    hold: float = 3.0
    """Time to hold it still after lift and displacement [s]."""
    place: np.ndarray
    """Final position of its centre in the world, shape (3,) [m]."""
    zone: float = 0.05
    """Largest distance from the final position [m]."""
    ground: float | None = None
    """Height of the ground under the object [m]; None if it hangs."""

    def __post_init__(self) -> None:
        check_number("goal.lift", self.lift, above=0.0)
        check_number("goal.hold", self.hold, above=0.0)


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Task:
    """Robot, object and goal."""

    design: TrunkDesign
    """The nominal robot; the real or simulated one may differ."""
    target: Target
    """The object."""
    goal: Goal
    """Required motion of the object."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class CameraObservation:
    """Pose of the object as a camera measured it, accurate to a few millimetres."""

    time: float
    """Time of the measurement [s]."""
    position: np.ndarray
    """Centre of the object in the world, shape (3,) [m]."""
    axis: np.ndarray
    """Unit vector along the object in the world, shape (3,) [-]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Observation:
    """What the robot measures at one instant."""

    time: float
    """Time since reset [s]."""
    task: Task
    """The task, constant during a run."""
    T_world_base: np.ndarray
    """Pose of the trunk's base from the arm's joints: x along the trunk, y dorsal, shape (4, 4) [-, m]."""
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
    camera: CameraObservation | None = None
    """Latest camera observation of the object; None without a camera, and for strategies that need none."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Command:
    """Set points of arm, cables and gripper until the next command."""

    T_world_base: np.ndarray
    """Desired pose of the trunk's base, shape (4, 4) [-, m]."""
    cable_tension: np.ndarray
    """Upper limit of each cable's tension, from 0 to the design's ``tension_max``, shape (n_cable,) [N]."""
    cable_pull: np.ndarray | None = None
    """Upper limit of the cable pulled in since the straight trunk, shape (n_cable,) [m]; None sets no limit."""
    gripper: float = 0.0
    """Tip gripper from -1 (open) over 0 (slack) to 1 (closed) [-]."""
