"""The moves of the strategies that grip with the fingers at the trunk's tip, part by part of their cycle."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.control.messages import Observation
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.strategies.fingertip.plan import TipOptions, closing, gripper_of, opening, tip_height
from spiraltrunk.strategies.moves import Move


@final
@dataclass(frozen=True, kw_only=True)
class Curl:
    """What the cables do while the object is carried."""

    tension: np.ndarray
    """Tension ceilings, shape (n_cable,) [N]."""
    pull: np.ndarray
    """Cable to pull in at most, shape (n_cable,) [m]."""


CHECK = 1.2
"""Time to look at the object and to weigh it [s]: two looks at least, and torques that are noisy."""


def reach(observation: Observation, place: np.ndarray, options: TipOptions) -> tuple[Move, ...]:
    """Above the object, fingers open, to look; ``place`` is where it seems to be, shape (3,) [m]."""
    base = gripping_base(observation, place, options)
    base[2] += options.hover * gripper_of(observation).finger_length
    slack = np.zeros(observation.cable_tension.shape)
    gripper = opened(observation, options)
    approach = Move(phase="reach", action="approach", duration=2.5, position=base, tension=slack, gripper=gripper)
    return approach, replace(approach, action="look", duration=CHECK)


def grip(above: Move, base: np.ndarray, rotation: np.ndarray, lift: float, hold: float) -> tuple[Move, ...]:
    """Down round the object, close, lift, and check.

    Args:
        above: the move that ended above the object.
        base: where the base grips, shape (3,) [m].
        rotation: how it is turned then, shape (3, 3) [-].
        lift: height to lift by [m].
        hold: gripper command that holds [-].
    """
    over = np.array([base[0], base[1], above.position[2]])
    turn = replace(above, phase="reach", action="turn", duration=1.0, position=over, rotation=rotation)
    descend = replace(turn, action="descend", duration=1.5, position=base)
    settle = replace(descend, action="settle", duration=0.8)
    close = replace(settle, phase="prehension", action="close", milestone=Milestone.TOUCHED, duration=1.2, gripper=hold)
    tighten = replace(close, action="tighten", milestone=None, duration=0.6)
    lifted = replace(
        close, phase="transport", action="lift", milestone=Milestone.LIFTED, duration=2.0,
        position=base + np.array([0.0, 0.0, lift]),
    )  # fmt: skip
    check = replace(lifted, action="check", milestone=None, duration=CHECK)
    return turn, descend, settle, close, tighten, lifted, check


def carry(checked: Move, observation: Observation, curl: Curl | None, place: np.ndarray) -> tuple[Move, ...]:
    """Curl where there is one, carry aside, hold, uncurl, and bring the base over ``place``.

    Args:
        checked: the move that ended with the object lifted.
        observation: what is seen now.
        curl: what the cables do meanwhile; None for a straight trunk.
        place: of the base when the object stands over its goal, as high as now, shape (3,) [m].
    """
    goal = observation.task.goal
    over = replace(
        checked, action="carry", milestone=Milestone.CARRIED, duration=2.5, position=checked.position + goal.aside
    )
    hold = replace(over, action="hold", milestone=Milestone.HELD, duration=goal.hold)
    if curl is None:
        return over, hold, replace(
            hold, phase="release", action="bring", milestone=None, duration=2.0, position=place
        )  # fmt: skip
    straight = np.where(curl.tension > 0, 0.0, curl.pull)
    taut = replace(checked, action="draw taut", duration=0.5, tension=curl.tension, pull=straight)
    flip = replace(taut, action="flip", duration=4.0, pull=curl.pull)
    over, hold = (replace(move, tension=curl.tension, pull=curl.pull) for move in (over, hold))
    back = replace(hold, action="flip back", milestone=None, duration=4.0, pull=straight)
    bring = replace(back, phase="release", action="bring", duration=2.0, position=place, tension=checked.tension)
    return taut, flip, over, hold, back, bring


def put(brought: Move, base: np.ndarray, gripper: float) -> tuple[Move, ...]:
    """Down to the height ``base`` [m] at which the object stands, open, and leave.

    Args:
        brought: the move that ended over the goal.
        base: where the base lets go, shape (3,) [m].
        gripper: command that opens [-].
    """
    lower = replace(brought, action="lower", milestone=Milestone.SET_DOWN, duration=4.0, position=base)
    let_go = replace(lower, action="open", milestone=Milestone.RELEASED, duration=1.5, gripper=gripper)
    leave = replace(let_go, action="leave", duration=2.0, position=brought.position)
    return lower, let_go, leave, replace(leave, action="rest", duration=2.0)


def again(checked: Move, base: np.ndarray, above: np.ndarray, gripper: float) -> tuple[Move, ...]:
    """Back down, let go of whatever hangs there askew, and up again to look anew.

    Args:
        checked: the move that ended with nothing lifted.
        base: where the base had gripped, shape (3,) [m].
        above: where to look from, shape (3,) [m].
        gripper: command that opens [-].
    """
    down = replace(checked, phase="prehension", action="return", duration=2.0, position=base)
    let_go = replace(down, action="let go", duration=1.0, gripper=gripper)
    rise = replace(let_go, phase="reach", action="rise", duration=1.5, position=above)
    return down, let_go, rise, replace(rise, action="look", duration=CHECK + 1.0)


def gripping_base(observation: Observation, place: np.ndarray, options: TipOptions) -> np.ndarray:
    """Where the base stands to grip an object at ``place``, the trunk hanging below it, shape (3,) [m]."""
    task = observation.task
    height = tip_height(gripper_of(observation), task.target, task.goal, options)
    return np.array([place[0], place[1], height + task.design.length])


def holding(observation: Observation, options: TipOptions) -> float:
    """Gripper command that holds the object [-]."""
    return closing(gripper_of(observation), observation.task.target, options)


def opened(observation: Observation, options: TipOptions) -> float:
    """Gripper command that opens the fingers round the object [-].

    Raises:
        ModelError: where they do not open so wide.
    """
    task = observation.task
    return opening(gripper_of(observation), task.target, task.goal, options)
