"""Evidence of a trial, on which its verdict and the cause of its failure rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from spiraltrunk.control.arm_limits import ArmLimits
from spiraltrunk.control.loop import RunLog
from spiraltrunk.control.messages import Task
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.sim.ground_truth import Sample
from spiraltrunk.sim.machine import SimMachine

Span = tuple[float, float]


@final
@dataclass(frozen=True, kw_only=True)
class Moments:
    """Begin and end of what the strategy reported by its milestones [s]; None for what it did not report."""

    push: Span | None = None
    """From the begin of the push until the trunk has withdrawn."""
    lift: Span | None = None
    """The lift."""
    carry: Span | None = None
    """The carry aside."""
    hold: Span | None = None
    """The hold."""

    @classmethod
    def from_log(cls, log: RunLog) -> Moments:
        """Moments of a run, by the milestones of its statuses."""
        return cls(
            push=log.milestone_span(Milestone.PUSHED), lift=log.milestone_span(Milestone.LIFTED),
            carry=log.milestone_span(Milestone.CARRIED), hold=log.milestone_span(Milestone.HELD),
        )  # fmt: skip


@final
@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What a verdict rests on."""

    trace: Sequence[Sample]
    """True states of the simulation over time."""
    task: Task
    """What was to be done."""
    moments: Moments
    """When the strategy lifted, carried and held, as it reported."""
    gave_up: str | None
    """Why the strategy ended before its goal, if it did."""
    warnings: int
    """Number of warnings of the solver."""
    limits: ArmLimits
    """Limits of the arm."""

    @classmethod
    def from_run(cls, plant: SimMachine, log: RunLog) -> Evidence:
        """Evidence of a run on a simulated machine."""
        return cls(
            trace=plant.trace, task=plant.task, moments=Moments.from_log(log), gave_up=log.gave_up,
            warnings=plant.warnings, limits=plant.arm_limits,
        )  # fmt: skip

    def between(self, span: Span | None) -> list[Sample]:
        """Samples of a span of time [s]; none for None."""
        return [] if span is None else [s for s in self.trace if span[0] - 1e-9 <= s.time <= span[1] + 1e-9]
