"""Evaluation of an episode by the true state: its moments, verdict and progress, and what ends it."""

from __future__ import annotations

from typing import final

from spiraltrunk.control.strategy import Milestone
from spiraltrunk.envs.rewards import PROGRESS, Terms
from spiraltrunk.sim.ground_truth import Sample
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.workflows.grasp.verdict.evidence import Evidence
from spiraltrunk.workflows.grasp.verdict.faults import PENETRATION_MOST, compute_bend_most
from spiraltrunk.workflows.grasp.verdict.grasp_verdict import Verdict
from spiraltrunk.workflows.grasp.verdict.jobs import JOBS
from spiraltrunk.workflows.grasp.verdict.moments import Referee

QUIET = 25
"""Control periods (0.5 s) for which the object rests untouched before a job counts as ended (ours)."""

FALL = 0.30
"""Height below its start at which the object is lost [m] (ours)."""


@final
class EpisodeEvaluator:
    """Evaluates an episode on a plant, from the reset on.

    Args:
        plant: the plant.
        job: "grasp", "kick" or "sweep".
    """

    def __init__(self, plant: SimPlant, job: str) -> None:
        self._plant, self._job = plant, job
        self._progress = PROGRESS[job](plant)
        self._lowest = float(plant.trace[0].object_position[2]) - FALL
        self._bend_most = compute_bend_most(plant.design)
        self.referee = Referee(plant.task)
        """Finds the moments of the episode."""
        self.quiet = 0
        """Control periods for which the object has rested untouched on table or ground."""
        self.referee.update(plant.trace[0])

    def update(self, sample: Sample) -> None:
        """Take the next sample into account."""
        referee = self.referee
        referee.update(sample)
        is_quiet = sample.touches_table and sample.grip_force == 0.0 and referee.is_at_rest()
        self.quiet = self.quiet + 1 if is_quiet else 0

    def has_ended(self) -> bool:
        """Whether the job ended in this control period, the object at rest, so that the verdict is final.

        True once in a rest.
        """
        if self.quiet != QUIET:
            return False
        if self._job != "kick":
            return Milestone.RELEASED in self.referee.reached
        return self.measure()["way"] >= 1.0

    def find_fault(self, sample: Sample) -> str:
        """The fault that ends the episode, in words; empty where there is none."""
        if sample.bend_most > self._bend_most:
            return "a joint was bent too far"
        if sample.penetration > PENETRATION_MOST:
            return "bodies overlapped"
        if sample.touches_robot:
            return "the object touched housing or arm"
        if sample.arm_touches_ground:
            return "housing or arm touched the ground"
        return "the object fell" if sample.object_position[2] < self._lowest else ""

    def verdict(self) -> Verdict:
        """Verdict of the survey on the episode so far, by the referee's moments."""
        plant = self._plant
        evidence = Evidence(
            trace=plant.trace, task=plant.task, moments=self.referee.moments, gave_up=None, warnings=plant.warnings,
            limits=plant.arm_limits,
        )  # fmt: skip
        return JOBS[self._job](evidence)

    def measure(self) -> Terms:
        """Terms of the progress at the latest sample."""
        trace = self._plant.trace
        return self._progress.measure(trace[0], trace[-1], self.referee)

    def potential(self, terms: Terms) -> float:
        """Potential of the dense reward [-]."""
        return self._progress.potential(terms)

    def latest_milestone(self) -> str:
        """Name of the milestone that was reached last; empty for none."""
        reached = self.referee.reached
        return max(reached, key=lambda each: reached[each]).value if reached else ""
