"""The four phases of a point-to-point grasp as moves of arm and cables in sequence.

Source: "Grasping by Spiraling", figure 1e and Results, after Dagenais et al. 2021.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy.spatial.transform import Rotation

from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.strategy import Milestone, Status

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
    milestone: Milestone | None = None
    """What it works towards."""
    duration: float
    """Time it takes [s]."""
    position: np.ndarray
    """Where it takes the trunk's base, in the world, shape (3,) [m]."""
    tension: np.ndarray
    """Tension ceilings at its end, shape (n_cable,) [N]."""
    rotation: np.ndarray | None = None
    """Orientation of the base at its end, in the world, shape (3, 3) [-]; None keeps the one it began with."""
    gripper: float = 0.0
    """Tip gripper at its end, from -1 (open) over 0 (slack) to 1 (closed) [-]."""
    pull: np.ndarray | None = None
    """Cable to pull in at most at its end, shape (n_cable,) [m]; None sets no bound."""


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
    """Frame of the base when it began, shape (4, 4) [-, m]."""
    tension_start: np.ndarray
    """Tension ceilings when it began, shape (n_cable,) [N]."""
    velocity_start: np.ndarray
    """Velocity of the base when it began, shape (3,) [m/s]."""
    gripper_start: float = 0.0
    """Tip gripper when it began [-]."""
    pull_start: np.ndarray | None = None
    """Bound of the cables' pulls when it began, shape (n_cable,) [m]; None where there was none."""

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


def status_of(progress: Progress, *, is_done: bool, gave_up: str | None) -> Status:
    """Where a strategy stands that follows moves."""
    move = progress.move
    return Status(
        phase=move.phase, action=move.action, milestone=move.milestone, is_done=is_done, gave_up=gave_up
    )  # fmt: skip


def fraction(progress: Progress, time: float) -> float:
    """Part of the move's time that has passed, 0 to 1."""
    return min(1.0, max(0.0, (time - progress.since) / progress.move.duration))


def command_at(progress: Progress, time: float) -> Command:
    """What to do at ``time`` [s]: base along a path of least jerk, tensions, pulls and gripper along ramps."""
    s, move = fraction(progress, time), progress.move
    T_world_base = progress.T_start.copy()
    way = move.position - progress.T_start[:3, 3]
    T_world_base[:3, 3] += _ease(s) * way + _run_out(s) * move.duration * progress.velocity_start
    if move.rotation is not None:
        T_world_base[:3, :3] = _turned(progress.T_start[:3, :3], move.rotation, _ease(s))
    return Command(
        T_world_base=T_world_base,
        cable_tension=progress.tension_start + s * (move.tension - progress.tension_start),
        cable_pull=_pull(progress, s),
        gripper=progress.gripper_start + s * (move.gripper - progress.gripper_start),
    )


def advance(progress: Progress, time: float) -> Progress:
    """The next move, begun from where the present one's commands have come and as fast, be it at its end or not."""
    now, step = command_at(progress, time), 1e-4
    before = command_at(progress, time - step)
    velocity = (now.T_world_base[:3, 3] - before.T_world_base[:3, 3]) / step
    return replace(
        progress, index=progress.index + 1, since=time, T_start=now.T_world_base, tension_start=now.cable_tension,
        velocity_start=velocity if fraction(progress, time) < 1.0 else np.zeros(3),
        gripper_start=now.gripper, pull_start=now.cable_pull,
    )  # fmt: skip


def _turned(start: np.ndarray, end: np.ndarray, s: float) -> np.ndarray:
    """Orientation part ``s`` of the shortest turn from one to another, shape (3, 3) [-]."""
    turn = Rotation.from_matrix(start.T @ end).as_rotvec()
    return np.asarray(start @ Rotation.from_rotvec(s * turn).as_matrix())


def _pull(progress: Progress, s: float) -> np.ndarray | None:
    end, start = progress.move.pull, progress.pull_start
    if end is None or start is None or not np.isfinite(start).all():
        return end
    return np.asarray(start + s * (end - start))


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


def shift_later(progress: Progress, way: np.ndarray, phase: str | None = None) -> Progress:
    """The same sequence with the end of every later move, or of those of one phase, shifted by ``way``, (3,) [m]."""
    i = progress.index + 1
    later = tuple(
        replace(move, position=move.position + way) if phase in (None, move.phase) else move
        for move in progress.moves[i:]
    )
    return replace(progress, moves=(*progress.moves[:i], *later))


def raise_tension(progress: Progress, factor: float, ceiling: float) -> Progress:
    """The same sequence with the tension of this and every later carrying move raised, up to a ceiling [N]."""
    moves = tuple(
        replace(move, tension=np.minimum(move.tension * factor, ceiling)) if i >= progress.index else move
        for i, move in enumerate(progress.moves)
    )
    return replace(progress, moves=moves)
