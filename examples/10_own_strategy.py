"""A tenth strategy to copy: nudge a hanging object until the arm feels it, then draw back.

A strategy is pure: it gets what it remembers and what is seen, and returns what to remember and what to do. It sees
nothing but an `Observation`, which a real robot has as well, so it runs unchanged on any `Plant`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.control.loop import run
from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.strategy import Status, Strategy
from spiraltrunk.design import presets
from spiraltrunk.sim import SimPlant
from spiraltrunk.strategies.moves import Move, Progress, advance, begin, command_at, fraction

TOUCH = 0.05
"""Force against the trunk's way that counts as a touch [N]; a real arm is noisier and needs more."""


@final
@dataclass(frozen=True, kw_only=True)
class NudgeState:
    """What the strategy remembers."""

    progress: Progress
    """Moves done and to do."""
    force: float = 0.0
    """Force against the trunk's way, smoothed [N]."""
    touched_at: np.ndarray | None = None
    """Where the base was when the touch was felt, shape (3,) [m]."""
    is_done: bool = False
    """Whether all moves are done."""


@final
class Nudge(Strategy[NudgeState]):
    """The trunk hangs straight and moves sideways, slowly, through where the object is announced."""

    name = "nudge"
    number = 10
    stage = "hung"

    def init(self, observation: Observation) -> NudgeState:
        """Plan: beside the object, through it, and back, with the trunk's lower third at the object's height."""
        design, target = observation.task.design, observation.task.target
        ahead = -observation.T_world_base[:3, 1]  # Ventral: the side that the trunk curls to.
        height = np.array([0.0, 0.0, 0.65 * design.length])
        start = target.position + height - 0.12 * ahead
        slack = np.zeros(design.n_cable)
        moves = (
            Move(phase="reach", action="approach", duration=2.5, position=start, tension=slack),
            Move(phase="prehension", action="feel", duration=6.0, position=start + 0.12 * ahead, tension=slack),
            Move(phase="release", action="draw back", duration=1.5, position=start, tension=slack),
        )
        return NudgeState(progress=begin(moves, observation))

    def step(self, state: NudgeState, observation: Observation) -> tuple[NudgeState, Command]:
        """Follow the moves; the touch cuts the second one short."""
        against = float(observation.base_force @ observation.T_world_base[:3, 1])
        state = replace(state, force=state.force + 0.2 * (against - state.force))
        feels = state.progress.move.action == "feel" and fraction(state.progress, observation.time) > 0.1
        if feels and state.force > TOUCH:
            here = observation.T_world_base[:3, 3]
            state = replace(state, touched_at=here, progress=advance(state.progress, observation.time))
        elif fraction(state.progress, observation.time) >= 1.0:
            if state.progress.is_last:
                state = replace(state, is_done=True)
            else:
                state = replace(state, progress=advance(state.progress, observation.time))
        return state, command_at(state.progress, observation.time)

    def status(self, state: NudgeState) -> Status:
        """Where the strategy stands."""
        move = state.progress.move
        gave_up = "nothing was felt" if state.is_done and state.touched_at is None else None
        return Status(phase=move.phase, action=move.action, is_done=state.is_done, gave_up=gave_up)


def main() -> None:
    """Run it in simulation."""
    plant = SimPlant(presets.PAPER)
    log = run(plant, Nudge())
    span = log.span("prehension")
    assert span is not None
    print(f"felt after {span[1] - span[0]:.2f} s: {log.gave_up or 'the object is there'}")
    assert log.gave_up is None


if __name__ == "__main__":
    main()
