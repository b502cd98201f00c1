"""How fast held things creep in simulation, by the hardness of friction, and what that costs.

MuJoCo softens friction: what a real hand would hold still sinks out of it, at a speed that falls with the hardness of
friction (``impratio``). Everyday things (`spiraltrunk.sim.objects.everyday`) that ``auto`` takes first with fingers, or
with the trunk, are tried in the same worlds at each hardness. Printed are how many are held and succeed, the speed at
which what is held to the end sinks in the hold, and the processor's time over the simulated time. With ``--noslip``
MuJoCo's second solver, which takes the softness out, has that many iterations.

    python benchmarks/held_creep.py --holds fingers --hardness 30 100 300 1000
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from auto_choice import draw_object, read_count, read_index

from spiraltrunk.design import presets
from spiraltrunk.errors import SpiralTrunkError
from spiraltrunk.processes.pool import run_jobs
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.objects.presentation import as_measured
from spiraltrunk.strategies import get
from spiraltrunk.workflows.grasp.choice.ranking import rank_object
from spiraltrunk.workflows.grasp.trial import Trial, build_plant, run_plant
from spiraltrunk.workflows.grasp.world import draw_scene

SWING = 0.5
"""Time from the beginning of the hold in which what is held still swings [s]."""


@dataclass(frozen=True)
class Holding:
    """A thing as it is held.

    Attributes:
        is_held: whether it was held.
        is_success: whether the trial succeeded.
        sink: speed at which it sank in the hold [m/s]; None where it was not held to the end of it.
        cost: processor's time over simulated time [-].
    """

    is_held: bool
    is_success: bool
    sink: float | None
    cost: float


def find_first(index: int) -> str | None:
    """The strategy that ``auto`` tries first with a drawn thing; None where it refuses it."""
    feasible = [each for each in rank_object(presets.PAPER, parse_object(draw_object(index))) if each.feasible]
    return feasible[0].strategy if feasible else None


def hold(job: tuple[int, str], *, hardness: float, noslip: int) -> Holding:
    """Try a thing with a strategy at a hardness of friction."""
    index, name = job
    strategy, shape = get(name), as_measured(parse_object(draw_object(index)))
    scene = replace(draw_scene(shape, index, strategy=strategy), friction_hardness=hardness)
    began = time.process_time()
    try:
        plant = build_plant(presets.PAPER, scene, strategy)
        plant.model.opt.noslip_iterations = noslip
        trial = run_plant(plant, strategy, seed=index)
    except SpiralTrunkError:
        return Holding(False, False, None, float("nan"))
    cost = (time.process_time() - began) / trial.plant.trace[-1].time
    return Holding(trial.verdict.is_held, trial.verdict.success, measure_sink(trial), cost)


def measure_sink(trial: Trial) -> float | None:
    """Speed at which the thing sinks while it is held, by the line of least squares [m/s]."""
    span = trial.log.span("transport", "hold")
    if span is None or not trial.verdict.is_held:
        return None
    held = [sample for sample in trial.plant.trace if span[0] + SWING <= sample.time <= span[1]]
    times = np.array([sample.time for sample in held])
    heights = np.array([sample.object_position[2] for sample in held])
    return float(-np.polyfit(times - times[0], heights, 1)[0])


def describe(hardness: float, holdings: Sequence[Holding]) -> str:
    """One line of what was measured at a hardness."""
    held, succeed = sum(each.is_held for each in holdings), sum(each.is_success for each in holdings)
    line = f"hardness {hardness:6.0f}: {held} of {len(holdings)} held, {succeed} succeed"
    sinks = 1e3 * np.abs([each.sink for each in holdings if each.sink is not None])
    if not sinks.size:
        return line
    median, high, most = np.quantile(sinks, (0.5, 0.9, 1.0))
    cost = np.nanmean([each.cost for each in holdings])
    return (
        f"{line}; sinking {median:.3f} mm/s in the median, {high:.3f} of one in ten, {most:.3f} at most; "
        f"{cost:.3f} s a simulated second"
    )


def run_all(work: Callable[[Any], Any], jobs: Sequence[Any], workers: int) -> list[tuple[Any, Any]]:
    """Jobs with their results, in the order in which they end; a job that fails ends the script."""
    ended = []
    with closing(run_jobs(work, jobs, workers=workers)) as outcomes:
        for outcome in outcomes:
            if outcome.fault:
                raise RuntimeError(f"{outcome.job}: {outcome.fault}")
            ended.append((outcome.job, outcome.result))
    return ended


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--holds", choices=("fingers", "trunk"), default="fingers", help="(default %(default)s)")
    parser.add_argument("--hardness", type=float, nargs="+", default=[10.0, 30.0, 100.0, 300.0, 1000.0])
    parser.add_argument("--noslip", type=read_index, default=0, help="iterations of MuJoCo's second solver (default 0)")
    parser.add_argument("--start", type=read_index, default=12000, help="seed of the first thing (default %(default)s)")
    parser.add_argument("--objects", type=read_count, default=120, help="things drawn (default %(default)s)")
    parser.add_argument("--workers", type=read_count, default=2)
    given = parser.parse_args(arguments)
    seeds = range(given.start, given.start + given.objects)
    firsts = sorted(run_all(find_first, seeds, given.workers))
    chosen = [(seed, name) for seed, name in firsts if name is not None and get(name).holds == given.holds]
    print(f"{len(chosen)} things of seeds {seeds[0]} to {seeds[-1]} are taken by {given.holds} first", flush=True)
    for hardness in given.hardness:
        task = partial(hold, hardness=hardness, noslip=given.noslip)
        print(describe(hardness, [holding for _, holding in run_all(task, chosen, given.workers)]), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
