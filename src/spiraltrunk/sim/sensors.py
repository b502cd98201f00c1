"""Sensor models: noise of the readings, delay of the commands, error of the camera."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np

from spiraltrunk.checks import check_number
from spiraltrunk.control.messages import CameraObservation
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.sim.plant_state import SensorState

CAMERA_PERIOD = 0.5
"""Period of the camera's observations [s] (ours)."""

DELAY_MOST = 10.0
"""Largest delay of the commands [s] (ours)."""

_JITTER = 0.3
"""Share of the camera's error that varies between observations; the rest is constant in a trial [-] (ours)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class SensorOptions:
    """Errors of sensors and commands; 0 by default."""

    pull_noise: float = 0.0
    """Standard deviation of each measured cable length, of encoder and winder [m]."""
    tension_noise: float = 0.0
    """Standard deviation of each tension estimate at zero tension [N]."""
    tension_share: float = 0.0
    """Additional standard deviation over the tension, of estimates from motor currents [-]."""
    torque_noise: float = 0.0
    """Standard deviation of each measured torque of the arm's joints [N m]."""
    delay: float = 0.0
    """Time from a command to its effect, rounded to control periods [s]."""
    has_camera: bool = False
    """Whether a camera observes the object."""
    camera_error: float = 0.0
    """Largest error of the observed position [m]."""
    camera_turn: float = 0.0
    """Largest error of the observed yaw [rad]."""
    seed: int = 0
    """Seed of the random errors."""

    def __post_init__(self) -> None:
        for name in ("pull_noise", "tension_noise", "tension_share", "torque_noise", "camera_error", "camera_turn"):
            check_number(f"sensors.{name}", getattr(self, name), least=0.0)
        check_number("sensors.delay", self.delay, least=0.0, most=DELAY_MOST)


@final
class Sensors:
    """Readings with errors drawn from the seed of ``options``."""

    def __init__(self, options: SensorOptions) -> None:
        self.options = options
        self.reset()

    def reset(self) -> None:
        """Reset the random generator and the camera."""
        self._rng = np.random.default_rng(self.options.seed)
        self._bias = _draw_in_ball(self._rng) * self.options.camera_error * (1 - _JITTER)
        self._bias_turn = float(self._rng.uniform(-1, 1)) * self.options.camera_turn
        self._camera: CameraObservation | None = None

    def get_state(self) -> SensorState:
        """State of the random generator and the camera."""
        return SensorState(
            generator=dict(self._rng.bit_generator.state), bias=self._bias.copy(), bias_turn=self._bias_turn,
            camera=self._camera,
        )  # fmt: skip

    def set_state(self, state: SensorState) -> None:
        """Restore a state."""
        self._rng.bit_generator.state = state.generator
        self._bias, self._bias_turn, self._camera = state.bias.copy(), state.bias_turn, state.camera

    def read_pull(self, pull: np.ndarray) -> np.ndarray:
        """Measured length of cable pulled in, from motor angles, shape (n_cable,) [m]."""
        return self._add_noise(pull, self.options.pull_noise)

    def read_tension(self, tension: np.ndarray) -> np.ndarray:
        """Estimated tension, from motor currents, shape (n_cable,) [N]."""
        constant, share = self.options.tension_noise, self.options.tension_share
        if not share:
            return self._add_noise(tension, constant)
        # In plain numbers: on three cables, arrays take twice as long.
        deviation = [constant + share * abs(each) for each in tension.tolist()]
        return self._add_noise(tension, np.array(deviation) if any(deviation) else 0.0)

    def read_torque(self, torque: np.ndarray) -> np.ndarray:
        """Measured torques of the arm's joints, shape (n_arm,) [N m]."""
        return self._add_noise(torque, self.options.torque_noise)

    def read_camera(self, time: float, position: np.ndarray, quat_wxyz: np.ndarray) -> CameraObservation | None:
        """The camera's latest observation, None without a camera."""
        if not self.options.has_camera:
            return None
        if self._camera is None or time >= self._camera.time + CAMERA_PERIOD - 1e-9:
            jitter = _draw_in_ball(self._rng) * self.options.camera_error * _JITTER
            axis = np.zeros(3)
            mujoco.mju_rotVecQuat(axis, np.array([1.0, 0.0, 0.0]), quat_wxyz)
            axis = _rotate_yaw(axis, self._bias_turn)
            position = position + self._bias + jitter
            self._camera = CameraObservation(time=time, position=position, axis=axis)
        return self._camera

    def _add_noise(self, truth: np.ndarray, deviation: float | np.ndarray) -> np.ndarray:
        """Gaussian noise added to ``truth``, shape (n,); with a deviation of 0 a copy, and nothing is drawn."""
        if isinstance(deviation, float) and deviation == 0.0:
            return truth.copy()
        return np.asarray(truth + deviation * self._rng.standard_normal(truth.size))


def _draw_in_ball(rng: np.random.Generator) -> np.ndarray:
    """A point, uniform in the unit ball, shape (3,) [-]."""
    direction = rng.normal(size=3)
    return np.asarray(float(rng.uniform()) ** (1 / 3) * direction / np.linalg.norm(direction))


def _rotate_yaw(axis: np.ndarray, angle: float) -> np.ndarray:
    """The axis rotated about the vertical by ``angle`` [rad], shape (3,) [-]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * axis[0] - s * axis[1], s * axis[0] + c * axis[1], axis[2]])
