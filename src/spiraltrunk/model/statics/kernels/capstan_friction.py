"""Capstan friction along the cables, and the loading history that it needs.

Hole k of a cable, counted by gaps, obeys `capstan_law` with w_k, the turn at the hole beyond gap k - 1 plus that at the
hole before gap k. Below the slip force the cable sticks. Slip forces are found by fixed-point iteration: the shape at
the last forces gives tensions and turns, and those give the next forces.
"""

from __future__ import annotations

import numpy as np

from spiraltrunk.model.statics.kernels import compiled, owning
from spiraltrunk.model.statics.kernels.address import by_address
from spiraltrunk.model.statics.kernels.cable_gaps import hole_turns
from spiraltrunk.model.statics.kernels.capstan_law import ratio, slip_forces
from spiraltrunk.model.statics.kernels.cholesky import column_sum, copy
from spiraltrunk.model.statics.kernels.energy import Case, Control, hold, place
from spiraltrunk.model.statics.kernels.projected_newton import solve_safely

ROUNDS = 1200
"""Most repetitions for the friction forces of one increment."""
COARSER = 10.0
"""Tolerance of friction's moments over that of all others [-]."""
SMALLEST_SHARE = 1 / 32
"""Least part of their change by which friction forces are brought up to date [-]."""


@owning
def find_hole_turns(rotation, before, beyond, at_before, at_beyond):
    """Evaluate `hole_turns` for all joints and cables into ``at_before``, ``at_beyond`` (n_joint, n_cable) [rad]."""
    v = np.empty(3)
    for i in range(at_before.shape[0]):
        for c in range(at_before.shape[1]):
            turns = hole_turns(rotation[i], before[i, c], beyond[i, c], v)
            at_before[i, c], at_beyond[i, c] = turns[0], turns[1]


@compiled
def measure_turns(trunk, work):
    """Turn w_k of every cable before each gap into ``work.turn`` [rad]."""
    turns, v = work.turn, work.vectors[0]
    for c in range(turns.shape[1]):
        last = 0.0
        for i in range(turns.shape[0]):
            before, beyond = hole_turns(work.rotation[i], trunk.rub_before[i, c], trunk.rub_beyond[i, c], v)
            turns[i, c] = last + before
            last = beyond


@compiled
def update_forces(mu, share, trunk, pulls, work, friction):
    """Relax the slip force of each hole by ``share`` towards the capstan law at the present tensions and turns.

    Returns the largest change that the whole way would be, as a moment [N m].
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
def reconstruct_slip_forces(q, pulls, case, mu, work):
    """Slip forces of the holes in the initial shape, reconstructed from its anchors."""
    trunk, friction, turns = case.trunk, case.friction, work.turn
    place(q, case.base, trunk, work)
    measure_turns(trunk, work)
    for c in range(turns.shape[1]):
        tension, beyond = pulls[c], column_sum(work.gap, c)
        for i in range(turns.shape[0]):
            towards, away = slip_forces(tension, ratio(mu, turns[i, c]), ratio(-mu, turns[i, c]))
            friction.force[i, c], friction.force_back[i, c] = towards, away
            tension = max(tension + hold(beyond, i, c, friction)[0], 0.0)
            beyond -= work.gap[i, c]


@compiled
def move_anchors(work, friction):
    """Let the holes' anchors follow the cable that slid."""
    for c in range(work.gap.shape[1]):
        beyond = 0.0
        for i in range(work.gap.shape[0] - 1, -1, -1):
            beyond += work.gap[i, c]
            held = friction.stiffness * (beyond - friction.anchor[i, c])
            held = min(max(held, -friction.force[i, c]), friction.force_back[i, c])
            friction.anchor[i, c] = beyond - held / friction.stiffness


@compiled
def load_at_once(q, tension, case, start, tolerance, most, work, system):
    """Go from the lengths and tensions in ``start`` (2, n_cable) to those of the case in one step, without friction.

    ``q`` and ``tension`` are brought up to date in place, and the holes hold nothing. Returns the residual [N m], the
    violation [m] and the number of steps.
    """
    control, stage = case.control, by_address(stage_case(case, system))
    copy(tension, system.final)
    advance(1.0, system.length, tension, control, start, system.final)
    residual, violation, count = solve_safely(q, tension, stage, tolerance, most, work, system)
    release(work.gap, case.friction.anchor)
    return residual, violation, count


@compiled
def stage_case(case, system):
    """The case with the lengths in ``system.length``, which change on the way to its own."""
    control = case.control
    on_way = Control(control.by_tension, system.length, control.most, control.compliance)
    return Case(case.base, case.trunk, case.field, on_way, case.friction)


@compiled
def follow(q, tension, case, mu, start, increments, tolerance, most, work, system):
    """Load from the lengths and tensions in ``start`` (2, n_cable) to those of the case in equal increments.

    In each, shape, tensions and friction forces are found together. ``q``, ``tension`` and the friction's anchors are
    brought up to date in place. Returns the last residual [N m], the last violation [m] and the number of steps.
    """
    control, stage = case.control, by_address(stage_case(case, system))
    total, residual, violation = 0, 0.0, 0.0
    copy(tension, system.final)
    if case.friction.stiffness > 0.0:
        reconstruct_slip_forces(q, start[1], case, mu, work)
    for step in range(increments):
        advance((step + 1) / increments, system.length, tension, control, start, system.final)
        residual, violation, count = settle(q, tension, stage, mu, tolerance, most, work, system)
        total += count
    if case.friction.stiffness == 0.0:
        release(work.gap, case.friction.anchor)
    return residual, violation, total


@compiled
def settle(q, tension, case, mu, tolerance, most, work, system):
    """Shape, tensions and friction forces of one increment together, and the anchors that the cables then have.

    Returns the residual [N m], the violation [m] and the number of steps.
    """
    friction, share, before, residual, violation, spent = case.friction, 1.0, 1e300, 0.0, 0.0, 0
    for again in range(ROUNDS):
        residual, violation, count = solve_safely(q, tension, case, tolerance, most, work, system)
        spent += count
        if friction.stiffness == 0.0:
            break
        change = update_forces(mu, share, case.trunk, tension, work, friction)
        if again > 3 and change > (1 - 0.5 * share) * before:  # Some hole goes to and fro.
            share = max(0.5 * share, SMALLEST_SHARE)
        before = change
        residual = max(residual, change)
        if change <= COARSER * tolerance or spent > most:
            break
    if friction.stiffness > 0.0:
        move_anchors(work, friction)
    return residual, violation, spent


@compiled
def release(gap, anchor):
    """Let every hole of ``gap`` (n_joint, n_cable) hold nothing, so that friction may go on from here."""
    for c in range(gap.shape[1]):
        beyond = 0.0
        for i in range(gap.shape[0] - 1, -1, -1):
            beyond += gap[i, c]
            anchor[i, c] = beyond


@compiled
def advance(part, length, tension, control, start, goal):
    """Lengths, and the tensions that are given, at a part of the way from ``start`` (2, n_cable) to the control's."""
    for c in range(length.shape[0]):
        length[c] = start[0, c] + part * (control.length[c] - start[0, c])
        if control.by_tension[c]:
            tension[c] = start[1, c] + part * (goal[c] - start[1, c])
