"""Statistics of paired trials that succeed or fail: exact test, its correction, interval of the difference."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from spiraltrunk.workflows.survey.summary import wilson


@final
@dataclass(frozen=True, kw_only=True)
class Pairs:
    """Number of pairs of trials by outcome."""

    both: int
    """Pairs of which both trials succeeded."""
    only_a: int
    """Pairs of which the first alone succeeded."""
    only_b: int
    """Pairs of which the second alone succeeded."""
    neither: int
    """Pairs of which both failed."""

    @property
    def count(self) -> int:
        """Number of pairs."""
        return self.both + self.only_a + self.only_b + self.neither


def compute_mcnemar(pairs: Pairs) -> float:
    """Probability of discordant pairs at least as uneven as these if both rates are equal [-].

    The exact two-sided test: ``only_a`` of the discordant pairs is binomial with 1/2 (McNemar, Psychometrika 12, 1947).
    """
    from scipy.stats import binomtest

    discordant = pairs.only_a + pairs.only_b
    return float(binomtest(pairs.only_a, discordant, 0.5).pvalue) if discordant else 1.0


def correct_by_holm(probabilities: Sequence[float]) -> list[float]:
    """Probabilities of several tests, corrected so that all together err with the level of one (Holm 1979)."""
    order = sorted(range(len(probabilities)), key=lambda i: probabilities[i])
    corrected, largest = [0.0] * len(order), 0.0
    for rank, i in enumerate(order):
        largest = max(largest, min(1.0, (len(order) - rank) * probabilities[i]))
        corrected[i] = largest
    return corrected


def compute_difference(pairs: Pairs) -> tuple[float, float, float]:
    """Rate of the second minus rate of the first trials, and its 95 % interval [-]; -1 to 1 without pairs.

    Newcombe, "Improved confidence intervals for the difference between binomial proportions based on paired data",
    Stat. Med. 17 (1998), method 10: Wilson intervals of both rates, combined with the correlation of the pairs.
    """
    n = pairs.count
    if n == 0:
        return 0.0, -1.0, 1.0
    first, second = (pairs.both + pairs.only_a) / n, (pairs.both + pairs.only_b) / n
    (low_a, high_a), (low_b, high_b) = (wilson(round(rate * n), n) for rate in (first, second))
    phi = _compute_correlation(pairs)

    def combine(one: float, other: float) -> float:
        return math.sqrt(max(0.0, one**2 - 2 * phi * one * other + other**2))

    difference = second - first
    low = difference - combine(second - low_b, high_a - first)
    return difference, low, difference + combine(high_b - second, first - low_a)


def _compute_correlation(pairs: Pairs) -> float:
    """Correlation of the outcomes of a pair with Newcombe's continuity correction [-]; 0 where a rate is 0 or 1."""
    succeeded = pairs.both + pairs.only_a, pairs.both + pairs.only_b
    margins = math.prod((*succeeded, *(pairs.count - each for each in succeeded)))
    if margins == 0:
        return 0.0
    product = pairs.both * pairs.neither - pairs.only_a * pairs.only_b
    corrected = product if product < 0 else max(product - pairs.count / 2, 0.0)
    return corrected / math.sqrt(margins)
