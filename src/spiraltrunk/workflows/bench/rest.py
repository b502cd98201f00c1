"""The trunk at rest under gravity: the paper's equations by our Newton, by SciPy, and by relaxation in MuJoCo."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
from scipy.optimize import fsolve

from spiraltrunk.design import presets
from spiraltrunk.model import reference
from spiraltrunk.model.reference.constants import prepare, read_table
from spiraltrunk.sim.relaxation.relax import RelaxationOptions, RelaxationRig
from spiraltrunk.workflows.bench.claim import Claim, time_in_turns

TILTS = (0.0, 0.4, 0.8, 1.2)
"""Angles of the base axis below the horizontal, used in turn so that results cannot be cached [rad]."""

TUNED = RelaxationOptions(timestep=8e-3, damping_factor=8.0, still=2e-3)
"""Options with which MuJoCo reaches its rest within 0.5 mm in the least wall time.

The best of a grid of steps (1 to 8 ms), damping (1 to 40 times the design's), armature (1 to 100 times) and speeds of
rest (0.001 to 0.1 rad/s).
"""


def measure_rest_mujoco() -> Claim:
    """A shape at rest against MuJoCo's trunk, reset and relaxed with tuned damping [s]."""
    rigs = [RelaxationRig(presets.PAPER, theta_0=tilt, options=TUNED) for tilt in TILTS]
    ours, other = time_in_turns(rest_in_turn(), in_turn([rig.relax for rig in rigs]), turns=4 * len(TILTS))
    return Claim(ours=ours, other=other, bar=50.0)


def measure_rest_fsolve() -> Claim:
    """A shape at rest against SciPy's ``fsolve`` on the same equations in NumPy with their Jacobian [s]."""
    ours, other = time_in_turns(rest_in_turn(), in_turn([NumpyRest(tilt).solve for tilt in TILTS]))
    return Claim(ours=ours, other=other, bar=5.0)


class NumpyRest:
    """The equations of rest in NumPy, without joint limits.

    Args:
        theta_0: angle of the base axis below the horizontal [rad].
    """

    def __init__(self, theta_0: float) -> None:
        table = read_table(prepare(presets.PAPER).constants)
        self.theta_0, self.stiffness, self.weight = theta_0, table.stiffness, table.weight
        self.elastic = np.diag(table.stiffness) - np.diag(table.stiffness[1:], 1)
        self.before = np.tril(np.ones_like(self.elastic))

    def residual(self, sag: np.ndarray) -> np.ndarray:
        """Residual moment of each joint, shape (n_joint,) [N m]."""
        moment = self.stiffness * sag
        left = moment - self.weight * np.cos(self.theta_0 + np.cumsum(sag))
        left[:-1] -= moment[1:]
        return left

    def jacobian(self, sag: np.ndarray) -> np.ndarray:
        """Its derivative, shape (n_joint, n_joint) [N m/rad]."""
        return self.elastic + self.before * (self.weight * np.sin(self.theta_0 + np.cumsum(sag)))[:, None]

    def solve(self) -> np.ndarray:
        """Sag of every joint, shape (n_joint,) [rad]."""
        return np.asarray(fsolve(self.residual, np.zeros(len(self.weight)), fprime=self.jacobian))


def rest_in_turn() -> Callable[[], object]:
    """Our shape at rest, at the next tilt with every call."""
    tilts = itertools.cycle(TILTS)
    return lambda: reference.rest(presets.PAPER, next(tilts))


def in_turn(calls: list[Callable[[], object]]) -> Callable[[], object]:
    """A function that makes the calls in turn."""
    turns = itertools.cycle(calls)

    def call_next() -> object:
        return next(turns)()

    return call_next
