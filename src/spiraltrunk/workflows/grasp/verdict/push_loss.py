"""What happened to the object of a failed kick or push, from the simulator's true state alone."""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.workflows.grasp.verdict.cause import Cause, Failure
from spiraltrunk.workflows.grasp.verdict.course import Course
from spiraltrunk.workflows.grasp.verdict.evidence import Evidence
from spiraltrunk.workflows.grasp.verdict.grasp_loss import find_topple

GATE = math.radians(30.0)
"""Largest angle between the way to the goal and the object's motion [rad] (ours)."""


def compute_path(evidence: Evidence) -> tuple[np.ndarray, np.ndarray, float]:
    """Displacement along and across the way to the goal, shape (n_sample,) each, and the length of that way [m]."""
    goal, start = evidence.task.goal.place, evidence.task.target.position
    way = (goal - start) * [1.0, 1.0, 0.0]
    way /= np.linalg.norm(way)
    moved = np.array([s.object_position for s in evidence.trace]) - evidence.trace[0].object_position
    return moved @ way, moved @ np.array([way[1], -way[0], 0.0]), float(np.dot(goal - start, way))


def find_kick_loss(evidence: Evidence) -> Failure:
    """A kick missed, knocked the object over, sent it off the way to the goal, or not far enough."""
    along, aside, line = compute_path(evidence)
    off = np.abs(aside) > math.tan(GATE) * np.abs(along)
    passed = np.flatnonzero(along >= line)
    at = int(passed[0]) if passed.size else int(np.argmax(np.hypot(along, aside)))
    return _find_push_loss(evidence, is_off=bool(off[at]) or bool(along[at] < 0), at=at)


def find_sweep_loss(evidence: Evidence) -> Failure:
    """A push missed, knocked the object over, took it off the way or past its place, or not far enough."""
    along, aside, line = compute_path(evidence)
    push, zone = evidence.moments.push, evidence.task.goal.zone
    times = np.array([s.time for s in evidence.trace])
    before = times <= (times[-1] if push is None else push[1]) + 1e-9
    off = ((np.abs(aside) > zone) | (along > line + zone)) & before
    at = int(np.argmax(off)) if off.any() else int(np.flatnonzero(before)[-1])
    return _find_push_loss(evidence, is_off=bool(off.any()), at=at)


def _find_push_loss(evidence: Evidence, *, is_off: bool, at: int) -> Failure:
    """The loss at sample ``at``, unless the trunk never touched the object or knocked it over before."""
    trace, push = evidence.trace, evidence.moments.push
    if not any(s.grip_force > 0 for s in trace):
        return Failure(cause=Cause.MISSED, time=trace[-1].time if push is None else push[1])
    toppled = find_topple(Course.from_evidence(evidence))
    if toppled is not None:
        return toppled
    return Failure(cause=Cause.PUSHED_AWAY if is_off else Cause.MISPLACED, time=trace[at].time)
