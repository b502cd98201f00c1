"""The equilibrium by a projected Newton method, joints in their cones, cables by multipliers.

Tensions and shape are found together: each step shortens the cables as far as the largest turn of a joint allows, and
a merit function guards it. Where that does not fall, the tensions are held while the augmented Lagrangian is
minimised, then brought up to date, which always ends.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from spiraltrunk.model.statics.kernels import compiled, owning
from spiraltrunk.model.statics.kernels.address import by_address
from spiraltrunk.model.statics.kernels.cholesky import (
    column_sum,
    copy,
    copy_rows,
    dot,
    factorise,
    solve_factored,
    solve_small,
)
from spiraltrunk.model.statics.kernels.energy import Case, Control, Trunk, linearise_placed, merit, merit_placed, place
from spiraltrunk.model.statics.kernels.joint_limits import activate_outward_limits, move, project_to_limits, reduce

STEP = 0.35
"""Largest turn of a joint in one step [rad]."""
TIGHT = 1e-10
"""Cables are as long as they should be to this [m]."""
PENALTY = 1e3
"""First stiffness of the penalty on the cables' lengths [N/m]."""
LEVER = 0.025
"""Turns a cable's excess length into an angle when the two are compared [m]; of a hole's distance from the joint."""

CLOSE = 1e-3
"""Violation below which the penalty is raised until Newton's matrix is positive definite [m]."""
STIFFEST = 1e7
"""Penalty at which that ends [N/m]."""
FIRST = 60
"""Steps after which a first try is given up."""
SOFTEST = 3e-3
"""Gaps shut at a third of this in a second try [m]."""
NONE = np.int64(0)
"""Where a count begins, like any number to the compiler."""


class System(NamedTuple):
    """The equations of one step and their solution."""

    gradient: np.ndarray
    slopes: np.ndarray
    pressed: np.ndarray
    reaction: np.ndarray
    weight: np.ndarray
    step: np.ndarray
    response: np.ndarray
    works: np.ndarray
    excess: np.ndarray
    wish: np.ndarray
    goal: np.ndarray
    trial: np.ndarray
    normal: np.ndarray
    rim: np.ndarray
    pulls: np.ndarray
    aimed: np.ndarray
    length: np.ndarray
    final: np.ndarray
    now: np.ndarray
    more: np.ndarray
    matrix: np.ndarray
    copied: np.ndarray
    chosen: np.ndarray
    motion: np.ndarray
    columns: np.ndarray


@owning
def room_for_steps(n_joint, n_cable, nd, stiffness):
    """`System` for a trunk."""
    size = n_joint * nd
    weight = np.empty(size)
    for row in range(size):
        weight[row] = stiffness[row // nd, row % nd]
    return System(
        np.zeros(size), np.zeros((n_cable, size)), np.zeros(n_joint, np.bool_), np.zeros(n_joint), weight,
        np.zeros(size), np.zeros((n_cable, size)), np.zeros(n_cable, np.bool_), np.zeros(n_cable), np.zeros(n_cable),
        np.zeros(n_cable), np.zeros((n_joint, 3)), np.zeros((n_joint, 2)), np.zeros(3),
        np.zeros(n_cable), np.zeros(n_cable), np.zeros(n_cable), np.zeros(n_cable), np.zeros(n_cable),
        np.zeros(n_cable), np.zeros((n_cable, n_cable)), np.zeros((n_cable, n_cable)), np.zeros(n_cable, np.int64),
        np.zeros((3, size)), np.zeros((size, 4)),
    )  # fmt: skip


@compiled
def find_excess(gap, control, pulls, system):
    """Constraint residual of each cable and the active set of cables; returns the largest violation [m]."""
    worst = 0.0
    for c in range(pulls.shape[0]):
        system.works[c], system.excess[c] = False, 0.0
        if not control.by_tension[c]:
            over = column_sum(gap, c) - control.length[c] - control.compliance[c] * pulls[c]
            is_idle = (pulls[c] <= 0 and over <= 0) or (pulls[c] >= control.most[c] and over >= 0)
            system.works[c], system.excess[c] = not is_idle, over
            if not is_idle:
                worst = max(worst, abs(over))
    return worst


@compiled
def add_penalty(system, control, penalty, hessian):
    """Add the working cables' own stiffness to the lower triangle."""
    size = hessian.shape[0]
    for c in range(system.works.shape[0]):
        if system.works[c]:
            stiff = penalty / (1 + penalty * control.compliance[c])
            for row in range(size):
                push = stiff * system.slopes[c, row]
                if push != 0.0:
                    for column in range(row + 1):
                        hessian[row, column] += push * system.slopes[c, column]


@compiled
def guarded_factor(work, weight):
    """Factorise with no shift, or the first of a growing row that makes the matrix positive definite."""
    shift = 0.0
    while not factorise(work.hessian, work.factor, weight, shift):
        shift = 0.05 if shift == 0.0 else 2.5 * shift


@compiled
def descend(q, trunk, work, system):
    """Newton's step at held tensions, into ``system.step``; joints on the rim that it would push out are held.

    The Hessian's factor is in ``work``.
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
    """Largest turn that a step asks of a joint [rad]."""
    worst, nd = 0.0, step.shape[0] // n_joint
    for i in range(n_joint):
        worst = max(worst, step[i * nd] ** 2 + step[i * nd + 1] ** 2)
    return math.sqrt(worst)


@compiled
def pursue(control, pulls, penalty, system, work):
    """Schur complement step of the active cables' tensions, added to ``system.step``; fills ``wish`` and ``goal``."""
    n_cable, matrix, index, now, more = pulls.shape[0], system.matrix, system.chosen, system.now, system.more
    count = NONE
    for c in range(n_cable):
        if system.works[c]:
            solve_factored(work.factor, system.slopes[c], system.response[count])
            index[count] = c
            count += 1
    for a in range(count):
        c = index[a]
        give = control.compliance[c]
        stiff = penalty / (1 + penalty * give)
        for b in range(count):
            matrix[a, b] = dot(system.slopes[c], system.response[b])
        matrix[a, a] = matrix[a, a] * (1 + 1e-12) + give / (1 - stiff * give) + 1e-15
        now[a] = dot(system.slopes[c], system.step)
        more[a] = system.excess[c] / (1 - stiff * give)
    copy_rows(matrix, system.copied)
    solve_small(matrix, now, count)
    solve_small(system.copied, more, count)
    share = limit_share(system, now, more, count)
    for c in range(n_cable):
        system.wish[c], system.goal[c] = pulls[c], control.length[c]
    for a in range(count):
        c = index[a]
        pull = now[a] + share * more[a]
        for row in range(system.step.shape[0]):
            system.step[row] -= pull * system.response[a, row]
        stiff = penalty / (1 + penalty * control.compliance[c])
        change = (pull - stiff * share * system.excess[c]) / (1 - stiff * control.compliance[c])
        system.wish[c] = min(max(pulls[c] + change, 0.0), control.most[c])
        system.goal[c] = control.length[c] + (1 - share) * system.excess[c]


@compiled
def limit_share(system, now, more, count):
    """Which part of the excess length a step may take away, by the largest turn of a joint."""
    worst, nd = 1.0, system.step.shape[0] // system.pressed.shape[0]
    for i in range(system.pressed.shape[0]):
        rest, turn = 0.0, 0.0
        for row in range(i * nd, i * nd + 2):
            fixed, moved = system.step[row], 0.0
            for a in range(count):
                fixed -= now[a] * system.response[a, row]
                moved -= more[a] * system.response[a, row]
            rest += fixed * fixed
            turn += moved * moved
        room = max(STEP - math.sqrt(rest), 0.2 * STEP)
        if turn > room * room:
            worst = min(worst, room / math.sqrt(turn))
    return worst


@compiled
def tensions_at(gap, control, tension, penalty, pulls):
    """Tensions of the augmented Lagrangian at the measured gaps."""
    for c in range(tension.shape[0]):
        pulls[c] = tension[c]
        if not control.by_tension[c]:
            excess = column_sum(gap, c) - control.length[c]
            wish = (excess + tension[c] / penalty) / (control.compliance[c] + 1 / penalty)
            pulls[c] = min(max(wish, 0.0), control.most[c])


@compiled
def search(q, case, multiplier, penalty, slope, work, system):
    """Walk along the step until the merit has fallen enough; returns the share taken, 0 where it never falls.

    ``work`` is placed at ``q``, and after where it has fallen.
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
    """One step of shape and tensions together; whether the merit fell."""
    pursue(case.control, tension, penalty, system, work)
    pulls = system.aimed
    tensions_at(work.gap, goal.control, system.wish, penalty, pulls)
    slope = dot(system.gradient, system.step)
    for c in range(tension.shape[0]):
        slope += (pulls[c] - tension[c]) * dot(system.slopes[c], system.step)
    if slope >= 0:
        return False
    share = search(q, goal, system.wish, penalty, slope, work, system)
    for c in range(tension.shape[0]):
        tension[c] += share * (system.wish[c] - tension[c])
    return share > 0.0


@compiled
def linearise_reduced(q, tension, pulls, case, penalty, work, system):
    """Linearise at ``q``, where ``work`` is placed, and reduce to the active set; returns residual and violation.

    Without a penalty the winders hold ``tension``, with one what the augmented Lagrangian makes of it.
    """
    copy(tension, pulls)
    if penalty > 0.0:
        tensions_at(work.gap, case.control, tension, penalty, pulls)
    linearise_placed(q, case, pulls, work)
    reduce(q, case.trunk, work, system)
    left = 0.0
    for row in range(system.gradient.shape[0]):
        size = abs(system.gradient[row])
        if not size <= left and left == left:  # What is not a number stays.
            left = size
    return left, find_excess(work.gap, case.control, pulls, system)


@compiled
def does_work(system):
    """Whether any cable is held by its length."""
    for c in range(system.works.shape[0]):  # noqa: SIM110  # Numba compiles a loop sooner than any().
        if system.works[c]:
            return True
    return False


@compiled
def solve(q, tension, case, tolerance, most, work, system):
    """Bring ``q`` (n_joint, 3) and ``tension`` (n_cable) to equilibrium, in place.

    Returns the residual [N m], the cables' violation [m] and the number of steps. ``system.reaction`` (n_joint) has the
    moments of the closed faces [N m], ``work.tension`` the tensions of all gaps [N].
    """
    control = case.control
    aim = by_address(Control(control.by_tension, system.goal, control.most, control.compliance))
    goal = by_address(Case(case.base, case.trunk, case.field, aim, case.friction))
    pulls = system.pulls
    project_to_limits(q, case.trunk, system.rim)
    penalty, tries, is_pursuing, before, is_placed = PENALTY, 3, True, 1e300, False
    for count in range(most + 1):
        if not is_placed:
            place(q, case.base, case.trunk, work)
        residual, violation = linearise_reduced(q, tension, pulls, case, 0.0 if is_pursuing else penalty, work, system)
        if (residual <= tolerance and violation <= TIGHT) or count == most:
            break
        if not is_pursuing and residual <= max(tolerance, 0.1 * violation / LEVER):
            copy(pulls, tension)
            penalty = min(10 * penalty, 1e10) if violation > 0.1 * before else penalty
            before, is_pursuing, is_placed = violation, tries > 0, True
            continue
        add_penalty(system, control, penalty, work.hessian)
        is_factored = False
        if violation < CLOSE and penalty < STIFFEST and does_work(system):
            is_factored = factorise(work.hessian, work.factor, system.weight, 0.0)
            if not is_factored:
                penalty *= 10  # Along the cables' constraints the energy may fall; held hard enough, it does not.
                is_placed = True
                continue
        if not is_factored:
            guarded_factor(work, system.weight)
        descend(q, case.trunk, work, system)
        if is_pursuing:
            is_placed = primal_dual_step(q, tension, case, goal, penalty, work, system)
            if not is_placed:
                is_pursuing, tries, before = False, tries - 1, 1e300
        else:
            is_placed = search(q, case, tension, penalty, dot(system.gradient, system.step), work, system) > 0.0
            if not is_placed:
                copy(pulls, tension)  # Nothing more to gain at these tensions.
                penalty, is_pursuing = min(10 * penalty, 1e10), tries > 0
    copy(pulls, tension)
    return residual, violation, count


@compiled
def _with_shut(trunk, shut):
    return Trunk(
        trunk.kind, trunk.stiffness, trunk.natural, trunk.limit, trunk.length, trunk.before, trunk.beyond,
        trunk.rub_before, trunk.rub_beyond, shut,
    )  # fmt: skip


@compiled
def solve_safely(q, tension, case, tolerance, most, work, system):
    """`solve`; where it does not end well, once more with gaps that shut softly at first, then as hard as asked.

    With every cable pulled the trunk is pressed into corners, where a gap is shut and its cable's length has a kink.
    """
    trunk = case.trunk
    residual, violation, total = solve(q, tension, case, tolerance, min(FIRST, most), work, system)
    shut = SOFTEST
    while (residual > tolerance or violation > TIGHT) and total < most:
        shut = max(shut / 3, trunk.shut)
        soft = by_address(_with_shut(trunk, shut))
        enough = tolerance if shut == trunk.shut else 1e-4
        softened = by_address(Case(case.base, soft, case.field, case.control, case.friction))
        residual, violation, count = solve(q, tension, softened, enough, min(3 * FIRST, most - total), work, system)
        total += count + 1
        if shut > trunk.shut:
            residual = max(residual, 2 * tolerance)
        elif residual > tolerance or violation > TIGHT:
            shut = SOFTEST
    return residual, violation, total
