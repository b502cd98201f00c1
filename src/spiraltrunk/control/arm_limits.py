"""Limits of an arm: joint position, velocity, acceleration, jerk and torque, independent of the simulator."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.field_docs import explain_fields

QUANTITIES = ("position", "velocity", "acceleration", "jerk", "torque")
"""What a verdict compares with a limit."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class ArmLimits:
    """Limits joint by joint; None where none is known, infinite for a joint without one. Slides have m and N."""

    position: tuple[np.ndarray, np.ndarray] | None
    """Least and largest joint positions, two of shape (n_arm,) [rad]."""
    velocity: np.ndarray | None
    """Largest speed, shape (n_arm,) [rad/s]."""
    acceleration: np.ndarray | None
    """Largest acceleration, shape (n_arm,) [rad/s^2]."""
    jerk: np.ndarray | None
    """Largest jerk, shape (n_arm,) [rad/s^3]."""
    torque: np.ndarray | None
    """Largest torque, shape (n_arm,) [N m]."""
    braking: tuple[np.ndarray, np.ndarray] | None = None
    """Speed offset [rad/s] and deceleration [rad/s^2] of a speed limit that falls towards the ends of the range, two
    of shape (n_arm,), see `velocity_bounds`; None for a speed limit that is the same everywhere."""


def velocity_bounds(limits: ArmLimits, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest joint velocities at joint positions ``q``, two arrays of its shape (..., n_arm) [rad/s].

    They are those of `speed_towards` the lower and the upper end of the range.

    Raises:
        ValueError: where no speed limit is known.
    """
    return -speed_towards(limits, q, np.array(False)), speed_towards(limits, q, np.array(True))


def speed_towards(limits: ArmLimits, q: np.ndarray, is_up: np.ndarray) -> np.ndarray:
    """Largest speed of joints that move up or down at joint positions ``q``, of its shape (..., n_arm) [rad/s].

    Where braking is published, a joint may move towards an end of its range only as fast as it can still stop before
    it: dq_max(q) = min(v, max(0, -o + sqrt(max(0, 2 d (q_max - q))))) with speed limit v, offset o and deceleration d,
    and likewise towards q_min (Franka, "Control Interface Specification and Robot Limits", position-based velocity
    limits).

    Raises:
        ValueError: where no speed limit is known.
    """
    if limits.velocity is None:
        raise ValueError("no speed limit is known")
    if limits.braking is None or limits.position is None:
        return np.broadcast_to(limits.velocity, q.shape)
    offset, deceleration = limits.braking
    low, high = limits.position
    way = np.where(is_up, high - q, q - low)
    return np.minimum(limits.velocity, np.maximum(0.0, np.sqrt(np.maximum(0.0, 2 * deceleration * way)) - offset))


def standstill_margin(limits: ArmLimits) -> np.ndarray | float:
    """Distance from the ends of the range within which a joint may not move towards them, o^2 / (2 d) [rad]."""
    if limits.braking is None:
        return 0.0
    offset, deceleration = limits.braking
    return offset**2 / (2 * deceleration)


def find_missing_limits(limits: ArmLimits) -> tuple[str, ...]:
    """Quantities of which a limit is missing, such as "velocity", or "torque of 2 of 6 joints"."""
    return tuple(name + missing for name in QUANTITIES if (missing := _missing(getattr(limits, name))) is not None)


def _missing(limit: np.ndarray | tuple[np.ndarray, np.ndarray] | None) -> str | None:
    """What to say of joints without a limit; None where all have one."""
    if limit is None:
        return ""
    is_missing = ~np.isfinite(np.atleast_2d(limit)).all(axis=0)
    if not is_missing.any():
        return None
    return "" if is_missing.all() else f" of {is_missing.sum()} of {is_missing.size} joints"
