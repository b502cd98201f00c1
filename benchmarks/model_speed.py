"""What a shape costs: single calls, and 100,000 bendings on one core against what arithmetic and memory allow.

Wall times are the least of many turns taken one after the other, so that all see the same load, which is told beside
them.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from spiraltrunk.design import presets
from spiraltrunk.files.atomic import atomic_file
from spiraltrunk.model import reference, statics
from spiraltrunk.model.reference.constants import prepare
from spiraltrunk.model.reference.planar_batch import build_workspace, solve_points
from spiraltrunk.workflows.bench.bending import COUNT, MOST, PULL, TILT, NumpyBending
from spiraltrunk.workflows.bench.claim import one_core, time_in_turns
from spiraltrunk.workflows.bench.rest import rest_in_turn

PAPER = presets.PAPER

QUASI_STATIC = statics.StaticsOptions(quasi_static=statics.QuasiStatic())

GOAL = 5e6
"""Shapes that one core should bend in a second [1/s]."""

OPERATIONS = 60 * PAPER.n_joint
"""Additions, multiplications, divisions and roots of one bending, counted in the source of `reference_lean` [-]."""

WRITTEN = 8 * (2 * PAPER.n_section + PAPER.n_joint)
"""What one bending fills: section ends in x and y, as memory comes with z = 0, and bends [B]."""


def time_single() -> dict[str, float]:
    """Wall time of single calls, the last one not ours [us]."""
    slack = np.array([False, True, True])
    law = NumpyBending(TILT)
    calls = {
        "reference.rest": rest_in_turn(),
        "reference.bend_dorsal": lambda: reference.bend_dorsal(PAPER, PULL, TILT),
        "reference.bend_ventral": lambda: reference.bend_ventral(PAPER, PULL, TILT),
        "reference.twist": lambda: reference.twist(PAPER, PULL, 0.03, TILT),
        "statics.solve, rest": lambda: statics.solve(PAPER, theta_0=TILT, friction=0.0),
        "statics.solve, one cable": lambda: statics.solve(
            PAPER, pull=[PULL, 0.0, 0.0], by_tension=slack, theta_0=TILT, friction=0.0
        ),
        "the same, quasi-statically, with friction": lambda: statics.solve(
            PAPER, pull=[PULL, 0.0, 0.0], by_tension=slack, theta_0=TILT, friction=0.15, options=QUASI_STATIC
        ),
        "one bending in NumPy": lambda: law.bend_one(PULL),
    }
    return {name: time * 1e6 for name, time in zip(calls, time_in_turns(*calls.values()), strict=True)}


def time_batch() -> dict[str, float]:
    """Bendings of one core, and its floors [1/s]."""
    pulls = np.random.default_rng(0).uniform(0.0, MOST, COUNT)
    asked = pulls, np.array([TILT]), build_workspace(PAPER.n_joint)
    ends, bend = np.zeros((3, PAPER.n_section, COUNT)), np.empty((PAPER.n_joint, COUNT))
    own = reference.bend_dorsal_points(PAPER, pulls, TILT)
    constants, law, block = prepare(PAPER).constants, NumpyBending(TILT), np.empty(COUNT * WRITTEN // 8)
    calls = {
        "laws alone": lambda: solve_points(asked, constants, ends, bend, (0, COUNT)),
        "bend_dorsal_points": lambda: reference.bend_dorsal_points(PAPER, pulls, TILT),
        "the same, out given": lambda: reference.bend_dorsal_points(PAPER, pulls, TILT, out=own),
        "bend_dorsal, whole shapes": lambda: reference.bend_dorsal(PAPER, pulls, TILT),
        "NumPy over arrays": lambda: law.bend(pulls, ends),
        "floor: memory written": lambda: block.fill(1.0),
        "floor: new memory written": lambda: np.empty_like(block).fill(1.0),
    }
    with one_core():
        times = time_in_turns(*calls.values())
    return {name: COUNT / time for name, time in zip(calls, times, strict=True)}


def measure() -> dict[str, dict[str, float]]:
    """All figures."""
    single, batch = time_single(), time_batch()
    alone = batch["laws alone"]
    return {
        "single_us": single,
        "batch_per_s": batch,
        "floors": {
            "bytes_written_per_shape": WRITTEN,
            "memory_gb_per_s": batch["floor: memory written"] * WRITTEN * 1e-9,
            "part_of_memory_floor": alone / batch["floor: memory written"],
            "operations_per_shape": OPERATIONS,
            "gflop_per_s": alone * OPERATIONS * 1e-9,
            "part_of_goal": alone / GOAL,
        },
        "load": {"average_1_min": os.getloadavg()[0], "cores": float(os.cpu_count() or 1)},
    }


def format_figures(figures: dict[str, dict[str, float]]) -> str:
    """The figures as text."""
    lines = ["single calls [us]"]
    lines += [f"  {name:<34}{value:10.1f}" for name, value in figures["single_us"].items()]
    lines += [f"{COUNT} bendings on one core [million shapes/s]"]
    lines += [f"  {name:<34}{value * 1e-6:10.2f}" for name, value in figures["batch_per_s"].items()]
    floors, load = figures["floors"], figures["load"]
    return "\n".join(
        [
            *lines,
            f"  a shape is {OPERATIONS} operations ({floors['gflop_per_s']:.1f} Gflop/s) and {WRITTEN} B written, "
            f"{100 * floors['part_of_memory_floor']:.0f} % of what memory takes ({floors['memory_gb_per_s']:.0f} GB/s)",
            f"  {100 * floors['part_of_goal']:.0f} % of {GOAL * 1e-6:g} million a second",
            f"load average {load['average_1_min']:.1f} on {load['cores']:.0f} cores",
        ]
    )


def main(argv: Sequence[str] | None = None) -> int:
    """Measure, print, and write model_speed.json where asked to."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0], allow_abbrev=False)
    parser.add_argument("--out", type=Path, metavar="DIR", help="write model_speed.json there")
    arguments = parser.parse_args(argv)
    figures = measure()
    if arguments.out is not None:
        with atomic_file(arguments.out / "model_speed.json") as draft:
            draft.write_text(json.dumps(figures, indent=2) + "\n")
    print(format_figures(figures))
    return 0


if __name__ == "__main__":
    sys.exit(main())
