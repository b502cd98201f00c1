"""Newton's method as other kernels call it: compiled once, for the equilibrium and the inverse alike.

`operate` is compiled by itself, and reached through a pointer; the other functions here are what the kernels call.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numba import typeof, types
from numba.core.typing.templates import Signature, signature
from numba.extending import intrinsic

from spiraltrunk.model.jit import compile_shared, compiler
from spiraltrunk.model.shared_kernel import SharedKernel
from spiraltrunk.model.statics.kernels import STAMP, compiled, projected_newton
from spiraltrunk.model.statics.kernels.address import address_of
from spiraltrunk.model.statics.kernels.cholesky import factorise, solve_factored
from spiraltrunk.model.statics.kernels.laws.energy import (
    Case,
    Control,
    Friction,
    Trunk,
    add_penalty,
    find_excess,
    linearise_placed,
    place,
    room_for_work,
)
from spiraltrunk.model.statics.kernels.laws.joint_limits import activate_outward_limits, move, reduce
from spiraltrunk.model.statics.kernels.projected_newton import (
    NONE,
    PENALTY,
    descend,
    guarded_factor,
    primal_dual_step,
    room_for_steps,
    schur_complement,
)

SAME = 0.3
"""Difference of all bends within which an iteration goes to the shape that it has come so near to [rad]."""
RETRACED = 40
"""Steps from the straight trunk after which it is not followed any further."""

SOLVE, RETRACE, PLACE, LINEARISE, LINEARISE_STUCK = range(5)
FACTORISE, GUARD, HOLD, COMPLEMENT, RESPOND, ACTIVATE, MOVE = range(5, 12)
"""What `operate` does."""


def operate(what, near, q, tension, pulls, case, tolerance, most, work, system):
    """What the functions at the end of this module ask for, by number; returns residual, violation and count.

    ``near``, ``pulls``, ``tolerance`` and ``most`` are what the one asked for takes; a truth is 1.
    """
    if what == SOLVE:
        return projected_newton.solve_safely(q, tension, case, tolerance, most, work, system)
    if what == RETRACE:
        return (1.0 if _converges_to(near, q, tension, case, work, system) else 0.0), 0.0, NONE
    if what <= LINEARISE_STUCK:
        place(q, case.base, case.trunk, work)
    if what == LINEARISE:
        left, violation = projected_newton.linearise_reduced(q, tension, pulls, case, 0.0, work, system)
        return left, violation, NONE
    if what == LINEARISE_STUCK:
        linearise_placed(q, case, tension, work)
        reduce(q, case.trunk, work, system)
    if what > LINEARISE_STUCK:
        return 0.0, 0.0, _do_step(what, near, q, tension, case, tolerance, work, system)
    return 0.0, 0.0, NONE


@compiled
def _do_step(what, near, q, tension, case, number, work, system):
    """Parts of a step; the result is a count, or 1 for true."""
    if what == FACTORISE:
        return np.int64(factorise(work.hessian, work.factor, system.weight, 0.0))
    if what == ACTIVATE:
        return np.int64(activate_outward_limits(q, case.trunk, work, system))
    if what == COMPLEMENT:
        return schur_complement(case.control, number, work, system)
    if what == MOVE:
        move(q, case.trunk, system, number)
    elif what == RESPOND:
        for c in range(near.shape[0]):
            solve_factored(work.factor, system.slopes[c], near[c])
    else:
        if what == HOLD:
            find_excess(work.gap, case.control, tension, system)
            add_penalty(system, case.control, number, work.hessian)
        guarded_factor(work, system.weight)
    return NONE


@compiled
def _converges_to(near, q, tension, case, work, system):
    place(q, case.base, case.trunk, work)
    for _ in range(RETRACED):
        projected_newton.linearise_reduced(q, tension, system.pulls, case, 0.0, work, system)
        guarded_factor(work, system.weight)
        descend(q, case.trunk, work, system)
        if not primal_dual_step(q, tension, case, case, PENALTY, work, system):
            return False
        if _difference(q, near) < SAME:
            return True
    return False


@compiled
def _difference(first, second):
    worst = 0.0
    for i in range(first.shape[0]):
        for a in range(first.shape[1]):
            worst = max(worst, abs(first[i, a] - second[i, a]))
    return worst


@cache
def _sign() -> Signature:
    """Signature of `operate`: the types of its arguments are always the same."""
    one, flag = np.zeros(1), np.zeros(1, np.bool_)
    two, three = np.zeros((1, 1)), np.zeros((1, 1, 1))
    trunk = Trunk(np.zeros(1, np.int64), two, two, 0.0, one, three, three, three, three, 0.0)
    case = Case(two, trunk, (two, two, two), Control(flag, one, one, one), Friction(two, two, two, 0.0))
    work, system = room_for_work.py_func(1, 1, 1), room_for_steps.py_func(1, 1, 1, two)
    parts = [address_of(typeof(part)) for part in (case, work, system)]
    result = types.Tuple((types.float64, types.float64, types.int64))
    vector, rows = typeof(one), typeof(two)
    return signature(
        result, types.int64, rows, rows, vector, vector, parts[0], types.float64, types.int64, *parts[1:]
    )  # fmt: skip


SHARED = SharedKernel(compile_shared(operate, STAMP), _sign, (__name__, "SHARED"))
"""`operate`, compiled by itself."""

calling: Any = compiler(STAMP, calls=SHARED)
"""How a kernel is compiled that Python calls, and that calls functions of this module."""


def _call(typing, what, near, q, tension, pulls, case, tolerance, most, work, system):
    return SHARED.sign(), SHARED.generate


_operate: Any = intrinsic(_call)
"""`operate` through its pointer."""


@compiled
def solve_safely(q, tension, case, tolerance, most, work, system):
    """`projected_newton.solve_safely`."""
    return _operate(SOLVE, q, q, tension, tension, case, tolerance, most, work, system)


@compiled
def place_trunk(q, case, work, system):
    """`energy.place`."""
    _operate(PLACE, q, q, system.pulls, system.pulls, case, 0.0, NONE, work, system)


@compiled
def linearise_equilibrium(q, tension, pulls, case, work, system):
    """`energy.place` and `projected_newton.linearise_reduced` without a penalty; the residual [N m]."""
    return _operate(LINEARISE, q, q, tension, pulls, case, 0.0, NONE, work, system)[0]


@compiled
def linearise_stuck(q, tension, case, work, system):
    """`energy.linearise` and `joint_limits.reduce`: holes stick or slide as they do at the last friction forces."""
    _operate(LINEARISE_STUCK, q, q, tension, tension, case, 0.0, NONE, work, system)


@compiled
def converges_to(near, q, tension, case, work, system):
    """Whether the iteration from ``q`` at these tensions, all given, comes as near as `SAME` to the shape ``near``."""
    return _operate(RETRACE, near, q, tension, tension, case, 0.0, NONE, work, system)[0] > 0.0


@compiled
def has_factor(q, case, work, system):
    """Factorise the Hessian without a shift; whether it is positive definite."""
    return _operate(FACTORISE, q, q, system.pulls, system.pulls, case, 0.0, NONE, work, system)[2] > 0


@compiled
def factorise_guarded(q, case, work, system):
    """`projected_newton.guarded_factor`."""
    _operate(GUARD, q, q, system.pulls, system.pulls, case, 0.0, NONE, work, system)


@compiled
def factorise_held(q, tension, case, penalty, work, system):
    """The same with a penalty on the lengths of the active cables [N/m], which are found."""
    _operate(HOLD, q, q, tension, tension, case, penalty, NONE, work, system)


@compiled
def complement(q, case, penalty, work, system):
    """`projected_newton.schur_complement`."""
    return _operate(COMPLEMENT, q, q, system.pulls, system.pulls, case, penalty, NONE, work, system)[2]


@compiled
def solve_slopes(q, case, work, system, rates):
    """H^-1 dg/dT for every cable, from the factor of the Hessian H, into ``rates`` (n_cable, n_joint x nd)."""
    _operate(RESPOND, rates, q, system.pulls, system.pulls, case, 0.0, NONE, work, system)


@compiled
def activate_limits(q, case, work, system):
    """`joint_limits.activate_outward_limits`."""
    return _operate(ACTIVATE, q, q, system.pulls, system.pulls, case, 0.0, NONE, work, system)[2] > 0


@compiled
def move_trunk(q, case, share, work, system):
    """`joint_limits.move`."""
    _operate(MOVE, q, q, system.pulls, system.pulls, case, share, NONE, work, system)
