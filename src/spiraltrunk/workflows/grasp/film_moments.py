"""Moments of a trial that a film strip shows."""

from __future__ import annotations

import numpy as np

from spiraltrunk.control.strategy import Milestone
from spiraltrunk.sim.ground_truth import Sample
from spiraltrunk.workflows.grasp.trial import Trial

_UNSHOWN = (Milestone.CARRIED,)
"""Milestones without a picture of their own: the object is where it is held afterwards."""

_PARTS = (("prehension", 0.55), ("prehension", 1.0), ("reach", 0.5))
"""Pictures between milestones, the most important first: phase, and the elapsed part of its steps [-]."""


def find_moments(trial: Trial, count: int = 8) -> list[tuple[str, Sample]]:
    """Captions and samples of a film strip, in order of time.

    Every milestone is shown where it is reached, the hold in its middle. Up to ``count``, moments of the phases are
    added, then the ends of further actions, evenly chosen; these are captioned by the action.
    """
    trace, statuses = trial.plant.trace, trial.log.statuses
    if not statuses:
        return [(f"start, {trace[0].time:.1f} s", trace[0])]
    shown: dict[int, str] = {}
    for milestone in Milestone:
        steps = [i for i, status in enumerate(statuses) if status.milestone is milestone]
        if steps and milestone not in _UNSHOWN:
            shown[_at(steps, 0.5 if milestone is Milestone.HELD else 1.0)] = milestone.value
    for phase, part in _PARTS:
        steps = [i for i, status in enumerate(statuses) if status.phase == phase]
        if steps and len(shown) < count and statuses[_at(steps, part)].milestone in (None, *_UNSHOWN):
            shown[_at(steps, part)] = statuses[_at(steps, part)].action
    captioned = {statuses[i].action for i in shown}
    ends = sorted({status.action: i for i, status in enumerate(statuses) if status.action not in captioned}.values())
    for choice in np.linspace(0, len(ends) - 1, max(0, min(len(ends), count - len(shown)))):
        shown[ends[round(choice)]] = statuses[ends[round(choice)]].action
    return [(f"{statuses[i].phase}: {shown[i]}, {trace[i + 1].time:.1f} s", trace[i + 1]) for i in sorted(shown)]


def _at(steps: list[int], part: float) -> int:
    return steps[round(part * (len(steps) - 1))]
