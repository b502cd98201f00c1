"""Whether a kick or a sweep truly succeeded, from the simulator's record alone.

A kick succeeds where the object's centre passes the line through the goal's place, across the way to it, at most 30 deg
off that way, and comes to rest on the ground. A sweep succeeds where the object, which began outside, rests within the
goal's zone when the trunk has withdrawn, and the grasp that follows succeeds by a grasp's own verdict.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from spiraltrunk.control.messages import Task
from spiraltrunk.sim.ground_truth import Sample
from spiraltrunk.workflows.grasp.verdict import (
    Evidence,
    Verdict,
    arm_conditions,
    decide,
    evaluate_grasp,
    fault_conditions,
)

GATE = math.radians(30.0)
"""Largest angle between the way to the goal and where the object truly went [rad] (ours)."""

GRASP_ZONE = 0.05
"""Distance from its place within which the grasp after a sweep shall set the object down [m], as for any grasp."""

REST_TIME = 0.2
"""Time for which an object at rest keeps its place [s]."""

REST_WAY = 0.002
"""Way by which an object at rest may still move in that time [m]."""


def evaluate_kick(evidence: Evidence) -> Verdict:
    """Whether a kick succeeded; ``carry`` is how far the object went, ``place_error`` what lacked the goal's way."""
    trace, task = evidence.trace, evidence.task
    line = float(np.dot(task.goal.place - task.target.position, _way(task)))
    along, aside = _progress(trace, task)
    passed = next((i for i in range(len(trace)) if along[i] >= line), None)
    angle = 0.0 if passed is None else math.atan2(abs(float(aside[passed])), float(along[passed]))
    return decide(
        (
            *fault_conditions(evidence),
            (passed is not None, f"went {along.max() * 100:.0f} cm the goal's way"),
            (angle <= GATE, f"went {math.degrees(angle):.0f} deg off the goal's way"),
            (_rests(trace, trace[-1].time, task), "not at rest on the ground"),
            *arm_conditions(evidence),
        ),
        evidence, lift=0.0, hold=0.0, place_error=max(0.0, line - float(along.max())),
        carry=float(np.linalg.norm((trace[-1].object_position - trace[0].object_position)[:2])),
    )  # fmt: skip


def evaluate_sweep(evidence: Evidence) -> Verdict:
    """Whether a sweep and the grasp after it succeeded; the grasp is evaluated from where the object truly rested."""
    trace, task, push = evidence.trace, evidence.task, evidence.moments.push
    at = trace[-1] if push is None else min(trace, key=lambda s: abs(s.time - push[1]))
    goal = replace(task.goal, place=at.object_position + task.goal.aside, zone=GRASP_ZONE)
    grasp = evaluate_grasp(replace(evidence, task=replace(task, goal=goal)))
    conditions = (
        *fault_conditions(replace(evidence, gave_up=None)),
        (_beside(trace[0], task) > task.goal.zone, "the object began in the zone"),
        (push is not None, evidence.gave_up or "the strategy reported no push"),
        (_rests(trace, at.time, task), "not at rest after the sweep"),
        (_beside(at, task) <= task.goal.zone, f"swept to {_beside(at, task) * 100:.1f} cm from the place"),
        (grasp.success, grasp.reason),
    )
    reason = next((text for holds, text in conditions if not holds), "success")
    return replace(grasp, success=reason == "success", reason=reason)


def _way(task: Task) -> np.ndarray:
    """Unit vector from the object to its goal, level, shape (3,) [-]."""
    way = (task.goal.place - task.target.position) * [1.0, 1.0, 0.0]
    return np.asarray(way / np.linalg.norm(way))


def _progress(trace: Sequence[Sample], task: Task) -> tuple[np.ndarray, np.ndarray]:
    """How far the object went the goal's way, and beside it, two of shape (n_sample,) [m]."""
    way = _way(task)
    moved = np.array([s.object_position for s in trace]) - trace[0].object_position
    return moved @ way, moved @ np.array([way[1], -way[0], 0.0])


def _beside(sample: Sample, task: Task) -> float:
    """Horizontal distance of the object from the goal's place [m]."""
    return float(np.linalg.norm((sample.object_position - task.goal.place)[:2]))


def _rests(trace: Sequence[Sample], time: float, task: Task) -> bool:
    """Whether the object lay still on the ground until ``time`` [s]."""
    part = [s for s in trace if time - REST_TIME - 1e-9 <= s.time <= time + 1e-9]
    moved = float(np.ptp([s.object_position for s in part], axis=0).max())
    is_up = task.goal.ground is None or bool(part[-1].object_position[2] > task.goal.ground)
    return moved <= REST_WAY and part[-1].touches_table and is_up
