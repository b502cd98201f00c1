"""Confidence interval of a success rate."""

from __future__ import annotations


def wilson(successes: int, trials: int) -> tuple[float, float]:
    """Wilson interval of 95 % for a success rate [-]; 0 to 1 without trials."""
    from scipy.stats import binomtest

    if not trials:
        return 0.0, 1.0
    low, high = binomtest(successes, trials).proportion_ci(0.95, method="wilson")
    return float(low), float(high)
