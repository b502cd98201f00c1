"""Inverse of the tip position: ours against SciPy's least squares over the same equilibrium."""

from __future__ import annotations

from typing import NamedTuple, final

import numpy as np
from scipy.optimize import least_squares

from spiraltrunk.design import presets
from spiraltrunk.model import inverse, statics
from spiraltrunk.workflows.bench.claim import Claim, time_in_turns

COUNT = 200
"""Number of targets."""

TIMED = 31
"""Number of timed targets; the median ratio counts."""

MOST = 8.0
"""Largest tension of a target shape [N]."""

CLOSE = 1e-4
"""Largest distance from a reached target [m]."""


@final
class TipTarget(NamedTuple):
    """A reachable tip position."""

    tip: np.ndarray
    """Position, shape (3,) [m]."""
    tilt: float
    """Angle of the base axis below the horizontal [rad]."""


def draw_targets(count: int, seed: int = 0) -> list[TipTarget]:
    """Tips of equilibria under random tensions of one or two cables, from hanging to horizontal."""
    rng = np.random.default_rng(seed)
    n_cable, targets = presets.PAPER.n_cable, []
    for _ in range(count):
        tension = np.zeros(n_cable)
        pulled = rng.permutation(n_cable)[: rng.integers(1, 3)]
        tension[pulled] = rng.uniform(0.0, MOST, len(pulled))
        tilt = float(rng.uniform(0.0, np.pi / 2))
        shape = statics.solve(presets.PAPER, tension=tension, theta_0=tilt, friction=0.0)
        targets.append(TipTarget(shape.points[-1], tilt))
    return targets


def measure_inverse_least_squares() -> Claim:
    """Cables for a tip against ``scipy.optimize.least_squares`` over the tensions, with finite differences [s].

    The times are those of the target with the median ratio. SciPy starts once, from 1 N on every cable, whether it
    converges or not. The time of our first call at a tilt, which fills a cache, is not counted.
    """
    timed = sorted((time_target(target) for target in draw_targets(TIMED)), key=lambda pair: pair[1] / pair[0])
    ours, other = timed[len(timed) // 2]
    return Claim(ours=ours, other=other, bar=50.0)


def measure_inverse_success() -> Claim:
    """Share of the targets reached within 0.1 mm [-], against 99 %."""
    near = [
        float(inverse.solve(presets.PAPER, target.tip, theta_0=target.tilt).distance) <= CLOSE
        for target in draw_targets(COUNT, seed=1)
    ]
    return Claim(ours=0.99, other=sum(near) / len(near), bar=1.0)


def time_target(target: TipTarget) -> tuple[float, float]:
    """Wall time of our inverse and of SciPy's [s]."""
    ours, other = time_in_turns(
        lambda: inverse.solve(presets.PAPER, target.tip, theta_0=target.tilt),
        lambda: fit_tensions(target),
        turns=6,
        span=0.2,
    )
    return ours, other


def fit_tensions(target: TipTarget) -> np.ndarray:
    """Tensions for a tip by SciPy, shape (n_cable,) [N]."""
    n_cable, most = presets.PAPER.n_cable, presets.PAPER.cable.tension_max

    def miss(tension: np.ndarray) -> np.ndarray:
        shape = statics.solve(presets.PAPER, tension=tension, theta_0=target.tilt, friction=0.0)
        return shape.points[-1] - target.tip

    return np.asarray(least_squares(miss, np.ones(n_cable), bounds=(0.0, most), diff_step=1e-6).x)
