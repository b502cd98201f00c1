"""Verdicts on a kick and on a sweep, from the simulator's true state alone.

A kick succeeds where the object's centre moves along the way from the announced place to the goal's by the length of
that way, in a direction at most 30 deg off it, and comes to rest on the ground. A sweep succeeds where the object,
which began outside, rests within the goal's zone when the trunk has withdrawn, and the grasp that follows succeeds as a
grasp.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from spiraltrunk.control.messages import Task
from spiraltrunk.sim.ground_truth import Sample
from spiraltrunk.workflows.grasp.verdict.arm_conditions import arm_conditions
from spiraltrunk.workflows.grasp.verdict.evidence import Evidence
from spiraltrunk.workflows.grasp.verdict.faults import fault_conditions, find_failure
from spiraltrunk.workflows.grasp.verdict.grasp_verdict import Verdict, decide, evaluate_grasp
from spiraltrunk.workflows.grasp.verdict.moments import REST_TIME, REST_WAY
from spiraltrunk.workflows.grasp.verdict.push_loss import (
    GATE,
    compute_path,
    find_kick_loss,
    find_sweep_loss,
)

GRASP_ZONE = 0.05
"""Distance from its place within which the grasp after a sweep sets the object down [m], as for any grasp."""


def evaluate_kick(evidence: Evidence) -> Verdict:
    """Verdict on a kick; ``carry`` is the object's displacement, ``place_error`` what it lacks of the goal's way."""
    trace, (along, aside, line) = evidence.trace, compute_path(evidence)
    moved = trace[-1].object_position - trace[0].object_position
    passed = next((i for i in range(len(trace)) if along[i] >= line), None)
    angle = 0.0 if passed is None else math.atan2(abs(float(aside[passed])), float(along[passed]))
    return decide(
        (
            *fault_conditions(evidence),
            (passed is not None, f"went {along.max() * 100:.0f} cm the goal's way"),
            (angle <= GATE, f"went {math.degrees(angle):.0f} deg off the goal's way"),
            (_is_at_rest(evidence, trace[-1].time), "not at rest on the ground"),
            *arm_conditions(evidence),
        ),
        evidence, find_loss=find_kick_loss, lift=0.0, hold=0.0, carry=float(np.linalg.norm(moved[:2])),
        place_error=max(0.0, line - float(along.max())),
    )  # fmt: skip


def evaluate_sweep(evidence: Evidence) -> Verdict:
    """Verdict on a sweep and the grasp after it; the grasp is evaluated from where the object truly rested."""
    trace, task, push = evidence.trace, evidence.task, evidence.moments.push
    at = trace[-1] if push is None else min(trace, key=lambda s: abs(s.time - push[1]))
    goal = replace(task.goal, place=at.object_position + task.goal.aside, zone=GRASP_ZONE)
    grasp = evaluate_grasp(replace(evidence, task=replace(task, goal=goal)))
    before, after = _distance(trace[0], task), _distance(at, task)
    conditions = (
        *fault_conditions(replace(evidence, gave_up=None)),
        (before > task.goal.zone, "the object began in the zone"),
        (push is not None, evidence.gave_up or "the strategy reported no push"),
        (_is_at_rest(evidence, at.time), "not at rest after the sweep"),
        (after <= task.goal.zone, f"swept to {after * 100:.1f} cm from the place"),
        (grasp.success, grasp.reason),
    )
    reason = next((text for holds, text in conditions if not holds), "success")
    success, is_swept = reason == "success", push is not None and after <= task.goal.zone
    failure = grasp.failure if is_swept else None
    if not success and failure is None:  # The push failed, if only by its begin or its end.
        failure = find_failure(evidence, find_sweep_loss(evidence))
    return replace(grasp, success=success, reason=reason, failure=failure)


def _distance(sample: Sample, task: Task) -> float:
    """Horizontal distance of the object from the goal's place [m]."""
    return float(np.linalg.norm((sample.object_position - task.goal.place)[:2]))


def _is_at_rest(evidence: Evidence, time: float) -> bool:
    """Whether the object lay still on the ground until ``time`` [s]."""
    part, ground = evidence.between((time - REST_TIME, time)), evidence.task.goal.ground
    moved = float(np.ptp([s.object_position for s in part], axis=0).max())
    is_up = ground is None or bool(part[-1].object_position[2] > ground)
    return moved <= REST_WAY and part[-1].touches_table and is_up
