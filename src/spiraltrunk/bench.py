"""Performance claims, each a ratio of two things measured in one run."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from dataclasses import dataclass
from typing import final

from spiraltrunk.design import presets
from spiraltrunk.sim.objects import DEFAULT_OBJECT, parse_object
from spiraltrunk.trial import run_trial

REPEATS = 3
"""Measurements of each claim; the median counts."""


@final
@dataclass(frozen=True, kw_only=True)
class Claim:
    """One claim, measured."""

    ours: float
    """Ours, in the claim's unit."""
    other: float
    """What it is compared with, in the same unit."""
    bar: float
    """Least ratio that is claimed [-]."""

    @property
    def ratio(self) -> float:
        """How many times better ours is [-]."""
        return self.other / self.ours

    @property
    def holds(self) -> bool:
        """Whether the claim is met."""
        return self.ratio >= self.bar


def measure_grasp_real_time() -> Claim:
    """Wall time of a default grasp in simulation, control loop included, against the time that it simulates [s]."""
    shape = parse_object(DEFAULT_OBJECT)
    trials = [run_trial(presets.PAPER, shape) for _ in range(REPEATS)]
    simulated = trials[0].plant.trace[-1].time
    factor = statistics.median(trial.real_time_factor for trial in trials)
    return Claim(ours=simulated / factor, other=simulated, bar=10.0)


CLAIMS: dict[str, Callable[[], Claim]] = {"grasp_real_time": measure_grasp_real_time}
"""How each claim is measured."""
