"""Moves of the strategies that grip with the fingers at the trunk's tip, part by part of their cycle."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.control.messages import Observation
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.strategies.fingertip.plan import gripper_of, gripping_base, opening
from spiraltrunk.strategies.moves import Move

CHECK = 1.2
"""Time to observe and to weigh the object [s] (ours): two camera observations at least, and torques are noisy."""

HOVER = 2.0
"""Height above the grip at which the robot observes and weighs, over a finger's length [-] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class Curl:
    """Command of the cables while the object is carried."""

    tension: np.ndarray
    """Tension ceilings, shape (n_cable,) [N]."""
    pull: np.ndarray
    """Upper bounds of the cable pulls, shape (n_cable,) [m]."""


def hover(observation: Observation, base: np.ndarray) -> np.ndarray:
    """Position of the base above the one that grips, shapes (3,) [m]."""
    return base + np.array([0.0, 0.0, HOVER * gripper_of(observation.task).finger_length])


def reach(observation: Observation, place: np.ndarray) -> tuple[Move, ...]:
    """Go above the object at ``place``, shape (3,) [m], fingers open, and observe."""
    approach = Move(
        phase="reach", action="approach", duration=2.5, gripper=opening(observation.task),
        position=hover(observation, gripping_base(observation.task, place)),
        tension=np.zeros(observation.cable_tension.shape),
    )  # fmt: skip
    return approach, replace(approach, action="look", duration=CHECK)


def grip(above: Move, base: np.ndarray, rotation: np.ndarray, lift: float, hold: float) -> tuple[Move, ...]:
    """Go down from ``above`` round the object to ``base``, shape (3,) [m], close, lift, and check.

    ``rotation`` is the orientation there, shape (3, 3) [-], ``hold`` the gripper command that holds [-].
    """
    over = np.array([base[0], base[1], above.position[2]])
    turn = replace(above, phase="reach", action="turn", duration=1.0, position=over, rotation=rotation)
    descend = replace(turn, action="descend", duration=1.5, position=base)
    settle = replace(descend, action="settle", duration=0.8)
    closed = replace(settle, phase="prehension", action="tighten", duration=0.6, gripper=hold)
    close = replace(closed, action="close", milestone=Milestone.TOUCHED, duration=1.2)
    lifted = replace(closed, phase="transport", position=base + np.array([0.0, 0.0, lift]))
    return (
        turn, descend, settle, close, closed,
        replace(lifted, action="lift", milestone=Milestone.LIFTED, duration=2.0),
        replace(lifted, action="check", duration=CHECK),
    )  # fmt: skip


def carry(checked: Move, observation: Observation, curl: Curl | None, place: np.ndarray) -> tuple[Move, ...]:
    """Curl where there is a curl, carry aside, hold, uncurl, and bring the base over ``place``, shape (3,) [m]."""
    goal, aside = observation.task.goal, checked.position + observation.task.goal.aside
    over = replace(checked, action="carry", milestone=Milestone.CARRIED, duration=2.5, position=aside)
    hold = replace(over, action="hold", milestone=Milestone.HELD, duration=goal.hold)
    bring = replace(checked, phase="release", action="bring", duration=2.0, position=place)
    if curl is None:
        return over, hold, bring
    straight = np.where(curl.tension > 0, 0.0, curl.pull)
    taut = replace(checked, action="draw taut", duration=0.5, tension=curl.tension, pull=straight)
    flip = replace(taut, action="flip", duration=4.0, pull=curl.pull)
    over, hold = (replace(move, tension=curl.tension, pull=curl.pull) for move in (over, hold))
    back = replace(flip, action="flip back", position=aside, pull=straight)
    return taut, flip, over, hold, back, replace(bring, pull=straight)


def put(brought: Move, base: np.ndarray, gripper: float) -> tuple[Move, ...]:
    """Lower the base to ``base``, shape (3,) [m], at which the object stands; open with ``gripper`` [-]; leave."""
    lower = replace(brought, action="lower", milestone=Milestone.SET_DOWN, duration=4.0, position=base)
    let_go = replace(lower, action="open", milestone=Milestone.RELEASED, duration=1.5, gripper=gripper)
    leave = replace(let_go, action="leave", duration=2.0, position=brought.position)
    return lower, let_go, leave, replace(leave, action="rest", duration=2.0)


def again(checked: Move, base: np.ndarray, above: np.ndarray, gripper: float) -> tuple[Move, ...]:
    """Go down to ``base``, let go with ``gripper`` [-], rise to ``above``, and observe again; positions (3,) [m]."""
    down = replace(checked, phase="prehension", action="return", duration=2.0, position=base)
    let_go = replace(down, action="let go", duration=1.0, gripper=gripper)
    rise = replace(let_go, phase="reach", action="rise", duration=1.5, position=above)
    return down, let_go, rise, replace(rise, action="look", duration=CHECK + 1.0)
