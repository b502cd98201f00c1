"""Equilibrium by a projected Newton method; joint limits as an active set, cable lengths by augmented Lagrangian.

A primal-dual step changes shape and tensions together, up to the largest turn of a joint, with a line search on the
merit function. Where the merit does not fall, the method of multipliers takes over, which always converges: the
augmented Lagrangian is minimised at held multipliers, then the multipliers are updated.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from spiraltrunk.model.statics.kernels import compiled, owning
from spiraltrunk.model.statics.kernels.address import by_address
from spiraltrunk.model.statics.kernels.cholesky import copy, copy_rows, dot, factorise, solve_factored, solve_small
from spiraltrunk.model.statics.kernels.laws.energy import (
    add_penalty,
    find_excess,
    linearise_placed,
    merit,
    merit_placed,
    place,
    replace_parts,
    replace_trunk,
    update_tensions,
)
from spiraltrunk.model.statics.kernels.laws.joint_limits import activate_outward_limits, move, project_to_limits, reduce
from spiraltrunk.model.statics.kernels.zeros import counts, flags, zeros

STEP = 0.35
"""Largest turn of a joint in one step [rad]."""
TIGHT = 1e-10
"""Tolerance of the cables' lengths [m]."""
PENALTY = 1e3
"""First stiffness of the penalty on the cables' lengths [N/m]."""
LEVER = 0.025
"""Length that makes a cable's violation comparable to a residual [m]; about a hole's distance from the joint."""

CLOSE = 1e-3
"""Violation below which the penalty is raised until the Hessian is positive definite [m]."""
STIFFEST = 1e7
"""Largest penalty reached that way [N/m]."""
FIRST = 60
"""Largest number of steps before the gaps are smoothed."""
SOFTEST = 3e-3
"""Three times the first smoothing length of the gaps [m]."""
NONE = np.int64(0)
"""Start of a count, an integer of the type that the compiler infers for counts."""


class System(NamedTuple):
    """Linear equations of one step, reduced to the active set, their solution and workspace."""

    gradient: np.ndarray
    slopes: np.ndarray
    pressed: np.ndarray
    reaction: np.ndarray
    weight: np.ndarray
    step: np.ndarray
    response: np.ndarray
    active: np.ndarray
    excess: np.ndarray
    next_tension: np.ndarray
    next_length: np.ndarray
    trial: np.ndarray
    normal: np.ndarray
    rim: np.ndarray
    pulls: np.ndarray
    next_pulls: np.ndarray
    length: np.ndarray
    final: np.ndarray
    keep: np.ndarray
    close: np.ndarray
    matrix: np.ndarray
    copied: np.ndarray
    chosen: np.ndarray
    motion: np.ndarray
    columns: np.ndarray


@owning
def room_for_steps(n_joint, n_cable, nd, stiffness):
    """`System` for a trunk."""
    size = n_joint * nd
    weight = zeros(size)
    for row in range(size):
        weight[row] = stiffness[row // nd, row % nd]
    return System(
        zeros(size), zeros((n_cable, size)), flags(n_joint), zeros(n_joint), weight,
        zeros(size), zeros((n_cable, size)), flags(n_cable), zeros(n_cable), zeros(n_cable),
        zeros(n_cable), zeros((n_joint, 3)), zeros((n_joint, 2)), zeros(3),
        zeros(n_cable), zeros(n_cable), zeros(n_cable), zeros(n_cable), zeros(n_cable),
        zeros(n_cable), zeros((n_cable, n_cable)), zeros((n_cable, n_cable)), counts(n_cable),
        zeros((3, size)), zeros((size, 4)),
    )  # fmt: skip


@compiled
def guarded_factor(work, weight):
    """Factorise the Hessian plus the smallest of a series of shifts, 0 first, that makes it positive definite."""
    shift = 0.0
    while not factorise(work.hessian, work.factor, weight, shift):
        shift = 0.05 if shift == 0.0 else 2.5 * shift


@compiled
def descend(q, trunk, work, system):
    """Newton step at held tensions into ``system.step``; joints that it would move past their limit become active.

    ``work`` holds the factor of the Hessian.
    """
    for turn in range(4):
        if turn > 0:
            guarded_factor(work, system.weight)
        solve_factored(work.factor, system.gradient, system.step)
        for row in range(system.step.shape[0]):
            system.step[row] = -system.step[row]
        if not activate_outward_limits(q, trunk, work, system):
            return


@compiled
def largest_turn(step, n_joint):
    """Largest turn of a joint in a step [rad]."""
    worst, nd = 0.0, step.shape[0] // n_joint
    for i in range(n_joint):
        worst = max(worst, step[i * nd] ** 2 + step[i * nd + 1] ** 2)
    return math.sqrt(worst)


@compiled
def schur_complement(control, penalty, work, system):
    """Schur complement of the active cables into the leading rows of ``system.matrix``; returns their number.

    ``system.chosen`` receives their indices, ``system.response`` the bends per tension of each.
    """
    matrix, index, count = system.matrix, system.chosen, NONE
    for c in range(system.active.shape[0]):
        if system.active[c]:
            solve_factored(work.factor, system.slopes[c], system.response[count])
            index[count] = c
            count += 1
    for a in range(count):
        for b in range(count):
            matrix[a, b] = dot(system.slopes[index[a]], system.response[b])
        give = control.compliance[index[a]]
        stiff = penalty / (1 + penalty * give)
        matrix[a, a] = matrix[a, a] * (1 + 1e-12) + give / (1 - stiff * give) + 1e-15
    return count


@compiled
def add_tension_step(control, pulls, penalty, system, work):
    """Change the tensions so that the active cables reach their lengths, as far as the largest turn of a joint allows.

    Adds what that moves to ``system.step``; fills ``system.next_tension`` and ``system.next_length``.
    """
    index, keep, close = system.chosen, system.keep, system.close
    count = schur_complement(control, penalty, work, system)
    for a in range(count):
        c = index[a]
        stiff = penalty / (1 + penalty * control.compliance[c])
        keep[a] = dot(system.slopes[c], system.step)
        close[a] = system.excess[c] / (1 - stiff * control.compliance[c])
    copy_rows(system.matrix, system.copied)
    solve_small(system.matrix, keep, count)
    solve_small(system.copied, close, count)
    share = limit_share(system, count)
    for c in range(pulls.shape[0]):
        system.next_tension[c], system.next_length[c] = pulls[c], control.length[c]
    for a in range(count):
        c = index[a]
        pull = keep[a] + share * close[a]
        for row in range(system.step.shape[0]):
            system.step[row] -= pull * system.response[a, row]
        stiff = penalty / (1 + penalty * control.compliance[c])
        change = (pull - stiff * share * system.excess[c]) / (1 - stiff * control.compliance[c])
        system.next_tension[c] = min(max(pulls[c] + change, 0.0), control.most[c])
        system.next_length[c] = control.length[c] + (1 - share) * system.excess[c]


@compiled
def limit_share(system, count):
    """Largest share of the excess lengths that one step may remove, by the largest turn of a joint [-].

    ``system.keep`` holds the change of tensions that keeps the lengths, ``system.close`` that which removes the excess.
    """
    worst, nd = 1.0, system.step.shape[0] // system.pressed.shape[0]
    for i in range(system.pressed.shape[0]):
        kept, turn = 0.0, 0.0
        for row in range(i * nd, i * nd + 2):
            fixed, moved = system.step[row], 0.0
            for a in range(count):
                fixed -= system.keep[a] * system.response[a, row]
                moved -= system.close[a] * system.response[a, row]
            kept += fixed * fixed
            turn += moved * moved
        margin = max(STEP - math.sqrt(kept), 0.2 * STEP)
        if turn > margin * margin:
            worst = min(worst, margin / math.sqrt(turn))
    return worst


@compiled
def line_search(q, case, multiplier, penalty, slope, work, system):
    """Backtracking line search on the merit (Armijo); returns the share of the step taken, 0 where it never falls.

    ``work`` must be placed at ``q``; where the merit fell it is then placed at the new ``q``.
    """
    before = merit_placed(q, case, multiplier, penalty, work)
    share = min(1.0, STEP / max(largest_turn(system.step, q.shape[0]), 1e-300))
    noise = 1e-14 * (abs(before) + 1.0)
    for _ in range(30):
        move(q, case.trunk, system, share)
        after = merit(system.trial, case, multiplier, penalty, work)
        if after <= before + 1e-4 * share * slope + (noise if -slope < 1e-9 else 0.0):
            copy_rows(system.trial, q)
            return share
        share *= 0.4
    return 0.0


@compiled
def primal_dual_step(q, tension, case, goal, penalty, work, system):
    """One step of shape and tensions together; returns whether the merit of ``goal``, the next lengths, fell."""
    add_tension_step(case.control, tension, penalty, system, work)
    update_tensions(work.gap, goal.control, system.next_tension, penalty, system.next_pulls)
    slope = dot(system.gradient, system.step)
    for c in range(tension.shape[0]):
        slope += (system.next_pulls[c] - tension[c]) * dot(system.slopes[c], system.step)
    if slope >= 0:
        return False
    share = line_search(q, goal, system.next_tension, penalty, slope, work, system)
    for c in range(tension.shape[0]):
        tension[c] += share * (system.next_tension[c] - tension[c])
    return share > 0.0


@compiled
def linearise_reduced(q, tension, pulls, case, penalty, work, system):
    """Linearise at ``q``, where ``work`` is placed, and reduce to the active set; returns residual and violation.

    The winders' tensions ``pulls`` are ``tension`` where the penalty is 0, else those of the augmented Lagrangian.
    """
    copy(tension, pulls)
    if penalty > 0.0:
        update_tensions(work.gap, case.control, tension, penalty, pulls)
    linearise_placed(q, case, pulls, work)
    reduce(q, case.trunk, work, system)
    left = 0.0
    for row in range(system.gradient.shape[0]):
        size = abs(system.gradient[row])
        if not size <= left and left == left:  # NaN is kept.
            left = size
    return left, find_excess(work.gap, case.control, pulls, system)


@compiled
def factorise_step(penalty, violation, work, system):
    """Factorise the Hessian; False where it is indefinite and a larger penalty on the cables' lengths may mend that.

    Along the constraints of the cables the energy may be concave; with a stiff enough penalty the merit is not.
    """
    for c in range(system.active.shape[0]):
        if system.active[c] and violation < CLOSE and penalty < STIFFEST:
            return factorise(work.hessian, work.factor, system.weight, 0.0)
    guarded_factor(work, system.weight)
    return True


@compiled
def solve(q, tension, case, tolerance, most, work, system):
    """Bring ``q`` (n_joint, 3) and ``tension`` (n_cable) to equilibrium, in place.

    Returns the residual [N m], the cables' violation [m] and the number of steps. ``system.reaction`` receives the
    reactions at the joint limits [N m], ``work.tension`` the tensions of all gaps [N].
    """
    control, pulls = case.control, system.pulls
    goal = by_address(replace_parts(case, case.trunk, system.next_length))
    project_to_limits(q, case.trunk, system.rim)
    penalty, tries, is_primal_dual, before, is_placed = PENALTY, 3, True, 1e300, False
    for count in range(most + 1):
        if not is_placed:
            place(q, case.base, case.trunk, work)
        is_placed, used = True, 0.0 if is_primal_dual else penalty
        residual, violation = linearise_reduced(q, tension, pulls, case, used, work, system)
        if (residual <= tolerance and violation <= TIGHT) or count == most:
            break
        if not is_primal_dual and residual <= max(tolerance, 0.1 * violation / LEVER):
            copy(pulls, tension)
            penalty = min(10 * penalty, 1e10) if violation > 0.1 * before else penalty
            before, is_primal_dual = violation, tries > 0
            continue
        add_penalty(system, control, penalty, work.hessian)
        if not factorise_step(penalty, violation, work, system):
            penalty *= 10
            continue
        descend(q, case.trunk, work, system)
        if is_primal_dual:
            is_placed = primal_dual_step(q, tension, case, goal, penalty, work, system)
            if not is_placed:
                is_primal_dual, tries, before = False, tries - 1, 1e300
        else:
            slope = dot(system.gradient, system.step)
            is_placed = line_search(q, case, tension, penalty, slope, work, system) > 0.0
            if not is_placed:  # Minimum at these multipliers, to rounding.
                copy(pulls, tension)
                penalty, is_primal_dual = min(10 * penalty, 1e10), tries > 0
    copy(pulls, tension)
    return residual, violation, count


@compiled
def solve_safely(q, tension, case, tolerance, most, work, system):
    """`solve`; where it does not converge, by continuation in the smoothing of the gaps, down to the trunk's own.

    With every cable pulled the solution often lies where a gap is closed and the cable's length has a kink.
    """
    trunk, length = case.trunk, case.control.length
    residual, violation, total = solve(q, tension, case, tolerance, min(FIRST, most), work, system)
    shut = SOFTEST
    while (residual > tolerance or violation > TIGHT) and total < most:
        shut = max(shut / 3, trunk.shut)
        smooth = replace_trunk(trunk, trunk.stiffness, trunk.natural, shut)
        smoothed = by_address(replace_parts(case, smooth, length))
        enough = tolerance if shut == trunk.shut else 1e-4
        residual, violation, count = solve(q, tension, smoothed, enough, min(3 * FIRST, most - total), work, system)
        total += count + 1
        if shut > trunk.shut:
            residual = max(residual, 2 * tolerance)
        elif residual > tolerance or violation > TIGHT:
            shut = SOFTEST
    return residual, violation, total
