"""In which cases one shape alone balances: the same tensions reached from the straight trunk and from another shape.

The trunk is drawn at any roll, without friction. The first kind hangs or lies, bears no load and has a slack cable;
that it has one shape is what the inverse model relies on. The others show where several shapes come from.
Exits with 1 where the first kind has two shapes.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
from collections.abc import Sequence
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from spiraltrunk.design import presets
from spiraltrunk.model import statics
from spiraltrunk.model.inverse.start_table import least_tension

APART = 1e-6
"""Distance of section ends beyond which two shapes differ [m]."""


class Kind(NamedTuple):
    """What is drawn."""

    is_up: bool
    """Whether the base axis points above the horizontal, else below."""
    is_slack: bool
    """Whether one cable pulls no more than `least_tension`."""
    mass: float
    """Largest load [kg]."""


KINDS = {
    "hangs or lies, a cable slack": Kind(False, True, 0.0),
    "stands up, a cable slack": Kind(True, True, 0.0),
    "hangs or lies, all cables pull": Kind(False, False, 0.0),
    "hangs or lies, a cable slack, loaded": Kind(False, True, 0.5),
}


def draw_tensions(name: str, kind: Kind, rng: np.random.Generator, count: int) -> np.ndarray:
    """Tensions even in their logarithm from 0.1 N to the largest, one of them slack if the kind says so [N]."""
    design = presets.get(name)
    tension = 10 ** rng.uniform(-1, math.log10(design.cable.tension_max), (count, design.n_cable))
    if kind.is_slack:
        cable = rng.integers(design.n_cable, size=count)
        tension[np.arange(count), cable] = rng.uniform(0.0, least_tension(design), count)
    return tension


def count_two(name: str, kind: Kind, count: int, seed: int) -> int:
    """Of ``count`` drawn tensions, those at which the trunk rests in two shapes by two ways."""
    design, rng = presets.get(name), np.random.default_rng([23, seed])
    low, high = (-math.pi / 2, 0.0) if kind.is_up else (0.0, math.pi / 2)
    stand = {
        "theta_0": rng.uniform(low, high, count), "roll": rng.uniform(-math.pi, math.pi, count), "friction": 0.0,
        "loads": statics.Loads(mass=rng.uniform(0, kind.mass, count)) if kind.mass else None,
    }  # fmt: skip
    before, tension = (draw_tensions(name, kind, rng, count) for _ in range(2))
    straight = statics.solve(design, tension=tension, **stand)
    other = statics.solve(design, tension=tension, start=statics.solve(design, tension=before, **stand), **stand)
    away = np.linalg.norm(straight.points - other.points, axis=-1).max(axis=-1)
    return int(np.count_nonzero(~(away <= APART)))


def main(argv: Sequence[str] | None = None) -> int:
    """Draw, count and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0], allow_abbrev=False)
    parser.add_argument("--trials", type=int, default=20_000, metavar="N", help="of each kind and preset")
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args(argv)
    if asked.trials < 1 or asked.seed < 0:
        parser.error("--trials must be at least 1 and --seed at least 0")
    failed = 0
    for text, kind in KINDS.items():
        for name in presets.NAMES:
            two = count_two(name, kind, asked.trials, asked.seed)
            print(f"{text}: {name}: {two} of {asked.trials} in two shapes", flush=True)
            failed += two if kind == next(iter(KINDS.values())) else 0
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
