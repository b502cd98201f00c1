"""Candidates for a task: all strategies of its stage, ranked by the models before anything moves.

Each strategy first assesses the task: widths, friction, payload, the push that topples the object. Then it plans its
moves; a plan fails, for example, where the housing would touch the ground. Last, the arm's inverse kinematics follow
the plan. A frame of the base out of the arm's reach makes the candidate infeasible; the nearer the arm comes to being
straight, the lower is its score.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from spiraltrunk import strategies
from spiraltrunk.control.messages import Observation, Task
from spiraltrunk.control.strategy import Assessment, Strategy
from spiraltrunk.errors import ModelError, UnknownName
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.sim.robot.arm_ik import ArmReach
from spiraltrunk.sim.scene.options import SUPPORTS
from spiraltrunk.strategies.assessment import assess, plan_frames
from spiraltrunk.strategies.scores import format_factor, margin_factor, refuse

STAGES = SUPPORTS
"""What may support the object: strings, or the ground."""

REACH_SLACK = 0.005
"""Distance from a frame of the base within which it counts as reached [m] (ours)."""
TURN_SLACK = math.radians(3.0)
"""Angle from a frame of the base within which it counts as reached [rad] (ours)."""
AMPLE_REACH = 0.05
"""Height above the highest frame from which, if the arm reaches it, the score is not reduced [m] (ours)."""

_IK_STEP, _IK_STEPS, _IK_STILL = 0.1, 150, 1e-5
"""Period [s], largest number and least size [rad] of the steps of the inverse kinematics."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Candidate:
    """A strategy, and what its model predicts for a task."""

    strategy: str
    """Name of the strategy."""
    feasible: bool
    """Whether it can do the task."""
    score: float
    """Predicted chance of success, from 0 (infeasible) to 1 [-]."""
    reason: str
    """What decides, in words and numbers."""


def list_strategies(stage: str) -> tuple[str, ...]:
    """Names of the strategies that lift an object from a stage.

    Kick and sweep push along the ground, to a place that a task of lifting does not name.

    Raises:
        UnknownName: for a stage that does not exist.
    """
    if stage not in STAGES:
        raise UnknownName("stage", stage, STAGES)
    known = (strategies.get(name) for name in strategies.NAMES)
    return tuple(each.name for each in known if each.support == stage and each.job == "grasp")


def stage_of(task: Task) -> str:
    """What supports the object of a task."""
    return "hung" if task.goal.ground is None else "ground"


def find_highest_base(task: Task) -> float | None:
    """Largest height of the base that any strategy able to do the task plans [m]; None where no strategy plans one."""
    heights = []
    for name in list_strategies(stage_of(task)):
        strategy = strategies.get(name)
        if assess(strategy, task).feasible:
            heights.append(strategy.highest_base(task))
    return max((height for height in heights if height is not None), default=None)


def rank(observation: Observation, reach: ArmReach, *, but: Iterable[str] = ()) -> tuple[Candidate, ...]:
    """Candidates for an observed task: the feasible ones by score, then the others.

    Args:
        observation: the task and the robot at rest.
        reach: the arm's inverse kinematics.
        but: names of strategies to leave out.
    """
    names = [name for name in list_strategies(stage_of(observation.task)) if name not in tuple(but)]
    found = [assess_candidate(strategies.get(name), observation, reach) for name in names]
    return tuple(sorted(found, key=lambda each: -each.score))


def assess_candidate(strategy: Strategy[Any], observation: Observation, reach: ArmReach) -> Candidate:
    """What the models of strategy, plan and arm predict for an observed task."""
    assessment = assess(strategy, observation.task)
    if assessment.feasible:
        assessment = _assess_plan(strategy, observation, reach, assessment)
    return Candidate(
        strategy=strategy.name, feasible=assessment.feasible, score=round(assessment.score, 3),
        reason=assessment.reason,
    )  # fmt: skip


def _assess_plan(
    strategy: Strategy[Any], observation: Observation, reach: ArmReach, assessment: Assessment
) -> Assessment:
    try:
        frames = plan_frames(strategy, observation)
    except ModelError as error:
        return refuse(str(error))
    short, turn = follow_frames(reach, observation.arm_position, frames)
    if short > REACH_SLACK:
        return refuse(f"base beyond the arm's reach by {_format(short)}")
    if turn > TURN_SLACK:
        return refuse(f"base beyond the arm's reach: it ends {math.degrees(turn):.0f} deg askew")
    top = max(float(frame[2, 3]) for frame in frames)
    highest = {tuple(frame[:2, 3].round(3)): frame for frame in frames if frame[2, 3] > top - REACH_SLACK}
    room = min(_room_above(reach, observation.arm_position, frame, top) for frame in highest.values())
    factor = margin_factor(room, AMPLE_REACH)
    reason = assessment.reason + format_factor("reach", factor)
    return Assessment(feasible=True, score=assessment.score * factor, reason=reason)


def follow_frames(reach: ArmReach, q: np.ndarray, frames: Iterable[np.ndarray]) -> tuple[float, float]:
    """Largest error of position [m] and of orientation [rad] with which the arm follows frames of the base.

    The arm starts at ``q`` [rad] and moves through all frames, each of shape (4, 4).
    """
    short = turn = 0.0
    for frame in frames:
        q = _approach(reach, q, frame)
        reached = reach.T_base(q)
        short = max(short, float(np.linalg.norm(reached[:3, 3] - frame[:3, 3])))
        cosine = (float(np.trace(reached[:3, :3].T @ frame[:3, :3])) - 1) / 2
        turn = max(turn, math.acos(max(-1.0, min(1.0, cosine))))
    return short, turn


def _approach(reach: ArmReach, q: np.ndarray, frame: np.ndarray) -> np.ndarray:
    for reached in reach.steps(q, frame, _IK_STEP, _IK_STEPS):
        before, q = q, reached
        if float(np.abs(q - before).max()) < _IK_STILL:
            break
    return q


def _room_above(reach: ArmReach, q: np.ndarray, frame: np.ndarray, top: float) -> float:
    """How far above the height ``top`` [m] the arm still reaches over the place of a frame, up to AMPLE_REACH [m]."""
    above = frame.copy()
    above[2, 3] = top + AMPLE_REACH
    short, _ = follow_frames(reach, q, [frame, above])
    return max(0.0, AMPLE_REACH - short)


def _format(length: float) -> str:
    return f"{1e2 * length:.0f} cm" if length >= 0.01 else f"{1e3 * length:.0f} mm"
