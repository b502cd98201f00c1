"""Strategies that strike an object with the rolled trunk, observe the result, and strike once more."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace

import numpy as np

from spiraltrunk.control.messages import Observation
from spiraltrunk.strategies.moves import Move, advance, insert_next
from spiraltrunk.strategies.push.push_strategy import PushState, PushStrategy
from spiraltrunk.strategies.sensing import seen_position

# All of these are ours, tuned in simulated trials.
RUN_UP = 0.08
"""Travel of the rolled trunk before it meets the object [m]; of a learned stroke, where the trunk is rolled up."""
RISE = (0.10, 0.15)
"""Way back and way up after the stroke [m]."""
WATCH = 4.0
"""Longest time to wait after the stroke until the object is at rest [s]."""
RETRIES = 1
"""Number of further strokes at an object that did not go far enough [-]."""


class StrikeStrategy(PushStrategy[PushState]):
    """A stroke with the rolled trunk, and one more at an object that is then seen short of its goal."""

    gap = RUN_UP

    @abstractmethod
    def strike(self, state: PushState, observation: Observation) -> tuple[Move, ...]:
        """Moves down behind the object as observed, the stroke, and those of `rise_and_watch`."""

    def next_move(self, state: PushState, observation: Observation) -> PushState:
        """Aim by the last camera observation before the stroke; observe the result after it."""
        sequence, action = state.sequence, state.sequence.move.action
        if action == "watch":
            left = observation.task.goal.place - seen_position(observation)
            if float(np.dot(left, state.pose.way)) <= 0.0:
                return replace(state, is_done=True)
            if state.retries >= RETRIES:
                return replace(state, is_done=True, gave_up="the object did not go far enough")
            state = replace(state, retries=state.retries + 1)
        if action in ("turn", "watch"):
            sequence = insert_next(sequence, self.strike(state, observation))
        return replace(state, sequence=advance(sequence, observation.time))


def rise_point(end: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Position to which the base rises from the end of a stroke along ``way``, each of shape (3,) [m], [m], [-]."""
    return end - RISE[0] * way + np.array([0.0, 0.0, RISE[1]])


def rise_and_watch(stroke: Move, position: np.ndarray, duration: float) -> tuple[Move, Move]:
    """The rise to a position, shape (3,) [m], after a stroke, and the wait there."""
    rise = replace(stroke, phase="release", action="rise", duration=duration, position=position)
    return rise, replace(rise, action="watch", duration=WATCH)
