"""Quasi-static loading with overdamped joints, by the implicit Euler method, until the trunk is at rest.

Every joint's damping is its stiffness times one time tau, so that the bends follow tau K dq/dt = -dE/dq within their
cones. A step of the implicit Euler method is the minimum of E + tau / (2 h) |q - q_before|_K^2: an equilibrium of a
trunk whose joints are 1 + tau / h times as stiff and want to stay where they were. A step is short enough to stand for
the motion: no joint turns far in it, and what drives the trunk away from a shape that it cannot keep grows little. With
friction the holes hold in it what the shape before makes of them; at rest shape and friction are found together.
"""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.model.statics.kernels import compiled, owning
from spiraltrunk.model.statics.kernels.address import by_address
from spiraltrunk.model.statics.kernels.capstan_friction import (
    COARSER,
    advance,
    move_anchors,
    reconstruct_slip_forces,
    settle,
    update_forces,
)
from spiraltrunk.model.statics.kernels.cholesky import copy, copy_rows, factorise
from spiraltrunk.model.statics.kernels.energy import Case, Control, Trunk
from spiraltrunk.model.statics.kernels.projected_newton import STIFFEST, TIGHT, add_penalty, solve_safely

TURN = 0.002
"""Largest turn of a joint in a step [rad]."""
SHORTEST = 1e-5
"""Shortest step over the damping time [-]."""
FIRST = 1e-2
"""First step over the damping time [-]."""
LONGEST = 1e4
"""Step over the damping time from which on nothing moves any more [-]."""
GROWTH = 0.1
"""What drives the trunk away from a shape grows by at most this part in a step [-]."""
SHARES = 2000
"""Least number of steps in which the cables are loaded."""
STILL = 1e-11
"""Turn in a step up to which a trunk that may not stay as it is does not move by itself [rad]."""
LEAN = 1e-6
"""Bend that is then added to every joint [rad]: nothing balances on a point."""
TRIES = np.int64(200)
"""Steps of Newton's method after which a step of time is tried again, half as long; like any number to the compiler."""


@owning
def creep(q, tension, case, mu, start, motion, tolerance, most, slow, work, system):
    """Load from the lengths and tensions in ``start`` (2, n_cable) to those of the case, and wait until it rests.

    ``motion`` is the time that the loading takes and the damping time [s]. ``q`` and ``tension`` are brought up to date
    in place; ``slow`` is of `room_for_creep`. Returns the last residual [N m], the last violation [m] and the number of
    Newton's steps.
    """
    seconds, delay = motion
    control, trial, now, pace, total, friction = case.control, np.zeros(q.shape), 0.0, FIRST * delay, 0, case.friction
    kept, residual, violation = np.zeros(tension.shape[0]), 0.0, 0.0
    copy(tension, system.final)
    copy(start[1], kept)
    stage = by_address(Control(control.by_tension, system.length, control.most, control.compliance))
    under_way = by_address(Case(case.base, slow, case.field, stage, friction))
    if friction.stiffness > 0.0:
        reconstruct_slip_forces(q, kept, case, mu, work)
    for _ in range(most):
        step, left, part = pace, seconds - now, 1.0
        if left > 0.0:
            step = min(pace, max(seconds / SHARES, SHORTEST * delay))
            is_last = left < 1.5 * step
            step = max(left, SHORTEST * delay) if is_last else step
            part = 1.0 if is_last else (now + step) / seconds
        copy(kept, tension)
        advance(part, system.length, tension, control, start, system.final)
        _hold_back(q, delay / step, case.trunk, slow)
        copy_rows(q, trial)
        residual, violation, count = solve_safely(trial, tension, under_way, tolerance, TRIES, work, system)
        total += count + 1
        turn = _largest_turn(q, trial)
        is_good = residual <= tolerance and violation <= TIGHT and turn <= TURN
        if step > SHORTEST * delay and not (is_good and _grows_little(delay / step, stage, work, system)):
            pace = 0.5 * step
            if is_good and turn <= STILL:
                _lean(q)
            continue
        now = now + step if part < 1.0 else seconds
        copy_rows(trial, q)
        copy(tension, kept)
        if friction.stiffness > 0.0:
            update_forces(mu, 1.0, case.trunk, tension, work, friction)
            move_anchors(work, friction)
        if turn < 0.4 * TURN:
            pace = 1.6 * step
        if part == 1.0 and step > LONGEST * delay:
            residual, violation, count = settle(q, tension, case, mu, tolerance, most, work, system)
            return residual, violation, total + count
    return max(residual, 2 * COARSER * tolerance), violation, total


@owning
def room_for_creep(trunk):
    """A trunk whose stiffness and natural bends are its own, yet to be filled."""
    return Trunk(
        trunk.kind, np.zeros(trunk.stiffness.shape), np.zeros(trunk.natural.shape), trunk.limit, trunk.length,
        trunk.before, trunk.beyond, trunk.rub_before, trunk.rub_beyond, trunk.shut,
    )  # fmt: skip


@compiled
def _hold_back(q, share, trunk, slow):
    """Joints that want to stay at ``q``, by ``share`` of their stiffness."""
    for i in range(q.shape[0]):
        for a in range(3):
            slow.stiffness[i, a] = (1 + share) * trunk.stiffness[i, a]
            slow.natural[i, a] = (trunk.natural[i, a] + share * q[i, a]) / (1 + share)


@compiled
def _lean(q):
    for i in range(q.shape[0]):
        q[i, 0] += LEAN
        q[i, 1] += LEAN


@compiled
def _largest_turn(before, after):
    worst = 0.0
    for i in range(before.shape[0]):
        bent = (after[i, 0] - before[i, 0]) ** 2 + (after[i, 1] - before[i, 1]) ** 2
        worst = max(worst, bent + (after[i, 2] - before[i, 2]) ** 2)
    return math.sqrt(worst)


@compiled
def _grows_little(share, control, work, system):
    """Whether no curvature of the energy is below -`GROWTH` of the damping over the step, at a step just solved."""
    add_penalty(system, control, STIFFEST, work.hessian)
    return factorise(work.hessian, work.factor, system.weight, (GROWTH - 1) * share)
