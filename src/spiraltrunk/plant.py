"""What simulator and hardware both are: something that takes commands and gives observations.

A strategy sees nothing else. An observation holds what the real robot has (motor angles as cable lengths, motor
currents as tension estimates, arm joints), and the task as it was given; where the object truly is, only a simulator
knows.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import RunError, tell

FARTHEST = 100.0
"""Largest coordinate of a place, and most cable to pay out, that a command may ask for [m]: more is a mistake."""

_SQUARE = 1e-6
"""How far the axes of a commanded frame may be from unit length and from a right angle [-]."""


@final
@dataclass(frozen=True, kw_only=True)
class Target:
    """The object as it was announced to the robot: its nominal place and size."""

    kind: str
    """Shape, such as cylinder, sphere or box."""
    width: float
    """Extent across its axis, the diameter of a cylinder [m]."""
    length: float
    """Extent along its axis [m]."""
    mass: float
    """Mass [kg]."""
    position: np.ndarray
    """Centre in the world, shape (3,) [m]."""
    axis: np.ndarray
    """Unit vector along the object: horizontal where it hangs or lies, up where it stands, shape (3,) [-]."""
    friction: float = 0.8
    """Coefficient of friction that the robot may count on [-]."""


@final
@dataclass(frozen=True, kw_only=True)
class Goal:
    """Where the object shall go."""

    lift: float = 0.20
    """Height to lift it by [m]."""
    aside: np.ndarray
    """Horizontal carry from where it was, shape (3,) [m]."""
    hold: float = 3.0
    """Time to hold it still up there [s]."""
    place: np.ndarray
    """Where its centre shall rest at the end, shape (3,) [m]."""
    zone: float = 0.05
    """Distance from there within which it shall rest [m]."""
    ground: float | None = None
    """Height of the ground that the object stands or lies on [m]; None where it hangs."""


@final
@dataclass(frozen=True, kw_only=True)
class Task:
    """What is to be done, and with which robot."""

    design: TrunkDesign
    """The robot as designed; the real or simulated one may differ."""
    target: Target
    """The object."""
    goal: Goal
    """Where it shall go."""


@final
@dataclass(frozen=True, kw_only=True)
class Look:
    """Where a camera saw the object; right to a few millimetres."""

    time: float
    """When it looked [s]."""
    position: np.ndarray
    """Centre of the object in the world, shape (3,) [m]."""
    axis: np.ndarray
    """Unit vector along the object in the world, shape (3,) [-]."""


@final
@dataclass(frozen=True, kw_only=True)
class Observation:
    """What the robot knows at one instant."""

    time: float
    """Time since reset [s]."""
    task: Task
    """The task, the same throughout."""
    T_world_base: np.ndarray
    """Frame of the trunk's base from the arm's joints: x along the trunk, y dorsal, shape (4, 4) [-, m]."""
    arm_position: np.ndarray
    """Joint positions of the arm, shape (n_arm,) [rad]."""
    arm_velocity: np.ndarray
    """Joint velocities of the arm, shape (n_arm,) [rad/s]."""
    cable_pull: np.ndarray
    """Cable pulled in since the straight trunk, from the motor angles, shape (n_cable,) [m]."""
    cable_tension: np.ndarray
    """Tension estimates from the motor currents, shape (n_cable,) [N]."""
    base_force: np.ndarray
    """Force of all that hangs on the trunk's base, from the arm's joint torques, in the world, shape (3,) [N]."""
    base_torque: np.ndarray
    """Torque of the same about the trunk's base, in the world, shape (3,) [N m]."""
    look: Look | None = None
    """The camera's last look at the object; None on a plant without a camera, and for strategies that need none."""


@final
@dataclass(frozen=True, kw_only=True)
class Command:
    """What the robot shall do until the next command."""

    T_world_base: np.ndarray
    """Frame that the trunk's base shall reach, shape (4, 4) [-, m]."""
    cable_tension: np.ndarray
    """Ceiling of each cable's tension, shape (n_cable,) [N]."""
    cable_pull: np.ndarray | None = None
    """Cable to pull in at most, shape (n_cable,) [m]; None pulls with the tension whatever the length."""
    gripper: float = 0.0
    """Tip gripper from -1 (open) over 0 (slack) to 1 (closed) [-]."""


class Plant(ABC):
    """A robot with its surroundings, advanced one control period at a time."""

    @property
    @abstractmethod
    def control_period(self) -> float:
        """Time between two commands [s]."""

    @abstractmethod
    def reset(self) -> Observation:
        """Bring everything to the start of the task and return the first observation."""

    @abstractmethod
    def step(self, command: Command) -> Observation:
        """Carry out a command for one control period and return what is seen then.

        Raises:
            RunError: where the command is none (`read_command`), or the plant cannot go on.
        """


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
