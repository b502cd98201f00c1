"""Start table of the inverse model: equilibria of one load case at sampled tensions, from which searches start."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.model.inverse.kernels.multistart import Limits, Starts, solve_target_rows
from spiraltrunk.model.inverse.kernels.target_residual import Targets
from spiraltrunk.model.jit import share
from spiraltrunk.model.kinematics.frames import base_orientation
from spiraltrunk.model.statics import equilibrium
from spiraltrunk.model.statics.equilibrium import StaticsOptions
from spiraltrunk.model.statics.kernels.batch import Problem
from spiraltrunk.model.statics.kernels.laws.energy import Trunk
from spiraltrunk.model.statics.loads import Loads, read_forces
from spiraltrunk.model.statics.solutions import allocate

CHUNK = 8
"""Targets that a core searches in a row; between two such rows a batch can be stopped."""

_CROSSED = 0.3
"""Relative distance that is added to a start with all tensions at their maximum, to prefer slack ones [-]."""

_SLACK = 0.23
"""Share of the samples in which a cable is slack [-]."""

_OPPOSED = -0.51
"""Cosine of the angle between two cables below which they count as opposed [-]: a little over 120 deg."""

_PRIMES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37)
"""Bases of the Halton sequence, one per cable."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, eq=False)
class StartTable:
    """Equilibria of one load case."""

    starts: Starts
    """Equilibria in the arrays that the kernels read."""
    base: np.ndarray
    """Axes of the base for which they were solved, shape (3, 3) [-]."""
    slack: float
    """Tension below which a cable counts as slack, so that the others are not opposed; -inf where they may be [N]."""


@final
@dataclass(frozen=True)
class LoadCase:
    """Base pose and loads of one trunk as plain numbers, the key of its start table; see `Loads`."""

    theta_0: float
    roll: float
    mass: float
    section: int
    force: tuple[float, ...] | None
    force_section: int

    @property
    def loads(self) -> Loads | None:
        """The loads, None where there are none."""
        if self.mass == 0.0 and self.force is None:
            return None
        return Loads(mass=self.mass, section=self.section, force=self.force, force_section=self.force_section)


@lru_cache(maxsize=128)
def get_start_table(design: TrunkDesign, case: LoadCase, count: int, options: StaticsOptions) -> StartTable:
    """`compute_start_table`, cached by the numbers of design and load case."""
    return compute_start_table(design, case, count, options)


def compute_start_table(design: TrunkDesign, case: LoadCase, count: int, options: StaticsOptions) -> StartTable:
    """``count`` equilibria without friction at tensions spread evenly over their logarithms, some cables slack."""
    tension, base = sample_tensions(design, count), base_orientation(case.theta_0, case.roll)
    forces, (posed, trunk) = read_forces(design, case.loads), pose_tensions(design, count, options)
    parts = (base, forces.direction, forces.factor, forces.moment)
    problem = Problem(*(np.repeat(part[None], count, axis=0) for part in parts), *posed)
    solution, rows = allocate(trunk, count), np.arange(count)
    solution.tension[:] = tension
    effort = _CROSSED * (tension / design.cable.tension_max).mean(axis=1)
    starts = Starts(tension, effort, solution.bend, solution.points, np.zeros_like(solution.points))
    limits, targets = Limits(0, 0, 0.0, 0.0, 0.0, count_bends(options), 0.0), build_no_targets(design, 1)

    def solve(first: int, last: int) -> None:
        solve_target_rows(rows[first:last], limits, case.loads is None, trunk, problem, targets, starts, base, solution)

    share(solve, count, CHUNK)
    starts = starts._replace(heads=section_axes(solution.points))
    return StartTable(starts=starts, base=base, slack=least_tension(design) if _is_slack_by_one(design) else -math.inf)


def pose_tensions(design: TrunkDesign, rows: int, model: StaticsOptions) -> tuple[tuple[np.ndarray, ...], Trunk]:
    """What a `Problem` has after base and weights: no friction, tensions up to the design's largest yet to come."""
    trunk, straight = equilibrium.get_trunk(design, model)
    count = design.n_cable
    none, friction = np.zeros(count), np.array((0.0, model.hole_stiffness, model.tolerance, model.steps_most))
    return (
        np.zeros((rows, count)), np.zeros((rows, 2, count)), np.ones(rows, np.int64),
        np.full((rows, count), design.cable.tension_max), np.zeros((rows, 2)), np.full(count, True), none, friction,
        straight,
    ), trunk  # fmt: skip


def count_bends(model: StaticsOptions) -> int:
    """Bends of a joint [-]."""
    return 3 if model.has_torsion else 2


def build_no_targets(design: TrunkDesign, rows: int) -> Targets:
    """Targets whose weights are all 0."""
    count, solid = design.n_section, design.solid
    return Targets(
        np.zeros((rows, count, 3)), np.zeros(count), np.zeros((rows, 3)), 0.0, np.zeros((rows, 7)),
        np.zeros((rows, count)), 0.0, np.outer(design.scale, [solid.radius, solid.rim_start, solid.rim_end]),
    )  # fmt: skip


def _is_slack_by_one(design: TrunkDesign) -> bool:
    """Whether no cables are opposed once one is slack: at most three cables, no two of them opposed."""
    if design.n_cable < 3:
        return True
    side = design.cable_direction
    return design.n_cable == 3 and float((side @ side.T).min()) > _OPPOSED


def sample_tensions(design: TrunkDesign, count: int) -> np.ndarray:
    """Tensions from 0 to the largest by a Halton sequence, the first row 0, shape (count, n_cable) [N]."""
    least, most = least_tension(design), design.cable.tension_max
    unit = np.stack([_halton(base, count) for base in _PRIMES[: design.n_cable]], axis=-1)
    part = (unit - _SLACK) / (1 - _SLACK)
    return np.where(part <= 0, 0.0, least * (most / least) ** np.maximum(part, 0.0))


def least_tension(design: TrunkDesign) -> float:
    """Tension that bends the most compliant joint of the weightless trunk by a fiftieth of its limit [N]."""
    lever = design.hole_to_joint * math.cos(design.joint_limit / 2)
    tension = float((0.02 * design.joint_limit * design.joint_stiffness / lever).min())
    return min(tension, 0.1 * design.cable.tension_max)


def section_axes(points: np.ndarray) -> np.ndarray:
    """Unit vectors along the sections from their ends, shape (..., n_section, 3) [-]."""
    along = np.diff(points, axis=-2, prepend=0.0)
    return along / np.linalg.norm(along, axis=-1, keepdims=True)


def _halton(base: int, count: int) -> np.ndarray:
    """Halton sequence from 0 on, shape (count,) [-]."""
    index, value, share = np.arange(count), np.zeros(count), 1.0
    while index.any():
        share /= base
        value += share * (index % base)
        index = index // base
    return value
