"""The trunk in static equilibrium: elastic joints, weight, loads, cables that only pull, and faces that meet.

Nothing of the paper's bending and twisting algorithms is assumed: the shape is a minimum of the energy

    sum 1/2 K_i |q_i|^2 - sum m_n g . x_n - f . x_load + cables,   |q_i| <= joint limit,

with q_i the bends of joint i about y and z (rotation vector without torsion; torsion on request). A cable runs through
the designed holes, its gaps straight in three dimensions, and pulls only. Between its winder and its gaps acts capstan
friction, if the design or the caller says so; then the loading history matters, and a solution can be the start of the
next.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.checks import broadcast_batches, check_count, check_number, check_type
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.model.identity_cache import IdentityKey
from spiraltrunk.model.jit import share
from spiraltrunk.model.kinematics.cables import hole_positions
from spiraltrunk.model.kinematics.frames import base_orientation
from spiraltrunk.model.kinematics.shape import Forces, History, Shape, Status, build
from spiraltrunk.model.statics.kernels.batch import NUDGE, Problem, Solution, solve_rows
from spiraltrunk.model.statics.kernels.energy import Trunk
from spiraltrunk.model.statics.kernels.joint_rotation import VECTOR, Y_FIRST, Z_FIRST
from spiraltrunk.model.statics.loads import (
    Drive,
    Fields,
    Loads,
    QuasiStatic,
    check_start,
    read_angle,
    read_drive,
    read_fields,
)

__all__ = ["Loads", "QuasiStatic", "StaticsOptions", "solve"]

POISSON = 0.48
"""Poisson's ratio of TPU [-]: an assumption, used for torsion alone, whose stiffness is E I / (L (1 + nu))."""

SHUT = 1e-6
"""Length at which a gap counts as shut [m]."""

_FALLBACK = QuasiStatic()
"""Quasi-static loading, used when incremental loading with friction fails to converge."""

_CHUNK = 16
"""Equilibria that a core solves in a row."""


@final
@dataclass(frozen=True, kw_only=True)
class StaticsOptions:
    """Options of the model and the solver."""

    has_torsion: bool = False
    """Whether joints also twist, with torsional stiffness G J / L; the paper neglects torsion."""
    has_hinges: bool = False
    """Whether each joint is two hinges in series, in alternating order, as in the simulation."""
    hole_set_back: float = 0.0
    """Distance of the holes behind the face over its half-width [-], as in the simulation; 0 is the design.

    Friction acts at the designed holes in either case."""
    cable_stiffness: float = math.inf
    """Tension per stretch of a cable and its winder [N/m]; infinity is inextensible."""
    increment: float = 5e-3
    """Largest change of a cable's length per increment where there is friction [m].

    A trunk that buckles during loading, as some do with several cables pulled, may end up to centimetres elsewhere with
    smaller increments. Where that matters, try smaller ones or quasi-static loading, which chooses its own steps."""
    tension_increment: float = 2.0
    """Largest change of a tension per increment where there is friction [N]."""
    hole_stiffness: float = 5e4
    """Force per slip of a cable at a hole before it slides [N/m]; regularises friction, 1 N before 20 um."""
    tolerance: float = 1e-9
    """Largest moment left at a joint [N m]; ten times that where there is friction."""
    quasi_static: QuasiStatic | None = None
    """Quasi-static loading; None loads in one step, or with friction in increments."""
    steps_most: int = 20_000
    """Largest number of solver steps of an increment or of a quasi-static loading."""

    def __post_init__(self) -> None:
        check_number("hole_set_back", self.hole_set_back, least=0.0, below=0.5)
        if self.cable_stiffness != math.inf:
            check_number("cable_stiffness", self.cable_stiffness, least=1e2)
        check_number("increment", self.increment, least=1e-5, below=10.0)
        check_number("tension_increment", self.tension_increment, least=1e-3, below=1e4)
        check_number("hole_stiffness", self.hole_stiffness, least=1.0, below=1e8)
        check_number("tolerance", self.tolerance, least=1e-12, below=1e-3)
        check_count("steps_most", self.steps_most, least=1, most=10**8)
        if self.quasi_static is not None:
            check_type("quasi_static", self.quasi_static, QuasiStatic)
        if self.has_torsion and self.has_hinges:
            raise ModelError("has_torsion and has_hinges given; allowed: one of them")


def solve(
    design: TrunkDesign,
    *,
    pull: ArrayLike | None = None,
    tension: ArrayLike | None = None,
    by_tension: ArrayLike | None = None,
    theta_0: ArrayLike = math.pi / 2,
    roll: ArrayLike = 0.0,
    loads: Loads | None = None,
    friction: float | None = None,
    start: Shape | None = None,
    options: StaticsOptions | None = None,
) -> Shape:
    """The shape in which trunk, loads and cables balance.

    Args:
        design: the trunk.
        pull: cable pulled in since the straight trunk, straight length minus length, negative for cable paid out, shape
            (..., n_cable) [m]. Used for cables that are held by length.
        tension: tension of the cables that are held by tension, and the largest one of the others, shape
            (..., n_cable) [N]; by default 0 for the former (relaxed) and the design's ``tension_max`` for the latter.
        by_tension: which cables are held by tension, shape (n_cable,) [bool]; by default all of them where no pull is
            given, and none otherwise.
        theta_0: angle of the base axis below the horizontal, shape (...) [rad]; pi / 2 hangs.
        roll: turn of the trunk about its base axis, shape (...) [rad].
        loads: what else weighs on it.
        friction: coefficient between cables and holes [-]; None takes the design's, 0 by default.
        start: an earlier solution, from which the cables go on; None starts straight, or, with friction, at rest under
            gravity with slack cables.
        options: how it is modelled and solved.

    The weight is that of the sections alone: a tip gripper's mass is a load, or is put into the last section, as the
    paper does, by `pulls.carry_gripper`.

    More than one shape may balance, above all with every cable pulled or the trunk upright under a load. Which one is
    found depends on ``start`` and on the loading: in one step, in increments where there is friction, or quasi-static.
    Loads and base take effect at once. Where every cable is held by length and none stretches, the tensions that act
    against each other are ill-conditioned: give ``cable_stiffness``.

    Returns:
        The shape with its `Forces` and, for a next call, its `History`. Its status is CONVERGED, STALLED where a winder
        reached its largest tension before its length, ALL_SHUT where every joint is at its limit, or NOT_CONVERGED,
        where the moments left are in ``forces.residual``; numbers are finite in every case.

    Raises:
        ModelError: for shapes that do not fit, numbers that are not finite or out of range, a start of another trunk.
        DesignError: for a friction out of range.
    """
    options = _DEFAULT if options is None else options
    check_type("design", design, TrunkDesign)
    check_type("options", options, StaticsOptions)
    if start is not None:
        check_type("start", start, Shape)
    mu = design.cable.friction if friction is None else friction
    check_number("friction", mu, least=0.0, below=2.0)
    drive = read_drive(design, pull, tension, by_tension)
    fields = read_fields(design, loads)
    base = base_orientation(read_angle("theta_0", theta_0), read_angle("roll", roll))
    batch = broadcast_batches(
        {
            "pull": drive.pull.shape[:-1],
            "tension": drive.tension.shape[:-1],
            "theta_0 and roll": base.shape[:-2],
            "loads": fields.factor.shape[:-2],
            "start": () if start is None else start.status.shape,
        }
    )
    if start is None and (mu > 0 or options.quasi_static is not None):
        at_once = replace(options, quasi_static=None)
        start = solve(design, theta_0=theta_0, roll=roll, loads=loads, friction=0.0, options=at_once)
    if start is not None:
        check_start(design, start)
    trunk, straight = get_trunk(design, options)
    problem = _pose(straight, drive, fields, base, (batch, start, mu, options))
    solution = _start(trunk, drive, batch, start)
    _run(problem, solution, trunk, 3 if options.has_torsion else 2)
    if mu > 0 and options.quasi_static is None and (solution.status == Status.NOT_CONVERGED).any():
        options, again = replace(options, quasi_static=_FALLBACK), _start(trunk, drive, batch, start)
        problem = _pose(straight, drive, fields, base, (batch, start, mu, options))
        _run_again(problem, (solution, again), trunk, 3 if options.has_torsion else 2)
    return read_out(solution, batch)


_DEFAULT = StaticsOptions()


def build_trunk(design: TrunkDesign, options: StaticsOptions) -> Trunk:
    """The design in the arrays that the kernels read."""
    beyond, before = hole_positions(design, options.hole_set_back)
    rub_beyond, rub_before = hole_positions(design)
    stiffness = np.repeat(design.joint_stiffness[:, None], 3, axis=1)
    stiffness[:, 2] /= 1 + POISSON
    kind = np.full(design.n_joint, VECTOR)
    if options.has_hinges:
        kind[0::2], kind[1::2] = Z_FIRST, Y_FIRST
    return Trunk(
        kind, stiffness, np.zeros_like(stiffness), design.joint_limit, design.section_length.copy(),
        np.ascontiguousarray(before), np.ascontiguousarray(beyond), np.ascontiguousarray(rub_before),
        np.ascontiguousarray(rub_beyond), SHUT,
    )  # fmt: skip


def straight_length(trunk: Trunk) -> np.ndarray:
    """Sum of each cable's gaps in the straight trunk, shape (n_cable,) [m]."""
    return np.linalg.norm(trunk.beyond - trunk.before, axis=-1).sum(axis=0)


def get_trunk(design: TrunkDesign, options: StaticsOptions) -> tuple[Trunk, np.ndarray]:
    """`build_trunk` and `straight_length`, kept for designs lately used."""
    return _keep_trunk(IdentityKey(design), options)


@lru_cache(maxsize=64)
def _keep_trunk(key: IdentityKey, options: StaticsOptions) -> tuple[Trunk, np.ndarray]:
    trunk = build_trunk(key.design, options)
    return trunk, straight_length(trunk)


def _pose(
    straight: np.ndarray,
    drive: Drive,
    fields: Fields,
    base: np.ndarray,
    rest: tuple[tuple[int, ...], Shape | None, float, StaticsOptions],
) -> Problem:
    """The problem of every row, and from where each is loaded."""
    batch, start, mu, options = rest
    rows, count = math.prod(batch), drive.by_tension.size
    length = _spread(straight - drive.pull, batch, 1)
    tension = _spread(drive.tension, batch, 1)
    begin = np.empty((rows, 2, count))
    if start is None or start.forces is None:
        begin[:, 0], begin[:, 1] = length, np.where(drive.by_tension, tension, 0.0)
    else:
        begin[:, 1] = _spread(start.forces.cable_tension, batch, 1)
        stretch = begin[:, 1] / options.cable_stiffness
        begin[:, 0] = _spread(start.gap.sum(axis=-2), batch, 1) - stretch
    far = np.where(drive.by_tension, 0.0, np.abs(length - begin[:, 0])).max(axis=1)
    hard = np.where(drive.by_tension, np.abs(tension - begin[:, 1]), 0.0).max(axis=1)
    increments, motion, slow = np.ones(rows, np.int64), np.zeros((rows, 2)), options.quasi_static
    if mu > 0 and slow is None:
        parts = np.maximum(far / options.increment, hard / options.tension_increment)
        increments = np.maximum(np.ceil(parts - 1e-9), 1.0).astype(np.int64)
    elif slow is not None:
        motion[:, 0] = np.maximum(far / slow.pull_speed, hard / slow.tension_speed)
        motion[:, 1] = slow.damping_time
    return Problem(
        _spread(base, batch, 2), _spread(fields.direction, batch, 2), _spread(fields.factor, batch, 2),
        _spread(fields.moment, batch, 2), length, begin, increments, tension, motion, drive.by_tension,
        np.full(count, 1 / options.cable_stiffness),
        np.array((mu, options.hole_stiffness, options.tolerance, float(options.steps_most))), straight,
    )  # fmt: skip


def _start(trunk: Trunk, drive: Drive, batch: tuple[int, ...], start: Shape | None) -> Solution:
    """Room for the solutions, with the bends, tensions and anchors from which they are sought."""
    solution = make_room(trunk, math.prod(batch))
    if start is None:
        solution.bend[..., :2] = NUDGE
    elif start.history is None:
        solution.bend[..., :2] = NUDGE
        solution.anchor[:] = _spread(np.cumsum(start.gap[..., ::-1, :], axis=-2)[..., ::-1, :], batch, 2)
    else:
        solution.bend[:] = _spread(start.history.bend, batch, 2)
        solution.anchor[:] = _spread(start.history.anchor, batch, 2)
        if start.forces is not None:
            solution.tension[:] = _spread(start.forces.cable_tension, batch, 1)
    given = drive.tension if not batch else _spread(drive.tension, batch, 1)
    np.copyto(solution.tension, given, where=drive.by_tension)
    return solution


def make_room(trunk: Trunk, rows: int) -> Solution:
    """Room for solutions, with straight trunks and slack cables."""
    joints, count = trunk.before.shape[:2]
    return Solution(
        np.zeros((rows, joints, 3)), np.zeros((rows, count)), np.zeros((rows, joints, count)),
        np.empty((rows, joints, 3, 3)), np.empty((rows, joints + 1, 3)), np.empty((rows, joints, count)),
        np.empty((rows, joints, count)), np.empty((rows, joints)), np.empty((rows, 3, 3)), np.empty((rows, 3)),
        np.empty((rows, joints)), np.empty((rows, count)), np.empty((rows, joints), np.bool_), np.empty(rows, np.int64),
    )  # fmt: skip


def _run(problem: Problem, solution: Solution, trunk: Trunk, nd: int) -> None:
    """Solve all rows, on all cores where there are enough."""
    share(lambda first, last: solve_rows(first, last, nd, trunk, problem, solution), len(problem.base), _CHUNK)


def _run_again(problem: Problem, solutions: tuple[Solution, Solution], trunk: Trunk, nd: int) -> None:
    """Solve the rows of the first that did not converge from the start in the second, and keep those that now do."""
    kept, again = solutions
    rows = np.flatnonzero(kept.status == Status.NOT_CONVERGED)
    own = {name: getattr(problem, name)[rows] for name in Problem._fields[:9]}
    part = Solution(*(array[rows] for array in again))
    _run(problem._replace(**own), part, trunk, nd)
    good = part.status != Status.NOT_CONVERGED
    for array, found in zip(kept, part, strict=True):
        array[rows[good]] = found[good]


def read_out(solution: Solution, batch: tuple[int, ...]) -> Shape:
    """The shapes, with the batch's axes for the rows."""

    figures, status = solution.figures[:, 0], solution.status
    if batch:
        each = [array.reshape((*batch, *array.shape[1:])) for array in solution]
        solution, figures, status = Solution(*each), figures.reshape(batch), status.reshape(batch)
    else:
        solution, figures, status = Solution(*[array[0] for array in solution]), figures.reshape(()), status.reshape(())
    forces = {
        "cable_tension": solution.tension, "gap_tension": solution.gap_tension, "limit_reaction": solution.reaction,
        "tip_compliance": solution.compliance, "residual": figures,
    }  # fmt: skip
    return build(
        Shape,
        {
            "points": solution.points, "joint_rotation": solution.rotation, "joint_angle": solution.angle,
            "gap": solution.gap, "cable_change": solution.change, "is_shut": solution.shut, "status": status,
            "forces": build(Forces, forces),
            "history": build(History, {"bend": solution.bend, "anchor": solution.anchor}),
        },
    )  # fmt: skip


def _spread(array: np.ndarray, batch: tuple[int, ...], own: int) -> np.ndarray:
    """An array with ``own`` axes of its own, copied over the batch: shape (rows, own axes)."""
    if not batch:
        return array.copy()[None]
    tail = array.shape[array.ndim - own :]
    return np.array(np.broadcast_to(array, (*batch, *tail)), order="C").reshape(math.prod(batch), *tail)
