"""
Write a strategy
================

A tenth strategy to copy: hook the trunk's tip under a hanging cylinder, hoist it over the table and put it down.

A strategy is pure: it gets what it remembers and what is seen, and returns what to remember and what to do. It sees
nothing but an `Observation`, which a real robot has as well, so it runs unchanged on any `Plant`. Its actions bear
names of their own; the verdict finds lift, carry and hold by the milestones that the strategy reports.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.control import Command, Milestone, Observation, Status, Strategy
from spiraltrunk.design import presets
from spiraltrunk.design.trunk import ventral_cables
from spiraltrunk.sim import parse_object
from spiraltrunk.strategies.moves import Move, Progress, advance, begin, command_at, fraction, status_of
from spiraltrunk.strategies.sensing import weight
from spiraltrunk.strategies.wrap.hung_model import predict_wrap, wrap_tension
from spiraltrunk.workflows.grasp.trial import run_trial
from spiraltrunk.workflows.grasp.world import Spread

BASE_BEND = 0.8
"""Bend that the trunk's first joint keeps under the load, over its limit [-]; it sets the tension."""


@final
@dataclass(frozen=True, kw_only=True)
class HookState:
    """What the strategy remembers."""

    progress: Progress
    """Moves done and to do."""
    weight_empty: float
    """What hangs on the base without the object [N]."""
    is_done: bool = False
    """Whether all moves are done."""


@final
class Hook(Strategy[HookState]):
    """Without a search: the object must hang where it is announced."""

    name = "hook"
    number = 10
    stage = "hung"

    def init(self, observation: Observation) -> HookState:
        """Plan all moves from the design, the announced object and the goal."""
        return HookState(progress=begin(plan_moves(observation), observation), weight_empty=weight(observation))

    def step(self, state: HookState, observation: Observation) -> tuple[HookState, Command]:
        """Follow the moves; what is put down is let go as soon as the table bears it."""
        progress = state.progress
        load = weight(observation) - state.weight_empty
        is_borne = progress.move.milestone is Milestone.SET_DOWN and load < 0.5 * 9.81 * observation.task.target.mass
        if is_borne or fraction(progress, observation.time) >= 1.0:
            if progress.is_last:
                state = replace(state, is_done=True)
            else:
                state = replace(state, progress=advance(progress, observation.time))
        return state, command_at(state.progress, observation.time)

    def status(self, state: HookState) -> Status:
        """Phase, action and milestone of the present move."""
        return status_of(state.progress, is_done=state.is_done, gave_up=None)


def plan_moves(observation: Observation) -> tuple[Move, ...]:
    """Moves of the whole task, for a trunk that hangs straight and curls ahead, to its ventral side."""
    design, target, goal = observation.task.design, observation.task.target, observation.task.goal
    length, down, ahead = design.length, observation.T_world_base[:3, 0], -observation.T_world_base[:3, 1]
    tension = wrap_tension(design, target.width, target.mass, BASE_BEND * design.joint_limit)
    center = predict_wrap(design, target.width, target.mass, tension).center
    to_base = -center[0] * down - center[1] * ahead
    beside = target.position - 0.7 * length * down - (target.width / 2 + 0.05) * ahead
    wrapped = target.position + to_base + 0.01 * length * down
    hoisted = wrapped - goal.lift * down
    placed = goal.place + to_base
    clear = placed - 0.12 * length * down - 0.09 * length * ahead
    away = clear - 0.15 * length * down - 0.2 * length * ahead
    taut, slack = tension * ventral_cables(design), np.zeros(design.n_cable)

    def move(
        phase: str, action: str, duration: float, position: np.ndarray, milestone: Milestone | None = None
    ) -> Move:
        is_slack = phase == "reach" or milestone is Milestone.RELEASED
        return Move(
            phase=phase, action=action, duration=duration, position=position, milestone=milestone,
            tension=slack if is_slack else taut,
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
