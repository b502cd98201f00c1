"""Lateness of the driver's loop: how long after its due time each period of control begins."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.field_docs import explain_fields

_REMEMBERED = 30_000
"""Periods that are remembered: a minute at 500 Hz [-] (ours)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Lateness:
    """Percentiles of the lateness over the last periods."""

    p50: float
    """Median [s]."""
    p99: float
    """99th percentile [s]."""
    p999: float
    """99.9th percentile [s]."""
    n_period: int
    """Periods since the start [-]."""


@final
class Schedule:
    """Due times at a fixed period, and how late they were met; memory is bounded."""

    def __init__(self, period: float) -> None:
        self._period = period
        self._late = np.zeros(_REMEMBERED)
        self._count = 0
        self.due = -math.inf
        """When the next period is due [s]; minus infinity before the first."""

    def begin(self, now: float) -> None:
        """Note that a period begins; periods that were missed altogether are left out, not made up for."""
        if self.due == -math.inf:
            self.due = now
        late = max(0.0, now - self.due)
        self._late[self._count % _REMEMBERED] = late
        self._count += 1
        self.due += self._period * (1 + math.floor(late / self._period))

    def summarise(self) -> Lateness:
        """Percentiles; zeros before the first period."""
        if not self._count:
            return Lateness(p50=0.0, p99=0.0, p999=0.0, n_period=0)
        late = np.percentile(self._late[: min(self._count, _REMEMBERED)], [50.0, 99.0, 99.9])
        p50, p99, p999 = late.tolist()
        return Lateness(p50=p50, p99=p99, p999=p999, n_period=self._count)
