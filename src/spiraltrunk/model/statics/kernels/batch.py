"""Many equilibria, one after another."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from spiraltrunk.model.statics.kernels import compiled, owning
from spiraltrunk.model.statics.kernels.address import by_address
from spiraltrunk.model.statics.kernels.capstan_friction import COARSER, follow, load_at_once, release
from spiraltrunk.model.statics.kernels.cholesky import copy, copy_rows
from spiraltrunk.model.statics.kernels.energy import Case, Control, Friction, room_for_work
from spiraltrunk.model.statics.kernels.joint_limits import is_shut
from spiraltrunk.model.statics.kernels.projected_newton import TIGHT, room_for_steps
from spiraltrunk.model.statics.kernels.quasi_static import creep, room_for_creep
from spiraltrunk.model.statics.kernels.tip_compliance import tip_compliance

CONVERGED, ALL_SHUT, STALLED, NOT_CONVERGED = range(4)
"""The numbers of `Status`."""

NUDGE = 1e-6
"""Bend from which a solution starts [rad], so that a trunk balanced on its base falls to one side."""


class Problem(NamedTuple):
    """What to solve, one row an equilibrium; the first axis of every array but the last four is the batch's."""

    base: np.ndarray
    """Orientation of the base, shape (b, 3, 3) [-]."""
    direction: np.ndarray
    """Gravity, and a force, shape (b, 1 or 2, 3) [m/s^2], [N]."""
    factor: np.ndarray
    """What gravity and the force act on, by section, shape (b, 1 or 2, n_section) [kg], [-]."""
    moment: np.ndarray
    """The same times the distance along the section, shape (b, 1 or 2, n_section) [kg m], [m]."""
    length: np.ndarray
    """Gaps' sum that each winder leaves, shape (b, n_cable) [m]."""
    start: np.ndarray
    """Gaps' sum and tension from which the loading goes, shape (b, 2, n_cable) [m], [N]."""
    increments: np.ndarray
    """Equal parts of the loading, shape (b,) [-]."""
    most: np.ndarray
    """Largest tension, shape (b, n_cable) [N]."""
    motion: np.ndarray
    """Time that the loading takes and damping time, of trunks that creep; else 0, shape (b, 2) [s]."""
    by_tension: np.ndarray
    """Whether the tension is given, shape (n_cable,) [bool]."""
    compliance: np.ndarray
    """Stretch of a cable per tension, shape (n_cable,) [m/N]."""
    friction: np.ndarray
    """Coefficient [-], stiffness of a hole [N/m], tolerance [N m], most steps, shape (4,)."""
    straight: np.ndarray
    """Gaps' sum of the straight trunk, shape (n_cable,) [m]."""


class Solution(NamedTuple):
    """What comes out, one row an equilibrium."""

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


@owning
def solve_rows(first, last, nd, trunk, problem, solution):
    """Equilibria ``first`` to ``last`` without friction; bend, tension and anchor hold where each starts."""
    work, system = room_for_rows(nd, trunk)
    for b in range(first, last):
        solve_row(b, build_case(b, trunk, problem, solution), problem, solution, work, system)


@owning
def follow_rows(first, last, nd, trunk, problem, solution):
    """The same with friction."""
    work, system = room_for_rows(nd, trunk)
    for b in range(first, last):
        follow_row(b, build_case(b, trunk, problem, solution), problem, solution, work, system)


@owning
def creep_rows(first, last, nd, trunk, problem, solution):
    """The same with friction or without, the trunks creeping, or at once where that takes no time."""
    (work, system), slow = room_for_rows(nd, trunk), room_for_creep(trunk)
    for b in range(first, last):
        creep_row(b, build_case(b, trunk, problem, solution), slow, problem, solution, work, system)


@compiled
def solve_row(b, case, problem, solution, work, system):
    """Row ``b`` without friction."""
    case, problem, solution = by_address(case), by_address(problem), by_address(solution)
    work, system = by_address(work), by_address(system)
    load_row(b, case, problem, solution, work, system)
    write_row(b, case, problem, solution, work, system)


@compiled
def follow_row(b, case, problem, solution, work, system):
    """Row ``b`` with friction."""
    case, problem, solution = by_address(case), by_address(problem), by_address(solution)
    work, system, mu = by_address(work), by_address(system), problem.friction[0]
    q, tension, start, parts = solution.bend[b], solution.tension[b], problem.start[b], problem.increments[b]
    tolerance, most = problem.friction[2], int(problem.friction[3])
    note(b, follow(q, tension, case, mu, start, parts, tolerance, most, work, system), solution)
    write_row(b, case, problem, solution, work, system)


@compiled
def creep_row(b, case, slow, problem, solution, work, system):
    """Row ``b``, the trunk creeping."""
    case, slow, problem, solution = by_address(case), by_address(slow), by_address(problem), by_address(solution)
    work, system, mu, motion = by_address(work), by_address(system), problem.friction[0], problem.motion[b]
    q, tension, start, tolerance = solution.bend[b], solution.tension[b], problem.start[b], problem.friction[2]
    if motion[1] > 0.0:
        most = int(problem.friction[3])
        found = creep(q, tension, case, mu, start, motion, tolerance, most, slow, work, system)
        note(b, found, solution)
        if mu == 0.0:
            release(work.gap, solution.anchor[b])
    else:
        load_row(b, case, problem, solution, work, system)
    write_row(b, case, problem, solution, work, system)


@compiled
def load_row(b, case, problem, solution, work, system):
    """Bends and tensions of row ``b`` without friction."""
    q, tension, start, tolerance = solution.bend[b], solution.tension[b], problem.start[b], problem.friction[2]
    note(b, load_at_once(q, tension, case, start, tolerance, int(problem.friction[3]), work, system), solution)


@owning
def room_for_rows(nd, trunk):
    """`Work` and `System` for trunks like this."""
    n_joint, n_cable = trunk.before.shape[0], trunk.before.shape[1]
    return room_for_work(n_joint, n_cable, nd), room_for_steps(n_joint, n_cable, nd, trunk.stiffness)


@owning
def build_case(b, trunk, problem, solution):
    """Row ``b`` as the laws read it; its holes' anchors are the solution's."""
    mu, stiffness, size = problem.friction[0], problem.friction[1], (trunk.before.shape[0], trunk.before.shape[1])
    control = Control(problem.by_tension, problem.length[b], problem.most[b], problem.compliance)
    field = (problem.direction[b], problem.factor[b], problem.moment[b])
    friction = Friction(np.zeros(size), np.zeros(size), solution.anchor[b], stiffness if mu > 0.0 else 0.0)
    return Case(problem.base[b], trunk, field, control, friction)


@compiled
def note(b, found, solution):
    """Residual, violation and steps of row ``b``."""
    figures = solution.figures[b]
    figures[0], figures[1], figures[2] = found


@compiled
def write_row(b, case, problem, solution, work, system):
    """What follows from the bends and tensions of row ``b``, just found."""
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
    """Angles between the sections, what the cables gave, which faces meet, and the status of row ``b``."""
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
    """Section ends into ``points`` (n_section, 3)."""
    for x in range(3):
        end = 0.0
        for n in range(length.shape[0]):
            end += length[n] * frames[n, x, 0]
            points[n, x] = end
