"""Pace of the twin: its simulated time follows the computer's clock, as far as the computer is fast enough."""

from __future__ import annotations

import math
from typing import final

import numpy as np

from spiraltrunk.hardware.driver.lateness import Lateness

CATCH_UP = 0.2
"""Lateness behind the clock that is made up for; more is given up [s] (ours)."""

_REMEMBERED = 3000
"""Cycles that are remembered: a minute of 20 ms [-] (ours)."""


@final
class Pace:
    """Cycles that are due at a fixed period, and how late they began."""

    def __init__(self, period: float) -> None:
        self._period = period
        self._late = np.zeros(_REMEMBERED)
        self._count = 0
        self._due = -math.inf

    def wait(self, now: float) -> float:
        """Time until the next cycle is due [s]; called once a cycle."""
        self._due = max(self._due + self._period, now - CATCH_UP) if self._count else now
        return max(0.0, self._due - now)

    def begin(self, now: float) -> None:
        """Note that the cycle begins."""
        self._late[self._count % _REMEMBERED] = max(0.0, now - self._due)
        self._count += 1

    def summarise(self) -> Lateness:
        """Percentiles; zeros before the first cycle."""
        if not self._count:
            return Lateness(p50=0.0, p99=0.0, p999=0.0, n_period=0)
        p50, p99, p999 = np.percentile(self._late[: min(self._count, _REMEMBERED)], [50.0, 99.0, 99.9]).tolist()
        return Lateness(p50=p50, p99=p99, p999=p999, n_period=self._count)
