"""What recording a trial costs over the trial alone, without and with a camera.

Claim: at most 1.15 times the trial without pictures (50 frames per second), at most twice the trial with one camera of
96 by 96 pixels at 10 frames per second. Processor time is measured, so that other programs on the core do not count;
each figure is the ratio of sums over the same trials, in one process, after one trial that compiles what is compiled.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

os.environ.setdefault("MUJOCO_GL", "egl")

from spiraltrunk.design.presets import PAPER
from spiraltrunk.workflows.demos.options import PICTURE_RATE, RecordingOptions
from spiraltrunk.workflows.demos.recording.run_entry import record_entry
from spiraltrunk.workflows.grasp.choice.auto import list_objects
from spiraltrunk.workflows.survey.plan import SurveyPlan
from spiraltrunk.workflows.survey.run_entry import compute_row

BARS = {"recorded": 1.15, "recorded with one camera": 2.0}
"""Largest ratios that are claimed [-]."""


def measure(work: Callable[[Any], Any], entries: tuple[Any, ...]) -> float:
    """Processor time of these trials [s]."""
    start = time.process_time()
    for entry in entries:
        work(entry)
    return time.process_time() - start


def run(strategy: str, trials: int, folder: Path) -> dict[str, Any]:
    """Run the trials in each of the three ways, and compare."""
    entries = SurveyPlan(objects={strategy: list_objects(strategy)}, trials=trials).entries()
    record = partial(record_entry, design=PAPER, folder=folder)
    ways: dict[str, Callable[[Any], Any]] = {
        "alone": compute_row,
        "recorded": partial(record, recording=RecordingOptions(keeps_failures=True)),
        "recorded with one camera": partial(
            record, recording=RecordingOptions(keeps_failures=True, cameras=("front",), fps=PICTURE_RATE)
        ),
    }
    measure(ways["recorded with one camera"], entries[:1])
    spent = {name: measure(work, entries) for name, work in ways.items()}
    ratios = {name: round(spent[name] / spent["alone"], 3) for name in BARS}
    size = sum(path.stat().st_size for path in folder.iterdir()) / len(entries)
    return {
        "strategy": strategy, "trials": trials, "cpu_s": {name: round(value, 2) for name, value in spent.items()},
        "ratios": ratios, "bars": BARS, "episode_with_camera_mb": round(size / 1e6, 2),
        "holds": all(ratios[name] <= bar for name, bar in BARS.items()),
    }  # fmt: skip


def main() -> int:
    """Print the figures; 1 where the claim does not hold."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--strategy", default="wrap-vertical", help="strategy of the trials")
    parser.add_argument("--trials", type=int, default=3, help="number of trials")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        figures = run(given.strategy, given.trials, Path(folder))
    print(json.dumps(figures))
    return 0 if figures["holds"] else 1


if __name__ == "__main__":
    sys.exit(main())
