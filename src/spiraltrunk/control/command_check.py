"""Check of a command before anything moves: finite numbers, shapes, a rigid transform."""

from __future__ import annotations

import numpy as np

from spiraltrunk.checks import read_array, read_numbers
from spiraltrunk.control.messages import Command
from spiraltrunk.errors import RunError, describe

FARTHEST = 100.0
"""Largest coordinate of a position, and most cable to pay out, that a command may ask for [m]."""

_ROUNDING = 1e-9
"""Part of a motor's largest by which a command may exceed it, the rounding of interpolated commands [-]."""

_SQUARE = 1e-6
"""Largest deviation of the axes of a commanded frame from unit length and from right angles [-]."""


def read_command(command: Command, n_cable: int, tension_max: float) -> Command:
    """The command of a strategy in arrays of floats, for a trunk of ``n_cable`` cables of at most ``tension_max`` [N].

    Raises:
        RunError: where a value is not a number, not finite or of another shape, the frame is not a rigid transform, or
            tension or gripper is more than a motor does.
    """
    if not isinstance(command, Command):
        raise RunError(f"command is {describe(command)}; allowed: a Command")
    frame = read_numbers("command.T_world_base", command.T_world_base, shape=(4, 4), error=RunError)
    _check_frame(frame)
    tension = read_numbers("command.cable_tension", command.cable_tension, shape=(n_cable,), error=RunError)
    pull = None if command.cable_pull is None else _read_pull(command.cable_pull, n_cable)
    gripper = float(read_numbers("command.gripper", command.gripper, shape=(), error=RunError))
    _check_motors(tension, gripper, tension_max)
    return Command(T_world_base=frame, cable_tension=tension, cable_pull=pull, gripper=gripper)


def _check_motors(tension: np.ndarray, gripper: float, tension_max: float) -> None:
    """Refuse tensions and gripper values out of range; rounding errors of a ramp pass, and the plant clips them."""
    rounding = _ROUNDING * tension_max
    if not all(-rounding <= one <= tension_max + rounding for one in tension.tolist()):
        wrong = max(tension.tolist(), key=lambda one: abs(one - tension_max / 2))
        raise RunError(
            f"command.cable_tension is {wrong:g} N; allowed: 0 to {tension_max:g} N, the largest of the design"
        )
    if not abs(gripper) <= 1.0 + _ROUNDING:
        raise RunError(f"command.gripper is {gripper:g}; allowed: -1 (open) to 1 (closed)")


def _read_pull(value: np.ndarray, n_cable: int) -> np.ndarray:
    """Cable to pull in at most; infinity sets no limit."""
    pull = read_array("command.cable_pull", value, (n_cable,), error=RunError)
    if not all(length > -FARTHEST for length in pull.tolist()):
        allowed = f"metres above -{FARTHEST:g}, or infinity for no bound"
        raise RunError(f"command.cable_pull is {describe(value)}; allowed: {allowed}")
    return pull


def _check_frame(frame: np.ndarray) -> None:
    rotation, (x, y, z) = frame[:3, :3], frame[:3, 3].tolist()
    if max(abs(x), abs(y), abs(z)) > FARTHEST:
        raise RunError(f"command.T_world_base is at ({x:g}, {y:g}, {z:g}) m; allowed: within {FARTHEST:g} m")
    if frame[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
        raise RunError("command.T_world_base ends in another row than 0, 0, 0, 1; allowed: a frame in the world")
    (a, b, c), (d, e, f), (g, h, i) = rotation.tolist()
    misfits = (
        a * a + d * d + g * g - 1.0, b * b + e * e + h * h - 1.0, c * c + f * f + i * i - 1.0,
        a * b + d * e + g * h, a * c + d * f + g * i, b * c + e * f + h * i,
    )  # fmt: skip
    is_right_handed = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) > 0.0
    if not (is_right_handed and all(-_SQUARE <= misfit <= _SQUARE for misfit in misfits)):
        misfit = max(map(abs, misfits))
        error = f"off by up to {misfit:.2g}" if is_right_handed else "left-handed"
        raise RunError(f"command.T_world_base has axes that are {error}; allowed: a rotation matrix")
