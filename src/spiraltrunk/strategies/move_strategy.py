"""Strategies that follow a sequence of moves."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TypeVar

from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.strategy import Status, Strategy
from spiraltrunk.strategies.moves import MoveSequence, command_at, fraction
from spiraltrunk.strategies.sensing import load_fraction

BORNE = 0.5
"""Measured load over the object's weight above which the object counts as carried [-] (ours)."""


@dataclass(frozen=True, kw_only=True)
class MoveState:
    """What every strategy of moves remembers."""

    sequence: MoveSequence
    """Moves, done and to do."""
    retries: int = 0
    """Attempts after the first [-]."""
    is_done: bool = False
    """Whether the strategy has ended."""
    gave_up: str | None = None
    """Why it ended before its goal, if it did."""


@dataclass(frozen=True, kw_only=True)
class LoadState(MoveState):
    """What a strategy remembers that weighs its load."""

    weight: float = 0.0
    """Weight on the trunk's base, smoothed [N]."""
    weight_empty: float = 0.0
    """The same before the object was touched [N]."""

    def is_carried(self, observation: Observation) -> bool:
        """Whether the trunk bears more than `BORNE` of the object's announced weight."""
        return load_fraction(observation, self.weight, self.weight_empty) > BORNE


State = TypeVar("State", bound=MoveState)


class MoveStrategy(Strategy[State]):
    """A strategy that follows moves: it senses, and plans on where a move ends."""

    def step(self, state: State, observation: Observation) -> tuple[State, Command]:
        """Next state and command: `sense`, then `next_move` where the present move `has_ended`, then `command`."""
        state = self.sense(state, observation)
        if self.has_ended(state, observation):
            state = self.next_move(state, observation)
        return state, self.command(state, observation)

    def status(self, state: State) -> Status:
        """Phase, action and milestone of the present move."""
        move = state.sequence.move
        return Status(
            phase=move.phase, action=move.action, milestone=move.milestone, is_done=state.is_done, gave_up=state.gave_up
        )  # fmt: skip

    def sense(self, state: State, observation: Observation) -> State:
        """Take the observation into account, at every step."""
        return state

    def has_ended(self, state: State, observation: Observation) -> bool:
        """Whether the present move has ended: by its duration, unless the strategy says otherwise."""
        return fraction(state.sequence, observation.time) >= 1.0

    @abstractmethod
    def next_move(self, state: State, observation: Observation) -> State:
        """Begin the next move, or end."""

    def command(self, state: State, observation: Observation) -> Command:
        """Command of the present move."""
        return command_at(state.sequence, observation.time)
