"""Trials that take no time, in a module that processes can import; their outcomes depend on the seed alone."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from spiraltrunk.processes.pool import Outcome
from spiraltrunk.workflows.survey.plan import Entry
from spiraltrunk.workflows.survey.row import build_empty_row


def run_inline(work: Callable[[Any], Any], jobs: Iterable[Any], workers: int) -> Iterator[Outcome[Any, Any]]:
    """An engine without processes, which take seconds to start."""
    for job in jobs:
        try:
            outcome = Outcome(job=job, result=work(job))
        except Exception as error:  # Told as the pool tells it.
            outcome = Outcome(
                job=job, result=None, fault=" ".join(f"{type(error).__name__}: {error}".split()), error=error
            )
        yield outcome


def work(entry: Entry) -> dict[str, Any]:
    """One trial of three fails, with a number in its reason."""
    part = entry.seed / 2**32
    drawn = {"width_m": 0.03 + 0.09 * part, "mass_kg": 0.1 + 0.4 * (97 * part % 1), "wall_s": time.perf_counter()}
    if entry.seed % 3 == 0:
        return build_empty_row(entry, f"lifted {entry.seed % 20} cm") | drawn
    return build_empty_row(entry, "success") | drawn | {"success": True, "cause": None, "simulated_s": 30.0 + part}


def raise_second(entry: Entry) -> dict[str, Any]:
    if entry.index == 1:
        raise ValueError(f"no plan\nfor seed {entry.seed}")
    return work(replace(entry, seed=1))


def die_second(entry: Entry) -> dict[str, Any]:
    if entry.index == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return work(replace(entry, seed=1))


def work_slowly(entry: Entry) -> dict[str, Any]:
    time.sleep(0.5)
    return work(entry)


def die_once(entry: Entry) -> dict[str, Any]:
    """The process dies at one trial, the first time; the environment names the file that remembers it."""
    if entry.index == 2:
        try:
            Path(os.environ["SURVEY_FAKES_DEAD"]).touch(exist_ok=False)
        except FileExistsError:
            return work(entry)
        os.kill(os.getpid(), signal.SIGKILL)
    return work(entry)


def hang_after_third(entry: Entry) -> dict[str, Any]:
    if entry.index >= 3:
        time.sleep(60)
    return work(entry)


def miss_package(entry: Entry) -> dict[str, Any]:
    if entry.index == 1:
        raise ModuleNotFoundError("No module named 'coacd'", name="coacd")
    return work(entry)
