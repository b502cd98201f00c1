"""Multistart search: rank known equilibria as starts, search from each, and re-solve from the straight trunk."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from spiraltrunk.model.inverse.kernels import calling, compiled, owning
from spiraltrunk.model.inverse.kernels.levenberg_marquardt import room_for_search, search
from spiraltrunk.model.inverse.kernels.simultaneous_newton import solve_simultaneously
from spiraltrunk.model.inverse.kernels.target_residual import evaluate_residual, place_sections
from spiraltrunk.model.statics.kernels.address import by_address
from spiraltrunk.model.statics.kernels.batch import NUDGE, build_case, room_for_rows, write_row
from spiraltrunk.model.statics.kernels.cholesky import copy, copy_rows
from spiraltrunk.model.statics.kernels.laws.energy import Work
from spiraltrunk.model.statics.kernels.newton_calls import converges_to, solve_safely
from spiraltrunk.model.statics.kernels.projected_newton import System
from spiraltrunk.model.statics.kernels.zeros import counts, flags, zeros


class Starts(NamedTuple):
    """Equilibria from which targets are sought, s of them, each solved from the straight trunk."""

    tension: np.ndarray
    """Shape (s, n_cable) [N]."""
    effort: np.ndarray
    """By which part of its distance each ranks behind a slack one, shape (s,) [-]."""
    bend: np.ndarray
    """Bends of the joints, shape (s, n_joint, 3) [rad]."""
    points: np.ndarray
    """Section ends, shape (s, n_section, 3) [m]."""
    heads: np.ndarray
    """Axes of the sections, shape (s, n_section, 3) [-]."""


class Limits(NamedTuple):
    """Limits and tolerances of the search."""

    tries: int
    """Starts at most."""
    rounds: int
    """Equilibria from one start at most."""
    enough: float
    """Norm of the residuals within which a target is met [m]."""
    apart: float
    """Distance by which the tips of every other start lie apart [m]."""
    close: float
    """Distance beyond which a start's tension ranks it no further behind [m]."""
    nd: int
    """Bends of a joint."""
    slack: float
    """Tension up to which a cable hardly pulls against the others [N]."""


class Spare(NamedTuple):
    """More room: for a second way to a shape, and for the ranks of the known equilibria."""

    work: Work
    system: System
    score: np.ndarray
    order: np.ndarray
    other: np.ndarray
    is_free: np.ndarray


@owning
def room_for_ranks(count, nd, trunk):
    """`Spare` for a trunk and so many known equilibria."""
    work, system = room_for_rows(nd, trunk)
    order, other = counts(count), counts(count)
    return Spare(work, system, zeros(count), order, other, flags(count))


@calling
def solve_target_rows(rows, limits, is_bare, trunk, problem, targets, starts, turn, solution):
    """Tensions for the targets ``rows`` of one stand, and their equilibria from the straight trunk, into ``solution``.

    ``is_bare`` says that no load hangs on the trunk; ``turn`` brings the known equilibria to this stand. With no tries
    the tensions are those in ``solution``: so the known equilibria are found, and nothing else is compiled for them.
    """
    work, system = room_for_rows(limits.nd, trunk)
    room = room_for_search(trunk.before.shape[0], trunk.before.shape[1], limits.nd)
    spare = room_for_ranks(starts.effort.shape[0], limits.nd, trunk)
    for r in range(rows.shape[0]):
        case = build_case(rows[r], trunk, problem, solution)
        solve_target_row(
            rows[r], limits, is_bare, case, problem, targets, starts, turn, solution, work, system, room, spare
        )


@compiled
def solve_target_row(b, limits, is_bare, case, problem, targets, starts, turn, solution, work, system, room, spare):
    """Row ``b``."""
    case, problem, targets, starts = by_address(case), by_address(problem), by_address(targets), by_address(starts)
    limits, solution, work, system = by_address(limits), by_address(solution), by_address(work), by_address(system)
    room, spare = by_address(room), by_address(spare)
    if limits.tries > 0:
        rank(b, targets, starts, turn, limits.close, spare.score, room)
        search_from_starts(b, limits, is_bare, case, problem, targets, starts, solution, work, system, room, spare)
    else:
        copy(solution.tension[b], room.kept)
        solve_anew(b, case, problem, solution, work, system, room)
    write_row(b, case, problem, solution, work, system)


@compiled
def search_from_starts(b, limits, is_bare, case, problem, targets, starts, solution, work, system, room, spare):
    """One target from the best ranked start on, until it is met or there are no more to try."""
    best, norm, tolerance, score, order = 1e300, 1e300, problem.friction[2], spare.score, spare.order
    start = least(score)
    for attempt in range(min(limits.tries, score.shape[0])):
        if attempt == 1:
            sort(score, order, spare.other)
        if attempt > 0:
            start = pick(order, attempt, limits.apart, starts.points, spare.is_free)
        begin(start, starts, room)
        is_there, left = solve_simultaneously(b, limits.enough, tolerance, case, targets, work, system, room)
        if not is_there:
            begin(start, starts, room)
            search(b, limits.rounds, limits.enough, case, targets, work, system, room)
        if not (is_there and is_found(b, left, limits, is_bare, case, solution, room, spare)):
            solve_anew(b, case, problem, solution, work, system, room)
        norm = look_at(b, case, targets, work, room)
        if norm < best:
            best = norm
            copy(room.kept, room.best)
        if best <= limits.enough:
            break
    if norm != best:  # The last attempt was not the best one.
        copy(room.best, room.kept)
        solve_anew(b, case, problem, solution, work, system, room)


@compiled
def begin(start, starts, room):
    """Put a known equilibrium on trial."""
    copy_rows(starts.bend[start], room.trial)
    copy(starts.tension[start], room.tension)


@compiled
def look_at(b, case, targets, work, room):
    """Norm of the residuals of the placed chain [m]."""
    place_sections(work, case.trunk.length, room.points, room.heads)
    return math.sqrt(2 * evaluate_residual(b, room.points, room.heads, targets, room.residual))


@compiled
def is_found(b, left, limits, is_bare, case, solution, room, spare):
    """Whether the equilibrium in ``room`` is what the iteration from the straight trunk goes to; if so, row ``b``."""
    q, tension, figures = solution.bend[b], solution.tension[b], solution.figures[b]
    _make_straight(q)
    copy(room.kept, tension)
    is_clear = is_bare and is_unique(limits, case, room)
    if not is_clear and not converges_to(room.q, q, tension, case, spare.work, spare.system):
        return False
    copy_rows(room.q, q)
    figures[0], figures[1], figures[2] = left, 0.0, 0.0
    return True


@compiled
def is_unique(limits, case, room):
    """Whether the equilibrium of the unloaded trunk at the tensions ``room.kept`` is unique (empirical criterion).

    Several shapes need cables that pull against each other, a load, or a trunk that stands up and may topple; without
    these none was found in tens of thousands of draws (`benchmarks/statics_ways.py`).
    """
    down = 0.0
    for x in range(3):
        down += case.base[x, 0] * case.field[0][0, x]
    return down >= 0.0 and room.kept[least(room.kept)] <= limits.slack


@compiled
def solve_anew(b, case, problem, solution, work, system, room):
    """Row ``b`` of the solution: the equilibrium at the tensions ``room.kept``, from the straight trunk."""
    q, tension, figures = solution.bend[b], solution.tension[b], solution.figures[b]
    _make_straight(q)
    copy(room.kept, tension)
    residual, violation, steps = solve_safely(
        q, tension, case, problem.friction[2], int(problem.friction[3]), work, system
    )
    figures[0], figures[1], figures[2] = residual, violation, steps


@compiled
def _make_straight(q):
    for i in range(q.shape[0]):
        q[i, 0], q[i, 1], q[i, 2] = NUDGE, NUDGE, 0.0


@compiled
def rank(b, targets, starts, turn, close, score, room):
    """Norm of target ``b``'s residuals at every start, turned to this stand, with its effort, into ``score`` [m]."""
    if targets.deep == 0.0:
        _rank_places(b, targets, starts, turn, score, room.place)
    else:
        _rank_curls(b, targets, starts, turn, score, room)
    for s in range(score.shape[0]):
        score[s] += min(score[s], close) * starts.effort[s]


@compiled
def _rank_places(b, targets, starts, turn, score, place):
    """The norms for a target without a circle, which is turned to the starts instead of them to it."""
    last = starts.points.shape[1] - 1
    for s in range(score.shape[0]):
        score[s] = 0.0
    for n in range(last + 1):
        if targets.weight[n] != 0.0:
            _turn_back(turn, targets.point[b, n], place)
            _add_squares(targets.weight[n], starts.points[:, n], place, score)
    if targets.turn != 0.0:
        _turn_back(turn, targets.heading[b], place)
        _add_squares(targets.turn, starts.heads[:, last], place, score)
    for s in range(score.shape[0]):
        score[s] = math.sqrt(score[s])


@compiled
def _add_squares(weight, vectors, wanted, score):
    for s in range(score.shape[0]):
        x, y, z = vectors[s, 0] - wanted[0], vectors[s, 1] - wanted[1], vectors[s, 2] - wanted[2]
        score[s] += weight * weight * (x * x + y * y + z * z)


@compiled
def _rank_curls(b, targets, starts, turn, score, room):
    places, axes, points, heads = starts.points, starts.heads, room.points, room.heads
    for s in range(score.shape[0]):
        for n in range(places.shape[1]):
            _turn(turn, places[s, n], points[n])
            _turn(turn, axes[s, n], heads[n])
        score[s] = math.sqrt(2 * evaluate_residual(b, points, heads, targets, room.residual))


@compiled
def _turn(turn, vector, out):
    for x in range(3):
        out[x] = turn[x, 0] * vector[0] + turn[x, 1] * vector[1] + turn[x, 2] * vector[2]


@compiled
def _turn_back(turn, vector, out):
    for x in range(3):
        out[x] = turn[0, x] * vector[0] + turn[1, x] * vector[1] + turn[2, x] * vector[2]


@compiled
def least(values):
    """Where the least value is, the first of several."""
    best = 0
    for k in range(1, values.shape[0]):
        if values[k] < values[best]:
            best = k
    return best


@compiled
def sort(values, order, other):
    """Write the order that sorts ``values``, equal ones kept in order, into ``order`` (merge sort)."""
    count, run = values.shape[0], 1
    for k in range(count):
        order[k] = k
    while run < count:
        for first in range(0, count, 2 * run):
            a, b, middle, last = first, first + run, min(first + run, count), min(first + 2 * run, count)
            for k in range(first, last):
                is_right = b < last and (a >= middle or values[order[b]] < values[order[a]])
                other[k] = order[b] if is_right else order[a]
                a, b = (a, b + 1) if is_right else (a + 1, b)
        for k in range(count):
            order[k] = other[k]
        run *= 2


@compiled
def pick(order, attempt, apart, points, is_free):
    """Start of an attempt: in turns the next in the order, and the next whose tip is ``apart`` from those before."""
    if attempt % 2 == 0:
        return order[attempt // 2]
    last, chosen = points.shape[1] - 1, 0
    for k in range(order.size):
        is_free[k] = True
    for _ in range(attempt // 2 + 1):
        is_any, first = False, 0
        for k in range(order.size):
            away = 0.0
            for x in range(3):
                away += (points[order[k], last, x] - points[order[chosen], last, x]) ** 2
            is_free[k] = is_free[k] and away > apart * apart
            if is_free[k] and not is_any:
                is_any, first = True, k
        if not is_any:
            return order[attempt % order.size]
        chosen = first
    return order[chosen]
