"""Runs the nine strategies on other robots than the one they are tuned for: trials of validation/robustness.md.

Each condition changes one thing of the preset ``paper``: friction between cables and holes, the overlap ratio m, the
radius of the arm's last link, or the angle of a section. The worlds of a condition are drawn as a survey draws them
(`spiraltrunk survey --design FILE --friction MU --seed SEED`), from the same seeds in all conditions. Each trial's row
is appended to ``trials.jsonl`` in ``--out`` as it ends; a run that was interrupted goes on where it ended, and more
``--trials`` continue a finished one. Rows keep the digest of the code that they were run with.
`make_robustness.py` puts the counts into the pages.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from spiraltrunk import strategies
from spiraltrunk.design import presets
from spiraltrunk.design.rules import design_from_rules
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.processes.pool import run_jobs
from spiraltrunk.workflows.survey.code_version import compute_source
from spiraltrunk.workflows.survey.plan import Entry, derive_seed
from spiraltrunk.workflows.survey.row import Row, build_empty_row
from spiraltrunk.workflows.survey.run_entry import compute_row

SEED = 23
"""Seed that the seeds of all trials are derived from; no strategy was tuned in its worlds before they were counted."""

SURVEY_SEEDS = {
    "friction 0.15": 8217, "m 1.45": 8214, "m 1.7": 8214, "arm radius 36 mm": 8214, "arm radius 55 mm": 8214,
    "sections of 20 deg": 8218,
}  # fmt: skip
"""Seeds of the trials that stand in the page (`--seed`, or a survey's by `make_robustness.py --survey`)."""

RECOUNTED = ("wrap-vertical", "wrap-oblique-low", "wrap-oblique", "wrap-horizontal", "sweep")
"""Strategies that were counted again in all conditions, since they had changed."""

FINGERS = ("pinch", "tip-grip", "flip-grip")
"""Strategies that hold with the fingers, whose friction no longer creeps."""

RADII = ("arm radius 36 mm", "arm radius 55 mm")
"""Conditions that change the radius of the arm's last link."""

TRUNKS = ("m 1.45", "m 1.7", "sections of 20 deg")
"""The other conditions that change the trunk."""

LATER_SEEDS = {
    ("friction 0.15", "wrap-vertical"): 8228,
    **{("friction 0.15", name): 8233 for name in RECOUNTED[1:4]},
    **{(radius, name): 8229 for radius in RADII for name in RECOUNTED[1:]},
    **{(radius, "wrap-vertical"): 8230 for radius in RADII},
    **{(RADII[1], name): 8235 for name in RECOUNTED},
    **{(trunk, name): 8231 for trunk in TRUNKS for name in ("wrap-vertical", "sweep")},
    **{(trunk, name): 8234 for trunk in TRUNKS for name in RECOUNTED[1:4]},
    **{("friction 0.15", name): 8237 for name in (*FINGERS, "sweep")},
    **{(radius, name): 8238 for radius in RADII for name in FINGERS},
    **{(radius, "kick"): 8239 for radius in RADII},
    (RADII[0], "sweep"): 8239,
}
"""Seeds of the conditions and strategies that were counted again."""

FRICTION = 0.15
"""Coefficient of friction between cables and holes, as a print may have it [-]."""

CONDITIONS: dict[str, TrunkDesign] = {
    "friction 0.15": replace(presets.PAPER, cable=replace(presets.PAPER.cable, friction=FRICTION)),
    "m 1.45": design_from_rules(m=1.45),
    "m 1.7": design_from_rules(m=1.7),
    "arm radius 36 mm": design_from_rules(arm_radius=0.036),
    "arm radius 55 mm": design_from_rules(arm_radius=0.055),
    "sections of 20 deg": design_from_rules(delta_theta=math.radians(20.0)),
    "paper": presets.PAPER,
}
"""Robot of each condition; one thing differs from the preset ``paper``, which is the last."""


def find_seed(condition: str, strategy: str) -> int:
    """Seed of the trials of a condition and strategy that stand in the page."""
    return LATER_SEEDS.get((condition, strategy), SURVEY_SEEDS.get(condition, SEED))


Job = tuple[str, Entry]
"""Condition and trial."""


def main() -> int:
    """Run the trials that are not there yet."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("out/robustness"), help="folder of trials.jsonl")
    parser.add_argument("--trials", type=int, default=5, help="trials of each strategy in each condition")
    parser.add_argument("--seed", type=int, default=SEED, help="seed of all trials")
    parser.add_argument("--conditions", nargs="+", choices=CONDITIONS, default=list(CONDITIONS), metavar="NAME")
    parser.add_argument("--strategies", nargs="+", choices=strategies.NAMES, default=strategies.NAMES, metavar="NAME")
    parser.add_argument("--workers", type=int, default=1, help="processes that share the trials")
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    path = asked.out / "trials.jsonl"
    done = {(row["condition"], row["strategy"], row["seed"]) for row in load_rows(path)}
    jobs = [
        (condition, entry)
        for condition, entry in list_jobs(asked.conditions, asked.strategies, asked.trials, asked.seed)
        if (condition, entry.strategy, entry.seed) not in done
    ]
    with path.open("a") as log, closing(run_jobs(partial(run_job), jobs, asked.workers)) as outcomes:
        for outcome in outcomes:
            condition, entry = outcome.job
            row = outcome.result or build_empty_row(entry, outcome.fault or "")
            log.write(json.dumps({"condition": condition, "source": compute_source(), **row}) + "\n")
            log.flush()
            told = "success" if row["success"] else row["reason"][:100]
            print(f"{condition}, {entry.strategy}, {entry.object}, seed {entry.seed}: {told}", flush=True)
    return 0


def list_jobs(conditions: Sequence[str], names: Sequence[str], trials: int, seed: int) -> Iterator[Job]:
    """The first trial of every strategy in every condition, then the second, and so on."""
    objects = {name: strategies.get(name).objects for name in names}
    for index in range(trials):
        for name in names:
            for condition in conditions:
                each = objects[name][index % len(objects[name])]
                yield condition, Entry(strategy=name, object=each, index=index, seed=derive_seed(seed, name, index))


def run_job(job: Job) -> Row:
    """One trial as a survey's row."""
    condition, entry = job
    return compute_row(entry, CONDITIONS[condition])


def load_rows(path: Path) -> list[dict[str, Any]]:
    """Rows that were logged; a last line that was cut off is left out."""
    if not path.exists():
        return []
    return [json.loads(line) for line in path.read_text().splitlines(keepends=True) if line.endswith("\n")]


if __name__ == "__main__":
    sys.exit(main())
