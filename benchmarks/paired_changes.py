"""What a change of the strategies gains and loses: the same drawn things tried with it and without it.

Things (`spiraltrunk.sim.objects.everyday`) of one set are tried by ``auto`` in the same world, once for each variant.
A variant gives constants or functions of the package other values. The sets:

- ``light``: 90 mm tall or more, toppling at 0.035 to 0.2 N, which a wrap takes first;
- ``slender``: taller than 70 mm and up to 36 mm wide on one side, which fingers take first;
- ``low-wide`` and ``tall-wide``: more than 99 mm wide from above, lower or taller than 1.15 times that, and no limit of
  the height over that width but 1;
- ``near-fingers``: wider than what fingers hold, by up to 4 mm on the shorter side or as wide as they open, tried by
  `tip-grip` all the same;
- ``heavy``: too heavy for `wrap-oblique-low` by up to 40 % of what it holds, tried by it all the same.

Every row is kept as it ends, so that the same command goes on after an interruption.

    python benchmarks/paired_changes.py --set light --out out/light
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

from auto_choice import draw_object, read_count, read_index, try_object
from scipy.stats import binomtest

from spiraltrunk.control.messages import Task
from spiraltrunk.control.strategy import Assessment
from spiraltrunk.design import graspable_range, presets
from spiraltrunk.files.atomic import write_text
from spiraltrunk.processes.pool import run_jobs
from spiraltrunk.sim.objects.catalogue import ObjectSpec, parse_object
from spiraltrunk.sim.objects.presentation import as_measured
from spiraltrunk.strategies import get
from spiraltrunk.strategies.assessment import assess as assess_task
from spiraltrunk.strategies.fingertip import assess as finger_assess
from spiraltrunk.strategies.fingertip import cycle, moves
from spiraltrunk.strategies.object_measures import height_of, widths_between
from spiraltrunk.strategies.wrap import assess, standing_plan
from spiraltrunk.strategies.wrap.standing_model import loop_band
from spiraltrunk.strategies.wrap.unsteady import push_that_topples
from spiraltrunk.workflows.grasp.choice import auto
from spiraltrunk.workflows.grasp.choice.ranking import announce_task, rank_object

WRAP, FINGERS = "wrap-oblique-low", "tip-grip"

Patch = tuple[Any, str, Any]
"""Module, name in it, and the value that it has in a variant."""

ANY_HEIGHT: Patch = (assess, "SQUAT_HEIGHT", 1.0)
"""Wraps take what is wide and as tall as that."""
WIDER = ((finger_assess, "SLAB", 1.0), (finger_assess, "HELD_OPENING", 1.0))
"""Fingers take what is as wide as they open, or whose shorter side is."""
LIGHT = 0.2
"""Push up to which what topples is light [N]."""
EXCESS = 0.4
"""Largest part of the mass that a wrap holds by which a thing is too heavy [-]."""


@dataclass(frozen=True)
class PairedSet:
    """Things that are tried, and how.

    Attributes:
        seeds: first and last seed that its figures in the documentation are of.
        find: whether a drawn thing is of the set.
        variants: constants and functions that each variant changes, by its name.
        strategy: which strategy tries it.
    """

    seeds: tuple[int, int]
    find: Callable[[ObjectSpec], bool]
    variants: dict[str, tuple[Patch, ...]]
    strategy: str = "auto"


def is_light(shape: ObjectSpec) -> bool:
    """Whether a thing topples at a light push, and a wrap takes it first."""
    target = find_task(shape, WRAP).target
    if not assess.TOUCH_FORCE < push_that_topples(target) < LIGHT or height_of(target) < 0.09:
        return False
    return find_best(shape).startswith("wrap")


def is_slender(shape: ObjectSpec) -> bool:
    """Whether a thing is tall, thin on one side, and fingers take it first."""
    target = find_task(shape, FINGERS).target
    if height_of(target) < 0.07 or widths_between(target, *loop_band(target))[0] > 0.036:
        return False
    return find_best(shape) in {"tip-grip", "pinch", "flip-grip"}


def is_wide(shape: ObjectSpec, *, is_low: bool) -> bool:
    """Whether a thing is wide from above, low or tall for that width, and a wrap takes it first without that limit."""
    target = find_task(shape, WRAP).target
    most = widths_between(target, *loop_band(target))[1]
    if most <= assess.SQUAT * graspable_range(presets.PAPER)[1]:
        return False
    if (height_of(target) < assess.SQUAT_HEIGHT * most) is not is_low:
        return False
    with patched((ANY_HEIGHT,)):
        return find_best(shape).startswith("wrap")


def is_near_fingers(shape: ObjectSpec) -> bool:
    """Whether fingers refuse a thing for its width alone, and by little: `WIDER`."""
    if assess_thing(shape, FINGERS).feasible:
        return False
    with patched(WIDER):
        return assess_thing(shape, FINGERS).feasible


def is_heavy(shape: ObjectSpec) -> bool:
    """Whether a wrap refuses a thing for its mass, and takes it where it has 1 / 1.4 of it."""
    if "too heavy" not in assess_thing(shape, WRAP).reason:
        return False
    return assess_thing(replace(shape, mass=shape.mass / (1.0 + EXCESS)), WRAP).feasible


def find_task(shape: ObjectSpec, strategy: str) -> Task:
    """The task with the thing as a strategy is told it."""
    return announce_task(presets.PAPER, as_measured(shape), get(strategy))


def assess_thing(shape: ObjectSpec, strategy: str) -> Assessment:
    """What a strategy's model says of a thing, whether the arm reaches it or not."""
    return assess_task(get(strategy), find_task(shape, strategy))


def find_best(shape: ObjectSpec) -> str:
    """Strategy that the choice takes first; empty where it refuses all."""
    best = rank_object(presets.PAPER, shape)[0]
    return best.strategy if best.feasible else ""


def _without(*_: object) -> None:
    """Correct no place."""


def _keep(sequence: Any, *_: object) -> Any:
    """Add no rest."""
    return sequence


BACK = (standing_plan, "OPENED_TAIL", 0.8)
NO_RESTS = (cycle, "rest_until_still", _keep)
SETS = {
    "light": PairedSet((12000, 12899), is_light, {
        "as it is": (), "place not corrected": ((auto, "correct_place", _without),),
        "and tail lifted by half": ((auto, "correct_place", _without), BACK),
        "tail not lifted": ((standing_plan, "OPENED_TAIL", 0.0),),
        "tail lifted more": ((standing_plan, "OPENED_TAIL", 5.0),),
    }),
    "slender": PairedSet((12000, 12441), is_slender, {
        "as it is": (), "no rests": (NO_RESTS,), "and no rise": (NO_RESTS, (moves, "EASE", 0.0)),
    }),
    "low-wide": PairedSet((11000, 13139), partial(is_wide, is_low=True), {"tried": (ANY_HEIGHT,)}),
    "tall-wide": PairedSet((11000, 12135), partial(is_wide, is_low=False), {"as it is": ()}),
    "near-fingers": PairedSet((11000, 13131), is_near_fingers, {"forced": ()}, FINGERS),
    "heavy": PairedSet((11000, 13731), is_heavy, {"forced": ()}, WRAP),
}  # fmt: skip


@contextmanager
def patched(patches: Sequence[Patch]) -> Iterator[None]:
    """The package with a variant's values, which it has no longer afterwards."""
    before = [getattr(module, name) for module, name, _ in patches]
    try:
        for module, name, value in patches:
            setattr(module, name, value)
        yield
    finally:
        for (module, name, _), value in zip(patches, before, strict=True):
            setattr(module, name, value)


def run_seed(seed: int, *, name: str) -> dict[str, Any] | None:
    """A thing's trials of all variants as a row; None of what is not of the set."""
    own, text = SETS[name], draw_object(seed)
    shape = parse_object(text)
    if not own.find(shape):
        return None
    row: dict[str, Any] = {"seed": seed, "object": text, "scores": {}}
    for variant, patches in own.variants.items():
        with patched(patches):
            best = rank_object(presets.PAPER, shape)[0]
            row["scores"][variant] = best.score if best.feasible else 0.0
            row[variant] = try_object(own.strategy, shape, seed)
    return row


def summarize(rows: Sequence[dict[str, Any]], variants: Sequence[str]) -> str:
    """Successes of each variant, and what the first one gains and loses against each other."""
    lines, first = [], variants[0]
    for variant in variants:
        good, held = (sum(row[variant][key] for row in rows) for key in ("success", "held"))
        expected = sum(row["scores"][variant] for row in rows)
        line = f"{variant}: {good} of {len(rows)} succeed, {held} held; the scores add up to {expected:.1f}"
        if variant != first:
            gained = sum(row[first]["success"] and not row[variant]["success"] for row in rows)
            lost = sum(row[variant]["success"] and not row[first]["success"] for row in rows)
            chance = binomtest(lost, gained + lost).pvalue if gained + lost else 1.0
            line += f"; {first!r} gains {gained} and loses {lost} (exact test of pairs: p = {chance:.2g})"
        lines.append(line)
    return "\n".join(lines)


def main(argv: Sequence[str] | None = None) -> int:
    """Try what is missing, and print the successes of each variant."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0], allow_abbrev=False)
    parser.add_argument("--set", required=True, choices=sorted(SETS), help="things that are tried")
    parser.add_argument("--start", type=read_index, metavar="SEED", help="first seed (default: as documented)")
    parser.add_argument("--objects", type=read_count, metavar="N", help="seeds (default: as documented)")
    parser.add_argument("--workers", type=read_count, default=os.cpu_count() or 1, metavar="N", help="processes")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder of the rows")
    given = parser.parse_args(argv)
    own = SETS[given.set]
    start = own.seeds[0] if given.start is None else given.start
    seeds = range(start, start + given.objects) if given.objects else range(start, own.seeds[1] + 1)
    given.out.mkdir(parents=True, exist_ok=True)
    log = given.out / f"{given.set}.jsonl"
    lines = log.read_text().splitlines(keepends=True) if log.exists() else []
    rows = [json.loads(line) for line in lines if line.endswith("\n")]
    write_text(log, "".join(json.dumps(row) + "\n" for row in rows))  # Without a line that was cut off.
    left = sorted(set(seeds) - {row["seed"] for row in rows})
    with log.open("a") as file, closing(run_jobs(partial(run_seed, name=given.set), left, given.workers)) as outcomes:
        for outcome in outcomes:
            if outcome.fault:
                raise RuntimeError(f"seed {outcome.job}: {outcome.fault}")
            row = outcome.result or {"seed": outcome.job}
            rows.append(row)
            file.write(json.dumps(row) + "\n")
            file.flush()
            if outcome.result:
                told = ", ".join(f"{each}: {row[each]['reason']}" for each in own.variants)
                print(f"{len(rows)}/{len(seeds)} {row['object']}, {told}", file=sys.stderr, flush=True)
    found = [row for row in rows if "object" in row and row["seed"] in seeds]
    print(summarize(found, list(own.variants)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
