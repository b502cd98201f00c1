"""Full or distal wrap of what is just tall enough for a full one: everyday things tried with either.

A full wrap of a thing that is not much taller than the housing needs to clear the ground is near its rim, and climbs
over it as it tightens. Things (`spiraltrunk.sim.objects.everyday`) whose full wrap by `wrap-oblique-low` would be
higher than 0.76 of their height, and that the choice gives to it, are tried by ``auto`` in the same world with the
largest height of a full wrap at 0.85 and at 0.76. Every row is kept as it ends, so that the same command goes on after
an interruption.

    python benchmarks/rim_heights.py --start 9300 --objects 240 --out out/rim
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from contextlib import closing
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

from spiraltrunk.design import presets
from spiraltrunk.errors import SpiralTrunkError
from spiraltrunk.files.atomic import write_text
from spiraltrunk.processes.pool import run_jobs
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.objects.presentation import as_measured
from spiraltrunk.strategies.wrap import standing_plan
from spiraltrunk.strategies.wrap.standing import WrapObliqueLow
from spiraltrunk.workflows.grasp.choice.ranking import rank_object
from spiraltrunk.workflows.grasp.trial import build_plant, run_trial
from spiraltrunk.workflows.grasp.world import draw_scene

LIMITS = (standing_plan.HIGHEST, standing_plan.HIGHEST_NARROW)
"""Largest heights of a full wrap that are compared, over the object's height [-]."""

WIDTH = standing_plan.NARROW * presets.PAPER.length
"""Width up to which a thing counts as narrow [m]."""


def set_limit(limit: float) -> None:
    """Let full wraps be as high as ``limit``, whatever the width."""
    standing_plan.HIGHEST = standing_plan.HIGHEST_NARROW = limit


def is_between(seed: int) -> bool:
    """Whether the choice gives a thing to the wrap, which is a full one with the first limit alone."""
    shape = parse_object(f"everyday:seed={seed}")
    if as_measured(shape).up != "x":
        return False
    set_limit(LIMITS[0])
    best, strategy = next(iter(rank_object(presets.PAPER, shape))), WrapObliqueLow()
    if not best.feasible or best.strategy != strategy.name:
        return False
    scene = draw_scene(shape, seed, strategy=strategy)
    seen = build_plant(presets.PAPER, scene, strategy).reset()
    found = []
    for limit in LIMITS:
        set_limit(limit)
        found.append(strategy.init(seen).is_distal)
    return found == [False, True]


def run_seed(seed: int) -> dict[str, Any] | None:
    """Both trials of a thing as a row; None of what is not compared."""
    if not is_between(seed):
        return None
    shape = parse_object(f"everyday:seed={seed}")
    row: dict[str, Any] = {"seed": seed, "size_mm": [round(1e3 * each) for each in as_measured(shape).size]}
    for limit in LIMITS:
        set_limit(limit)
        try:
            verdict = run_trial(presets.PAPER, shape, strategy="auto", seed=seed).verdict
            row[f"{limit}"] = {"success": bool(verdict.success), "reason": verdict.reason}
        except SpiralTrunkError as error:
            row[f"{limit}"] = {"success": False, "reason": str(error)}
    return row


def main() -> int:
    """Try what is missing, and tell how many of narrow and of wide things succeed with either limit."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--start", type=int, default=9300, metavar="SEED", help="first seed looked at (default 9300)")
    parser.add_argument("--objects", type=int, default=240, metavar="N", help="seeds looked at (default 240)")
    parser.add_argument("--workers", type=int, default=1, metavar="N", help="processes that share them (default 1)")
    parser.add_argument("--out", type=Path, default=Path("out/rim"), metavar="DIR", help="folder of rim_heights.jsonl")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    log = given.out / "rim_heights.jsonl"
    lines = log.read_text().splitlines(keepends=True) if log.exists() else []
    rows = [json.loads(line) for line in lines if line.endswith("\n")]
    rows = [row for row in rows if row.get("fault") is None]
    write_text(log, "".join(json.dumps(row) + "\n" for row in rows))  # Without a line that was cut off.
    seeds = range(given.start, given.start + given.objects)
    left = [seed for seed in seeds if seed not in {row["seed"] for row in rows}]
    with log.open("a") as file, closing(run_jobs(run_seed, left, given.workers)) as outcomes:
        for outcome in outcomes:
            row = outcome.result or {"seed": outcome.job, "fault": outcome.fault}
            rows.append(row)
            file.write(json.dumps(row) + "\n")
            file.flush()
            if "size_mm" in row:
                print(json.dumps(row), flush=True)
    faults = sum(row.get("fault") is not None for row in rows)
    if faults:
        print(f"{faults} seeds ended in a fault; the same command tries them again")
    compared = [row for row in rows if "size_mm" in row and row["seed"] in seeds]
    for name, is_narrow in (("narrow", True), ("wide", False)):
        own = [row for row in compared if (max(row["size_mm"][1:]) <= 1e3 * WIDTH) is is_narrow]
        counts = ", ".join(f"{sum(row[f'{limit}']['success'] for row in own)} with {limit}" for limit in LIMITS)
        print(f"{name}: of {len(own)} things succeed {counts}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
