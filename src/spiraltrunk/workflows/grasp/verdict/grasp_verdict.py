"""Verdict on a grasp, from the simulator's true state alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby
from typing import final

import numpy as np

from spiraltrunk.control.arm_limits import find_missing_limits
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.sim.ground_truth import Sample
from spiraltrunk.workflows.grasp.verdict.arm_conditions import Condition, arm_conditions
from spiraltrunk.workflows.grasp.verdict.cause import Failure
from spiraltrunk.workflows.grasp.verdict.course import compute_angle
from spiraltrunk.workflows.grasp.verdict.evidence import Evidence
from spiraltrunk.workflows.grasp.verdict.faults import fault_conditions, find_failure
from spiraltrunk.workflows.grasp.verdict.grasp_loss import DROP_SPEED, FALL_MOST, find_grasp_loss
from spiraltrunk.workflows.grasp.verdict.moments import (
    HOLD_HEIGHT,
    HOLD_TOLERANCE,
    REST_TIME,
    REST_WAY,
    SLACK_SHARE,
    Span,
)

LIFT_TOLERANCE = 0.25
"""Largest deviation of lift and carry over the commanded ones [-] (ours)."""

UPRIGHT_MOST = math.radians(10.0)
"""Largest change of an object's axis to the vertical with which it is set down upright [rad] (ours): what rests on flat
ground keeps its angle or lies on another face; what leans is not upright."""


@final
@dataclass(frozen=True, kw_only=True)
class Verdict:
    """Success, or the first reason against it, and the figures that it rests on."""

    success: bool
    """Whether every condition held."""
    reason: str
    """"success", or the first condition that failed."""
    lift: float
    """Rise of the object during the lift [m]."""
    carry: float
    """Horizontal displacement of the object during the carry [m]."""
    hold: float
    """Time for which the trunk alone held the object still [s]."""
    place_error: float
    """Distance of the object from its place at the end [m]."""
    penetration: float
    """Deepest overlap of two bodies [m]."""
    bend: float
    """Largest joint bend [rad]."""
    unjudged: tuple[str, ...] = ()
    """Quantities of the arm without a known limit, which were not checked."""
    failure: Failure | None = None
    """What went wrong first, and when; None for a success."""
    is_held: bool = False
    """Whether the trunk alone held the object for as long as asked."""
    tilt: float | None = None
    """Change of the angle between the object's axis and the vertical from start to end [rad]; None for a sphere."""

    @property
    def is_upright(self) -> bool | None:
        """Whether an object that was held was set down as it began, within UPRIGHT_MOST; None for a sphere."""
        return None if self.tilt is None else self.is_held and self.tilt <= UPRIGHT_MOST


def evaluate_grasp(evidence: Evidence) -> Verdict:
    """Verdict on a grasp; conditions are tried in the order in which a trial would fail."""
    trace, goal, moments = evidence.trace, evidence.task.goal, evidence.moments
    lift = float(_displacement(evidence, moments.lift)[2])
    carry = float(np.linalg.norm(_displacement(evidence, moments.carry)[:2]))
    hold, aside = _time_held(evidence), float(np.linalg.norm(goal.aside))
    place_error = float(np.linalg.norm(trace[-1].object_position - goal.place))
    is_held = hold >= goal.hold - HOLD_TOLERANCE
    verdict = decide(
        (
            *fault_conditions(evidence),
            (moments.lift is not None, "the strategy reported no lift"),
            (abs(lift / goal.lift - 1) <= LIFT_TOLERANCE, f"lifted {lift * 100:.0f} cm"),
            (moments.carry is not None, "the strategy reported no carry"),
            (abs(carry / aside - 1) <= LIFT_TOLERANCE, f"carried {carry * 100:.0f} cm aside"),
            (moments.hold is not None, "the strategy reported no hold"),
            (is_held, f"held alone for {hold:.1f} s"),
            (_is_released(evidence), "not released at rest"),
            (place_error <= goal.zone, f"released {place_error * 100:.1f} cm from the target"),
            *_drop_conditions(evidence),
            *arm_conditions(evidence),
        ),
        evidence, find_loss=partial(find_grasp_loss, is_held=is_held), lift=lift, carry=carry, hold=hold,
        place_error=place_error,
    )  # fmt: skip
    return replace(verdict, is_held=is_held, tilt=_compute_tilt(evidence))


def decide(
    conditions: Sequence[Condition],
    evidence: Evidence,
    *,
    find_loss: Callable[[Evidence], Failure],
    lift: float,
    carry: float,
    hold: float,
    place_error: float,
) -> Verdict:
    """The verdict whose reason is the first condition that fails.

    Args:
        conditions: conditions, each with the reason that is given where it fails.
        evidence: what the verdict rests on.
        find_loss: what happened to the object of a failed trial.
        lift: as in `Verdict` [m].
        carry: likewise [m].
        hold: likewise [s].
        place_error: likewise [m].
    """
    reason = next((text for holds, text in conditions if not holds), "success")
    success = reason == "success"
    return Verdict(
        success=success, reason=reason, lift=lift, carry=carry, hold=hold, place_error=place_error,
        unjudged=find_missing_limits(evidence.limits),
        penetration=float(np.max([s.penetration for s in evidence.trace])),
        bend=float(np.max([s.bend_most for s in evidence.trace])),
        failure=None if success else find_failure(evidence, find_loss(evidence)),
    )  # fmt: skip


def _compute_tilt(evidence: Evidence) -> float | None:
    """Change of the angle between the object's axis and the vertical [rad]; None for a sphere, which has no axis."""
    if evidence.task.target.kind == "sphere":
        return None
    return abs(compute_angle(evidence.trace[-1].object_axis) - compute_angle(evidence.trace[0].object_axis))


def _displacement(evidence: Evidence, span: Span | None) -> np.ndarray:
    """Displacement of the object over a span, shape (3,) [m]; 0 for None."""
    part = evidence.between(span)
    return part[-1].object_position - part[0].object_position if part else np.zeros(3)


def _drop_conditions(evidence: Evidence) -> list[Condition]:
    """The lifted object is let down and never dropped; its places alone do not show a drop that lands well."""
    trace, lift, hold = evidence.trace, evidence.moments.lift, evidence.moments.hold
    if lift is None or hold is None or len(trace) < 2:
        return []
    after = evidence.between((lift[1], trace[-1].time))
    height = np.array([s.object_position[2] for s in after if s.time >= hold[1] - 1e-9])
    fall, speed = _longest_fall(after), float(-np.diff(height).min(initial=0.0)) / (trace[1].time - trace[0].time)
    is_carried = not any(s.touches_table for s in evidence.between((lift[1], hold[1])))
    return [
        (is_carried, "touched table or ground while it was carried"),
        (fall <= FALL_MOST, f"fell {fall * 100:.1f} cm"),
        (speed <= DROP_SPEED, f"came down at {speed:.1f} m/s"),
    ]


def _longest_fall(part: Sequence[Sample]) -> float:
    """Largest loss of height since the last touch of trunk or ground [m]; contacts flicker under rolling objects."""
    fall = held = 0.0
    for i, s in enumerate(part):
        height = float(s.object_position[2])
        held = height if i == 0 or s.grip_force > 0 or s.touches_table else held
        fall = max(fall, held - height)
    return fall


def _time_held(evidence: Evidence) -> float:
    """Longest time of the hold with strings slack, nothing else touched, the object within 2 cm of its mean height."""
    part = evidence.between(evidence.moments.hold)
    if len(part) < 2:
        return 0.0
    mean = np.mean([s.object_position[2] for s in part])
    slack = SLACK_SHARE * evidence.task.target.mass * GRAVITY
    is_held = [
        s.string_tension <= slack and s.grip_force > 0 and not s.touches_table and not s.touches_robot
        and abs(s.object_position[2] - mean) <= HOLD_HEIGHT
        for s in part
    ]  # fmt: skip
    longest = max(len(list(run)) if holds else 0 for holds, run in groupby(is_held))
    return longest * (part[1].time - part[0].time)


def _is_released(evidence: Evidence) -> bool:
    """Whether the trunk has let go and the object lay still on table or ground over the last 0.2 s."""
    end = evidence.trace[-1].time
    part = evidence.between((end - REST_TIME, end))
    moved = np.ptp([s.object_position for s in part], axis=0).max()
    return moved <= REST_WAY and part[-1].grip_force == 0.0 and part[-1].touches_table
