"""The robot arm: one interface over MuJoCo's arm and the drivers of real ones.

The loop of 1 kHz stays in the driver's own library; targets of the joints come at 20 to 100 Hz.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.control.arm_limits import ArmLimits
from spiraltrunk.field_docs import explain_fields


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class ArmState:
    """Measured state of the arm."""

    time: float
    """Time of the measurement on the driver's clock [s]."""
    position: np.ndarray
    """Joint positions, shape (n_arm,) [rad]."""
    velocity: np.ndarray
    """Joint velocities, shape (n_arm,) [rad/s]."""
    acceleration: np.ndarray
    """Joint accelerations, shape (n_arm,) [rad/s^2]; zeros where the driver does not give them."""
    torque: np.ndarray
    """Joint torques, shape (n_arm,) [N m]."""
    error: str | None = None
    """What the arm's controller reports, such as a reflex; None where it runs."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class ArmLoad:
    """What hangs on the flange, for the controller's own model."""

    mass: float
    """Mass [kg]."""
    center: np.ndarray
    """Centre of mass in the flange's frame, shape (3,) [m]."""
    inertia: np.ndarray
    """Inertia about the centre of mass along the flange's axes, shape (3, 3) [kg m^2]."""


class ArmPort(ABC):
    """An arm that follows joint positions."""

    limits: ArmLimits
    """Limits in force: those of the design's arm, or those that the arm itself tells where they are tighter."""

    @abstractmethod
    def read(self) -> ArmState:
        """Latest measured state; never waits.

        Raises:
            DriveError: where the connection is gone.
        """

    @abstractmethod
    def set_load(self, load: ArmLoad) -> None:
        """Tell the controller what hangs on the flange; refused while the arm moves."""

    @abstractmethod
    def send(self, position: np.ndarray) -> None:
        """Command joint positions, shape (n_arm,) [rad].

        Raises:
            DriveError: where a value is not finite, beyond a limit, or a jump that no joint can follow; nothing is sent
                then, and nothing is clamped.
        """

    @abstractmethod
    def hold(self) -> None:
        """Stop where the arm is and stay there; never refused, harmless when called again."""

    @abstractmethod
    def close(self) -> None:
        """Hold, and release the connection; harmless when called again."""
