"""What a claim is, and how two things are timed against each other."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import final

import numba

BURST = 2e-3
"""Wall time that calls in a row should take, so that the clock's own is nothing [s]."""

TURNS = 15
"""Least turns of each side; the fastest counts, for what slows a turn is the machine's other work."""

SPAN = 0.5
"""Least wall time over which the turns are spread [s]."""


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


def time_in_turns(*calls: Callable[[], object], turns: int = TURNS, span: float = SPAN) -> list[float]:
    """Least wall time of each call [s], its overhead included, all taken in turns under the same load.

    Every call is made once before, which compiles and fills caches.
    """
    bursts = []
    for call in calls:
        call()
        bursts.append(max(1, round(BURST / max(time_burst(call, 1), 1e-7))))
    least = [float("inf")] * len(calls)
    began, done = time.perf_counter(), 0
    while done < turns or time.perf_counter() - began < span:
        for i, (call, burst) in enumerate(zip(calls, bursts, strict=True)):
            least[i] = min(least[i], time_burst(call, burst))
        done += 1
    return least


def time_burst(call: Callable[[], object], count: int) -> float:
    """Mean wall time of calls in a row [s]."""
    began = time.perf_counter()
    for _ in range(count):
        call()
    return (time.perf_counter() - began) / count


@contextmanager
def one_core() -> Iterator[None]:
    """Within it one core works for this thread: Numba starts no others, and those started inherit the core."""
    cores, threads = os.sched_getaffinity(0), numba.get_num_threads()
    os.sched_setaffinity(0, {min(cores)})
    numba.set_num_threads(1)
    try:
        yield
    finally:
        numba.set_num_threads(threads)
        os.sched_setaffinity(0, cores)
