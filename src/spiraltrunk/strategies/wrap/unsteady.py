"""Unsteady objects: what topples at a light push is not touched before the trunk curls; its place is the camera's.

A touch ends the reach when the cables' lengths tell it, after the trunk has pressed by some millimetres: with 0.1 to
0.2 N. As the trunk swings by as much as a touch bends it, it may also tell a touch where there is none. In simulated
trials the curl then began 20 mm off, while the camera is wrong by 3 mm.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from spiraltrunk.control.messages import Observation, Target
from spiraltrunk.strategies.moves import Move
from spiraltrunk.strategies.object_measures import height_of, topple_force

TOUCH_HEIGHT = 0.6
"""Height of the touch over the object's height [-] (ours)."""
STEADY = 0.3
"""Force at that height from which an object that topples is touched [N] (ours)."""


def push_that_topples(target: Target) -> float:
    """Least horizontal force of a touch that topples an object that stands [N]."""
    return topple_force(target, TOUCH_HEIGHT * height_of(target))


def is_unsteady(observation: Observation) -> bool:
    """Whether the object topples at less than `STEADY`, and a camera sees where it stands."""
    return observation.camera is not None and push_that_topples(observation.task.target) < STEADY


def stop_before(moves: tuple[Move, ...], way: np.ndarray) -> tuple[Move, ...]:
    """Moves with the one that touches ending before the object, by ``way`` earlier, shape (3,) [m]."""
    return tuple(replace(move, position=move.position - way) if move.action == "touch" else move for move in moves)
