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

from spiraltrunk.control.arm_limits import ArmLimits, find_unjudged
from spiraltrunk.control.messages import Task
from spiraltrunk.sim.ground_truth import Sample
from spiraltrunk.workflows.grasp.verdict import Moments, Verdict, arm_conditions, fault_conditions, judge

GATE = math.radians(30.0)
"""Largest angle between the way to the goal and where the object truly went [rad] (ours)."""

GRASP_ZONE = 0.05
"""Distance from its place within which the grasp after a sweep shall set the object down [m], as for any grasp."""

REST_TIME = 0.2
"""Time for which an object at rest keeps its place [s]."""

REST_WAY = 0.002
"""Way by which an object at rest may still move in that time [m]."""


def judge_kick(
    trace: Sequence[Sample], task: Task, *, gave_up: str | None, warnings: int, limits: ArmLimits
) -> Verdict:
    """Weigh a kick; ``carry`` of the verdict is how far the object went the goal's way, place_error what it lacked."""
    start = trace[0].object_position
    line = float(np.dot(task.goal.place - task.target.position, _way(task)))
    along, aside = _progress(trace, task)
    passed = next((i for i in range(len(trace)) if along[i] >= line), None)
    angle = 0.0 if passed is None else math.atan2(abs(float(aside[passed])), float(along[passed]))
    conditions = (
        *fault_conditions(trace, task, gave_up=gave_up, warnings=warnings),
        (passed is not None, f"went {along.max() * 100:.0f} cm the goal's way"),
        (angle <= GATE, f"went {math.degrees(angle):.0f} deg off the goal's way"),
        (_rests(trace, trace[-1].time, task), "not at rest on the ground"),
        *arm_conditions(trace, limits),
    )
    reason = next((text for holds, text in conditions if not holds), "success")
    return Verdict(
        success=reason == "success", reason=reason, lift=0.0, hold=0.0,
        carry=float(np.linalg.norm((trace[-1].object_position - start)[:2])),
        place_error=max(0.0, line - float(along.max())),
        penetration=max(s.penetration for s in trace), bend=max(s.bend_most for s in trace),
        unjudged=find_unjudged(limits),
    )  # fmt: skip


def judge_sweep(
    trace: Sequence[Sample], task: Task, moments: Moments, swept: float | None, *, gave_up: str | None, warnings: int,
    limits: ArmLimits,
) -> Verdict:  # fmt: skip
    """Weigh a sweep and the grasp after it; ``swept`` is when the trunk had withdrawn and looked [s].

    The grasp is judged from where the object truly rested.
    """
    at = trace[-1] if swept is None else min(trace, key=lambda s: abs(s.time - swept))
    goal = replace(task.goal, place=at.object_position + task.goal.aside, zone=GRASP_ZONE)
    grasp = judge(
        trace, replace(task, goal=goal), moments, gave_up=gave_up, warnings=warnings, limits=limits
    )  # fmt: skip
    conditions = (
        *fault_conditions(trace, task, gave_up=None, warnings=warnings),
        (_beside(trace[0], task) > task.goal.zone, "the object began in the zone"),
        (swept is not None and _rests(trace, at.time, task), "not at rest after the sweep"),
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
