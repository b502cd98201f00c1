"""Sensor models: noise of readings, delay of commands, and error of the camera."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np

from spiraltrunk.control.messages import CameraObservation

LOOK_PERIOD = 0.5
"""Period of the camera [s] (ours)."""

_JITTER = 0.3
"""Share of the camera's error that varies between images; the rest is constant in a trial [-] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class SensorOptions:
    """Errors of sensors and commands; none by default."""

    pull_noise: float = 0.0
    """Standard deviation of each cable's length, from encoder and winder [m]."""
    tension_noise: float = 0.0
    """Standard deviation of each tension estimate at rest [N]."""
    tension_share: float = 0.0
    """Further standard deviation over the tension, as estimated from motor currents [-]."""
    torque_noise: float = 0.0
    """Standard deviation of each arm joint's torque [N m]."""
    delay: float = 0.0
    """Time from a command to its effect, rounded to control periods [s]."""
    looks: bool = False
    """Whether a camera observes the object."""
    look_error: float = 0.0
    """Largest error of the observed position [m]."""
    look_turn: float = 0.0
    """Largest error of the observed axis [rad]."""
    seed: int = 0
    """Seed of the errors."""


@final
class Sensors:
    """Draws the errors; the same seed gives the same errors."""

    def __init__(self, options: SensorOptions) -> None:
        self.options = options
        self.reset()

    def reset(self) -> None:
        """Start a new trial."""
        self._rng = np.random.default_rng(self.options.seed)
        self._bias = _draw_in_ball(self._rng) * self.options.look_error * (1 - _JITTER)
        self._bias_turn = float(self._rng.uniform(-1, 1)) * self.options.look_turn
        self._look: CameraObservation | None = None

    def read_pull(self, pull: np.ndarray) -> np.ndarray:
        """Cable pulled in, measured by the motors' encoders, shape (n_cable,) [m]."""
        return self._add_noise(pull, self.options.pull_noise)

    def read_tension(self, tension: np.ndarray) -> np.ndarray:
        """Tension estimated from the motors' currents, shape (n_cable,) [N]."""
        noise, share = self.options.tension_noise, self.options.tension_share
        return self._add_noise(tension, noise + share * np.abs(tension) if share else noise)

    def read_torque(self, torque: np.ndarray) -> np.ndarray:
        """Measured torques of the arm's joints, shape (n_arm,) [N m]."""
        return self._add_noise(torque, self.options.torque_noise)

    def look(self, time: float, position: np.ndarray, quat_wxyz: np.ndarray) -> CameraObservation | None:
        """The camera's last observation, renewed each LOOK_PERIOD."""
        if not self.options.looks:
            return None
        if self._look is None or time >= self._look.time + LOOK_PERIOD - 1e-9:
            jitter = _draw_in_ball(self._rng) * self.options.look_error * _JITTER
            axis = _rotate(quat_wxyz, np.array([1.0, 0.0, 0.0]))
            self._look = CameraObservation(
                time=time, position=position + self._bias + jitter, axis=_turn(axis, self._bias_turn)
            )
        return self._look

    def _add_noise(self, truth: np.ndarray, deviation: float | np.ndarray) -> np.ndarray:
        """``truth`` with noise, shape (n,); an exact copy without deviation, which draws no random numbers."""
        is_exact = not (deviation.any() if isinstance(deviation, np.ndarray) else deviation)
        return truth.copy() if is_exact else np.asarray(truth + deviation * self._rng.normal(size=truth.size))


def _draw_in_ball(rng: np.random.Generator) -> np.ndarray:
    """A uniformly distributed point in the unit ball, shape (3,) [-]."""
    direction = rng.normal(size=3)
    return np.asarray(float(rng.uniform()) ** (1 / 3) * direction / np.linalg.norm(direction))


def _rotate(quat_wxyz: np.ndarray, vector: np.ndarray) -> np.ndarray:
    turned = np.zeros(3)
    mujoco.mju_rotVecQuat(turned, vector, quat_wxyz)
    return turned


def _turn(axis: np.ndarray, angle: float) -> np.ndarray:
    """The axis turned about the vertical, shape (3,) [-]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * axis[0] - s * axis[1], s * axis[0] + c * axis[1], axis[2]])
