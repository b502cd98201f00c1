"""Simultaneous Newton iteration in shape and tensions; a fast path, used where it converges.

A step takes away what the bends are out of balance by, and moves the tensions by what the target is then still missed
by, both from one factor of the energy's Hessian. Nothing guards it but a count: where it does not converge quickly, the
search that balances every shape on its way takes over.
"""

from __future__ import annotations

import math

from spiraltrunk.model.inverse.kernels import compiled
from spiraltrunk.model.inverse.kernels.levenberg_marquardt import BALANCED, bounded_step, normal_equations
from spiraltrunk.model.inverse.kernels.target_residual import (
    chain_rates,
    evaluate_residual,
    place_sections,
    residual_jacobian,
    turn_back,
)
from spiraltrunk.model.statics.kernels.cholesky import copy, copy_rows, solve_columns
from spiraltrunk.model.statics.kernels.newton_calls import (
    activate_limits,
    factorise_guarded,
    has_factor,
    linearise_equilibrium,
    move_trunk,
)
from spiraltrunk.model.statics.kernels.projected_newton import STEP, largest_turn

MAX_STEPS = 10
"""Most steps."""
SLACKENING = 0.5
"""Part of the last distance that is left, of target and balance together, above which a step counts as failed [-]."""
FAILURES = 2
"""Failed steps after which it is given up."""
LEVER = 1.0
"""Turns a moment that is left into a distance when the two are added [m/(N m)]."""
DAMPING = 1e-9
"""Levenberg and Marquardt's, next to none [-]."""


@compiled
def solve_simultaneously(b, enough, tolerance, case, targets, work, system, room):
    """Bends and tensions for target ``b`` from those in ``room.trial`` and ``tension``, into ``room.q`` and ``kept``.

    Returns whether the target is met within half of ``enough`` [m], in balance within ``tolerance`` [N m], and the
    moment left [N m]; then ``work`` and ``system`` hold the equations there.
    """
    q, tension, trunk, before, failures = room.q, room.kept, case.trunk, 1e300, 0
    copy_rows(room.trial, q)
    copy(room.tension, tension)
    room.state[1] = DAMPING
    for _ in range(MAX_STEPS):
        left = linearise_equilibrium(q, tension, room.tension, case, work, system)
        place_sections(work, trunk.length, room.points, room.heads)
        norm = math.sqrt(2 * evaluate_residual(b, room.points, room.heads, targets, room.residual))
        if left <= tolerance and norm <= 0.5 * enough:
            return True, left
        now = norm + LEVER * left
        failures += 1 if now > SLACKENING * before else 0
        before = now
        if failures > FAILURES or not has_factor(q, case, work, system):
            return False, left
        simultaneous_step(b, left <= BALANCED and norm <= 0.5 * enough, case, targets, work, system, room)
    return False, left


@compiled
def simultaneous_step(b, is_met, case, targets, work, system, room):
    """One step of bends and tensions from the equations in ``system``, whose factor is in ``work``.

    Where the target is met already the bends alone move, to balance at these tensions.
    """
    most, step = case.control.most, system.step
    respond(room.q, case, work, system, room)
    room.step[:] = 0.0
    if not is_met:
        step_towards_targets(b, case, targets, work, system, room)
    share = min(1.0, STEP / max(largest_turn(step, room.q.shape[0]), 1e-300))
    system.pressed[:] = False  # The step is in the joints' own axes already.
    move_trunk(room.q, case, share, work, system)
    copy_rows(system.trial, room.q)
    for c in range(most.shape[0]):
        room.kept[c] = min(max(room.kept[c] + share * room.step[c], 0.0), most[c])


@compiled
def respond(q, case, work, system, room):
    """Newton's step at held tensions, into ``system.step``, and the bends per tension of each cable, ``room.rates``.

    As `descend` and `tension_sensitivity`, at once; the Hessian's factor is in ``work``.
    """
    step, rates, columns, nd = system.step, room.rates, room.columns, work.first.shape[1]
    for turn in range(4):
        if turn > 0:
            factorise_guarded(q, case, work, system)
        for row in range(step.shape[0]):
            columns[row, 0] = -system.gradient[row]
            for c in range(rates.shape[0]):
                columns[row, 1 + c] = -system.slopes[c, row]
        solve_columns(work.factor, columns)
        for row in range(step.shape[0]):
            step[row] = columns[row, 0]
        if not activate_limits(q, case, work, system):
            break
    for c in range(rates.shape[0]):
        for row in range(step.shape[0]):
            rates[c, row] = columns[row, 1 + c]
        turn_back(rates[c], system, nd)
    turn_back(step, system, nd)


@compiled
def step_towards_targets(b, case, targets, work, system, room):
    """Tensions' step towards the target, into ``room.step``, and what it moves the bends by, added to their step."""
    trunk, most, step = case.trunk, case.control.most, system.step
    chain_rates(step, work, trunk.length, room.ends, room.turns)
    residual_jacobian(b, room.points, room.heads, room.ends, room.turns, targets, room.slopes[0])
    for row in range(room.residual.shape[0]):
        room.residual[row] += room.slopes[0, row]
    for c in range(most.shape[0]):
        chain_rates(room.rates[c], work, trunk.length, room.ends, room.turns)
        residual_jacobian(b, room.points, room.heads, room.ends, room.turns, targets, room.slopes[c])
    normal_equations(room, most)
    bounded_step(room, most)
    for c in range(most.shape[0]):
        for row in range(step.shape[0]):
            step[row] += room.step[c] * room.rates[c, row]
