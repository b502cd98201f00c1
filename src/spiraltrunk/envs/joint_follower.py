"""Joint positions on the way to what actions ask for, with bounded speed and acceleration."""

from __future__ import annotations

from typing import final

import numpy as np

from spiraltrunk.control.encoding import next_velocity
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.sim.robot.arm_ik import SPEED_SHARE, ArmReach

SPEED, ACCELERATION = 2.0, 5.0
"""Speed [rad/s] and acceleration [rad/s^2] of a joint without a limit (ours)."""

ACCELERATION_SHARE = 0.5
"""Share of the joints' largest acceleration that is used [-] (ours)."""


@final
class JointFollower:
    """Set points of the arm's joints; see `control.encoding.next_velocity`."""

    def __init__(self, reach: ArmReach) -> None:
        limits, shape = reach.limits, reach.home.shape
        most = ACCELERATION / ACCELERATION_SHARE if limits.acceleration is None else limits.acceleration
        speed = SPEED / SPEED_SHARE if limits.velocity is None else limits.velocity
        self._acceleration = np.minimum(np.broadcast_to(ACCELERATION_SHARE * most, shape), 1e3)
        self._speed = np.minimum(np.broadcast_to(SPEED_SHARE * speed, shape), 1e2)
        self.restart(reach.home)

    def restart(self, position: np.ndarray, velocity: np.ndarray | None = None) -> None:
        """Go on from joint positions [rad] and velocities [rad/s], shape (n_arm,) each; None for joints at rest."""
        self.position = position.copy()
        self.velocity = np.zeros(position.shape) if velocity is None else velocity.copy()
        self._wanted, self._start = position.copy(), position.copy()

    def follow(self, target: np.ndarray, *, period: int = 0, periods: int = 1) -> np.ndarray:
        """Joint positions of the next control period on the way to a target that holds for several, (n_arm,) [rad]."""
        if period == 0:
            self._start = self._wanted
        wanted = self._start + (period + 1) / periods * (target - self._start)
        feed = (wanted - self._wanted) / CONTROL_PERIOD
        behind = self._wanted - self.position
        velocity = next_velocity(
            behind[:, None].tolist(), feed[:, None].tolist(), self.velocity[:, None].tolist(),
            self._acceleration.tolist(), self._speed.tolist(),
        )  # fmt: skip
        self.velocity = np.array(velocity)[:, 0]
        self.position, self._wanted = self.position + CONTROL_PERIOD * self.velocity, wanted
        return self.position

    def get_state(self) -> tuple[np.ndarray, ...]:
        """Positions, velocities, what is followed, and where that began, four of shape (n_arm,)."""
        return self.position.copy(), self.velocity.copy(), self._wanted.copy(), self._start.copy()

    def set_state(self, state: tuple[np.ndarray, ...]) -> None:
        """Restore a state."""
        self.position, self.velocity, self._wanted, self._start = (part.copy() for part in state)
