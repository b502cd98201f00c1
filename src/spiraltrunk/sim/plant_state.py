"""State of a simulated plant: everything that its next steps depend on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

import numpy as np

from spiraltrunk.control.messages import CameraObservation, Command
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.sim.ground_truth import Sample

Pending = tuple[Command, np.ndarray | None]
"""A command that has not taken effect yet, and joint positions where it sets the arm's joints."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class SensorState:
    """State of the sensors' errors."""

    generator: dict[str, Any]
    """State of the random generator, as NumPy gives it."""
    bias: np.ndarray
    """Constant part of the camera's error, shape (3,) [m]."""
    bias_turn: float
    """Error of the camera's yaw [rad]."""
    camera: CameraObservation | None
    """The camera's latest observation."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class PlantState:
    """State of a `SimPlant` between two steps, for the same scene, in this process or another."""

    integration: np.ndarray
    """MuJoCo's state of integration (`mjSTATE_INTEGRATION`): time, positions, velocities, controls, applied forces and
    warm start."""
    force_range: np.ndarray
    """Force limits of the actuators, shape (n_actuator, 2) [N, N m]."""
    warnings: tuple[int, ...]
    """Number of MuJoCo's warnings of each kind."""
    friction: tuple[np.ndarray, ...]
    """State of the cables' friction."""
    arm_command: np.ndarray
    """Commanded joint positions of the arm, shape (n_arm,) [rad]."""
    servo_offset: np.ndarray
    """Offset of the arm's servos, shape (n_arm,) [rad]."""
    arrived: tuple[np.ndarray, np.ndarray]
    """Joint positions and frame at which the inverse kinematics last arrived."""
    tension_limit: np.ndarray
    """Present tension limits of the winders, shape (n_cable,) [N]."""
    grip: float
    """Present tension of the gripper over its largest [-]."""
    pending: tuple[Pending, ...]
    """Commands that have not taken effect yet."""
    sensors: SensorState
    """State of the sensors."""
    extremes: tuple[float, float, bool, bool]
    """Extremes of the present period: penetration [m], bend [rad], touches of the robot and of the ground."""
    trace: tuple[Sample, ...]
    """Ground truth so far."""
