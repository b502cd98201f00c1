"""Real-time factor of the default grasp."""

from __future__ import annotations

import statistics

from spiraltrunk.design import presets
from spiraltrunk.sim.objects.catalogue import DEFAULT_OBJECT, parse_object
from spiraltrunk.workflows.bench.claim import Claim
from spiraltrunk.workflows.grasp.trial import run_trial

REPEATS = 3
"""Number of trials; the median counts."""


def measure_grasp_real_time() -> Claim:
    """Wall time of a default grasp, control loop included, against its simulated time [s]."""
    shape = parse_object(DEFAULT_OBJECT)
    trials = [run_trial(presets.PAPER, shape) for _ in range(REPEATS)]
    simulated = trials[0].plant.trace[-1].time
    factor = statistics.median(trial.real_time_factor for trial in trials)
    return Claim(ours=simulated / factor, other=simulated, bar=10.0)
