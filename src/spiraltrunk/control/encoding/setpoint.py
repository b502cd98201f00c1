"""Set points on the way to what actions ask for: with bounded acceleration, over one or several control periods.

A robot refuses commands that jump, and the verdict on a trial counts an arm that passes its limits as failed. Actions
of a policy jump, at least while it learns. So the base follows them with bounded acceleration, as behind libfranka's
rate limiter; the commands of strategies stay below the bounds and pass unchanged.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy.spatial.transform import Rotation

from spiraltrunk.control.encoding.actions import (
    ROTATION_SPEED,
    TRANSLATION_SPEED,
    decode_action,
    interpolate_command,
)
from spiraltrunk.control.encoding.control_mode import ControlMode
from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.errors import ModelError
from spiraltrunk.field_docs import explain_fields

ACCELERATION, ANGULAR_ACCELERATION = 1.0, 3.5
"""Largest acceleration of the base's set point [m/s^2, rad/s^2] (ours): a third more than that of the strategies, at
which the arm's joints stay below their limits but near the ends of its reach."""

BRAKING = 0.8
"""Speed towards a set point that was left behind, over that from which it can still stop [-] (ours)."""

_MOST = np.array([[ACCELERATION], [ANGULAR_ACCELERATION]])
_FASTEST = np.array([[TRANSLATION_SPEED], [ROTATION_SPEED]])


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Setpoint:
    """The command of a control period, and what the next one depends on."""

    command: Command
    """The command."""
    velocity: np.ndarray
    """Velocity and angular velocity of the commanded base in the world, shape (2, 3) [m/s, rad/s]."""
    wanted: Command
    """Command that the action asks for at this time; the base is on its way to it."""
    start: Command
    """The same at the begin of the action."""


def begin_setpoint(observation: Observation) -> Setpoint:
    """The set point before the first action: the base stays where it is, cables and gripper are slack."""
    rest = Command(T_world_base=observation.T_world_base, cable_tension=np.zeros(len(observation.cable_tension)))
    return restart_setpoint(rest)


def restart_setpoint(command: Command) -> Setpoint:
    """The set point of a base at rest at a command."""
    return Setpoint(command=command, velocity=np.zeros((2, 3)), wanted=command, start=command)


def follow_action(
    setpoint: Setpoint,
    mode: ControlMode,
    action: np.ndarray,
    observation: Observation,
    *,
    period: int = 0,
    periods: int = 1,
) -> Setpoint:
    """The set point of the next control period, on the way to an action that lasts several of them.

    The relative modes ask for the same displacement in each period. In the absolute modes the wanted command moves
    uniformly from that of the last action to that of this one.

    Args:
        setpoint: the last set point.
        mode: what the action sets; not the mode that sets joints.
        action: the action [-].
        observation: the last observation.
        period: which control period of the action this is, from 0.
        periods: control periods of the action.

    Raises:
        ModelError: as `decode_action`, and for the mode that sets joints.
    """
    if mode.sets_joints:
        raise ModelError(f"control mode {mode.value!r} sets joints; allowed: one that sets the base")
    before, measured = setpoint.command, observation.T_world_base
    wanted = decode_action(mode, action, before, observation.task, measured=measured)
    start = setpoint.wanted if period == 0 else setpoint.start
    if mode.is_relative:
        moved = _difference(wanted.T_world_base, before.T_world_base)
        velocity = next_velocity(np.zeros((2, 3)), moved / CONTROL_PERIOD, setpoint.velocity, _MOST, _FASTEST)
    else:
        wanted = interpolate_command(start, wanted, (period + 1) / periods)
        moved = _difference(wanted.T_world_base, setpoint.wanted.T_world_base)
        behind = _difference(setpoint.wanted.T_world_base, before.T_world_base)
        velocity = next_velocity(behind, moved / CONTROL_PERIOD, setpoint.velocity, _MOST, _FASTEST)
    command = replace(wanted, T_world_base=_move(before.T_world_base, CONTROL_PERIOD * velocity))
    return Setpoint(command=command, velocity=velocity, wanted=wanted, start=start)


def next_velocity(
    behind: np.ndarray, feed: np.ndarray, velocity: np.ndarray, most: np.ndarray, fastest: np.ndarray
) -> np.ndarray:
    r"""Velocity of the next period at bounded speed and acceleration, shape (n, k), of n vectors of k numbers.

    Wanted is :math:`v_f + e \min(1 / \Delta t, \beta \sqrt{2 a / |e|})`: the velocity :math:`v_f` of what is followed,
    and towards it from the error :math:`e`, with at most the share :math:`\beta` (`BRAKING`) of the speed from which
    the acceleration :math:`a` stops within :math:`|e|`. It is cut to the largest speed, and the velocity changes by at
    most :math:`a \Delta t` in a period.

    Args:
        behind: errors, what is followed less what follows, shape (n, k).
        feed: velocities of what is followed, shape (n, k) [1/s].
        velocity: present velocities, shape (n, k) [1/s].
        most: largest accelerations, shape (n, 1) [1/s^2].
        fastest: largest speeds, shape (n, 1) [1/s].
    """
    rows = zip(
        behind.tolist(), feed.tolist(), velocity.tolist(), most.ravel().tolist(), fastest.ravel().tolist(), strict=True
    )  # fmt: skip
    return np.array([_next_velocity(*row) for row in rows])


def _next_velocity(
    behind: list[float], feed: list[float], velocity: list[float], most: float, fastest: float
) -> list[float]:
    """`next_velocity` of one vector; in plain numbers, as arrays of three take three times as long."""
    wanted, error = feed, math.hypot(*behind)
    if error > 0.0:
        rate = min(1.0 / CONTROL_PERIOD, BRAKING * math.sqrt(2.0 * most / error))
        wanted = [v + rate * e for v, e in zip(feed, behind, strict=True)]
    share = min(1.0, fastest / max(math.hypot(*wanted), 1e-12))
    change = [share * w - v for w, v in zip(wanted, velocity, strict=True)]
    share = min(1.0, most * CONTROL_PERIOD / max(math.hypot(*change), 1e-12))
    return [v + share * c for v, c in zip(velocity, change, strict=True)]


def _difference(end: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Displacement and rotation vector in the world from one frame to another, shape (2, 3) [m, rad]."""
    moved = np.zeros((2, 3))
    moved[0] = end[:3, 3] - start[:3, 3]
    if not np.array_equal(end[:3, :3], start[:3, :3]):
        moved[1] = Rotation.from_matrix(end[:3, :3] @ start[:3, :3].T).as_rotvec()
    return moved


def _move(start: np.ndarray, moved: np.ndarray) -> np.ndarray:
    T = start.copy()
    T[:3, 3] += moved[0]
    if moved[1].any():
        T[:3, :3] = Rotation.from_rotvec(moved[1]).as_matrix() @ start[:3, :3]
    return T
