"""How the yaw of a flat object on the ground decides whether a wrap takes it.

Everyday things (`spiraltrunk.sim.objects.everyday`) that stand, are at least 1.25 times as wide as deep and 90 mm wide,
and that the choice gives to a wrap, are tried by ``auto`` once for each yaw of their wide side. Everything else of a
world stays as its seed draws it. Every row is kept as it ends, so that the same command goes on after an interruption.

    python benchmarks/turned_objects.py --start 8300 --objects 12 --out out/turned
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

from spiraltrunk.design import presets
from spiraltrunk.errors import SpiralTrunkError
from spiraltrunk.processes.pool import run_jobs
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.objects.presentation import as_measured
from spiraltrunk.workflows.grasp.choice.auto import get_strategy
from spiraltrunk.workflows.grasp.choice.ranking import rank_object
from spiraltrunk.workflows.grasp.trial import run_scene
from spiraltrunk.workflows.grasp.world import draw_scene

LEAST_RATIO, LEAST_WIDTH = 1.25, 0.09
"""Least ratio of the widths [-] and least width [m] of what is tried."""

ANGLES = (0, 30, 60, 90, 120, 150)
"""Angles of the wide side from the way that leads from the arm to the object, counterclockwise from above [deg]."""


def find_objects(start: int, count: int) -> list[int]:
    """Seeds, from ``start`` on, of the first ``count`` objects that are tried."""
    found: list[int] = []
    seed = start
    while len(found) < count:
        shape = parse_object(f"everyday:seed={seed}")
        _, *across = as_measured(shape).size
        is_flat = max(across) >= max(LEAST_WIDTH, LEAST_RATIO * min(across))
        if is_flat and as_measured(shape).up == "x":
            best = next(iter(rank_object(presets.PAPER, shape)))
            if best.feasible and best.strategy.startswith("wrap"):
                found.append(seed)
        seed += 1
    return found


def run_turned(job: tuple[int, int]) -> dict[str, Any]:
    """One trial as a row."""
    seed, angle = job
    shape = parse_object(f"everyday:seed={seed}")

    strategy = get_strategy("auto", presets.PAPER, shape, "ground")
    scene = draw_scene(shape, seed, strategy=strategy)
    _, across, beside = scene.announced.size  # With its axis up, its z points against the world's x.
    turned = replace(scene, yaw=math.radians(angle) - (math.pi / 2 if across > beside else 0.0))
    try:
        trial = run_scene(presets.PAPER, turned, strategy=strategy, seed=seed)
    except SpiralTrunkError as error:
        outcome = {"success": False, "cause": "refused", "reason": str(error), "tries": []}
    else:
        verdict = trial.verdict
        cause = None if verdict.failure is None else verdict.failure.cause.value
        tries = [each.strategy for each in getattr(trial.log.state, "attempts", ())]
        outcome = {"success": bool(verdict.success), "cause": cause, "reason": verdict.reason, "tries": tries}
    size = [round(1e3 * side) for side in as_measured(shape).size]
    return {"seed": seed, "angle_deg": angle, "name": shape.notes[0], "size_mm": size, **outcome}


def main() -> int:
    """Run what is missing and print successes by angle."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0], allow_abbrev=False)
    parser.add_argument(
        "--start", type=_count, default=8300, metavar="N", help="first seed of an object (default 8300)"
    )
    parser.add_argument("--objects", type=_count, default=12, metavar="N", help="number of objects (default 12)")
    parser.add_argument("--workers", type=_count, default=os.cpu_count() or 1, metavar="N", help="processes")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="rows are written there")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    log = given.out / "turned_objects.jsonl"
    kept = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    jobs = [(seed, angle) for seed in find_objects(given.start, given.objects) for angle in ANGLES]
    rows = [row for row in kept if (row["seed"], row["angle_deg"]) in jobs]
    done = {(row["seed"], row["angle_deg"]) for row in rows}
    left = [job for job in jobs if job not in done]
    with log.open("a") as file, closing(run_jobs(run_turned, left, given.workers)) as outcomes:
        for outcome in outcomes:
            if outcome.result is None:
                raise RuntimeError(f"object {outcome.job}: {outcome.fault}")
            rows.append(outcome.result)
            file.write(json.dumps(outcome.result) + "\n")
            file.flush()
            print(f"{len(rows)}/{len(jobs)}", file=sys.stderr, flush=True)
    for angle in ANGLES:
        own = [row for row in rows if row["angle_deg"] == angle]
        print(f"{angle:4d} deg: {sum(row['success'] for row in own)} of {len(own)}")
    return 0


def _count(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 10**6:
        raise argparse.ArgumentTypeError(f"{text!r} given; allowed: a whole number from 1 to 1000000")
    return int(text)


if __name__ == "__main__":
    sys.exit(main())
