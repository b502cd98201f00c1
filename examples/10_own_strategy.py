"""
Write a strategy
================

A tenth strategy to copy: hook the trunk's tip under a hanging cylinder, hoist it over the table and put it down.

A strategy is pure: it gets what it remembers and what is observed, and returns what to remember and what to do. It gets
nothing but an `Observation`, which a real robot has as well, so it runs unchanged on any `Plant`. Its actions bear
names of their own; the verdict finds lift, carry and hold by the milestones that the strategy reports.
"""

from __future__ import annotations

from dataclasses import replace
from typing import final

import numpy as np

from spiraltrunk.control import Milestone, Observation
from spiraltrunk.design import presets
from spiraltrunk.design.trunk import ventral_cables
from spiraltrunk.sim import parse_object
from spiraltrunk.strategies.move_strategy import LoadState, MoveStrategy
from spiraltrunk.strategies.moves import Move, advance, begin, fraction
from spiraltrunk.strategies.sensing import base_directions, load_fraction, weight
from spiraltrunk.strategies.wrap.hung_model import predict_wrap, wrap_tension
from spiraltrunk.workflows.grasp.trial import run_trial
from spiraltrunk.workflows.grasp.world import Spread

BASE_BEND = 0.8
"""Bend of the trunk's first joint under the load, over its limit [-]; it sets the tension."""


@final
class Hook(MoveStrategy[LoadState]):
    """One attempt, without a search: the object must hang where it is announced."""

    name = "hook"
    number = 10
    support = "hung"

    def init(self, observation: Observation) -> LoadState:
        """Plan all moves from the design, the announced object and the goal."""
        return LoadState(sequence=begin(plan_moves(observation), observation), weight_empty=weight(observation))

    def has_ended(self, state: LoadState, observation: Observation) -> bool:
        """Whether the present move has ended: setting down, as soon as the table bears half of the object."""
        load = load_fraction(observation, weight(observation), state.weight_empty)
        is_down = state.sequence.move.milestone is Milestone.SET_DOWN and load < 0.5
        return is_down or fraction(state.sequence, observation.time) >= 1.0

    def next_move(self, state: LoadState, observation: Observation) -> LoadState:
        """Begin the next move, or end after the last."""
        if state.sequence.is_last:
            return replace(state, is_done=True)
        return replace(state, sequence=advance(state.sequence, observation.time))


def plan_moves(observation: Observation) -> tuple[Move, ...]:
    """Moves of the whole task, for a trunk that hangs straight and curls ahead, to its ventral side."""
    design, target, goal = observation.task.design, observation.task.target, observation.task.goal
    length, (down, ahead) = design.length, base_directions(observation)
    tension = wrap_tension(design, target.width, target.mass, BASE_BEND * design.joint_limit)
    center = predict_wrap(design, target.width, target.mass, tension).center
    to_base = -center[0] * down - center[1] * ahead
    beside = target.position - 0.7 * length * down - (target.width / 2 + 0.05) * ahead
    wrapped = target.position + to_base + 0.01 * length * down
    hoisted, placed = wrapped - goal.lift * down, goal.place + to_base
    clear = placed - 0.12 * length * down - 0.09 * length * ahead
    away = clear - 0.15 * length * down - 0.2 * length * ahead

    def move(
        phase: str, action: str, duration: float, position: np.ndarray, milestone: Milestone | None = None
    ) -> Move:
        pulls = phase != "reach" and milestone is not Milestone.RELEASED
        return Move(
            phase=phase, action=action, milestone=milestone, duration=duration, position=position,
            tension=tension * pulls * ventral_cables(design),
        )  # fmt: skip

    return (
        move("reach", "sidle up", 3.0, beside - 0.16 * length * ahead),
        move("reach", "snuggle up", 2.0, beside, Milestone.TOUCHED),
        move("prehension", "hook", 4.0, wrapped),
        move("prehension", "cling", 1.0, wrapped),
        move("transport", "hoist", 3.0, hoisted, Milestone.LIFTED),
        move("transport", "swing over", 2.5, hoisted + goal.aside, Milestone.CARRIED),
        move("transport", "show", goal.hold, hoisted + goal.aside, Milestone.HELD),
        move("release", "come over", 1.5, np.array([*placed[:2], hoisted[2]])),
        move("release", "put down", 6.0, placed + 0.3 * length * down, Milestone.SET_DOWN),
        move("release", "unhook", 3.0, clear, Milestone.RELEASED),
        move("release", "bow out", 3.0, away, Milestone.RELEASED),
    )


def main() -> None:
    """Grasp a cylinder that hangs where it is announced."""
    trial = run_trial(presets.PAPER, parse_object("cylinder-60"), strategy=Hook(), spread=Spread(position=0.0))
    print(f"{trial.strategy}: {trial.verdict.reason}, lifted {trial.verdict.lift * 1e3:.0f} mm")
    assert trial.verdict.success, trial.verdict.reason


if __name__ == "__main__":
    main()
