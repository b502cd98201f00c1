"""Performance claims, and interleaved timing."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import final

import numba

BURST = 2e-3
"""Wall time of a burst of calls, long against the clock's resolution [s]."""

TURNS = 15
"""Least number of bursts of each call; the fastest counts, as other load only slows them."""

SPAN = 0.5
"""Least wall time of all bursts [s]."""


@final
@dataclass(frozen=True, kw_only=True)
class Claim:
    """One claim, measured."""

    ours: float
    """Our measure, in the claim's unit."""
    other: float
    """The measure it is compared with, in the same unit."""
    bar: float
    """Least claimed ratio [-]."""

    @property
    def ratio(self) -> float:
        """Factor by which ours is better [-]."""
        return self.other / self.ours

    @property
    def holds(self) -> bool:
        """Whether the claim is met."""
        return self.ratio >= self.bar


def time_in_turns(*calls: Callable[[], object], turns: int = TURNS, span: float = SPAN) -> list[float]:
    """Least wall time of each call [s], overhead included, in interleaved bursts under the same load.

    Every call is made once before, for compilation and caches.
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
    """Mean wall time of consecutive calls [s]."""
    began = time.perf_counter()
    for _ in range(count):
        call()
    return (time.perf_counter() - began) / count


@contextmanager
def one_core() -> Iterator[None]:
    """Restrict this thread to one core within the block: Numba starts no threads, and new threads inherit the core."""
    cores, threads = os.sched_getaffinity(0), numba.get_num_threads()
    os.sched_setaffinity(0, {min(cores)})
    numba.set_num_threads(1)
    try:
        yield
    finally:
        numba.set_num_threads(threads)
        os.sched_setaffinity(0, cores)
