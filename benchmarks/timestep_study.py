"""Do rates depend on the time step? Paired trials of every strategy at 0.5, 1 and 2 ms, and the speed at each.

The surveys stand in three folders below --out, as `spiraltrunk survey --timestep-ms` makes them, and go on where they
were stopped; the steps take turns, nine trials each, so that whatever has ended is paired. The script ends after
--minutes, or with --report at once, and tells rates, exact paired tests against 1 ms and speeds. Speeds are simulated
time over processor time of whole trials, Python included, which other work on the machine disturbs little.

A hundred trials of each strategy at each step take some five hours of two free cores:

    python benchmarks/timestep_study.py --out out/timestep --minutes 600 --workers 2

On a cluster, run the three surveys as docs/howto/clusters.md tells, and then this script with --report.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from spiraltrunk import strategies
from spiraltrunk.cli.progress import print_progress
from spiraltrunk.design import presets
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.workflows.grasp.trial import run_trial
from spiraltrunk.workflows.survey.compare.compare_surveys import compare_surveys
from spiraltrunk.workflows.survey.compare.comparison_text import format_comparison
from spiraltrunk.workflows.survey.plan import SurveyPlan
from spiraltrunk.workflows.survey.run_survey import run_survey

STEPS_MS = (1.0, 2.0, 0.5)
"""Time steps, first the one with which the others are compared."""

ROUND = len(strategies.NAMES)
"""Trials of one step before the next one's turn: one of each strategy."""


class _Enough(Exception):
    """The turn of a survey is over."""


def build_plan(step_ms: float, trials: int, seed: int) -> SurveyPlan:
    objects = {name: tuple(strategies.get(name).objects) for name in strategies.NAMES}
    return SurveyPlan(objects=objects, trials=trials, seed=seed, timestep=step_ms / 1e3)


def find_folder(out: Path, step_ms: float) -> Path:
    return out / f"{step_ms:g}ms"


def run_turn(plan: SurveyPlan, folder: Path, workers: int, end: float) -> bool:
    """Run one round of a survey; whether it is complete."""
    began: list[int] = []
    asked = sum(plan.count_trials().values())

    def watch(rows: Sequence[Any]) -> None:
        began.append(len(rows))
        print_progress(f"{1e3 * plan.timestep:g} ms: {len(rows)} trials", sys.stderr)
        if len(rows) < asked and (len(rows) - began[0] >= ROUND or time.monotonic() > end):
            raise _Enough

    try:
        return bool(run_survey(plan, folder=folder, workers=workers, watch=watch)["complete"])
    except _Enough:
        return False


def run_surveys(out: Path, asked: argparse.Namespace) -> None:
    end, left = time.monotonic() + 60 * asked.minutes, list(STEPS_MS)
    while left and time.monotonic() < end:
        for step in tuple(left):
            if run_turn(build_plan(step, asked.trials, asked.seed), find_folder(out, step), asked.workers, end):
                left.remove(step)


def measure_speed(step_ms: float, seeds: Sequence[int]) -> float:
    """Simulated time over processor time of the default grasp [-], the best of some seeds; the first compiles."""
    factors = []
    for seed in (seeds[0], *seeds):
        began = time.process_time()
        trial = run_trial(presets.PAPER, parse_object("cylinder-60"), seed=seed, timestep=step_ms / 1e3)
        factors.append(trial.plant.trace[-1].time / (time.process_time() - began))
    return max(factors[1:])


def count_rows(folder: Path) -> int:
    log = folder / "trials.jsonl"
    return len(log.read_text().splitlines()) if log.exists() else 0


def report(out: Path, tell: Callable[[str], None]) -> dict[str, Any]:
    base, compared = find_folder(out, STEPS_MS[0]), {}
    for step in STEPS_MS[1:]:
        other = find_folder(out, step)
        if count_rows(base) and count_rows(other):
            compared[f"{step:g}"] = compare_surveys(base, other)
            tell(f"A: {STEPS_MS[0]:g} ms, B: {step:g} ms\n{format_comparison(compared[f'{step:g}'])}\n")
    return compared


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("out/timestep"))
    parser.add_argument("--trials", type=int, default=100, help="trials of each strategy at each step (default 100)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=30.0, help="time for the trials; they go on next time")
    parser.add_argument("--report", action="store_true", help="run nothing, tell what is there")
    parser.add_argument("--speed", type=int, default=0, metavar="N", help="measure the speed with N seeds")
    asked = parser.parse_args()
    if not asked.report:
        run_surveys(asked.out, asked)
    result: dict[str, Any] = {"against_1ms": report(asked.out, print)}
    if asked.speed:
        result["real_time_factor"] = {f"{step:g}": measure_speed(step, range(asked.speed)) for step in sorted(STEPS_MS)}
        print("times real time in processor time:", result["real_time_factor"])
    asked.out.mkdir(parents=True, exist_ok=True)
    (asked.out / "timestep.json").write_text(json.dumps(result, indent=2, allow_nan=False) + "\n")


if __name__ == "__main__":
    main()
