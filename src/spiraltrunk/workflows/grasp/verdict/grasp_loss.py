"""What happened to the object of a failed grasp, from the simulator's true state alone."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from spiraltrunk.strategies.object_measures import TOPPLED
from spiraltrunk.workflows.grasp.verdict.cause import Cause, Failure
from spiraltrunk.workflows.grasp.verdict.course import Course, find_runs
from spiraltrunk.workflows.grasp.verdict.evidence import Evidence
from spiraltrunk.workflows.grasp.verdict.moments import Moments

LIFTED_LEAST = 0.020
"""Rise from which an object without support counts as lifted [m] (ours): a tenth of the commanded lift."""

LIFTED_TIME = 0.1
"""Time for which it is lifted at least [s] (ours): contacts with the ground flicker for shorter."""

AWAY = 0.030
"""Displacement from which an object is pushed away [m]: the largest error of position that strategies allow for."""

SLIP_LEAST = 0.020
"""Sliding along the trunk from which the grip is lost [m] (ours); of thinner objects, their width. Objects that are
held well settle by 1 to 3 mm, one of 1.5 kg in a wrap by 18 mm."""

UNROLLED_SHARE = 0.20
"""Share of its total bend that a trunk loses which unrolls [-] (ours): one that holds well loses under 1 %."""

ROLLED_LEAST = math.pi
"""Total bend below which a trunk is not rolled about anything, and cannot unroll [rad] (ours): half a turn."""

FALL_MOST = 0.010
"""Largest fall of a lifted object that touches neither trunk nor ground [m] (ours)."""

DROP_SPEED = 0.6
"""Largest speed of an object that is let down [m/s] (ours): that of a free fall by 18 mm; strategies lower at 0.1."""

CLOSED_LEAST = 2 * math.pi
"""Total bend from which the trunk has closed round its object [rad] (ours): a whole turn."""

SLIP_TIME = 1.0
"""Time before the contact is lost in which an object slides out of a closed trunk [s] (ours)."""


def find_grasp_loss(evidence: Evidence, *, is_held: bool) -> Failure:
    """How and when a grasp lost its object; ``is_held`` says whether the trunk held it for the time asked.

    What was held went wrong when it was set down. What was lifted went wrong when the trunk last lost it. What was
    never lifted toppled, slid out of the grip, was pushed away or was missed. After a sweep, the grasp begins where the
    object rested.
    """
    course, moments = Course.from_evidence(evidence), evidence.moments
    toppled = find_topple(course)
    if moments.push is not None:
        course = Course.from_evidence(replace(evidence, trace=evidence.between((moments.push[1], math.inf))))
    if is_held and moments.hold is not None:
        return _find_bad_release(course, course.index(moments.hold[1]))
    begin, end = _lifting_time(course, moments)
    lifts = [run for run in find_runs(is_aloft(course)) if begin <= run[0] < end and _lasts(course, run)]
    runs = [(max(first, begin), min(after, end)) for first, after in find_runs(course.is_borne)]
    runs = [run for run in runs if run[0] < run[1]]
    if lifts:
        last = [run for run in runs if run[0] <= lifts[-1][0]][-1:]
        return _find_lost_grip(course, last) or Failure(cause=Cause.MISPLACED, time=float(course.time[-1]))
    found = [loss for loss in (toppled, _find_lost_grip(course, runs)) if loss is not None]
    if found:
        return min(found, key=lambda loss: loss.time)
    away, out = _find_push_away(course, begin), _find_slip_out(course)
    is_hung = evidence.task.goal.ground is None
    losses = (out, away) if is_hung else (away, out)  # A hung object that slips out swings.
    missed = Failure(cause=Cause.MISSED, time=float(course.time[begin]))
    return next((loss for loss in losses if loss is not None), missed)


def find_topple(course: Course, begin: int = 0) -> Failure | None:
    """When a standing object fell over on the ground, from sample ``begin`` on: as its tilt passed the topple angle."""
    has_fallen = course.stands & course.is_supported & (course.tilt > TOPPLED)
    has_fallen[:begin] = False
    if not has_fallen.any():
        return None
    stood = np.flatnonzero(course.tilt[: int(np.argmax(has_fallen))] <= course.topple_angle)
    return Failure(cause=Cause.TOPPLED, time=float(course.time[int(stood[-1]) if stood.size else 0]))


def is_aloft(course: Course) -> np.ndarray:
    """Whether nothing but the trunk bears the object, higher than it began, shape (n_sample,)."""
    return np.asarray(~course.is_supported & (course.rise >= LIFTED_LEAST))


def slip_least(course: Course) -> float:
    """Sliding from which the grip is lost [m]."""
    return min(SLIP_LEAST, course.width)


def _lasts(course: Course, run: tuple[int, int]) -> bool:
    return bool(course.time[run[1] - 1] - course.time[run[0]] >= LIFTED_TIME)


def _lifting_time(course: Course, moments: Moments) -> tuple[int, int]:
    """Samples from the start of the lift to the end of the last of lift, carry and hold; none where none was tried."""
    if moments.lift is None:
        return len(course.time) - 1, len(course.time) - 1
    ends = [span[1] for span in (moments.lift, moments.carry, moments.hold) if span is not None]
    return course.index(moments.lift[0]), course.index(max(ends)) + 1


def _find_lost_grip(course: Course, runs: list[tuple[int, int]]) -> Failure | None:
    """First event of the last run of samples, first and after, in which the trunk bore the object and lost it."""
    for i in reversed(range(len(runs))):
        first, after = runs[i]
        until = runs[i + 1][0] if i + 1 < len(runs) else len(course.time)
        part, peak = slice(first, after), np.maximum.accumulate(course.curl[first:after])
        events = (
            (Cause.SLIPPED, np.linalg.norm(course.slide[part] - course.slide[first], axis=1) > slip_least(course)),
            (Cause.UNROLLED, (peak >= ROLLED_LEAST) & (course.curl[part] < (1 - UNROLLED_SHARE) * peak)),
            (Cause.DROPPED, course.fall[first:until] > FALL_MOST),
        )
        losses = [Failure(cause=c, time=float(course.time[first + int(np.argmax(m))])) for c, m in events if m.any()]
        if losses:
            return min(losses, key=lambda loss: loss.time)
    return None


def _find_push_away(course: Course, begin: int) -> Failure | None:
    """An object that was not at its place when the trunk lifted, from sample ``begin`` on, or is not at the end."""
    for i in (begin, len(course.time) - 1):
        if course.shift[i] >= AWAY:
            near = np.flatnonzero(course.shift[:i] < AWAY)
            return Failure(cause=Cause.PUSHED_AWAY, time=float(course.time[int(near[-1]) + 1]))
    return None


def _find_slip_out(course: Course) -> Failure | None:
    """When an object last slid out of the closed trunk before the lift."""
    for first, after in reversed(find_runs(course.is_borne)):
        late = max(first, course.index(float(course.time[after - 1]) - SLIP_TIME))
        slid = float(np.linalg.norm(course.slide[after - 1] - course.slide[late]))
        if after < len(course.time) and course.curl[after - 1] >= CLOSED_LEAST and slid > slip_least(course):
            return Failure(cause=Cause.SLIPPED, time=float(course.time[after - 1]))
    return None


def _find_bad_release(course: Course, begin: int) -> Failure:
    """What went wrong from the end of the hold on, at sample ``begin``."""
    sinking = -np.diff(course.rise[begin:], prepend=course.rise[begin]) > DROP_SPEED * np.diff(course.time[:2]).sum()
    fallen = (course.fall[begin:] > FALL_MOST) | sinking
    losses = [loss for loss in (find_topple(course, begin),) if loss is not None]
    if fallen.any():
        losses.append(Failure(cause=Cause.DROPPED, time=float(course.time[begin + int(np.argmax(fallen))])))
    return min(losses, key=lambda loss: loss.time, default=Failure(cause=Cause.MISPLACED, time=float(course.time[-1])))
