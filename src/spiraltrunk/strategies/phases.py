"""The four phases of a point-to-point grasp as moves of arm and cables in sequence.

Source: "Grasping by Spiraling", figure 1e and Results, after Dagenais et al. 2021.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.plant import Command, Observation

PHASES = ("reach", "prehension", "transport", "release")
"""The four phases, in order."""


@final
@dataclass(frozen=True, kw_only=True)
class Move:
    """Arm and cables from where they are to a new place and tension, in a given time."""

    phase: str
    """One of the four."""
    action: str
    """What the move is for."""
    duration: float
    """Time it takes [s]."""
    position: np.ndarray
    """Where it takes the trunk's base, in the world, shape (3,) [m]."""
    tension: np.ndarray
    """Tension ceilings at its end, shape (n_cable,) [N]."""


@final
@dataclass(frozen=True, kw_only=True)
class Progress:
    """How far a sequence of moves has come."""

    moves: tuple[Move, ...]
    """All moves, done and to do."""
    index: int
    """The move under way."""
    since: float
    """When it began [s]."""
    T_start: np.ndarray
    """Frame of the base when it began; its orientation is kept, shape (4, 4) [-, m]."""
    tension_start: np.ndarray
    """Tension ceilings when it began, shape (n_cable,) [N]."""
    velocity_start: np.ndarray
    """Velocity of the base when it began, shape (3,) [m/s]."""

    @property
    def move(self) -> Move:
        """The move under way."""
        return self.moves[self.index]

    @property
    def is_last(self) -> bool:
        """Whether no move follows."""
        return self.index == len(self.moves) - 1


def begin(moves: tuple[Move, ...], observation: Observation) -> Progress:
    """Start a sequence from what is seen, cables slack."""
    return Progress(
        moves=moves, index=0, since=observation.time, T_start=observation.T_world_base,
        tension_start=np.zeros(observation.cable_tension.shape), velocity_start=np.zeros(3),
    )  # fmt: skip


def fraction(progress: Progress, time: float) -> float:
    """Part of the move's time that has passed, 0 to 1."""
    return min(1.0, max(0.0, (time - progress.since) / progress.move.duration))


def command_at(progress: Progress, time: float) -> Command:
    """What to do at ``time`` [s]: base along a path of least jerk, tension along a ramp."""
    s = fraction(progress, time)
    T_world_base = progress.T_start.copy()
    way = progress.move.position - progress.T_start[:3, 3]
    T_world_base[:3, 3] += _ease(s) * way + _run_out(s) * progress.move.duration * progress.velocity_start
    tension = progress.tension_start + s * (progress.move.tension - progress.tension_start)
    return Command(T_world_base=T_world_base, cable_tension=tension)


def advance(progress: Progress, time: float) -> Progress:
    """The next move, begun from where the present one's commands have come and as fast, be it at its end or not."""
    now, step = command_at(progress, time), 1e-4
    before = command_at(progress, time - step)
    velocity = (now.T_world_base[:3, 3] - before.T_world_base[:3, 3]) / step
    return replace(
        progress, index=progress.index + 1, since=time, T_start=now.T_world_base, tension_start=now.cable_tension,
        velocity_start=velocity if fraction(progress, time) < 1.0 else np.zeros(3),
    )  # fmt: skip


def _ease(s: float) -> float:
    """Way from rest to rest of least jerk, 0 to 1."""
    return s**3 * (10 - 15 * s + 6 * s**2)


def _run_out(s: float) -> float:
    """Way from unit speed to rest of least jerk that ends where it began: s - 6 s^3 + 8 s^4 - 3 s^5."""
    return s - 6 * s**3 + 8 * s**4 - 3 * s**5


def insert_next(progress: Progress, moves: tuple[Move, ...]) -> Progress:
    """The same sequence with further moves after the present one."""
    i = progress.index + 1
    return replace(progress, moves=(*progress.moves[:i], *moves, *progress.moves[i:]))


def shift_later(progress: Progress, way: np.ndarray) -> Progress:
    """The same sequence with the end of every move after the present one shifted by ``way``, shape (3,) [m]."""
    i = progress.index + 1
    later = tuple(replace(move, position=move.position + way) for move in progress.moves[i:])
    return replace(progress, moves=(*progress.moves[:i], *later))


def raise_tension(progress: Progress, factor: float, ceiling: float) -> Progress:
    """The same sequence with the tension of this and every later carrying move raised, up to a ceiling [N]."""
    moves = tuple(
        replace(move, tension=np.minimum(move.tension * factor, ceiling)) if i >= progress.index else move
        for i, move in enumerate(progress.moves)
    )
    return replace(progress, moves=moves)
