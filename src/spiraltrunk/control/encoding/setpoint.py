"""Set points on the way to what actions ask for: with bounded acceleration, over one or several control periods.

A robot refuses commands that jump, and the verdict on a trial counts an arm that passes its limits as failed. Actions
of a policy jump, at least while it learns. So the base follows them with bounded acceleration, as behind libfranka's
rate limiter; the commands of strategies stay below the bounds and pass unchanged.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.control.encoding.actions import (
    ROTATION_SPEED,
    TRANSLATION_SPEED,
    Vectors,
    action_size,
    decode_action,
    decode_cables,
    interpolate_command,
    measure_displacement,
    move_frame,
    read_action,
    read_displacement,
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
"""Largest speed towards a set point, over the speed from which the base can still stop there [-] (ours)."""

_MOST, _FASTEST = (ACCELERATION, ANGULAR_ACCELERATION), (TRANSLATION_SPEED, ROTATION_SPEED)

_NONE: Vectors = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


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
    """In the absolute modes, command that the action asks for at this time; the base is on its way to it."""
    start: Command
    """The command that was asked for at the start of the action."""


def begin_setpoint(observation: Observation) -> Setpoint:
    """The set point before the first action: the base stays where it is, cables and gripper are slack."""
    rest = Command(T_world_base=observation.T_world_base, cable_tension=np.zeros(len(observation.cable_tension)))
    return restart_setpoint(rest)


def restart_setpoint(command: Command, before: Command | None = None) -> Setpoint:
    """The set point at a command that took effect as it is.

    Args:
        command: the command.
        before: the command of the control period before, from which the base moves on at constant velocity. A command
            farther from it than the largest speed goes in a control period is a jump, after which the base is at rest;
            None for a base at rest.
    """
    moved = _NONE if before is None else measure_displacement(command.T_world_base, before.T_world_base)
    velocity = np.array(moved) / CONTROL_PERIOD
    if any(math.hypot(*row) > fastest for row, fastest in zip(velocity.tolist(), _FASTEST, strict=True)):
        velocity = np.zeros((2, 3))
    return Setpoint(command=command, velocity=velocity, wanted=command, start=command)


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
    before, task = setpoint.command.T_world_base, observation.task
    start = setpoint.wanted if period == 0 else setpoint.start
    if mode.is_relative:
        given = read_action(action, action_size(mode, task.design))
        behind, moved = _NONE, read_displacement(given, before, CONTROL_PERIOD, observation.T_world_base)
        tension, pull = decode_cables(mode, given[6:-1], task.design)
        wanted = Command(T_world_base=before, cable_tension=tension, cable_pull=pull, gripper=float(given[-1]))
    else:
        wanted = decode_action(mode, action, setpoint.command, task)
        wanted = interpolate_command(start, wanted, (period + 1) / periods)
        moved = measure_displacement(wanted.T_world_base, setpoint.wanted.T_world_base)
        behind = measure_displacement(setpoint.wanted.T_world_base, before)
    feed = [[part / CONTROL_PERIOD for part in row] for row in moved]
    velocity = next_velocity(behind, feed, setpoint.velocity.tolist(), _MOST, _FASTEST)
    T = move_frame(before, [[CONTROL_PERIOD * part for part in row] for row in velocity])
    command = Command(
        T_world_base=T, cable_tension=wanted.cable_tension, cable_pull=wanted.cable_pull, gripper=wanted.gripper
    )  # fmt: skip
    return Setpoint(command=command, velocity=np.array(velocity), wanted=wanted, start=start)


def next_velocity(
    behind: Vectors, feed: Vectors, velocity: Vectors, most: Sequence[float], fastest: Sequence[float]
) -> list[list[float]]:
    r"""Velocity of the next period at bounded speed and acceleration, of n vectors of k numbers each.

    Wanted is :math:`v_f + e \min(1 / \Delta t, \beta \sqrt{2 a / |e|})`: the velocity :math:`v_f` of what is followed,
    and towards it from the error :math:`e`, with at most the share :math:`\beta` (`BRAKING`) of the speed from which
    the acceleration :math:`a` stops within :math:`|e|`. It is cut to the largest speed, and the velocity changes by at
    most :math:`a \Delta t` in a period.

    Args:
        behind: errors, what is followed less what follows.
        feed: velocities of what is followed [1/s].
        velocity: present velocities [1/s].
        most: largest acceleration of each vector [1/s^2].
        fastest: largest speed of each vector [1/s].
    """
    return [_next_velocity(*row) for row in zip(behind, feed, velocity, most, fastest, strict=True)]


def _next_velocity(
    behind: Sequence[float], feed: Sequence[float], velocity: Sequence[float], most: float, fastest: float
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
