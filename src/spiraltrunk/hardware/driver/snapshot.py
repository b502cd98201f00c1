"""What logs and screens show of a driver at one instant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.arm.arm_port import ArmState
from spiraltrunk.hardware.driver.lateness import Lateness
from spiraltrunk.hardware.safety.fault import Fault
from spiraltrunk.hardware.safety.states import Mode


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class CableSnapshot:
    """One cable with its motor."""

    pull: float
    """Cable wound in since the straight trunk [m]; 0 before homing."""
    speed: float
    """Speed of winding in [m/s]."""
    tension: float
    """Tension by a load cell, or, while torque is on, as the winder estimates it [N]."""
    felt: float | None
    """Tension by a load cell [N]; None without one, and where its reading may not be used."""
    cell_age: float | None
    """Age of the load cell's reading [s], infinite where none may be used; None where there is no load cell."""
    tension_target: float
    """Upper limit of the tension that was asked for [N]."""
    pull_target: float
    """Upper limit of the pull that was asked for [m]."""
    angle: float
    """Angle that the motor turned since the driver's start [rad]; NaN before the first feedback."""
    motor_speed: float
    """Its speed, positive when it winds in [rad/s]; NaN before the first feedback."""
    torque: float
    """Torque by the motor's own estimate, positive when it winds in [N m]; NaN before the first feedback."""
    torque_sent: float
    """Torque that was sent last, positive when it winds in [N m]."""
    temperature: float
    """Temperature of the motor [degC]; NaN before the first feedback."""
    voltage: float | None
    """Supply voltage [V]; None where the motor does not measure it."""
    feedback_age: float
    """Age of the motor's feedback [s]; infinite before the first."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class Snapshot:
    """State of the driver after a period of control."""

    time: float
    """Time on the driver's clock [s]."""
    mode: Mode
    """What the driver does."""
    is_homed: bool
    """Whether the drums are homed."""
    is_letting_go: bool
    """Whether torques ramp to zero, after a fault or on disarming."""
    absence: str
    """Why no watchdog is present, in words; empty where one is."""
    faults: tuple[Fault, ...]
    """Latched faults, the first cause first."""
    warnings: tuple[str, ...]
    """What is no fault yet, one line each."""
    cables: tuple[CableSnapshot, ...]
    """Cables in the order of the design."""
    arm: ArmState | None
    """Measured state of the arm; None without one."""
    gripper: float
    """Gripper that was asked for, -1 to 1 [-]."""
    n_refused: int
    """Commands that were refused [-]."""
    loss: float
    """Mean part of the feedback that is lost while torque is on [-]."""
    lateness: Lateness
    """Lateness of the loop."""

    @property
    def is_watched(self) -> bool:
        """Whether a watchdog is present."""
        return not self.absence
