"""How often the choice of a strategy is right: 85 % of what it calls feasible is lifted, 5 % of what it refuses.

Objects are everyday shapes (`spiraltrunk.sim.objects.everyday`): 25 to 120 mm wide, 30 to 240 mm tall, 20 to 1000 g.
``auto`` tries each on the ground. Of a share of the objects one refused strategy, drawn too, is tried all the same in
the same pose. Every row is kept as it ends, so that the same command goes on after an interruption. Exits with 1 where
a bar is missed and with 130 when interrupted.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from collections.abc import Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from spiraltrunk.design import presets
from spiraltrunk.errors import SpiralTrunkError
from spiraltrunk.processes.pool import run_jobs
from spiraltrunk.sim.objects.catalogue import ObjectSpec, parse_object
from spiraltrunk.sim.objects.presentation import as_measured
from spiraltrunk.workflows.grasp.choice.ranking import rank_object
from spiraltrunk.workflows.grasp.trial import run_trial
from spiraltrunk.workflows.survey.summary import wilson

FEASIBLE_BAR, REFUSED_BAR = 0.85, 0.05
"""Least part of the feasible, and largest part of the refused, that must succeed [-]."""

LAID = 0.25
"""Part of the objects that lie [-]."""

SLENDER, LYING = 0.5, 0.7
"""Width over height below which an upright object counts as tall, and height over width below which one is flat [-]."""


def draw_object(index: int) -> str:
    """An everyday thing as a text: some lie, the others stand with their axis up."""
    rng = np.random.default_rng([23, index])
    return f"everyday:seed={index}{',pose=lying' if rng.uniform() < LAID else ''}"


def classify(shape: ObjectSpec) -> str:
    """Class of an object as it rests: tall, compact or flat."""
    length, across, upwards = shape.size
    height, width = (length, max(across, upwards)) if shape.up == "x" and shape.pose != "lying" else (upwards, length)
    return "tall" if width < SLENDER * height else "flat" if height < LYING * width else "compact"


def run_index(index: int, *, share: float) -> dict[str, Any]:
    """One object as a row: what was predicted, what ``auto`` did, and what a refused strategy did."""
    text = draw_object(index)
    shape, rng = parse_object(text), np.random.default_rng([29, index])
    ranked = rank_object(presets.PAPER, shape)
    feasible = [each for each in ranked if each.feasible]
    row: dict[str, Any] = {
        "index": index, "object": text, "class": classify(shape),
        "feasible": {each.strategy: each.score for each in feasible}, "auto": None, "forced": None,
    }  # fmt: skip
    if feasible:
        row["auto"] = try_object("auto", shape, index)
    refused = [each for each in ranked if not each.feasible]
    if refused and float(rng.uniform()) < share:
        each = refused[int(rng.integers(len(refused)))]
        row["forced"] = {"strategy": each.strategy, "predicted": each.reason} | try_object(each.strategy, shape, index)
    return row


def try_object(name: str, shape: ObjectSpec, seed: int) -> dict[str, Any]:
    """Outcome of a trial; what the package raises on purpose is a failure."""
    own = shape if name == "auto" else as_measured(shape)
    try:
        trial = run_trial(presets.PAPER, own, strategy=name, seed=seed)
    except SpiralTrunkError as error:
        return {"success": False, "held": False, "cause": None, "reason": str(error), "tries": [], "simulated_s": 0.0}
    tries = [each.strategy for each in getattr(trial.log.state, "attempts", ())]
    verdict, end = trial.verdict, float(trial.plant.trace[-1].time)
    return {
        "success": bool(verdict.success), "held": bool(verdict.is_held),
        "cause": None if verdict.failure is None else verdict.failure.cause.value, "reason": verdict.reason,
        "tries": tries, "simulated_s": end,
    }  # fmt: skip


def summarize(rows: Sequence[dict[str, Any]], asked: int) -> dict[str, Any]:
    """Rates of what was called feasible and of what was refused, with Wilson intervals, in all and by class."""
    classes = sorted({row["class"] for row in rows})
    feasible = [row for row in rows if row["auto"] is not None]
    forced = [row for row in rows if row["forced"] is not None]
    tables = {
        key: {"all": _rate([row[key] for row in own])}
        | {name: _rate([row[key] for row in own if row["class"] == name]) for name in classes}
        for key, own in (("auto", feasible), ("forced", forced))
    }
    lifted, wrong = tables["auto"]["all"]["rate"], tables["forced"]["all"]["rate"]
    holds = (lifted is None or lifted >= FEASIBLE_BAR) and (wrong is None or wrong <= REFUSED_BAR)
    first = [row["auto"]["success"] and len(row["auto"]["tries"]) == 1 for row in feasible]
    return {
        "asked": asked, "objects": len(rows), "feasible": len(feasible), "by_the_first_try": sum(first),
        "rates": tables, "is_complete": len(rows) == asked, "holds": len(rows) == asked and holds,
    }  # fmt: skip


def _rate(outcomes: Sequence[dict[str, Any]]) -> dict[str, Any]:
    successes = sum(each["success"] for each in outcomes)
    low, high = wilson(successes, len(outcomes))
    rate = successes / len(outcomes) if outcomes else None
    return {"trials": len(outcomes), "successes": successes, "rate": rate, "low": low, "high": high}


def format_summary(summary: dict[str, Any]) -> str:
    """Both rates with their intervals, in all and by class."""
    lines = [f"{summary['objects']} of {summary['asked']} objects, {summary['feasible']} called feasible"]
    for key, what in (("auto", "feasible, lifted"), ("forced", "refused, lifted all the same")):
        for name, rate in summary["rates"][key].items():
            interval = f"{100 * rate['low']:.0f}-{100 * rate['high']:.0f} %"
            lines.append(f"{what}, {name}: {rate['successes']} of {rate['trials']} (Wilson 95 %: {interval})")
    return "\n".join(lines)


def main(argv: Sequence[str] | None = None) -> int:
    """Run what is missing, tell each object, and return the exit code."""
    arguments = _parse(argv)
    arguments.out.mkdir(parents=True, exist_ok=True)
    log = arguments.out / "auto_choice.jsonl"
    rows = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    indices = range(arguments.start, arguments.start + arguments.objects)
    rows = [row for row in rows if row["index"] in indices]
    left = sorted(set(indices) - {row["index"] for row in rows})
    is_interrupted = False
    try:
        with log.open("a") as file, closing(_run(left, arguments)) as found:
            for row in found:
                rows.append(row)
                file.write(json.dumps(row) + "\n")
                file.flush()
                _tell(row, len(rows), len(indices))
    except KeyboardInterrupt:
        is_interrupted = True
    summary = summarize(sorted(rows, key=lambda row: row["index"]), len(indices))
    _write(arguments.out / "auto_choice.json", summary)
    print(format_summary(summary))
    return 130 if is_interrupted else 0 if summary["holds"] else 1


def _run(indices: Sequence[int], arguments: argparse.Namespace) -> Any:
    work = partial(run_index, share=arguments.forced)
    if arguments.workers == 1:
        yield from map(work, indices)
        return
    with closing(run_jobs(work, indices, arguments.workers)) as outcomes:
        for outcome in outcomes:
            if outcome.result is None:
                raise RuntimeError(f"object {outcome.job}: {outcome.fault}")
            yield outcome.result


def _write(path: Path, summary: dict[str, Any]) -> None:
    """Write JSON, whole or not at all."""
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        draft.write_text(json.dumps(summary, indent=2, allow_nan=False) + "\n")
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)


def _tell(row: dict[str, Any], done: int, total: int) -> None:
    auto = "refused by all" if row["auto"] is None else f"{'/'.join(row['auto']['tries'])}: {row['auto']['reason']}"
    forced = "" if row["forced"] is None else f"; forced {row['forced']['strategy']}: {row['forced']['reason']}"
    print(f"{done}/{total} {row['object']}, {auto}{forced}", file=sys.stderr, flush=True)


def _parse(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0], allow_abbrev=False)
    parser.add_argument("--objects", type=read_count, default=100, metavar="N", help="number of objects (default 100)")
    parser.add_argument("--start", type=read_index, default=0, metavar="I", help="first object (default 0)")
    parser.add_argument(
        "--forced", type=_share, default=0.5, metavar="SHARE",
        help="part of the objects with which a refused strategy is tried (default 0.5)",
    )  # fmt: skip
    parser.add_argument(
        "--workers",
        type=read_count,
        default=os.cpu_count() or 1,
        metavar="N",
        help="processes (default: one a core)",
    )
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="rows and summary are written there")
    return parser.parse_args(argv)


def read_count(text: str) -> int:
    """A number of things or processes, as an argument's type."""
    if not text.isdecimal() or not 1 <= int(text) <= 100_000:
        raise argparse.ArgumentTypeError(f"{text!r} given; allowed: a whole number from 1 to 100000")
    return int(text)


def read_index(text: str) -> int:
    """The number of a drawn object, as an argument's type."""
    if not text.isdecimal() or int(text) >= 2**31:
        raise argparse.ArgumentTypeError(f"{text!r} given; allowed: a whole number from 0 to {2**31 - 1}")
    return int(text)


def _share(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 <= value <= 1.0:
        raise argparse.ArgumentTypeError(f"{text!r} given; allowed: a number from 0 to 1")
    return value


if __name__ == "__main__":
    sys.exit(main())
