"""Rates with everyday things, in classes: held, and set down upright, by the full verdict.

``upright`` things are taken by ``auto`` with the paper's trunk, ``compact`` ones by ``tip-grip`` and ``lying``
ones by ``pinch`` with larger fingers. Objects are drawn from the generator of everyday shapes, worlds with the full
`Spread`. Seeds from 1000 on are for figures, which are looked at once; the plans were made with seeds below 100. Each
row is written as its trial ends, with a digest of the code: the same command with the same code goes on where it was
interrupted. Exits with 1 where a rate is below its bar, and with 130 when interrupted.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from spiraltrunk.control.loop import RunLog
from spiraltrunk.design import load_design
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import SpiralTrunkError
from spiraltrunk.sim.objects.catalogue import ObjectSpec
from spiraltrunk.sim.objects.everyday import draw_everyday
from spiraltrunk.sim.objects.presentation import take_pose
from spiraltrunk.workflows.grasp.choice.last_try import list_attempts
from spiraltrunk.workflows.grasp.trial import run_trial
from spiraltrunk.workflows.grasp.verdict.cause import Cause
from spiraltrunk.workflows.survey.code_version import compute_source
from spiraltrunk.workflows.survey.summary import wilson

SLENDER = ("cylinder", "box", "superquadric")
"""Shapes of things that lie: those that do not roll round in a circle, as cones do."""

Draw = Callable[[int], tuple[str, ObjectSpec]]


@final
@dataclass(frozen=True, kw_only=True)
class ObjectClass:
    """A class of things, how they are taken, and the rates asked for."""

    draw: Draw
    """Name and shape of the thing of a seed."""
    strategy: str
    """Strategy, or "auto"."""
    design: str
    """Preset of the trunk."""
    bars: dict[str, float]
    """Least parts of the trials [-], by the rows' entry."""


def draw_upright(seed: int) -> tuple[str, ObjectSpec]:
    """A thing that stands, 40 to 80 mm wide without its handle, 80 to 240 mm tall, up to 400 g."""
    drawn = draw_everyday(_generator(seed), width=(0.040, 0.080), height=(0.080, 0.240), mass=(0.020, 0.400))
    return drawn.name, drawn.shape


def draw_compact(seed: int) -> tuple[str, ObjectSpec]:
    """A compact solid, 25 to 70 mm wide without its handle."""
    drawn = draw_everyday(_generator(seed), width=(0.025, 0.070), height=(0.030, 0.100), mass=(0.050, 0.250))
    return drawn.name, drawn.shape


def draw_lying(seed: int) -> tuple[str, ObjectSpec]:
    """A slender thing that lies, 15 to 45 mm wide; the height of what is drawn is its length."""
    kind = SLENDER[seed % len(SLENDER)]
    drawn = draw_everyday(_generator(seed), kind=kind, width=(0.015, 0.045), height=(0.080, 0.160), mass=(0.050, 0.250))
    return drawn.name, take_pose(drawn.shape, "lying")


def _generator(seed: int) -> np.random.Generator:
    return np.random.default_rng([23, seed])


CLASSES = {
    "upright": ObjectClass(draw=draw_upright, strategy="auto", design="paper", bars={"held": 0.90, "upright": 0.80}),
    "compact": ObjectClass(
        draw=draw_compact, strategy="tip-grip", design="paper-large-grip", bars={"success": 0.90}
    ),
    "lying": ObjectClass(draw=draw_lying, strategy="pinch", design="paper-large-grip", bars={"success": 0.80}),
}  # fmt: skip
"""Classes of things; the bars hold for the trials that are not refused."""


def run_seed(name: str, seed: int, design: TrunkDesign) -> dict[str, Any]:
    """One trial as a row; what the package refuses or raises is told as its reason."""
    kind = CLASSES[name]
    thing, shape = kind.draw(seed)
    size = [round(1e3 * extent) for extent in shape.size]
    row: dict[str, Any] = {
        "part": name, "seed": seed, "name": thing, "size_mm": size, "mass_g": round(1e3 * shape.mass),
        "success": False, "held": False, "upright": False, "refused": False, "cause": None, "tries": [],
    }  # fmt: skip
    began = time.perf_counter()
    try:
        trial = run_trial(design, shape, strategy=kind.strategy, seed=seed)
    except SpiralTrunkError as error:
        return row | {"refused": True, "reason": str(error)}
    verdict, failure = trial.verdict, trial.verdict.failure
    attempts = list_attempts(trial.log)
    return row | {
        "success": bool(verdict.success), "held": bool(verdict.is_held), "upright": bool(verdict.is_upright),
        "cause": None if failure is None else failure.cause.value, "reason": verdict.reason,
        "refused": failure is not None and failure.cause is Cause.REFUSED,
        "tries": [each.strategy for each in attempts] or [kind.strategy],
        "outcomes": [each.outcome for each in attempts],
        "lost_s": None if failure is None or math.isinf(failure.time) else round(failure.time, 2),
        "lost_in": None if failure is None else _action_at(trial.log, failure.time),
        "friction": round(trial.options.shape.friction, 2), "ground_m": trial.options.ground,
        "simulated_s": round(float(trial.plant.trace[-1].time), 2), "wall_s": round(time.perf_counter() - began),
    }  # fmt: skip


def _action_at(log: RunLog, time: float) -> str:
    """Action of the strategy at a time [s]."""
    seen = [status.action for seen, status in zip(log.observations, log.statuses, strict=False) if seen.time <= time]
    return seen[-1] if seen else ""


def summarize(name: str, rows: Sequence[dict[str, Any]]) -> tuple[str, bool]:
    """Rates with their intervals, one a line, and whether none is below its bar."""
    tried = [row for row in rows if not row["refused"]]
    lines, holds = [], bool(tried)
    for entry in ("success", "held", "upright"):
        count, bar = sum(row[entry] for row in tried), CLASSES[name].bars.get(entry)
        asked = "" if bar is None else f"; asked for: {100 * bar:.0f} %"
        lines.append(f"{name}, {entry}: {_format_rate(count, len(tried))}{asked}")
        holds = holds and (bar is None or count >= bar * len(tried))
    refused = len(rows) - len(tried)
    if refused:
        count = sum(row["success"] for row in rows)
        lines.append(f"{name}, success with the refused as failures: {_format_rate(count, len(rows))}")
    return "\n".join([*lines, f"{name}: {refused} refused"]), holds


def _format_rate(count: int, trials: int) -> str:
    low, high = wilson(count, trials)
    return f"{count} of {trials} ({100 * low:.0f} to {100 * high:.0f} % at 95 %)"


def main(argv: Sequence[str] | None = None) -> int:
    """Run what is missing, tell each row, and return the exit code."""
    arguments = _parse(argv)
    kind = CLASSES[arguments.part]
    name = arguments.design or kind.design
    key = {"design": name, "source": compute_source()}
    seeds = range(arguments.first_seed, arguments.first_seed + arguments.trials)
    rows = _load_rows(arguments.out, {"part": arguments.part, **key}, seeds)
    design, is_interrupted = load_design(name), False
    try:
        for seed in sorted(set(seeds) - {row["seed"] for row in rows}):
            rows.append(run_seed(arguments.part, seed, design) | key)
            _append(arguments.out, json.dumps(rows[-1]))
    except KeyboardInterrupt:
        is_interrupted = True
    text, holds = summarize(arguments.part, rows)
    print(text, flush=True)
    return 130 if is_interrupted else int(not holds)


def _load_rows(path: Path | None, key: dict[str, str], seeds: range) -> list[dict[str, Any]]:
    """Rows of earlier runs of the same code with these seeds; a line that was cut short is dropped from the file."""
    if path is None or not path.exists():
        return []
    whole = path.read_text()
    kept = whole[: whole.rfind("\n") + 1]
    if kept != whole:
        draft = path.with_name(f".{path.name}.{os.getpid()}")
        draft.write_text(kept)
        draft.replace(path)
    rows = [json.loads(line) for line in kept.splitlines()]
    return [row for row in rows if row["seed"] in seeds and all(row[entry] == key[entry] for entry in key)]


def _append(path: Path | None, line: str) -> None:
    print(line, flush=True)
    if path is not None:
        with path.open("a") as file:
            file.write(line + "\n")


def _parse(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0], allow_abbrev=False)
    parser.add_argument("--part", choices=sorted(CLASSES), required=True, help="class of things")
    parser.add_argument("--trials", type=_count, default=30, metavar="N", help="number of trials (default 30)")
    parser.add_argument(
        "--first-seed", type=_count, default=1000, metavar="I", help="seed of the first trial (default 1000)"
    )
    parser.add_argument("--design", help="the robot (default: the class's)")
    parser.add_argument("--out", type=Path, metavar="FILE", help="JSON lines, one a trial, to go on from")
    return parser.parse_args(argv)


def _count(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 10**6:
        raise argparse.ArgumentTypeError(f"{text!r} given; allowed: a whole number from 1 to 1000000")
    return int(text)


if __name__ == "__main__":
    sys.exit(main())
