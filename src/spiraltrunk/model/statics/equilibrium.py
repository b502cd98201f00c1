"""Static equilibrium of the trunk: elastic joints, weight, loads, cables that only pull, and joint limits.

The paper's bending and twisting algorithms are not used: the shape is a minimum of the energy

    sum 1/2 K_i |q_i|^2 - sum m_n g . x_n - f . x_load + cables,   |q_i| <= joint limit,

with q_i the bends of joint i about y and z (rotation vector, without torsion unless requested). A cable runs through
the designed holes, straight across each gap. With capstan friction at the holes the loading history matters, and a
solution can be the start of the next.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple, final

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.checks import broadcast_batches, check_count, check_number, check_type
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.model.identity_cache import IdentityKey
from spiraltrunk.model.jit import share
from spiraltrunk.model.kinematics.cables import hole_positions
from spiraltrunk.model.kinematics.frames import base_orientation
from spiraltrunk.model.kinematics.shape import Shape, Status
from spiraltrunk.model.statics.kernels.batch import (
    NUDGE,
    Problem,
    Solution,
    increment_rows,
    quasi_static_rows,
    solve_rows,
)
from spiraltrunk.model.statics.kernels.laws.energy import Trunk
from spiraltrunk.model.statics.kernels.laws.joint_rotation import VECTOR, Y_FIRST, Z_FIRST
from spiraltrunk.model.statics.loads import (
    BodyForces,
    CableInput,
    Loads,
    QuasiStatic,
    check_start,
    read_angle,
    read_cables,
    read_forces,
)
from spiraltrunk.model.statics.solutions import allocate, build_shape, to_rows

__all__ = ["Loads", "QuasiStatic", "StaticsOptions", "solve"]

POISSON = 0.48
"""Poisson's ratio of TPU [-] (assumed), for the torsional stiffness E I / (L (1 + nu)) only."""

SHUT = 1e-6
"""Length below which a gap counts as closed [m]."""

_CHUNK = 16
"""Equilibria per chunk of a thread."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class StaticsOptions:
    """Options of the model and the solver."""

    has_torsion: bool = False
    """Whether joints also twist, with torsional stiffness G J / L; the paper neglects torsion."""
    has_hinges: bool = False
    """Whether each joint is two hinges in series, in alternating order, as in the simulation."""
    hole_set_back: float = 0.0
    """Distance of the holes behind the face over its half-width [-], as in the simulation; friction ignores it."""
    cable_stiffness: float = math.inf
    """Tension per elongation of a cable and its winder [N/m]; infinity for an inextensible cable."""
    increment: float = 5e-3
    """Largest change of a cable's length per increment where there is friction [m].

    A trunk that buckles during loading, as some do with several cables pulled, may end up to centimetres elsewhere with
    smaller increments. Where that matters, try smaller ones or quasi-static loading, which chooses its own steps."""
    tension_increment: float = 2.0
    """Largest change of a tension per increment where there is friction [N]."""
    hole_stiffness: float = 5e4
    """Force per displacement of a cable at a hole before it slides [N/m]; regularises friction, 1 N at 20 um."""
    tolerance: float = 1e-9
    """Largest residual moment at a joint [N m]; ten times that with friction."""
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
    """Static equilibrium of the trunk under cables, weight and loads.

    Args:
        design: the trunk.
        pull: cable pulled in since the straight trunk, straight length minus length, negative for cable paid out, shape
            (..., n_cable) [m]. Used for cables that are held by length.
        tension: tension of the cables that are held by tension, and the largest one of the others, shape
            (..., n_cable) [N]; by default 0 for the former (relaxed) and the design's ``tension_max`` for the latter.
        by_tension: which cables are held by tension, shape (n_cable,) [bool]; by default all of them where no pull is
            given, and none otherwise.
        theta_0: angle of the base axis below the horizontal, shape (...) [rad]; pi / 2 hangs.
        roll: rotation of the trunk about its base axis, shape (...) [rad].
        loads: loads besides its weight.
        friction: coefficient between cables and holes [-]; None takes the design's, 0 by default.
        start: an earlier solution, from which loading continues; None starts straight, or, with friction, at rest under
            gravity with slack cables.
        options: options of the model and the solver.

    The weight is that of the sections alone: a tip gripper's mass is a load, or part of the last section, as in the
    paper (`pull_sequences.carry_gripper`).

    There may be several equilibria, above all with every cable pulled or the trunk upright under a load. Which one is
    found depends on ``start`` and on the loading: in one step, in increments where there is friction, or quasi-static.
    Loads and base take effect at once. Where every cable is held by length and none stretches, the tensions that act
    against each other are ill-conditioned: give ``cable_stiffness``.

    Returns:
        The shape with its `Forces` and, for a next call, its `History`. Its status is CONVERGED, STALLED where a winder
        reached its largest tension before its length, ALL_SHUT where every joint is at its limit, or NOT_CONVERGED,
        where ``forces.residual`` is the residual moment; numbers are finite in every case.

    Raises:
        ModelError: for wrong shapes, numbers that are not finite or out of range, a start of another trunk.
        DesignError: for a friction or a section out of range, and arguments of another type.
    """
    options = _DEFAULT if options is None else options
    check_type("design", design, TrunkDesign)
    check_type("options", options, StaticsOptions)
    if start is not None:
        check_type("start", start, Shape)
    mu = design.cable.friction if friction is None else friction
    check_number("friction", mu, least=0.0, below=2.0)
    cables, forces = read_cables(design, pull, tension, by_tension), read_forces(design, loads)
    base = base_orientation(read_angle("theta_0", theta_0), read_angle("roll", roll))
    batches = {
        "pull": cables.pull.shape[:-1], "tension": cables.tension.shape[:-1], "theta_0 and roll": base.shape[:-2],
        "loads": forces.factor.shape[:-2], "start": () if start is None else start.status.shape,
    }  # fmt: skip
    batch = broadcast_batches(batches)
    kernel = _choose_kernel(mu, options)
    if start is None and kernel is not solve_rows:
        slack, at_once = read_cables(design, None, None, None), replace(options, quasi_static=None)
        own = np.broadcast_shapes(base.shape[:-2], forces.factor.shape[:-2])
        start = _solve(kernel, design, _Arguments(slack, forces, base, own, None, 0.0, at_once))
    if start is not None:
        check_start(design, start)
    return _solve(kernel, design, _Arguments(cables, forces, base, batch, start, mu, options))


def _choose_kernel(friction: float, options: StaticsOptions) -> Any:
    """The smallest kernel for the options, so that no more is compiled."""
    if options.quasi_static is not None:
        return quasi_static_rows
    return increment_rows if friction > 0 else solve_rows


def _solve(kernel: Any, design: TrunkDesign, arguments: _Arguments, *, falls_back: bool = True) -> Shape:
    """Shapes by a kernel; where incremental loading with friction does not converge, by quasi-static loading."""
    options = arguments.options
    trunk, straight = get_trunk(design, options)
    nd, solution = 3 if options.has_torsion else 2, _start(arguments, trunk)
    _run(kernel, _build_problem(arguments, straight), solution, trunk, nd)
    if falls_back and arguments.friction > 0 and options.quasi_static is None:
        _fall_back(arguments, solution, trunk, straight, nd)
    return build_shape(solution, arguments.batch)


def solve_in_increments(
    design: TrunkDesign, cables: CableInput, forces: BodyForces, base: np.ndarray, start: Shape | None, **model: Any
) -> Shape:
    """`solve` from checked inputs, row by row of the start, without fallback; ``model``: friction and options."""
    batch = base.shape[:-2] if start is None else start.status.shape
    arguments = _Arguments(cables, forces, base, batch, start, **model)
    return _solve(increment_rows, design, arguments, falls_back=False)


def _fall_back(arguments: _Arguments, solution: Solution, trunk: Trunk, straight: np.ndarray, nd: int) -> None:
    """Solve the rows that did not converge by quasi-static loading, and keep those that then converge."""
    failed = np.flatnonzero(solution.status == Status.NOT_CONVERGED)
    if failed.size:
        slowly = arguments._replace(options=replace(arguments.options, quasi_static=QuasiStatic()))
        problem = _build_problem(slowly, straight)
        own = {name: getattr(problem, name)[failed] for name in Problem._fields[:9]}
        again = Solution(*(array[failed] for array in _start(slowly, trunk)))
        _run(quasi_static_rows, problem._replace(**own), again, trunk, nd)
        is_better = again.status != Status.NOT_CONVERGED
        for array, found in zip(solution, again, strict=True):
            array[failed[is_better]] = found[is_better]


def _run(kernel: Any, problem: Problem, solution: Solution, trunk: Trunk, nd: int) -> None:
    """Solve all rows on all cores."""
    share(lambda first, last: kernel(first, last, nd, trunk, problem, solution), len(problem.base), _CHUNK)


@final
class _Arguments(NamedTuple):
    """Checked arguments of `solve`."""

    cables: CableInput
    forces: BodyForces
    base: np.ndarray
    batch: tuple[int, ...]
    start: Shape | None
    friction: float
    options: StaticsOptions


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


def get_trunk(design: TrunkDesign, options: StaticsOptions) -> tuple[Trunk, np.ndarray]:
    """`build_trunk`, and the sum of each cable's gaps in the straight trunk, shape (n_cable,) [m]; both cached."""
    return _get_trunk(IdentityKey(design), options)


@lru_cache(maxsize=64)
def _get_trunk(key: IdentityKey[TrunkDesign], options: StaticsOptions) -> tuple[Trunk, np.ndarray]:
    trunk = build_trunk(key.value, options)
    return trunk, np.linalg.norm(trunk.beyond - trunk.before, axis=-1).sum(axis=0)


def _build_problem(arguments: _Arguments, straight: np.ndarray) -> Problem:
    """Inputs of the kernels, with lengths and tensions at the start and the increments from there."""
    cables, forces, base, batch, start, mu, options = arguments
    rows, count = math.prod(batch), cables.by_tension.size
    length = to_rows(straight - cables.pull, batch, 1)
    tension = to_rows(cables.tension, batch, 1)
    begin = np.empty((rows, 2, count))
    if start is None or start.forces is None:
        begin[:, 0], begin[:, 1] = length, np.where(cables.by_tension, tension, 0.0)
    else:
        begin[:, 1] = to_rows(start.forces.cable_tension, batch, 1)
        stretch = begin[:, 1] / options.cable_stiffness
        begin[:, 0] = to_rows(start.gap.sum(axis=-2), batch, 1) - stretch
    far = np.where(cables.by_tension, 0.0, np.abs(length - begin[:, 0])).max(axis=1)
    hard = np.where(cables.by_tension, np.abs(tension - begin[:, 1]), 0.0).max(axis=1)
    increments, motion, slow = np.ones(rows, np.int64), np.zeros((rows, 2)), options.quasi_static
    if mu > 0 and slow is None:
        parts = np.maximum(far / options.increment, hard / options.tension_increment)
        increments = np.maximum(np.ceil(parts - 1e-9), 1.0).astype(np.int64)
    elif slow is not None:
        motion[:, 0] = np.maximum(far / slow.pull_speed, hard / slow.tension_speed)
        motion[:, 1] = slow.damping_time
    return Problem(
        to_rows(base, batch, 2), to_rows(forces.direction, batch, 2), to_rows(forces.factor, batch, 2),
        to_rows(forces.moment, batch, 2), length, begin, increments, tension, motion, cables.by_tension,
        np.full(count, 1 / options.cable_stiffness),
        np.array((mu, options.hole_stiffness, options.tolerance, float(options.steps_most))), straight,
    )  # fmt: skip


def _start(arguments: _Arguments, trunk: Trunk) -> Solution:
    """Arrays of the solutions, filled with the bends, tensions and anchors at the start."""
    batch, start, cables = arguments.batch, arguments.start, arguments.cables
    solution = allocate(trunk, math.prod(batch))
    if start is None or start.history is None:
        solution.bend[..., :2] = NUDGE
        if start is not None:
            solution.anchor[:] = to_rows(np.cumsum(start.gap[..., ::-1, :], axis=-2)[..., ::-1, :], batch, 2)
    else:
        solution.bend[:] = to_rows(start.history.bend, batch, 2)
        solution.anchor[:] = to_rows(start.history.anchor, batch, 2)
        if start.forces is not None:
            solution.tension[:] = to_rows(start.forces.cable_tension, batch, 1)
    np.copyto(solution.tension, to_rows(cables.tension, batch, 1), where=cables.by_tension)
    return solution
