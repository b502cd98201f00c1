"""Tensions whose equilibrium is nearest to a target: Levenberg and Marquardt's method within bounds.

The unknowns are the tensions alone. Every step moves the shape along with them by the equilibrium's own slope, so that
the next equilibrium is a step or two of Newton's method away.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from spiraltrunk.model.inverse.kernels import compiled, owning
from spiraltrunk.model.inverse.kernels.target_residual import (
    chain_rates,
    evaluate_residual,
    place_sections,
    residual_jacobian,
    tension_sensitivity,
)
from spiraltrunk.model.statics.kernels.cholesky import copy, copy_rows, dot, solve_small
from spiraltrunk.model.statics.kernels.newton_calls import factorise_guarded, move_trunk, solve_safely
from spiraltrunk.model.statics.kernels.projected_newton import STEP, largest_turn
from spiraltrunk.model.statics.kernels.zeros import flags, zeros

BALANCED = 1e-7
"""Largest moment left at a joint near the target [N m]; about a thousandth of a millimetre at the tip."""
COARSE = 1e-5
"""Largest moment left on the way [N m]."""
SHARPER = 1e-3
"""Moment left per distance to the target [N m/m]."""
STEPS = np.int64(200)
"""Steps of Newton's method after which a trial is given up; like any number to the compiler."""
FRUGAL = 1e-5
"""The largest tension counts like this distance [m], so that tensions that change nothing do not grow."""
FLAT = 1e-9
"""Part of the cost below which a gain ends the search [-]."""


class Room(NamedTuple):
    """Room for one search: the best shape and tensions, those on trial, residuals and slopes."""

    q: np.ndarray
    kept: np.ndarray
    trial: np.ndarray
    tension: np.ndarray
    points: np.ndarray
    heads: np.ndarray
    ends: np.ndarray
    turns: np.ndarray
    rates: np.ndarray
    residual: np.ndarray
    slopes: np.ndarray
    matrix: np.ndarray
    right: np.ndarray
    step: np.ndarray
    damped: np.ndarray
    wish: np.ndarray
    held: np.ndarray
    best: np.ndarray
    place: np.ndarray
    columns: np.ndarray
    state: np.ndarray
    """Cost [m^2], damping [-], norm of the residuals [m], part of the cost last gained [-]."""


@owning
def room_for_search(n_joint, n_cable, nd):
    """`Room` for a trunk."""
    n_section, parts = n_joint + 1, 5 * n_joint + 8
    return Room(
        zeros((n_joint, 3)), zeros(n_cable), zeros((n_joint, 3)), zeros(n_cable),
        zeros((n_section, 3)), zeros((n_section, 3)), zeros((n_section, 3)), zeros((n_section, 3)),
        zeros((n_cable, n_joint * nd)), zeros(parts), zeros((n_cable, parts)),
        zeros((n_cable, n_cable)), zeros(n_cable), zeros(n_cable),
        zeros((n_cable, n_cable)), zeros(n_cable), flags(n_cable), zeros(n_cable), zeros(3),
        zeros((n_joint * nd, 4 * (n_cable // 4 + 1))), zeros(4),
    )  # fmt: skip


@compiled
def search(b, rounds, enough, case, targets, work, system, room):
    """Bends and tensions for target ``b`` from those in ``room.trial`` and ``tension``, into ``room.q``, ``kept``."""
    most = case.control.most
    copy_rows(room.trial, room.q)
    copy(room.tension, room.kept)
    room.state[0], room.state[1], room.state[2], room.state[3] = 1e300, 1e-6, 1e300, 1.0
    for _ in range(rounds):
        balanced = max(BALANCED, min(COARSE, SHARPER * room.state[2]))
        left, _, _ = solve_safely(room.trial, room.tension, case, balanced, STEPS, work, system)
        accept_step(b, left <= balanced, enough, targets, case, work, system, room)
        if is_over(enough, room):
            break
        bounded_step(room, most)
        propose(case, most, work, system, room)


@compiled
def accept_step(b, is_balanced, enough, targets, case, work, system, room):
    """Keep the shape on trial if it is nearer than the best one, with slopes there if need be; else damp more."""
    cost, most = 1e300, case.control.most
    if is_balanced:
        place_sections(work, case.trunk.length, room.points, room.heads)
        norm = math.sqrt(2 * evaluate_residual(b, room.points, room.heads, targets, room.residual))
        cost = 0.5 * norm * norm
        for c in range(most.shape[0]):
            cost += 0.5 * (FRUGAL * room.tension[c] / most[c]) ** 2
    if not cost < room.state[0]:
        room.state[1] = max(10 * room.state[1], 1e-4)
        return
    room.state[3] = (room.state[0] - cost) / max(cost, 1e-300)
    room.state[0], room.state[1], room.state[2] = cost, max(room.state[1] / 10, 1e-9), norm
    copy_rows(room.trial, room.q)
    copy(room.tension, room.kept)
    if is_over(enough, room):
        return
    factorise_guarded(room.trial, case, work, system)
    tension_sensitivity(room.trial, case, work, system, room.rates)
    for c in range(room.rates.shape[0]):
        chain_rates(room.rates[c], work, case.trunk.length, room.ends, room.turns)
        residual_jacobian(b, room.points, room.heads, room.ends, room.turns, targets, room.slopes[c])
    normal_equations(room, most)


@compiled
def is_over(enough, room):
    """Whether the target is met, or nothing more is to be gained."""
    cost, damping, norm, gained = room.state
    return cost >= 1e300 or norm <= 0.5 * enough or damping > 1e8 or gained < FLAT


@compiled
def normal_equations(room, most):
    """Gauss and Newton's matrix and gradient; the tensions themselves weigh a little."""
    for c in range(most.shape[0]):
        light = (FRUGAL / most[c]) ** 2
        room.right[c] = dot(room.slopes[c], room.residual) + light * room.kept[c]
        for d in range(c + 1):
            room.matrix[c, d] = dot(room.slopes[c], room.slopes[d])
            room.matrix[d, c] = room.matrix[c, d]
        room.matrix[c, c] += light


@compiled
def bounded_step(room, most):
    """Damped step that leaves every tension within 0 and the largest; what meets a bound is held there."""
    count, step, kept, held, wish = most.shape[0], room.step, room.kept, room.held, room.wish
    for c in range(count):
        step[c] = 0.0
        held[c] = (kept[c] <= 0.0 and room.right[c] > 0) or (kept[c] >= most[c] and room.right[c] < 0)
    for _ in range(count):
        free_step(room)
        again = False
        for c in range(count):
            if not held[c]:
                step[c] = min(max(wish[c], -kept[c]), most[c] - kept[c])
                if step[c] != wish[c]:
                    held[c], again = True, True
        if not again:
            return


@compiled
def free_step(room):
    """Damped step of the tensions that are not held, the held ones moving as they do, into ``room.wish``."""
    system, wish, held, count = room.damped, room.wish, room.held, room.held.shape[0]
    copy_rows(room.matrix, system)
    for c in range(count):
        wish[c] = -room.right[c]
        system[c, c] += room.state[1] * room.matrix[c, c]
    for c in range(count):
        if held[c]:
            for d in range(count):
                if not held[d]:
                    wish[d] -= system[d, c] * room.step[c]
                system[c, d], system[d, c] = 0.0, 0.0
            wish[c], system[c, c] = room.step[c], 1.0
    solve_small(system, wish, count)


@compiled
def propose(case, most, work, system, room):
    """Tensions and bends to try next; the step is cut to the largest turn of a joint."""
    system.step[:] = 0.0
    for c in range(most.shape[0]):
        for row in range(system.step.shape[0]):
            system.step[row] += room.step[c] * room.rates[c, row]
    share = min(1.0, STEP / max(largest_turn(system.step, room.q.shape[0]), 1e-300))
    system.pressed[:] = False  # The rates are in the joints' own axes already.
    move_trunk(room.q, case, share, work, system)
    copy_rows(system.trial, room.trial)
    for c in range(most.shape[0]):
        room.tension[c] = min(max(room.kept[c] + share * room.step[c], 0.0), most[c])
