"""How well a rate is known from a number of trials."""

from __future__ import annotations

import math

Z_95 = 1.959964
"""Quantile of the normal distribution for an interval of 95 % [-]."""


def wilson(successes: int, trials: int) -> tuple[float, float]:
    """Interval of 95 % for the rate of success (Wilson, "Probable Inference", JASA 1927); 0 to 1 without trials."""
    if trials == 0:
        return 0.0, 1.0
    rate, spread = successes / trials, Z_95**2 / trials
    middle = rate + spread / 2
    half = math.sqrt(spread * (rate * (1 - rate) + spread / 4))
    return max(0.0, (middle - half) / (1 + spread)), min(1.0, (middle + half) / (1 + spread))
