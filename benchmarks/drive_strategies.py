"""The nine strategies, unchanged, on the twin and on the ideal machine: which succeed, and why the others do not.

Claim (docs/validation/drive.md): a strategy that succeeds on `SimPlant` succeeds behind motors, bus and driver, without
a false alarm. The table goes on where it was interrupted: ``--out`` holds a line of JSON for each trial.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

from spiraltrunk import strategies
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import SpiralTrunkError
from spiraltrunk.sim.objects.catalogue import ObjectSpec, parse_object
from spiraltrunk.workflows.drive.trial import run_on_twin
from spiraltrunk.workflows.grasp.trial import run_trial

PLANTS = ("twin", "ideal")


def run_one(name: str, seed: int, plant: str) -> dict[str, Any]:
    """One trial as a row; what the package raises on purpose is a failure, not the end of the table."""
    shape, began = parse_object(strategies.get(name).objects[0]), time.perf_counter()
    try:
        outcome = _run_on_twin(shape, name, seed) if plant == "twin" else _run_ideal(shape, name, seed)
    except SpiralTrunkError as error:
        outcome = {"success": False, "reason": f"{type(error).__name__}: {error}", "faults": []}
    row = {"strategy": name, "seed": seed, "plant": plant} | outcome
    return row | {"wall_s": round(time.perf_counter() - began, 1)}


def _run_on_twin(shape: ObjectSpec, name: str, seed: int) -> dict[str, Any]:
    done = run_on_twin(PAPER, shape, strategy=name, seed=seed)
    verdict = done.trial.verdict
    faults = [f"{fault.kind.value}: {fault.text}" for fault in done.snapshot.faults]
    return {"success": verdict.success, "reason": verdict.reason, "faults": faults}


def _run_ideal(shape: ObjectSpec, name: str, seed: int) -> dict[str, Any]:
    verdict = run_trial(PAPER, shape, strategy=name, seed=seed).verdict
    return {"success": verdict.success, "reason": verdict.reason, "faults": []}


def read_rows(path: Path | None) -> list[dict[str, Any]]:
    """Rows of an earlier run; a last line that was cut off is left out."""
    if path is None or not path.exists():
        return []
    lines = path.read_text(encoding="utf-8").split("\n")
    return [json.loads(line) for line in lines[:-1] if line]


def run_all(
    names: Sequence[str], seeds: Sequence[int], done: Sequence[dict[str, Any]], plants: Sequence[str] = PLANTS
) -> Iterator[dict[str, Any]]:
    """Rows that are missing, seed by seed."""
    known = {(row["strategy"], row["seed"], row["plant"]) for row in done}
    for seed in seeds:
        for name in names:
            for plant in plants:
                if (name, seed, plant) not in known:
                    yield run_one(name, seed, plant)


def format_table(rows: Sequence[dict[str, Any]]) -> str:
    """Successes of each strategy on both plants, and every failure with its cause."""
    lines = [f"{'strategy':18}{'twin':>8}{'ideal':>8}{'false alarms':>14}"]
    for name in dict.fromkeys(row["strategy"] for row in rows):
        own = [row for row in rows if row["strategy"] == name]
        counts = [_count(own, plant) for plant in PLANTS]
        lines.append(f"{name:18}{counts[0]:>8}{counts[1]:>8}{sum(bool(row['faults']) for row in own):>14}")
    for row in rows:
        if not row["success"]:
            lines.append(f"{row['strategy']} seed {row['seed']} on the {row['plant']}: {row['reason']}")
    return "\n".join(lines)


def _count(rows: Sequence[dict[str, Any]], plant: str) -> str:
    outcomes = [row["success"] for row in rows if row["plant"] == plant]
    return f"{sum(outcomes)}/{len(outcomes)}"


def main(argv: Sequence[str] | None = None) -> int:
    """Run what is missing, and print the table; 1 where the twin fails and the ideal machine does not."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0], allow_abbrev=False)
    parser.add_argument("strategies", nargs="*", metavar="STRATEGY", help="strategies (default: all)")
    parser.add_argument("--seeds", type=int, default=3, metavar="N", help="seeds from 0 (default 3)")
    parser.add_argument("--plants", nargs="+", choices=PLANTS, default=PLANTS, help="plants (default: both)")
    parser.add_argument("--out", type=Path, metavar="FILE", help="JSON lines, appended; rows in it are not run again")
    arguments = parser.parse_args(argv)
    names = arguments.strategies or strategies.NAMES
    rows = read_rows(arguments.out)
    for row in run_all(names, range(arguments.seeds), rows, arguments.plants):
        rows.append(row)
        print(f"{row['strategy']} {row['seed']} {row['plant']}: {row['reason']}", file=sys.stderr, flush=True)
        if arguments.out is not None:
            with arguments.out.open("a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
    print(format_table(rows))
    won = {(row["strategy"], row["seed"], row["plant"]) for row in rows if row["success"]}
    return int(any((name, seed, "twin") not in won for name, seed, plant in won if plant == "ideal"))


if __name__ == "__main__":
    sys.exit(main())
