"""Moments of a trial that a film strip shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.control.strategy import Milestone
from spiraltrunk.sim.ground_truth import Sample
from spiraltrunk.workflows.grasp.trial import Trial

_UNSHOWN = (Milestone.CARRIED, Milestone.PUSHED)
"""Milestones without a picture of their own: a carried object is held afterwards, a push is shown in four pictures."""

_PARTS = (("prehension", 0.55), ("prehension", 1.0), ("reach", 0.5))
"""Pictures between milestones, the most important first: phase, and the elapsed part of its steps [-]."""

PUSH_PICTURES = 4
"""Pictures of a push."""

APART = 0.3
"""Least time between the end of an action and another picture [s] (ours)."""

REST_SPEED = 0.01
"""Speed below which a pushed object has come to rest [m/s] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class Moment:
    """One picture of a film strip."""

    caption: str
    """What it shows, and when."""
    sample: Sample
    """State of the simulation."""
    is_failure: bool = False
    """Whether it is the moment at which the trial failed."""
    is_push: bool = False
    """Whether it is a picture of a push, until the trunk leaves the object: these share a camera, to show the way."""


def find_moments(trial: Trial, count: int = 8) -> list[Moment]:
    """Moments of a film strip, in order of time.

    A push is shown where it begins, where the trunk meets the object, where the object is fastest and where it rests.
    Every other milestone is shown where it is reached, the hold in its middle, and a failure when it happened. Up to
    ``count``, and PUSH_PICTURES more for a grasp after a push, moments of the phases are added, then the ends of
    further actions, evenly chosen; these are captioned by the action.
    """
    trace, statuses = trial.plant.trace, trial.log.statuses
    if not statuses:
        return [Moment(caption=f"start, {trace[0].time:.1f} s", sample=trace[0])]
    push = _find_push(trial)
    shown, failed = dict(push), _find_failed(trial)
    if failed is not None and trial.verdict.failure is not None:
        shown[failed] = trial.verdict.failure.cause.value
    if push and any(status.milestone is Milestone.LIFTED for status in statuses):
        count += PUSH_PICTURES
    for milestone in Milestone:
        steps = [i for i, status in enumerate(statuses) if status.milestone is milestone]
        if steps and milestone not in _UNSHOWN:
            at = _at(steps, 0.5 if milestone is Milestone.HELD else 1.0)
            is_true = failed is None or at < failed  # After a failure, a milestone is what the strategy believes.
            shown.setdefault(at, milestone.value if is_true else statuses[at].action)
    for phase, part in _PARTS:
        steps = [i for i, status in enumerate(statuses) if status.phase == phase]
        if steps and len(shown) < count and statuses[_at(steps, part)].milestone in (None, *_UNSHOWN):
            shown.setdefault(_at(steps, part), statuses[_at(steps, part)].action)
    captioned = {statuses[i].action for i in shown}
    last = {status.action: i for i, status in enumerate(statuses) if status.action not in captioned}
    ends = [i for i in sorted(last.values()) if all(abs(trace[i].time - trace[j].time) >= APART for j in shown)]
    for choice in np.linspace(0, len(ends) - 1, max(0, min(len(ends), count - len(shown)))):
        shown.setdefault(ends[round(choice)], statuses[ends[round(choice)]].action)
    return [
        Moment(
            caption=f"{statuses[i].phase}: {shown[i]}, {trace[i + 1].time:.1f} s", sample=trace[i + 1],
            is_failure=i == failed, is_push=i in push and any(s.grip_force > 0.0 for s in trace[i:]),
        )
        for i in sorted(shown)
    ]  # fmt: skip


def _find_failed(trial: Trial) -> int | None:
    """Step at which the trial failed; None for a success."""
    if trial.verdict.failure is None:
        return None
    times = [sample.time for sample in trial.plant.trace[1:]]
    step = int(np.searchsorted(times, trial.verdict.failure.time - 1e-9))
    return min(step, len(trial.log.statuses) - 1)


def _find_push(trial: Trial) -> dict[int, str]:
    """Steps and captions of the object's push along the ground; none where it was not pushed."""
    steps = [i for i, status in enumerate(trial.log.statuses) if status.milestone is Milestone.PUSHED]
    if not steps:
        return {}
    trace = trial.plant.trace[: steps[-1] + 2]
    touching = [i for i, s in enumerate(trace) if i > steps[0] and s.grip_force > 0.0]
    if not touching:
        return {steps[0]: "push begins", steps[-1]: "push missed"}
    place = np.array([s.object_position[:2] for s in trace])
    speed = np.linalg.norm(np.gradient(place, axis=0), axis=1) / (trace[1].time - trace[0].time)
    fastest = touching[0] + int(np.argmax(speed[touching[0] :]))
    moving = np.flatnonzero(speed >= REST_SPEED)
    last = min(int(moving[-1]) + 1 if moving.size else touching[-1], len(trace) - 1)
    return {
        steps[0]: "push begins", touching[0] - 1: "push meets the object",
        fastest - 1: f"object fastest, {speed[fastest]:.2f} m/s", last - 1: "object at rest",
    }  # fmt: skip


def _at(steps: list[int], part: float) -> int:
    return steps[round(part * (len(steps) - 1))]
