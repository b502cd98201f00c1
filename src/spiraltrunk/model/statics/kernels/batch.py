"""Batches of equilibria: inputs and results, one row each, and the kernels that solve a range of rows."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from spiraltrunk.model.statics.kernels import compiled, owning
from spiraltrunk.model.statics.kernels.address import by_address
from spiraltrunk.model.statics.kernels.cholesky import copy, copy_rows
from spiraltrunk.model.statics.kernels.laws.energy import (
    Case,
    Control,
    Friction,
    replace_parts,
    replace_trunk,
    room_for_work,
)
from spiraltrunk.model.statics.kernels.laws.joint_limits import is_shut
from spiraltrunk.model.statics.kernels.loading import (
    COARSER,
    load_at_once,
    load_in_increments,
    load_quasi_statically,
    reset_anchors,
)
from spiraltrunk.model.statics.kernels.newton_calls import calling
from spiraltrunk.model.statics.kernels.projected_newton import TIGHT, room_for_steps
from spiraltrunk.model.statics.kernels.tip_compliance import tip_compliance
from spiraltrunk.model.statics.kernels.zeros import zeros

CONVERGED, ALL_SHUT, STALLED, NOT_CONVERGED = range(4)
"""Values of `kinematics.shape.Status`."""

NUDGE = 1e-6
"""Bend of the initial shape about y and z [rad]; it makes a trunk balanced on its base fall to one side."""


class Problem(NamedTuple):
    """Inputs of b equilibria."""

    base: np.ndarray
    """Orientation of the base, shape (b, 3, 3) [-]."""
    direction: np.ndarray
    """Gravity, and a force, shape (b, 1 or 2, 3) [m/s^2], [N]."""
    factor: np.ndarray
    """Mass of each section, and 1 where the force acts, shape (b, 1 or 2, n_section) [kg], [-]."""
    moment: np.ndarray
    """The same times the distance along the section, shape (b, 1 or 2, n_section) [kg m], [m]."""
    length: np.ndarray
    """Sum of the gaps of each cable held by length, without stretch, shape (b, n_cable) [m]."""
    start: np.ndarray
    """Sum of the gaps and tension at which the loading starts, shape (b, 2, n_cable) [m], [N]."""
    increments: np.ndarray
    """Number of equal increments of the loading, shape (b,) [-]."""
    most: np.ndarray
    """Largest tension, shape (b, n_cable) [N]."""
    motion: np.ndarray
    """Time of a quasi-static loading and damping time; 0 for other loadings, shape (b, 2) [s]."""
    by_tension: np.ndarray
    """Whether the cable is held by tension, shape (n_cable,) [bool]."""
    compliance: np.ndarray
    """Stretch of a cable per tension, shape (n_cable,) [m/N]."""
    friction: np.ndarray
    """Coefficient [-], stiffness of a hole [N/m], tolerance [N m], largest number of steps, shape (4,)."""
    straight: np.ndarray
    """Sum of the gaps in the straight trunk, shape (n_cable,) [m]."""


class Solution(NamedTuple):
    """Results, one row an equilibrium, in the shapes of `kinematics.shape.Shape` and its parts."""

    bend: np.ndarray
    tension: np.ndarray
    anchor: np.ndarray
    rotation: np.ndarray
    points: np.ndarray
    gap: np.ndarray
    gap_tension: np.ndarray
    reaction: np.ndarray
    compliance: np.ndarray
    figures: np.ndarray
    """Residual [N m], violation [m], steps, shape (b, 3)."""
    angle: np.ndarray
    change: np.ndarray
    shut: np.ndarray
    status: np.ndarray


@calling
def solve_rows(first, last, nd, trunk, problem, solution):
    """Rows ``first`` to ``last`` without friction; ``solution`` holds the bends, tensions and anchors at the start."""
    work, system = room_for_rows(nd, trunk)
    for b in range(first, last):
        solve_row(b, build_case(b, trunk, problem, solution), problem, solution, work, system)


@calling
def increment_rows(first, last, nd, trunk, problem, solution):
    """`solve_rows` in increments, with friction."""
    work, system = room_for_rows(nd, trunk)
    for b in range(first, last):
        increment_row(b, build_case(b, trunk, problem, solution), problem, solution, work, system)


@calling
def quasi_static_rows(first, last, nd, trunk, problem, solution):
    """`solve_rows` by quasi-static loading, with friction or without; in one step where the damping time is 0."""
    (work, system), joints = room_for_rows(nd, trunk), zeros((2, trunk.kind.shape[0], 3))
    for b in range(first, last):
        quasi_static_row(b, build_case(b, trunk, problem, solution), joints, problem, solution, work, system)


@compiled
def solve_row(b, case, problem, solution, work, system):
    """Row ``b`` of `solve_rows`."""
    case, problem, solution = by_address(case), by_address(problem), by_address(solution)
    work, system = by_address(work), by_address(system)
    solve_bends(b, case, problem, solution, work, system)
    write_row(b, case, problem, solution, work, system)


@compiled
def increment_row(b, case, problem, solution, work, system):
    """Row ``b`` of `increment_rows`."""
    case, problem, solution = by_address(case), by_address(problem), by_address(solution)
    work, system, figures = by_address(work), by_address(system), solution.figures[b]
    q, tension, start, parts = solution.bend[b], solution.tension[b], problem.start[b], problem.increments[b]
    mu, tolerance, most = problem.friction[0], problem.friction[2], int(problem.friction[3])
    found = load_in_increments(q, tension, case, mu, start, parts, tolerance, most, work, system)
    figures[0], figures[1], figures[2] = found
    write_row(b, case, problem, solution, work, system)


@compiled
def quasi_static_row(b, case, joints, problem, solution, work, system):
    """Row ``b`` of `quasi_static_rows`; ``joints`` is workspace for the damped stiffness and natural bends."""
    case, problem, solution = by_address(case), by_address(problem), by_address(solution)
    work, system, figures, motion = by_address(work), by_address(system), solution.figures[b], problem.motion[b]
    if motion[1] > 0.0:
        q, tension, start, mu = solution.bend[b], solution.tension[b], problem.start[b], problem.friction[0]
        tolerance, most = problem.friction[2], int(problem.friction[3])
        slow = replace_trunk(case.trunk, joints[0], joints[1], case.trunk.shut)
        damped = by_address(replace_parts(case, slow, system.length))
        found = load_quasi_statically(q, tension, case, mu, start, motion, tolerance, most, damped, work, system)
        figures[0], figures[1], figures[2] = found
        if mu == 0.0:
            reset_anchors(work.gap, solution.anchor[b])
    else:
        solve_bends(b, case, problem, solution, work, system)
    write_row(b, case, problem, solution, work, system)


@compiled
def solve_bends(b, case, problem, solution, work, system):
    """Bends and tensions of row ``b`` without friction."""
    q, tension, start, figures = solution.bend[b], solution.tension[b], problem.start[b], solution.figures[b]
    found = load_at_once(q, tension, case, start, problem.friction[2], int(problem.friction[3]), work, system)
    figures[0], figures[1], figures[2] = found


@owning
def room_for_rows(nd, trunk):
    """`Work` and `System` for a trunk whose joints have ``nd`` bends."""
    n_joint, n_cable = trunk.before.shape[0], trunk.before.shape[1]
    return room_for_work(n_joint, n_cable, nd), room_for_steps(n_joint, n_cable, nd, trunk.stiffness)


@owning
def build_case(b, trunk, problem, solution):
    """`Case` of row ``b``; its anchors are those of ``solution``."""
    mu, stiffness, size = problem.friction[0], problem.friction[1], (trunk.before.shape[0], trunk.before.shape[1])
    control = Control(problem.by_tension, problem.length[b], problem.most[b], problem.compliance)
    field = (problem.direction[b], problem.factor[b], problem.moment[b])
    friction = Friction(zeros(size), zeros(size), solution.anchor[b], stiffness if mu > 0.0 else 0.0)
    return Case(problem.base[b], trunk, field, control, friction)


@compiled
def write_row(b, case, problem, solution, work, system):
    """Results of row ``b`` from its bends and tensions, at which ``work`` and ``system`` are placed."""
    trunk = case.trunk
    for i in range(work.rotation.shape[0]):
        copy_rows(work.rotation[i], solution.rotation[b, i])
    copy_rows(work.gap, solution.gap[b])
    copy_rows(work.tension, solution.gap_tension[b])
    copy(system.reaction, solution.reaction[b])
    find_ends(work.frames, trunk.length, solution.points[b])
    measure(trunk, problem, solution, b)
    tip_compliance(solution.bend[b], solution.tension[b], case, work, system, solution.compliance[b])


@compiled
def measure(trunk, problem, solution, b):
    """Angles between the sections, which faces touch, change of the cables' lengths, and status of row ``b``."""
    are_all_shut, has_stalled = True, False
    for i in range(solution.angle.shape[1]):
        rotation = solution.rotation[b, i]
        solution.angle[b, i] = math.atan2(math.hypot(rotation[1, 0], rotation[2, 0]), rotation[0, 0])
        solution.shut[b, i] = is_shut(solution.angle[b, i], trunk.limit)
        are_all_shut = are_all_shut and solution.shut[b, i]
    for c in range(solution.change.shape[1]):
        total = 0.0
        for i in range(solution.gap.shape[1]):
            total += solution.gap[b, i, c]
        solution.change[b, c] = problem.straight[c] - total
        excess = total - problem.length[b, c] - problem.compliance[c] * solution.tension[b, c]
        has_stalled = has_stalled or (excess > TIGHT and not problem.by_tension[c])
    tolerance = problem.friction[2] * (COARSER if problem.friction[0] > 0.0 else 1.0)
    if not (solution.figures[b, 0] <= tolerance and solution.figures[b, 1] <= TIGHT):
        solution.status[b] = NOT_CONVERGED
    elif are_all_shut:
        solution.status[b] = ALL_SHUT
    else:
        solution.status[b] = STALLED if has_stalled else CONVERGED


@compiled
def find_ends(frames, length, points):
    """Section ends from their frames into ``points`` (n_section, 3) [m]."""
    for x in range(3):
        end = 0.0
        for n in range(length.shape[0]):
            end += length[n] * frames[n, x, 0]
            points[n, x] = end
