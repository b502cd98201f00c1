"""Targets of the driver, refused before any clamp where they are not sound."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.checks import Range, read_array, read_numbers
from spiraltrunk.control.command_check import FARTHEST
from spiraltrunk.errors import DriveError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.arm.arm_port import ArmPort

_ROUNDING = 1e-9
"""Part of the largest tension by which a target may exceed it, the rounding of interpolated commands [-]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Targets:
    """What the driver aims at until the next targets, checked."""

    tension: tuple[float, ...]
    """Upper limit of each cable's tension [N]."""
    pull: tuple[float, ...]
    """Upper limit of the cable wound in since the straight trunk [m]; infinity sets none."""
    arm_position: np.ndarray | None = None
    """Joint positions of the arm, shape (n_arm,) [rad]; None leaves it where it is."""
    gripper: float = 0.0
    """Gripper from -1 (open) over 0 (slack) to 1 (closed) [-]."""
    expires: float = 0.0
    """End of their validity on the driver's clock [s]."""


def read_tension(value: ArrayLike, tension_most: Sequence[float]) -> tuple[float, ...]:
    """Tensions [N], each from 0 to the largest of its cable.

    Raises:
        DriveError: where a value is not a finite number in its range, or their number is wrong.
    """
    tension = read_numbers("tension", value, shape=(len(tension_most),), unit="N", error=DriveError).tolist()
    for i, (one, most) in enumerate(zip(tension, tension_most, strict=True)):
        if not -_ROUNDING * most <= one <= (1.0 + _ROUNDING) * most:
            raise DriveError(f"tension[{i}] is {one:g} N; allowed: 0 to {most:g} N, the design's largest")
    return tuple(min(max(one, 0.0), most) for one, most in zip(tension, tension_most, strict=True))


def read_pull(value: ArrayLike | None, n_cable: int) -> tuple[float, ...]:
    """Pulls [m]; None and infinity set no limit.

    Raises:
        DriveError: where a value is NaN, more than `FARTHEST` paid out, or their number is wrong.
    """
    if value is None:
        return (float("inf"),) * n_cable
    pull = read_array("pull", value, (n_cable,), error=DriveError).tolist()
    for i, one in enumerate(pull):
        if not one > -FARTHEST:
            allowed = f"metres above -{FARTHEST:g}, or infinity for no limit"
            raise DriveError(f"pull[{i}] is {one:g} m; allowed: {allowed}")
    return tuple(pull)


def read_arm_position(value: ArrayLike | None, arm: ArmPort | None) -> np.ndarray | None:
    """Joint positions of the arm [rad], a copy, within its limits.

    Raises:
        DriveError: without an arm, or where a value is not a finite number within the limits, or their number is wrong.
    """
    if value is None:
        return None
    if arm is None:
        raise DriveError("arm_position is given without an arm; allowed: None")
    bounds = arm.limits.position
    shape = None if bounds is None else bounds[0].shape
    position = read_numbers("arm_position", value, shape=shape, unit="rad", error=DriveError)
    if bounds is not None and not ((bounds[0] <= position) & (position <= bounds[1])).all():
        i = int(np.argmax((position < bounds[0]) | (position > bounds[1])))
        allowed = f"{bounds[0][i]:g} to {bounds[1][i]:g} rad"
        raise DriveError(f"arm_position[{i}] is {position[i]:g} rad; allowed: {allowed}")
    return position.copy()


def read_gripper(value: ArrayLike, *, has_servo: bool) -> float:
    """Gripper [-].

    Raises:
        DriveError: where it is not a finite number from -1 to 1, or not 0 without a servo.
    """
    allowed = Range(least=-1.0, most=1.0) if has_servo else Range(least=0.0, most=0.0)
    return float(read_numbers("gripper", value, allowed, shape=(), error=DriveError))


def read_validity(value: ArrayLike, most: float) -> float:
    """Validity of targets [s].

    Raises:
        DriveError: where it is not a finite number from 0 to ``most``.
    """
    allowed = Range(least=0.0, most=most)
    return float(read_numbers("valid_for", value, allowed, shape=(), unit="s", error=DriveError))
