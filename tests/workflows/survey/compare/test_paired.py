"""Exact test, its correction and the interval against published examples and laws."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.workflows.survey.compare.paired import Pairs, compute_difference, compute_mcnemar, correct_by_holm

COUNT = st.integers(0, 60)
PAIRS = st.builds(Pairs, both=COUNT, only_a=COUNT, only_b=COUNT, neither=COUNT)

ARMITAGE = Pairs(both=20, only_a=12, only_b=2, neither=16)
"""Two media for tubercle bacilli (Armitage and Berry, "Statistical methods in medical research", 1994)."""


def swap(pairs: Pairs) -> Pairs:
    return Pairs(both=pairs.both, only_a=pairs.only_b, only_b=pairs.only_a, neither=pairs.neither)


def test_a_published_example() -> None:
    """Exact probability 0.0129; interval 0.056156 to 0.329207 by Newcombe's method, as StatsDirect prints it."""
    assert compute_mcnemar(ARMITAGE) == pytest.approx(2 * (1 + 14 + 91) / 2**14)
    assert compute_difference(swap(ARMITAGE)) == pytest.approx((0.2, 0.056156, 0.329207), abs=1e-6)


@given(PAIRS)
def test_the_exact_test_by_its_definition(pairs: Pairs) -> None:
    n, fewer = pairs.only_a + pairs.only_b, min(pairs.only_a, pairs.only_b)
    tail = sum(math.comb(n, k) for k in range(fewer + 1)) / 2**n
    assert compute_mcnemar(pairs) == pytest.approx(min(1.0, 2 * tail), rel=1e-9)


@given(PAIRS)
def test_the_interval_holds_the_difference_and_is_mirrored(pairs: Pairs) -> None:
    difference, low, high = compute_difference(pairs)
    assert -1.0 <= low <= difference + 1e-12
    assert difference - 1e-12 <= high <= 1.0
    other, other_low, other_high = compute_difference(swap(pairs))
    assert (other, other_low, other_high) == pytest.approx((-difference, -high, -low), abs=1e-12)


def test_the_interval_covers_the_truth() -> None:
    """In 95 % of drawn samples, within what the discreteness of 50 pairs leaves."""
    rng, chances = np.random.default_rng(0), (0.75, 0.15, 0.05, 0.05)
    samples = rng.multinomial(50, chances, size=400)
    held = 0
    for both, only_a, only_b, neither in samples.tolist():
        _, low, high = compute_difference(Pairs(both=both, only_a=only_a, only_b=only_b, neither=neither))
        held += low <= chances[2] - chances[1] <= high
    assert 0.92 <= held / len(samples) <= 0.99


def test_nothing_is_known_without_pairs() -> None:
    nothing = Pairs(both=0, only_a=0, only_b=0, neither=0)
    assert compute_mcnemar(nothing) == 1.0
    assert compute_difference(nothing) == (0.0, -1.0, 1.0)


def test_holm_by_hand() -> None:
    assert correct_by_holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert correct_by_holm([]) == []


@given(st.lists(st.floats(0, 1), max_size=9))
def test_holm_lies_between_none_and_bonferroni(probabilities: list[float]) -> None:
    for one, corrected in zip(probabilities, correct_by_holm(probabilities), strict=True):
        assert one <= corrected <= min(1.0, len(probabilities) * one) + 1e-15
