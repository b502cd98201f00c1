"""Evidence of a trial, on which its verdict and the cause of its failure rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from spiraltrunk.control.arm_limits import ArmLimits
from spiraltrunk.control.loop import RunLog
from spiraltrunk.control.messages import Task
from spiraltrunk.sim.ground_truth import Sample
from spiraltrunk.sim.machine import SimMachine
from spiraltrunk.workflows.grasp.verdict.moments import Moments, Span


@final
@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What a verdict rests on."""

    trace: Sequence[Sample]
    """True states of the simulation over time."""
    task: Task
    """What was to be done."""
    moments: Moments
    """When the object was lifted, carried and held, as the strategy reported it."""
    gave_up: str | None
    """Why the strategy ended before its goal, if it did."""
    warnings: int
    """Number of warnings of the solver."""
    limits: ArmLimits
    """Limits of the arm."""

    @classmethod
    def from_run(cls, plant: SimMachine, log: RunLog) -> Evidence:
        """Evidence of a run on a simulated machine; its moments are the true ones where no milestone was reported."""
        reports = any(status.milestone is not None for status in log.statuses)
        moments = Moments.from_log(log) if reports else Moments.from_trace(plant.trace, plant.task)
        return cls(
            trace=plant.trace, task=plant.task, moments=moments, gave_up=log.gave_up,
            warnings=plant.warnings, limits=plant.arm_limits,
        )  # fmt: skip

    def between(self, span: Span | None) -> list[Sample]:
        """Samples of a span of time [s]; none for None."""
        return [] if span is None else [s for s in self.trace if span[0] - 1e-9 <= s.time <= span[1] + 1e-9]
