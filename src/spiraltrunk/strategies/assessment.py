"""Assessment of a task by a strategy of this package, and the frames of the base that it will go through."""

from __future__ import annotations

from typing import Any

import numpy as np

from spiraltrunk.control.messages import Observation, Task
from spiraltrunk.control.strategy import Assessment, Strategy
from spiraltrunk.errors import ModelError
from spiraltrunk.strategies.fingertip.assess import assess_fingers, gripped_width
from spiraltrunk.strategies.fingertip.cycle import TipStrategy
from spiraltrunk.strategies.fingertip.plan import gripping_base
from spiraltrunk.strategies.move_strategy import MoveState
from spiraltrunk.strategies.moves import build_frame
from spiraltrunk.strategies.scores import refuse
from spiraltrunk.strategies.sensing import find_ventral, seen_position
from spiraltrunk.strategies.wrap.assess import assess_hung, assess_standing
from spiraltrunk.strategies.wrap.hung import WrapVertical
from spiraltrunk.strategies.wrap.standing import StandingWrap
from spiraltrunk.strategies.wrap.standing_model import wrapped_width


def assess(strategy: Strategy[Any], task: Task) -> Assessment:
    """Predict whether a strategy can do a task, from the announced object and the design alone.

    The plan of its moves and the arm's reach are not considered.
    """
    if isinstance(strategy, TipStrategy):
        return assess_fingers(strategy, task)
    try:
        find_ventral(task.design)
    except ModelError as error:
        return refuse(str(error))
    if isinstance(strategy, StandingWrap):
        return assess_standing(strategy, task)
    if isinstance(strategy, WrapVertical):
        return assess_hung(task)
    return refuse(f"{strategy.name} has no model that could tell")


def measure_width(strategy: Strategy[Any], task: Task) -> float:
    """Width of the object that a strategy's range is for [m]: where the fingers touch it, or that of its girth.

    For another strategy it is the announced one.
    """
    if isinstance(strategy, TipStrategy):
        return gripped_width(task)
    return wrapped_width(task.target) if isinstance(strategy, StandingWrap) else task.target.width


def plan_frames(strategy: Strategy[Any], observation: Observation) -> list[np.ndarray]:
    """Frames of the trunk's base at the ends of the moves that a strategy plans, each of shape (4, 4) [-, m].

    Raises:
        ModelError: where the robot cannot do what the task asks.
    """
    state = strategy.init(observation)
    rotation, frames = observation.T_world_base[:3, :3], []
    for move in state.sequence.moves if isinstance(state, MoveState) else ():
        rotation = rotation if move.rotation is None else move.rotation
        frames.append(build_frame(move.position, rotation))
    return [*frames, *_grip_frames(observation)] if isinstance(strategy, TipStrategy) else frames


def _grip_frames(observation: Observation) -> list[np.ndarray]:
    """Frames of a grip from above, which is planned only when the object has been observed: grip, lift, carry, put."""
    goal, rotation = observation.task.goal, observation.T_world_base[:3, :3]
    grip = gripping_base(observation.task, seen_position(observation))
    lifted = grip + np.array([0.0, 0.0, goal.lift])
    put = gripping_base(observation.task, goal.place)
    return [build_frame(at, rotation) for at in (grip, lifted, lifted + goal.aside, put)]
