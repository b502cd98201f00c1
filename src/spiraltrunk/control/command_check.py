"""The check of a command before anything moves: finite numbers, shapes, a proper frame."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from spiraltrunk.control.messages import Command
from spiraltrunk.errors import RunError, tell

FARTHEST = 100.0
"""Largest coordinate of a place, and most cable to pay out, that a command may ask for [m]: more is a mistake."""


_SQUARE = 1e-6
"""How far the axes of a commanded frame may be from unit length and from a right angle [-]."""


def read_command(command: Command, n_cable: int) -> Command:
    """The command in arrays of floats, as every plant reads it before anything moves.

    Tensions and gripper may lie outside what motors do, which then do what they can.

    Raises:
        RunError: where a value is no number, not finite or of another shape, or the frame is no place with axes of unit
            length at right angles, right-handed.
    """
    if not isinstance(command, Command):
        raise RunError(f"command is {tell(command)}; allowed: a Command")
    given = command.T_world_base, command.cable_tension, command.cable_pull, command.gripper
    frame = _read_numbers("T_world_base", given[0], (4, 4))
    _check_frame(frame)
    tension = _read_numbers("cable_tension", given[1], (n_cable,))
    pull = None if given[2] is None else _read_numbers("cable_pull", given[2], (n_cable,), is_bound=True)
    gripper = given[3] if type(given[3]) is float else float(_read_numbers("gripper", given[3], ()))
    if not math.isfinite(gripper):
        raise RunError("command.gripper is not finite; allowed: a finite number, -1 (open) to 1 (closed)")
    if frame is given[0] and tension is given[1] and pull is given[2] and gripper is given[3]:
        return command
    return replace(command, T_world_base=frame, cable_tension=tension, cable_pull=pull, gripper=gripper)


def _read_numbers(name: str, value: object, shape: tuple[int, ...], *, is_bound: bool = False) -> np.ndarray:
    """An array of floats; a bound may be infinite, and then bounds nothing."""
    if type(value) is np.ndarray and value.dtype == np.float64:
        array = value
    else:
        try:
            array = np.asarray(value)
        except ValueError:  # Ragged.
            array = np.empty(0, object)
        if array.dtype.kind not in "fiu" or isinstance(value, np.ma.MaskedArray):
            raise RunError(f"command.{name} is {tell(value)}; allowed: numbers")
        array = array.astype(float)
    if array.shape != shape:
        raise RunError(f"command.{name} has shape {array.shape}; allowed: {shape or 'one number'}")
    numbers = array.ravel().tolist()
    if is_bound and not all(number > -FARTHEST for number in numbers):
        allowed = f"metres above -{FARTHEST:g}, or infinity for no bound"
        raise RunError(f"command.{name} is not a length to pull; allowed: {allowed}")
    if not is_bound and not all(map(math.isfinite, numbers)):
        raise RunError(f"command.{name} is not finite; allowed: finite numbers")
    return array


def _check_frame(frame: np.ndarray) -> None:
    (a, b, c, x), (d, e, f, y), (g, h, i, z), last = frame.tolist()
    if max(abs(x), abs(y), abs(z)) > FARTHEST:
        raise RunError(f"command.T_world_base is at ({x:g}, {y:g}, {z:g}) m; allowed: within {FARTHEST:g} m")
    if last != [0.0, 0.0, 0.0, 1.0]:
        raise RunError("command.T_world_base ends in another row than 0, 0, 0, 1; allowed: a frame in the world")
    lengths = a * a + d * d + g * g, b * b + e * e + h * h, c * c + f * f + i * i
    products = a * b + d * e + g * h, a * c + d * f + g * i, b * c + e * f + h * i
    volume = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    misfit = max(*(abs(length - 1.0) for length in lengths), *map(abs, products))
    if not (misfit <= _SQUARE and volume > 0.0):
        what = f"up to {misfit:.2g} off" if volume > 0.0 else "left-handed"
        raise RunError(f"command.T_world_base turns by axes that are {what}; allowed: a rotation matrix")
