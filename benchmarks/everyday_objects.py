"""Rates of the larger fingers: compact solids by ``tip-grip``, slender lying things by ``pinch``, full verdict.

Objects are drawn from the generator of everyday shapes, worlds with the full `Spread`. Seeds from 1000 on are for the
figures of the documentation, which are looked at once; the plans were made with seeds below 100. Exits with 1 where a
rate is below its bar, and with 130 when interrupted.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from typing import Any

import numpy as np

from spiraltrunk.design import load_design
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import SpiralTrunkError
from spiraltrunk.sim.objects.everyday import draw_everyday
from spiraltrunk.sim.objects.presentation import take_pose
from spiraltrunk.workflows.grasp.trial import run_trial
from spiraltrunk.workflows.survey.summary import wilson

BARS = {"compact": 0.90, "lying": 0.80}
"""Least part of the trials that must succeed, of those that are not refused [-]."""

COMPACT: dict[str, Any] = {"width": (0.025, 0.070), "height": (0.030, 0.100), "mass": (0.050, 0.250)}
"""Width, height [m] and mass [kg] of compact solids."""

LYING: dict[str, Any] = {"width": (0.015, 0.045), "height": (0.080, 0.160), "mass": (0.050, 0.250)}
"""The same of things that lie: height is their length."""

SLENDER = ("cylinder", "box", "superquadric")
"""Shapes of things that lie: those that do not roll round in a circle, as cones do."""


def run_seed(part: str, seed: int, design: TrunkDesign) -> dict[str, Any]:
    """One trial as a row; what the package refuses or raises is told as its reason."""
    rng = np.random.default_rng([23, seed])
    if part == "compact":
        drawn = draw_everyday(rng, **COMPACT)
        shape, strategy = drawn.shape, "tip-grip"
    else:
        drawn = draw_everyday(rng, kind=SLENDER[seed % len(SLENDER)], **LYING)
        shape, strategy = take_pose(drawn.shape, "lying"), "pinch"
    extents = ", ".join(f"{1e3 * extent:.0f}" for extent in shape.size)
    row = {"part": part, "seed": seed, "name": drawn.name, "size_mm": extents, "mass_g": round(1e3 * shape.mass)}
    began = time.perf_counter()
    try:
        trial = run_trial(design, shape, strategy=strategy, seed=seed)
    except SpiralTrunkError as error:
        return row | {"success": False, "refused": True, "reason": str(error)}
    row |= {"friction": round(trial.options.shape.friction, 2), "ground_m": trial.options.ground}
    verdict = trial.verdict
    row |= {"success": bool(verdict.success), "refused": False, "reason": verdict.reason}
    return row | {"wall_s": round(time.perf_counter() - began)}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--part", choices=sorted(BARS), required=True, help="what is gripped")
    parser.add_argument("--trials", type=int, default=30, help="number of trials (default 30)")
    parser.add_argument("--first-seed", type=int, default=1000, help="seed of the first trial (default 1000)")
    parser.add_argument("--design", default="paper-large-grip", help="the robot (default paper-large-grip)")
    arguments = parser.parse_args()
    design, rows = load_design(arguments.design), []
    try:
        for seed in range(arguments.first_seed, arguments.first_seed + arguments.trials):
            rows.append(run_seed(arguments.part, seed, design))
            print(json.dumps(rows[-1]), flush=True)
    except KeyboardInterrupt:
        return 130
    finally:
        tried = [row for row in rows if not row["refused"]]
        held = sum(row["success"] for row in tried)
        low, high = wilson(held, len(tried)) if tried else (0.0, 1.0)
        print(f"{held} of {len(tried)}, {low:.2f} to {high:.2f} at 95 %; {len(rows) - len(tried)} refused", flush=True)
    return int(not tried or held < BARS[arguments.part] * len(tried))


if __name__ == "__main__":
    sys.exit(main())
