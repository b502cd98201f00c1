"""Loading of the trunk: in one step, in increments with capstan friction, or quasi-static.

Hole k of a cable, counted by gaps, obeys `capstan_law` with w_k, the turn at the hole beyond gap k - 1 plus that at the
hole before gap k. Below the slip force the cable sticks. Slip forces are found by fixed-point iteration: the shape at
the last forces gives tensions and turns, and those give the next forces.

Quasi-static loading integrates tau K dq/dt = -dE/dq, joints damped by their stiffness times a time tau, within the
joint limits until the trunk is at rest. A step h of the implicit Euler method minimises

    E + tau / (2 h) |q - q_before|_K^2,

the equilibrium of a trunk whose joints are 1 + tau / h times as stiff, with natural bends nearer to the last shape. The
step is limited by the turn of the joints and by the growth of unstable modes. During the motion the slip forces are
those of the last step; at rest shape and friction are solved together.
"""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.model.statics.kernels import compiled, owning
from spiraltrunk.model.statics.kernels.address import by_address
from spiraltrunk.model.statics.kernels.cholesky import column_sum, copy, copy_rows, factorise
from spiraltrunk.model.statics.kernels.laws.cable_gaps import measure_turns
from spiraltrunk.model.statics.kernels.laws.capstan_law import ratio, slip_forces
from spiraltrunk.model.statics.kernels.laws.energy import add_penalty, hole_force, replace_parts
from spiraltrunk.model.statics.kernels.newton_calls import place_trunk, solve_safely
from spiraltrunk.model.statics.kernels.projected_newton import STIFFEST, TIGHT
from spiraltrunk.model.statics.kernels.zeros import zeros

ROUNDS = 1200
"""Largest number of fixed-point iterations of the slip forces in one increment."""
COARSER = 10.0
"""Tolerance of the moments of friction over that of all others [-]."""
SMALLEST_SHARE = 1 / 32
"""Smallest relaxation factor of the slip forces [-]."""

TURN = 0.002
"""Largest turn of a joint in a time step [rad]."""
SHORTEST = 1e-5
"""Shortest time step over the damping time [-]."""
FIRST = 1e-2
"""First time step over the damping time [-]."""
LONGEST = 1e4
"""Time step over the damping time above which the trunk is at rest [-]."""
GROWTH = 0.1
"""Largest relative growth of an unstable mode in a time step [-]."""
SHARES = 2000
"""Smallest number of time steps of a loading."""
STILL = 1e-11
"""Below this turn per time step an unstable equilibrium is perturbed [rad]."""
PERTURBATION = 1e-6
"""Bend added to every joint to perturb it [rad]."""
TRIES = np.int64(200)
"""Newton steps after which a time step is halved, an integer of the type that the compiler infers for counts."""


@compiled
def update_forces(mu, share, trunk, pulls, work, friction):
    """Relax the slip forces by the factor ``share`` towards the capstan law at the present tensions and turns.

    Returns the largest unrelaxed change as a moment [N m].
    """
    measure_turns(trunk, work)
    turns, worst = work.turn, 0.0
    for c in range(turns.shape[1]):
        tension = pulls[c]
        for i in range(turns.shape[0]):
            lever = abs(trunk.before[i, c, 1]) + abs(trunk.before[i, c, 2])
            forward, backward = slip_forces(tension, ratio(mu, turns[i, c]), ratio(-mu, turns[i, c]))
            held = work.tension[i, c] - tension
            used = forward - friction.force[i, c] if held < 0 else backward - friction.force_back[i, c]
            worst = max(worst, abs(used) * lever)
            friction.force[i, c] += share * (forward - friction.force[i, c])
            friction.force_back[i, c] += share * (backward - friction.force_back[i, c])
            tension = max(work.tension[i, c], 0.0)
    return worst


@compiled
def reconstruct_slip_forces(q, pulls, case, mu, work, system):
    """Slip forces of the holes in the initial shape, reconstructed from its anchors."""
    trunk, friction, turns = case.trunk, case.friction, work.turn
    place_trunk(q, case, work, system)
    measure_turns(trunk, work)
    for c in range(turns.shape[1]):
        tension, beyond = pulls[c], column_sum(work.gap, c)
        for i in range(turns.shape[0]):
            towards, away = slip_forces(tension, ratio(mu, turns[i, c]), ratio(-mu, turns[i, c]))
            friction.force[i, c], friction.force_back[i, c] = towards, away
            tension = max(tension + hole_force(beyond, i, c, friction)[0], 0.0)
            beyond -= work.gap[i, c]


@compiled
def move_anchors(work, friction):
    """Move the anchors of the holes whose cable slid."""
    for c in range(work.gap.shape[1]):
        beyond = 0.0
        for i in range(work.gap.shape[0] - 1, -1, -1):
            beyond += work.gap[i, c]
            held = friction.stiffness * (beyond - friction.anchor[i, c])
            held = min(max(held, -friction.force[i, c]), friction.force_back[i, c])
            friction.anchor[i, c] = beyond - held / friction.stiffness


@compiled
def reset_anchors(gap, anchor):
    """Anchors at which no hole of ``gap`` (n_joint, n_cable) has a friction force, from which friction can start."""
    for c in range(gap.shape[1]):
        beyond = 0.0
        for i in range(gap.shape[0] - 1, -1, -1):
            beyond += gap[i, c]
            anchor[i, c] = beyond


@compiled
def interpolate_inputs(part, length, tension, control, start, final):
    """Lengths, and tensions of the cables held by tension, at a part of the way from ``start`` (2, n_cable)."""
    for c in range(length.shape[0]):
        length[c] = start[0, c] + part * (control.length[c] - start[0, c])
        if control.by_tension[c]:
            tension[c] = start[1, c] + part * (final[c] - start[1, c])


@compiled
def load_at_once(q, tension, case, start, tolerance, most, work, system):
    """Load from the lengths and tensions in ``start`` (2, n_cable) to those of the case in one step, without friction.

    ``q``, ``tension`` and the anchors are updated in place. Returns residual [N m], violation [m] and number of steps.
    """
    stage = by_address(replace_parts(case, case.trunk, system.length))
    copy(tension, system.final)
    interpolate_inputs(1.0, system.length, tension, case.control, start, system.final)
    found = solve_safely(q, tension, stage, tolerance, most, work, system)
    reset_anchors(work.gap, case.friction.anchor)
    return found


@compiled
def load_in_increments(q, tension, case, mu, start, increments, tolerance, most, work, system):
    """`load_at_once` with friction, in equal increments, each by `solve_increment`."""
    stage = by_address(replace_parts(case, case.trunk, system.length))
    total, residual, violation = 0, 0.0, 0.0
    copy(tension, system.final)
    if case.friction.stiffness > 0.0:
        reconstruct_slip_forces(q, start[1], case, mu, work, system)
    for step in range(increments):
        interpolate_inputs((step + 1) / increments, system.length, tension, case.control, start, system.final)
        residual, violation, count = solve_increment(q, tension, stage, mu, tolerance, most, work, system)
        total += count
    if case.friction.stiffness == 0.0:
        reset_anchors(work.gap, case.friction.anchor)
    return residual, violation, total


@compiled
def solve_increment(q, tension, case, mu, tolerance, most, work, system):
    """Shape, tensions, slip forces and anchors of one increment; returns residual, violation and number of steps."""
    friction, share, before, residual, violation, spent = case.friction, 1.0, 1e300, 0.0, 0.0, 0
    for again in range(ROUNDS):
        residual, violation, count = solve_safely(q, tension, case, tolerance, most, work, system)
        spent += count
        if friction.stiffness == 0.0:
            return residual, violation, spent
        change = update_forces(mu, share, case.trunk, tension, work, friction)
        if again > 3 and change > (1 - 0.5 * share) * before:  # Some slip force oscillates.
            share = max(0.5 * share, SMALLEST_SHARE)
        before = change
        residual = max(residual, change)
        if change <= COARSER * tolerance or spent > most:
            break
    move_anchors(work, friction)
    return residual, violation, spent


@owning
def load_quasi_statically(q, tension, case, mu, start, motion, tolerance, most, damped, work, system):
    """`load_at_once`, with friction or without, at constant speeds of the winders, and then until the trunk is at rest.

    ``motion`` is the time of the loading and the damping time [s]; ``damped`` is the case under way, with
    ``system.length`` and with workspace as stiffness and natural bends.
    """
    seconds, delay = motion
    trial, kept, friction = zeros(q.shape), zeros(tension.shape[0]), case.friction
    now, pace, total, residual, violation = 0.0, FIRST * delay, 0, 0.0, 0.0
    copy(tension, system.final)
    copy(start[1], kept)
    if friction.stiffness > 0.0:
        reconstruct_slip_forces(q, kept, case, mu, work, system)
    for _ in range(most):
        step, part = _choose_step(pace, now, seconds, delay)
        copy(kept, tension)
        interpolate_inputs(part, system.length, tension, case.control, start, system.final)
        _damp(q, delay / step, case.trunk, damped.trunk)
        copy_rows(q, trial)
        residual, violation, count = solve_safely(trial, tension, damped, tolerance, TRIES, work, system)
        total += count + 1
        turn = _largest_turn(q, trial)
        is_good = residual <= tolerance and violation <= TIGHT and turn <= TURN
        if step > SHORTEST * delay and not (is_good and _grows_little(delay / step, damped.control, work, system)):
            pace = 0.5 * step
            if is_good and turn <= STILL:
                _perturb(q)
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
            residual, violation, count = solve_increment(q, tension, case, mu, tolerance, most, work, system)
            return residual, violation, total + count
    return max(residual, 2 * COARSER * tolerance), violation, total


@compiled
def _choose_step(pace, now, seconds, delay):
    """Time step at most ``pace`` [s], and the part of the loading that is done after it [-]."""
    left = seconds - now
    if left <= 0.0:
        return pace, 1.0
    step = min(pace, max(seconds / SHARES, SHORTEST * delay))
    if left < 1.5 * step:
        return max(left, SHORTEST * delay), 1.0
    return step, (now + step) / seconds


@compiled
def _perturb(q):
    for i in range(q.shape[0]):
        q[i, 0] += PERTURBATION
        q[i, 1] += PERTURBATION


@compiled
def _damp(q, share, trunk, slow):
    """Add damping of ``share`` times the stiffness about the shape ``q`` to the trunk, into ``slow``."""
    for i in range(q.shape[0]):
        for a in range(3):
            slow.stiffness[i, a] = (1 + share) * trunk.stiffness[i, a]
            slow.natural[i, a] = (trunk.natural[i, a] + share * q[i, a]) / (1 + share)


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
