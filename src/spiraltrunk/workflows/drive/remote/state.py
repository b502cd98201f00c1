"""State of the robot as its process reports it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.driver.lateness import Lateness
from spiraltrunk.hardware.driver.snapshot import Snapshot
from spiraltrunk.hardware.safety.states import Mode


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class RobotState:
    """State of the robot at one instant."""

    is_twin: bool
    """Whether it is the twin."""
    snapshot: Snapshot
    """State of its driver."""
    pulls: tuple[float, ...]
    """Cable pulled in since the straight trunk, as the trunk sees it: without its slack [m]."""
    goals: tuple[float | None, ...]
    """Length that each cable is wound to [m]; None for one that follows the trunk."""
    page_age: float
    """Time since the page in control was asked what it answered last [s]; infinite without one."""
    lateness: Lateness
    """Lateness of the loop: the driver's own, or that of the twin's steps of 20 ms."""
    note: str
    """What was done last without being asked for, such as disarming; empty before."""
    run: str
    """Phase of the strategy that runs; empty while none does."""
    result: str
    """How the last strategy ended; empty before."""
    true_torques: tuple[float, ...] = ()
    """Electric torque of each of the twin's motors [N m]; empty on hardware."""
    frames: np.ndarray | None = None
    """Frames of the twin's sections in the frame of its base, shape (n_section, 4, 4) [-, m]; None on hardware."""

    @property
    def is_moving(self) -> bool:
        """Whether the robot has torque, or lets go."""
        return self.snapshot.mode in {Mode.HOMING, Mode.ARMED} or self.snapshot.is_letting_go
