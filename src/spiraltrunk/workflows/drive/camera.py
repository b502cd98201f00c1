"""A camera of the user: any function that returns the position of the object, checked and given the run's time."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, final

import numpy as np

from spiraltrunk.control.messages import CameraObservation
from spiraltrunk.errors import DriveError, RunError, describe
from spiraltrunk.hardware.clock import Clock

Look = Callable[[float], CameraObservation | None]
"""Given the time since the run began [s], the latest observation of the object in the world; None where there is none.

Its ``time`` is that of the measurement on the same clock, so that of an image that is 30 ms old ``time`` is the given
time less 0.03. It is called every 20 ms from the control loop and must return at once (ours: within 2 ms): detection
belongs into a thread of its own.
"""

ALLOWED = "MODULE:NAME, a function of a module that Python can import from here, such as my_camera:look"


@final
class Camera:
    """What a plant asks at every observation; the first one begins the run.

    Args:
        look: the user's function.
        name: what errors call it.
        clock: the driver's clock.
    """

    def __init__(self, look: Look, name: str, clock: Clock) -> None:
        self._look, self._name, self._clock = look, name, clock
        self._began: float | None = None

    def __call__(self) -> CameraObservation | None:
        """The latest observation.

        Raises:
            RunError: where the function raises, or returns what is no observation.
        """
        now = self._clock.now()
        self._began = now if self._began is None else self._began
        try:
            return ask_camera(self._look, self._name, now - self._began)
        except DriveError as error:
            raise RunError(str(error)) from error


def load_camera(name: str) -> Look:
    """The function that ``MODULE:NAME`` names, asked once; the module's own code runs.

    Raises:
        DriveError: where it cannot be imported, is no function, raises, or returns what is no observation.
    """
    module_name, _, attribute = name.partition(":")
    if not attribute.isidentifier() or not all(part.isidentifier() for part in module_name.split(".")):
        raise DriveError(f"camera is {describe(name)}; allowed: {ALLOWED}")
    if (folder := str(Path.cwd())) not in sys.path:
        sys.path.append(folder)
    try:
        module = importlib.import_module(module_name)
    except (Exception, SystemExit) as error:
        raise _refuse(name, f"cannot be imported: {describe(error)}") from error
    look = getattr(module, attribute, None)
    if not callable(look):
        is_there = "is no function" if hasattr(module, attribute) else f"is missing in {module.__file__}"
        raise _refuse(name, is_there)
    ask_camera(look, name, 0.0)
    return look


def ask_camera(look: Look, name: str, time: float) -> CameraObservation | None:
    """One observation, checked.

    Raises:
        DriveError: where the function raises, or returns what is no observation.
    """
    try:
        seen = look(time)
    except (Exception, SystemExit) as error:
        raise DriveError(f"camera {name} raised {describe(error)}; allowed: a CameraObservation or None") from error
    if seen is None:
        return None
    if not isinstance(seen, CameraObservation):
        raise DriveError(f"camera {name} returned {describe(seen)}; allowed: a CameraObservation or None")
    position, axis = _read_vector(name, "position", seen.position), _read_vector(name, "axis", seen.axis)
    if not abs(np.linalg.norm(axis) - 1.0) < 1e-3:
        raise DriveError(f"camera {name}: axis has length {np.linalg.norm(axis):g}; allowed: a unit vector")
    if not isinstance(seen.time, (int, float)) or not -np.inf < seen.time <= time + 1e-3:
        raise DriveError(f"camera {name}: time is {describe(seen.time)}; allowed: up to {time:.2f} s, that of the call")
    return CameraObservation(time=float(seen.time), position=position, axis=axis)


def _read_vector(name: str, what: str, value: Any) -> np.ndarray:
    """Three finite numbers."""
    try:
        vector = np.array(value, float)
    except (TypeError, ValueError):
        vector = np.empty(0)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise DriveError(f"camera {name}: {what} is {describe(value)}; allowed: 3 finite numbers")
    return vector


def _refuse(name: str, why: str) -> DriveError:
    return DriveError(f"camera {describe(name)} {why}; allowed: {ALLOWED}")
