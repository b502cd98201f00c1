"""Control modes: what the numbers of an action set, and how often."""

from __future__ import annotations

from enum import Enum
from functools import cached_property
from typing import final

from spiraltrunk.checks import check_number
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.errors import DesignError, UnknownName


@final
class ControlMode(Enum):
    """What an action sets: the arm's base or joints first, then the cables, then the gripper; the value is its name."""

    DELTA_POSE_TENSION = "delta-pose-tension"
    """Displacement of the commanded base in the world, largest tensions of the cables."""
    DELTA_POSE_PULL = "delta-pose-pull"
    """Displacement of the commanded base in the world, largest pulls of the cables."""
    DELTA_POSE_TENSION_PULL = "delta-pose-tension-pull"
    """Displacement of the commanded base in the world, largest tensions, then largest pulls of the cables."""
    JOINT_TENSION = "joint-tension"
    """Positions of the arm's joints, largest tensions of the cables."""
    POSE_TENSION = "pose-tension"
    """Pose of the base in the frame of the announced object, largest tensions of the cables."""
    POSE_TENSION_PULL = "pose-tension-pull"
    """Pose of the base in the frame of the announced object, largest tensions, then largest pulls of the cables."""

    @cached_property
    def sets_joints(self) -> bool:
        """Whether it sets the arm's joints, and not the base."""
        return self is ControlMode.JOINT_TENSION

    @cached_property
    def is_relative(self) -> bool:
        """Whether it displaces the base from where it was commanded to be."""
        return self.value.startswith("delta")

    @cached_property
    def sets_tension(self) -> bool:
        """Whether it sets largest tensions."""
        return "tension" in self.value

    @cached_property
    def sets_pull(self) -> bool:
        """Whether it sets largest pulls."""
        return self.value.endswith("pull")


def parse_control_mode(name: str | ControlMode) -> ControlMode:
    """The control mode of a name.

    Raises:
        UnknownName: lists the names.
    """
    known = {mode.value: mode for mode in ControlMode}
    if isinstance(name, ControlMode):
        return name
    if not isinstance(name, str) or name not in known:
        raise UnknownName("control mode", name, known)
    return known[name]


def read_periods(control_hz: float) -> int:
    """Control periods of one action, at a rate of actions [1/s].

    Raises:
        DesignError: for a rate of which 50 Hz is no whole multiple.
    """
    check_number("control_hz", control_hz, least=1.0, most=1 / CONTROL_PERIOD)
    periods = round(1 / (CONTROL_PERIOD * control_hz))
    if abs(periods * control_hz * CONTROL_PERIOD - 1.0) > 1e-9:
        raise DesignError("control_hz", got=control_hz, allowed="50 over a whole number, such as 50, 25 or 10")
    return periods
