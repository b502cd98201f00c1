"""Moves of arm and cables in sequence, grouped in the four phases of a point-to-point grasp.

Source of the phases: "Grasping by Spiraling", figure 1e and Results, after Dagenais et al. 2021.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy.spatial.transform import Rotation

from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.strategies.timing import PEAK_ACCELERATION

PHASES = ("reach", "prehension", "transport", "release")
"""The four phases, in order."""


@final
@dataclass(frozen=True, kw_only=True)
class Move:
    """Motion of arm and cables from where they are to an end, in a given time."""

    phase: str
    """One of PHASES."""
    action: str
    """Name of the move, for people to read."""
    milestone: Milestone | None = None
    """What it works towards; None between milestones."""
    duration: float
    """Duration [s]."""
    position: np.ndarray
    """Position of the trunk's base at the end, in the world, shape (3,) [m]."""
    tension: np.ndarray
    """Tension ceilings at the end, shape (n_cable,) [N]."""
    rotation: np.ndarray | None = None
    """Orientation of the base at the end, in the world, shape (3, 3) [-]; None keeps the present one."""
    gripper: float = 0.0
    """Command of the tip gripper at the end: -1 open, 0 slack, 1 closed [-]."""
    pull: np.ndarray | None = None
    """Upper bounds of the cable pulls at the end, shape (n_cable,) [m]; None for no bounds."""


@final
@dataclass(frozen=True, kw_only=True)
class MoveSequence:
    """A sequence of moves and the state of its execution."""

    moves: tuple[Move, ...]
    """All moves, done and to do."""
    index: int
    """Index of the present move."""
    since: float
    """Time at which the present move began [s]."""
    start: Command
    """Command at that time."""
    velocity: np.ndarray
    """Commanded velocity of the base at that time, shape (3,) [m/s]."""

    @property
    def move(self) -> Move:
        """The present move."""
        return self.moves[self.index]

    @property
    def is_last(self) -> bool:
        """Whether no move follows."""
        return self.index == len(self.moves) - 1


def begin(moves: tuple[Move, ...], observation: Observation) -> MoveSequence:
    """Start a sequence from the observed frame of the base, cables slack."""
    slack = Command(T_world_base=observation.T_world_base, cable_tension=np.zeros(observation.cable_tension.shape))
    return MoveSequence(moves=moves, index=0, since=observation.time, start=slack, velocity=np.zeros(3))


def fraction(sequence: MoveSequence, time: float) -> float:
    """Elapsed part of the present move at ``time`` [s], 0 to 1 [-]."""
    return min(1.0, max(0.0, (time - sequence.since) / sequence.move.duration))


def command_at(sequence: MoveSequence, time: float) -> Command:
    """Command at ``time`` [s]: minimum-jerk path of the base, linear ramps of tensions, pull bounds and gripper."""
    s, move, start = fraction(sequence, time), sequence.move, sequence.start
    T_world_base = start.T_world_base.copy()
    way = move.position - start.T_world_base[:3, 3]
    T_world_base[:3, 3] += _minimum_jerk(s) * way + _decelerate(s) * move.duration * sequence.velocity
    if move.rotation is not None:
        T_world_base[:3, :3] = _rotate(start.T_world_base[:3, :3], move.rotation, _minimum_jerk(s))
    pull = move.pull
    if pull is not None and start.cable_pull is not None and np.isfinite(start.cable_pull).all():
        pull = start.cable_pull + s * (pull - start.cable_pull)
    return Command(
        T_world_base=T_world_base,
        cable_tension=start.cable_tension + s * (move.tension - start.cable_tension),
        cable_pull=pull,
        gripper=start.gripper + s * (move.gripper - start.gripper),
    )


def base_position(sequence: MoveSequence, time: float) -> np.ndarray:
    """Commanded position of the base at ``time`` [s], shape (3,) [m]; before the move began, where it began."""
    return command_at(sequence, time).T_world_base[:3, 3]


def base_velocity(sequence: MoveSequence, time: float) -> np.ndarray:
    """Commanded velocity of the base at ``time`` [s], shape (3,) [m/s]; 0 at the end of a move."""
    step = 1e-4
    if fraction(sequence, time) >= 1.0:
        return np.zeros(3)
    if time - step < sequence.since:
        return sequence.velocity
    return np.asarray((base_position(sequence, time) - base_position(sequence, time - step)) / step)


def turn_left(sequence: MoveSequence, time: float) -> float:
    """Angle by which the base still turns after ``time`` [s] in the present move [rad]."""
    rotation = sequence.move.rotation
    return 0.0 if rotation is None else _angle_between(command_at(sequence, time).T_world_base[:3, :3], rotation)


def advance(sequence: MoveSequence, time: float) -> MoveSequence:
    """Begin the next move at ``time`` [s], which may cut the present one short.

    Position, velocity, tension and gripper are continuous.
    """
    now, velocity = command_at(sequence, time), base_velocity(sequence, time)
    return replace(sequence, index=sequence.index + 1, since=time, start=now, velocity=velocity)


def allow_time(sequence: MoveSequence, time: float, acceleration: float, angular_acceleration: float) -> MoveSequence:
    """The sequence with the next move as long as its path from where the base is at ``time`` [s] asks, or longer.

    Args:
        sequence: moves, the present one about to end.
        time: at which the next one begins [s].
        acceleration: largest acceleration of the base [m/s^2].
        angular_acceleration: the same of its orientation [rad/s^2].
    """
    now, i = command_at(sequence, time).T_world_base, sequence.index + 1
    move = sequence.moves[i]
    least = float(np.linalg.norm(move.position - now[:3, 3])) / acceleration
    if move.rotation is not None:
        least = max(least, _angle_between(now[:3, :3], move.rotation) / angular_acceleration)
    longer = replace(move, duration=max(move.duration, math.sqrt(PEAK_ACCELERATION * least)))
    return replace(sequence, moves=(*sequence.moves[:i], longer, *sequence.moves[i + 1 :]))


def insert_next(sequence: MoveSequence, moves: tuple[Move, ...]) -> MoveSequence:
    """The sequence with further moves after the present one."""
    i = sequence.index + 1
    return replace(sequence, moves=(*sequence.moves[:i], *moves, *sequence.moves[i:]))


def edit_moves(sequence: MoveSequence, first: int, change: Callable[[Move], Move]) -> MoveSequence:
    """The sequence with ``change`` applied to every move from index ``first`` on."""
    return replace(sequence, moves=(*sequence.moves[:first], *map(change, sequence.moves[first:])))


def shift_later(sequence: MoveSequence, way: np.ndarray, phases: tuple[str, ...] = PHASES) -> MoveSequence:
    """The sequence with the ends of the remaining moves of ``phases`` shifted by ``way``, shape (3,) [m]."""

    def shift(move: Move) -> Move:
        return replace(move, position=move.position + way) if move.phase in phases else move

    return edit_moves(sequence, sequence.index + 1, shift)


def build_frame(position: np.ndarray, rotation: np.ndarray | None) -> np.ndarray:
    """Frame of the base at a position, shape (3,) [m], by default oriented as the world, shape (4, 4) [-, m]."""
    T_world_base = np.eye(4)
    T_world_base[:3, 3] = position
    if rotation is not None:
        T_world_base[:3, :3] = rotation
    return T_world_base


def raise_tension(sequence: MoveSequence, factor: float, ceiling: float) -> MoveSequence:
    """The sequence with the tensions of the present and the remaining moves times ``factor``, up to a ceiling [N]."""
    return edit_moves(
        sequence, sequence.index, lambda move: replace(move, tension=np.minimum(move.tension * factor, ceiling))
    )


def tilted_base(way: np.ndarray, tilt: float) -> np.ndarray:
    """Orientation of a base tilted by ``tilt`` [rad] from hanging towards a level unit vector, shape (3, 3) [-].

    The trunk's axis x points down and along ``way``; ventral, -y, points level to its right.
    """
    along = math.sin(tilt) * np.array([way[0], way[1], 0.0]) - np.array([0.0, 0.0, math.cos(tilt)])
    dorsal = np.array([-way[1], way[0], 0.0])
    return np.stack([along, dorsal, np.cross(along, dorsal)], axis=1)


def _rotate(start: np.ndarray, end: np.ndarray, s: float) -> np.ndarray:
    """Spherical linear interpolation between two orientations, shape (3, 3) [-]."""
    turn = Rotation.from_matrix(start.T @ end).as_rotvec()
    return np.asarray(start @ Rotation.from_rotvec(s * turn).as_matrix())


def _angle_between(start: np.ndarray, end: np.ndarray) -> float:
    """Angle between two orientations, each of shape (3, 3) [rad]."""
    return math.acos(max(-1.0, min(1.0, (float(np.sum(start * end)) - 1) / 2)))


def _minimum_jerk(s: float) -> float:
    """Minimum-jerk displacement from rest to rest: 10 s^3 - 15 s^4 + 6 s^5 (Flash and Hogan 1985), 0 to 1 [-]."""
    return s**3 * (10 - 15 * s + 6 * s**2)


def _decelerate(s: float) -> float:
    """Minimum-jerk displacement from unit speed to rest, without a net way: s - 6 s^3 + 8 s^4 - 3 s^5 [-]."""
    return s - 6 * s**3 + 8 * s**4 - 3 * s**5
