"""Energy of the trunk under weight, elasticity, cables and their friction, with gradient and Hessian.

The merit of a shape is its elastic energy, the potential of the loads, and per cable held by length an augmented
Lagrangian of the constraints "length at most the given one, 0 <= tension <= largest"; a cable held by tension adds
tension times length. Friction adds at each hole the dissipation F |S - anchor|, S the cable beyond the hole, quadratic
near the anchor; its derivative by S is what the hole adds to the tension.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from spiraltrunk.model.statics.kernels import compiled, owning
from spiraltrunk.model.statics.kernels.address import by_address
from spiraltrunk.model.statics.kernels.cholesky import column_sum
from spiraltrunk.model.statics.kernels.laws.cable_gaps import differentiate_gap, gap_length
from spiraltrunk.model.statics.kernels.laws.gravity_load import add_weight, chain, weight_energy
from spiraltrunk.model.statics.kernels.laws.joint_rotation import differentiate, rotate
from spiraltrunk.model.statics.kernels.zeros import zeros


class Trunk(NamedTuple):
    """The design in arrays."""

    kind: np.ndarray
    """Kind of each joint, of `joint_rotation`, shape (n_joint,) [-]."""
    stiffness: np.ndarray
    """Bending stiffness about y and z, torsional about x, shape (n_joint, 3) [N m/rad]."""
    natural: np.ndarray
    """Bends without elastic moment, shape (n_joint, 3) [rad]."""
    limit: float
    """Largest bend [rad]."""
    length: np.ndarray
    """Lengths of the sections, shape (n_section,) [m]."""
    before: np.ndarray
    """Holes before the joints, from their centres, shape (n_joint, n_cable, 3) [m]."""
    beyond: np.ndarray
    """Holes beyond the joints, shape (n_joint, n_cable, 3) [m]."""
    rub_before: np.ndarray
    """Holes before the joints that count for friction: the designed ones, even where ``before`` is set back [m]."""
    rub_beyond: np.ndarray
    """The same beyond the joints [m]."""
    shut: float
    """Length that smooths the gap's length where the gap closes [m]."""


class Control(NamedTuple):
    """Inputs of the winders, shape (n_cable,) each."""

    by_tension: np.ndarray
    """Whether the cable is held by tension [bool], else by length."""
    length: np.ndarray
    """Sum of the gaps of a cable held by length, without stretch [m]."""
    most: np.ndarray
    """Largest tension [N]."""
    compliance: np.ndarray
    """Stretch per tension, 0 for an inextensible cable [m/N]."""


class Friction(NamedTuple):
    """Friction at the holes, arrays of shape (n_joint, n_cable); none where the stiffness is 0."""

    force: np.ndarray
    """Slip force of each hole towards the motor [N]."""
    force_back: np.ndarray
    """Slip force away from the motor [N]."""
    anchor: np.ndarray
    """Cable length beyond the hole at which its friction force is 0 [m]."""
    stiffness: float
    """Of a hole whose cable sticks [N/m]."""


class Case(NamedTuple):
    """One trunk with its base, loads and inputs."""

    base: np.ndarray
    """Axes of the base, shape (3, 3) [-]."""
    trunk: Trunk
    field: tuple[np.ndarray, np.ndarray, np.ndarray]
    """Loads, of `gravity_load.weight_energy`."""
    control: Control
    friction: Friction


class Work(NamedTuple):
    """Arrays of one solution, so that no iteration allocates.

    Per joint the ``rotation`` and its ``first`` and ``second`` derivatives by the bends; per gap its length ``gap``
    with the derivatives ``slope`` and ``curve``, the cable's ``tension``, its ``turn`` at the hole before it and the
    ``hole_stiffness`` there; of `gravity_load` the cross products ``force_cross`` and ``moment_cross``.
    """

    frames: np.ndarray
    rotation: np.ndarray
    first: np.ndarray
    second: np.ndarray
    gap: np.ndarray
    slope: np.ndarray
    curve: np.ndarray
    tension: np.ndarray
    turn: np.ndarray
    hole_stiffness: np.ndarray
    gradient: np.ndarray
    hessian: np.ndarray
    factor: np.ndarray
    force_cross: np.ndarray
    moment_cross: np.ndarray
    vectors: np.ndarray


@owning
def room_for_work(n_joint, n_cable, nd):
    """`Work` for a trunk whose joints have ``nd`` bends each."""
    size = n_joint * nd
    return Work(
        zeros((n_joint + 1, 3, 3)), zeros((n_joint, 3, 3)), zeros((n_joint, nd, 3, 3)),
        zeros((n_joint, nd, nd, 3, 3)), zeros((n_joint, n_cable)), zeros((n_joint, n_cable, nd)),
        zeros((n_joint, n_cable, nd, nd)), zeros((n_joint, n_cable)), zeros((n_joint, n_cable)),
        zeros((n_joint, n_cable)), zeros((n_joint, nd)), zeros((size, size)), zeros((size, size)),
        zeros((size, 3)), zeros((size, 3)), zeros((3, 3)),
    )  # fmt: skip


@compiled
def replace_trunk(trunk, stiffness, natural, shut):
    """The trunk with other stiffness, natural bends and smoothing length.

    For kernels that are `compiled`, not `owning`: nothing counts the references to the arrays of the result.
    """
    return Trunk(
        trunk.kind, stiffness, natural, trunk.limit, trunk.length, trunk.before, trunk.beyond, trunk.rub_before,
        trunk.rub_beyond, shut,
    )  # fmt: skip


@compiled
def replace_parts(case, trunk, length):
    """The case with another trunk and other cable lengths; for kernels as `replace_trunk`."""
    control = case.control
    held = Control(control.by_tension, length, control.most, control.compliance)
    return Case(case.base, trunk, case.field, held, case.friction)


@compiled
def place(q, base, trunk, work):
    """Rotations of the joints, frames of the sections and lengths of the gaps at the bends ``q``, into ``work``."""
    nd, v = work.first.shape[1], work.vectors[0]
    for i in range(q.shape[0]):
        rotate(q[i], trunk.kind[i], nd, work.rotation[i])
        for c in range(work.gap.shape[1]):
            work.gap[i, c] = gap_length(work.rotation[i], trunk.before[i, c], trunk.beyond[i, c], trunk.shut, v)
    chain(work.rotation, base, work.frames)


@compiled
def cable_tension(gap_sum, c, tension, control, penalty):
    """Tension of cable c in the augmented Lagrangian with multipliers ``tension`` [N], and its excess length [m]."""
    if control.by_tension[c]:
        return tension[c], 0.0
    excess = gap_sum - control.length[c]
    pull = (excess + tension[c] / penalty) / (control.compliance[c] + 1 / penalty)
    return min(max(pull, 0.0), control.most[c]), excess


@compiled
def update_tensions(gap, control, tension, penalty, pulls):
    """Tensions of the augmented Lagrangian at the lengths of the gaps, into ``pulls``."""
    for c in range(tension.shape[0]):
        pulls[c] = cable_tension(column_sum(gap, c), c, tension, control, penalty)[0]


@compiled
def find_excess(gap, control, pulls, system):
    """Excess length of each cable and the active set of cables; returns the largest violation [m]."""
    worst = 0.0
    for c in range(pulls.shape[0]):
        system.active[c], system.excess[c] = False, 0.0
        if not control.by_tension[c]:
            over = column_sum(gap, c) - control.length[c] - control.compliance[c] * pulls[c]
            is_idle = (pulls[c] <= 0 and over <= 0) or (pulls[c] >= control.most[c] and over >= 0)
            system.active[c], system.excess[c] = not is_idle, over
            if not is_idle:
                worst = max(worst, abs(over))
    return worst


@compiled
def add_penalty(system, control, penalty, hessian):
    """Add the penalty on the active cables' lengths to the lower triangle of the Hessian."""
    size = hessian.shape[0]
    for c in range(system.active.shape[0]):
        if system.active[c]:
            stiff = penalty / (1 + penalty * control.compliance[c])
            for row in range(size):
                push = stiff * system.slopes[c, row]
                if push != 0.0:
                    for column in range(row + 1):
                        hessian[row, column] += push * system.slopes[c, column]


@compiled
def merit(q, case, tension, penalty, work):
    """Merit of the shape [J]; ``work`` is then placed at ``q``."""
    place(q, case.base, case.trunk, work)
    return merit_placed(q, case, tension, penalty, work)


@compiled
def merit_placed(q, case, tension, penalty, work):
    """`merit` where ``work`` is placed at ``q`` already."""
    trunk, control, friction = case.trunk, case.control, case.friction
    energy = weight_energy(work.frames, trunk.length, case.field)
    for i in range(q.shape[0]):
        for a in range(work.first.shape[1]):
            bent = q[i, a] - trunk.natural[i, a]
            energy += 0.5 * trunk.stiffness[i, a] * bent * bent
    for c in range(work.gap.shape[1]):
        beyond = 0.0
        for i in range(q.shape[0] - 1, -1, -1):
            beyond += work.gap[i, c]
            if friction.stiffness > 0:
                energy += _dissipation(beyond, i, c, friction)
        pull, excess = cable_tension(beyond, c, tension, control, penalty)
        if control.by_tension[c]:
            energy += pull * beyond
        else:
            less = pull - tension[c]
            energy += pull * excess - 0.5 * (pull * pull * control.compliance[c] + less * less / penalty)
    return energy


@compiled
def _dissipation(beyond, i, c, friction):
    """Integral of `hole_force` over the cable's slip [J]."""
    slip = beyond - friction.anchor[i, c]
    force = friction.force[i, c] if slip < 0 else friction.force_back[i, c]
    size, foot = abs(slip), force / friction.stiffness
    return 0.5 * friction.stiffness * size * size if size < foot else force * (size - 0.5 * foot)


@compiled
def hole_force(beyond, i, c, friction):
    """Friction force of hole (i, c), added to the tension beyond it [N], and its derivative by the slip [N/m]."""
    slip = beyond - friction.anchor[i, c]
    force = friction.force[i, c] if slip < 0 else friction.force_back[i, c]
    if friction.stiffness * abs(slip) < force * (1 - 1e-9):  # A hole that slid stays on the boundary.
        return friction.stiffness * slip, friction.stiffness
    return (force if slip > 0 else -force), 0.0


@compiled
def linearise(q, case, pulls, work):
    """Gradient and lower Hessian of the energy with the winders at the tensions ``pulls``, into ``work``."""
    case, work = by_address(case), by_address(work)
    place(q, case.base, case.trunk, work)
    linearise_placed(q, case, pulls, work)


@compiled
def linearise_placed(q, case, pulls, work):
    """`linearise` where ``work`` is placed at ``q`` already."""
    work.gradient[:] = 0.0
    work.hessian[:] = 0.0
    _add_joints(q, case.trunk, work)
    add_weight(work, case.trunk.length, case.field)
    for c in range(work.gap.shape[1]):
        _propagate_tension(pulls[c], c, case.friction, work)
        _add_cable(c, work)
    if case.friction.stiffness > 0:
        _add_holes(work)


@compiled
def _add_joints(q, trunk, work):
    """Derivatives of every joint's rotation and gaps, and its elastic moment and stiffness."""
    nd, v = work.first.shape[1], work.vectors[0]
    for i in range(q.shape[0]):
        differentiate(q[i], trunk.kind[i], nd, work.first[i], work.second[i])
        for c in range(work.gap.shape[1]):
            p, m = trunk.before[i, c], trunk.beyond[i, c]
            length = gap_length(work.rotation[i], p, m, trunk.shut, v)
            differentiate_gap(work.first[i], work.second[i], p, m, length, v, work.slope[i, c], work.curve[i, c])
        for a in range(nd):
            work.gradient[i, a] += trunk.stiffness[i, a] * (q[i, a] - trunk.natural[i, a])
            work.hessian[i * nd + a, i * nd + a] += trunk.stiffness[i, a]


@compiled
def _propagate_tension(pull, c, friction, work):
    """Tension of cable c across every gap, from that at the winder, and the stiffness of its holes."""
    n_joint = work.gap.shape[0]
    if friction.stiffness == 0:
        work.tension[:, c] = pull
        return
    beyond = 0.0
    for i in range(n_joint - 1, -1, -1):
        beyond += work.gap[i, c]
        work.tension[i, c], work.hole_stiffness[i, c] = hole_force(beyond, i, c, friction)
    for i in range(n_joint):
        pull += work.tension[i, c]
        work.tension[i, c] = pull


@compiled
def _add_cable(c, work):
    nd = work.first.shape[1]
    for i in range(work.gap.shape[0]):
        pull = work.tension[i, c]
        if pull != 0.0:
            for a in range(nd):
                work.gradient[i, a] += pull * work.slope[i, c, a]
                for b in range(a + 1):
                    work.hessian[i * nd + a, i * nd + b] += pull * work.curve[i, c, a, b]


@compiled
def _add_holes(work):
    """Stiffness of the sticking holes: sum_m k_m dS_m dS_m over the holes, S_m the sum of the gaps from m on."""
    n_joint, n_cable = work.gap.shape
    nd = work.first.shape[1]
    for c in range(n_cable):
        stiff = 0.0
        for m in range(n_joint):
            stiff += work.hole_stiffness[m, c]
            if stiff == 0.0:
                continue
            for j in range(m, n_joint):  # Two gaps share every hole up to the nearer one, m.
                for a in range(nd):
                    push = stiff * work.slope[j, c, a]
                    for b in range(a + 1 if j == m else nd):
                        work.hessian[j * nd + a, m * nd + b] += push * work.slope[m, c, b]
