"""48 of 50 drawn trials succeed, or more: cylinders of 33 to 120 mm, 0.1 to 0.5 kg, up to 15 mm from where announced.

Friction (0.5 to 1.2) and stiffness (10 % about the design's) are drawn too. Exits with 1 below 96 % and with 130 when
interrupted; the trials that ended by then are told and written.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from spiraltrunk.design import presets
from spiraltrunk.errors import SpiralTrunkError
from spiraltrunk.processes.pool import run_jobs
from spiraltrunk.sim.objects.catalogue import ObjectSpec
from spiraltrunk.workflows.grasp.trial import run_trial
from spiraltrunk.workflows.grasp.world import EXACT, draw_scene
from spiraltrunk.workflows.survey.summary import wilson

BAR = 0.96
"""Least part of the trials that must succeed [-]."""

DIAMETER_RANGE = (0.033, 0.120)
"""What the paper's trunk grasps [m]."""

MASS_RANGE = (0.1, 0.5)
"""Mass of the object [kg]."""

LENGTH = 0.24
"""Length of the cylinder [m]."""


def draw_object(seed: int) -> ObjectSpec:
    """A cylinder, drawn apart from the rest of the world, which ``run_trial`` draws from the same seed."""
    rng = np.random.default_rng([7, seed])
    diameter, mass = float(rng.uniform(*DIAMETER_RANGE)), float(rng.uniform(*MASS_RANGE))
    return ObjectSpec(kind="cylinder", size=(LENGTH, diameter, diameter), mass=mass)


def run_seed(seed: int) -> dict[str, Any]:
    """One trial as a row of the table; what the package raises on purpose is a failure, not the end of the table."""
    shape = draw_object(seed)
    world = draw_scene(shape, seed, spread=EXACT)
    row = {
        "seed": seed,
        "diameter_m": shape.width,
        "mass_kg": shape.mass,
        "offset_m": list(world.offset),
        "friction": world.shape.friction,
        "stiffness_factor": world.trunk.stiffness_factor,
    }
    try:
        trial = run_trial(presets.PAPER, shape, seed=seed, spread=EXACT)
    except SpiralTrunkError as error:
        outcome = dict.fromkeys(("place_error_m", "penetration_m", "bend", "real_time_factor"))
        return row | {"success": False, "reason": f"{type(error).__name__}: {error}"} | outcome
    verdict = trial.verdict
    return row | {
        "success": verdict.success,
        "reason": verdict.reason,
        "place_error_m": _finite(verdict.place_error),
        "penetration_m": _finite(verdict.penetration),
        "bend": _finite(verdict.bend),
        "real_time_factor": trial.real_time_factor,
    }


def summarize(rows: Sequence[dict[str, Any]], asked: int) -> dict[str, Any]:
    """Rate of success and its interval over the trials that ended."""
    successes = sum(row["success"] for row in rows)
    low, high = wilson(successes, len(rows))
    return {
        "asked": asked,
        "trials": len(rows),
        "successes": successes,
        "rate": successes / len(rows) if rows else None,
        "wilson_low": low,
        "wilson_high": high,
        "bar": BAR,
        "is_complete": len(rows) == asked,
        "holds": len(rows) == asked and successes >= BAR * asked,
        "failures": [{"seed": row["seed"], "reason": row["reason"]} for row in rows if not row["success"]],
    }


def format_summary(summary: dict[str, Any]) -> str:
    """The summary in one line."""
    interval = f"{100 * summary['wilson_low']:.1f}-{100 * summary['wilson_high']:.1f} %"
    failures = "; ".join(f"seed {row['seed']}: {row['reason']}" for row in summary["failures"]) or "none"
    short = "" if summary["is_complete"] else f" (interrupted; {summary['asked']} asked for)"
    rate = f"{summary['successes']} of {summary['trials']} succeeded (Wilson 95 %: {interval})"
    return f"{rate}, failures: {failures}{short}"


def run_all(seeds: Sequence[int], workers: int) -> Iterator[dict[str, Any]]:
    """Rows as the trials end; leaving early drops what has not begun."""
    if workers == 1:
        yield from map(run_seed, seeds)
        return
    with closing(run_jobs(run_seed, seeds, workers)) as outcomes:
        for outcome in outcomes:
            if outcome.result is None:
                raise RuntimeError(f"seed {outcome.job}: {outcome.fault}")
            yield outcome.result


def write_table(folder: Path, table: dict[str, Any]) -> Path:
    """Write the table as JSON, whole or not at all."""
    folder.mkdir(parents=True, exist_ok=True)
    path, draft = folder / "grasp_trials.json", folder / f".grasp_trials.{os.getpid()}"
    try:
        draft.write_text(json.dumps(table, indent=2, allow_nan=False) + "\n")
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)
    return path


def main(argv: Sequence[str] | None = None) -> int:
    """Run the trials, tell each, and return the exit code."""
    arguments = _parse(argv)
    seeds = range(arguments.seed_from, arguments.seed_from + arguments.trials)
    rows: list[dict[str, Any]] = []
    is_interrupted = False
    try:
        for row in run_all(seeds, min(arguments.workers, arguments.trials)):
            rows.append(row)
            _tell(row, len(rows), arguments.trials)
    except KeyboardInterrupt:
        is_interrupted = True
    rows.sort(key=lambda row: row["seed"])
    summary = summarize(rows, arguments.trials)
    if arguments.out is not None:
        print(f"written: {write_table(arguments.out, {'summary': summary, 'trials': rows})}", file=sys.stderr)
    print(format_summary(summary))
    return 130 if is_interrupted else 0 if summary["holds"] else 1


def _parse(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0], allow_abbrev=False)
    parser.add_argument("--trials", type=_count, default=50, metavar="N", help="number of trials (default 50)")
    parser.add_argument("--seed-from", type=_seed, default=0, metavar="SEED", help="first seed (default 0)")
    parser.add_argument(
        "--workers", type=_count, default=os.cpu_count() or 1, metavar="N", help="processes (default: the processors)"
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="write grasp_trials.json there")
    return parser.parse_args(argv)


def _count(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 100_000:
        raise argparse.ArgumentTypeError(f"{text!r} given; allowed: a whole number from 1 to 100000")
    return int(text)


def _seed(text: str) -> int:
    if not text.isdecimal() or int(text) >= 2**31:
        raise argparse.ArgumentTypeError(f"{text!r} given; allowed: a whole number from 0 to {2**31 - 1}")
    return int(text)


def _tell(row: dict[str, Any], done: int, total: int) -> None:
    what = f"{row['diameter_m'] * 1e3:5.1f} mm, {row['mass_kg'] * 1e3:3.0f} g: {row['reason']}"
    print(f"{done}/{total} seed {row['seed']}, {what}", file=sys.stderr, flush=True)


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


if __name__ == "__main__":
    sys.exit(main())
