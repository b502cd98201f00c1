"""Energy and residual of the trunk under weight, elasticity, cables and their friction.

Merit of a shape: elastic energy, loads, and per cable an augmented Lagrangian of "no longer than its length, tension
from 0 to the largest"; a cable with a tension adds tension times length. Friction adds, hole by hole, a dissipation
F |S - anchor| with a short elastic foot, S the cable beyond the hole; its slope is what the hole takes off the tension.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from spiraltrunk.model.statics.kernels import compiled, owning
from spiraltrunk.model.statics.kernels.address import by_address
from spiraltrunk.model.statics.kernels.cable_gaps import differentiate_gap, gap_length
from spiraltrunk.model.statics.kernels.gravity_load import add_weight, chain, weight_energy
from spiraltrunk.model.statics.kernels.joint_rotation import differentiate, rotate


class Trunk(NamedTuple):
    """What does not change: the design in arrays."""

    kind: np.ndarray
    """How each joint turns, of `rotation`, shape (n_joint,) [-]."""
    stiffness: np.ndarray
    """About y, z and x (torsion), shape (n_joint, 3) [N m/rad]."""
    natural: np.ndarray
    """Bends that need no moment, shape (n_joint, 3) [rad]."""
    limit: float
    """Largest bend [rad]."""
    length: np.ndarray
    """Sections, shape (n_section,) [m]."""
    before: np.ndarray
    """Holes before the joints, from their centres, shape (n_joint, n_cable, 3) [m]."""
    beyond: np.ndarray
    """Holes beyond the joints, shape (n_joint, n_cable, 3) [m]."""
    rub_before: np.ndarray
    """Holes before the joints at which the cables rub: the designed ones, where ``before`` is set back [m]."""
    rub_beyond: np.ndarray
    """The same beyond the joints [m]."""
    shut: float
    """Length at which a gap counts as shut [m]."""


class Control(NamedTuple):
    """What the winders do, one number a cable, shape (n_cable,)."""

    by_tension: np.ndarray
    """Whether the tension is given [bool]; else the length is."""
    length: np.ndarray
    """Sum of the gaps that the winder leaves [m]."""
    most: np.ndarray
    """Largest tension [N]."""
    compliance: np.ndarray
    """Stretch per tension, 0 for an inextensible cable [m/N]."""


class Friction(NamedTuple):
    """Friction at the holes, shape (n_joint, n_cable) each; a stiffness of 0 leaves it out."""

    force: np.ndarray
    """What each hole can take off the tension when the cable slides to the motor [N]."""
    force_back: np.ndarray
    """The same when it slides away from the motor [N]."""
    anchor: np.ndarray
    """Cable beyond the hole at which the hole holds nothing [m]."""
    stiffness: float
    """Of a hole before its cable slides [N/m]."""


class Case(NamedTuple):
    """One trunk as it stands and is driven."""

    base: np.ndarray
    """Axes of the base, shape (3, 3) [-]."""
    trunk: Trunk
    """The design."""
    field: tuple[np.ndarray, np.ndarray, np.ndarray]
    """Loads, of `weight`."""
    control: Control
    """Winders."""
    friction: Friction
    """Holes."""


class Work(NamedTuple):
    """Room for one solution, so that nothing is allocated on the way."""

    frames: np.ndarray
    rotation: np.ndarray
    first: np.ndarray
    second: np.ndarray
    gap: np.ndarray
    slope: np.ndarray
    curve: np.ndarray
    tension: np.ndarray
    turn: np.ndarray
    bow: np.ndarray
    gradient: np.ndarray
    hessian: np.ndarray
    factor: np.ndarray
    lean: np.ndarray
    sway: np.ndarray
    vectors: np.ndarray


@owning
def room_for_work(n_joint, n_cable, nd):
    """`Work` for a trunk whose joints have ``nd`` bends each."""
    size = n_joint * nd
    return Work(
        np.zeros((n_joint + 1, 3, 3)), np.zeros((n_joint, 3, 3)), np.zeros((n_joint, nd, 3, 3)),
        np.zeros((n_joint, nd, nd, 3, 3)), np.zeros((n_joint, n_cable)), np.zeros((n_joint, n_cable, nd)),
        np.zeros((n_joint, n_cable, nd, nd)), np.zeros((n_joint, n_cable)), np.zeros((n_joint, n_cable)),
        np.zeros((n_joint, n_cable)), np.zeros((n_joint, nd)), np.zeros((size, size)), np.zeros((size, size)),
        np.zeros((size, 3)),
        np.zeros((size, 3)), np.zeros((3, 3)),
    )  # fmt: skip


@compiled
def place(q, base, trunk, work):
    """Put the chain at the bends ``q``: joints' rotations, sections' frames, gaps."""
    nd, v = work.first.shape[1], work.vectors[0]
    for i in range(q.shape[0]):
        rotate(q[i], trunk.kind[i], nd, work.rotation[i])
        for c in range(work.gap.shape[1]):
            work.gap[i, c] = gap_length(work.rotation[i], trunk.before[i, c], trunk.beyond[i, c], trunk.shut, v)
    chain(work.rotation, base, work.frames)


@compiled
def cable_tension(gap_sum, c, tension, control, penalty):
    """Tension of cable c by its augmented Lagrangian with the multiplier ``tension``, and the excess length."""
    if control.by_tension[c]:
        return tension[c], 0.0
    excess = gap_sum - control.length[c]
    pull = (excess + tension[c] / penalty) / (control.compliance[c] + 1 / penalty)
    return min(max(pull, 0.0), control.most[c]), excess


@compiled
def merit(q, case, tension, penalty, work):
    """Energy plus what cables and friction add [J]; leaves ``work`` placed at ``q``."""
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
    """Integral of `hold` over the cable's slip [J]."""
    slip = beyond - friction.anchor[i, c]
    force = friction.force[i, c] if slip < 0 else friction.force_back[i, c]
    size, foot = abs(slip), force / friction.stiffness
    return 0.5 * friction.stiffness * size * size if size < foot else force * (size - 0.5 * foot)


@compiled
def hold(beyond, i, c, friction):
    """What hole (i, c) adds to the tension beyond it [N], negative when it takes off, and its stiffness [N/m]."""
    slip = beyond - friction.anchor[i, c]
    force = friction.force[i, c] if slip < 0 else friction.force_back[i, c]
    if friction.stiffness * abs(slip) < force * (1 - 1e-9):  # A hole that slid is left just there, and slides on.
        return friction.stiffness * slip, friction.stiffness
    return (force if slip > 0 else -force), 0.0


@compiled
def linearise(q, case, pulls, work):
    """Gradient and lower Hessian of the energy with the winders at the tensions ``pulls``, into ``work``.

    ``work.tension`` receives the tension of every gap, ``work.bow`` the stiffness of every hole.
    """
    case, work = by_address(case), by_address(work)
    place(q, case.base, case.trunk, work)
    linearise_placed(q, case, pulls, work)


@compiled
def linearise_placed(q, case, pulls, work):
    """`linearise` where ``work`` is placed at ``q`` already."""
    trunk = case.trunk
    work.gradient[:] = 0.0
    work.hessian[:] = 0.0
    _differentiate(q, trunk, work)
    _add_elastic(q, trunk, work)
    add_weight(work, trunk.length, case.field)
    for c in range(work.gap.shape[1]):
        _spread(pulls[c], c, case.friction, work)
        _add_cable(c, work)
    if case.friction.stiffness > 0:
        _add_holes(work)


@compiled
def _differentiate(q, trunk, work):
    nd, v = work.first.shape[1], work.vectors[0]
    for i in range(q.shape[0]):
        differentiate(q[i], trunk.kind[i], nd, work.first[i], work.second[i])
        for c in range(work.gap.shape[1]):
            p, m = trunk.before[i, c], trunk.beyond[i, c]
            length = gap_length(work.rotation[i], p, m, trunk.shut, v)
            differentiate_gap(work.first[i], work.second[i], p, m, length, v, work.slope[i, c], work.curve[i, c])


@compiled
def _add_elastic(q, trunk, work):
    nd = work.first.shape[1]
    for i in range(q.shape[0]):
        for a in range(nd):
            work.gradient[i, a] += trunk.stiffness[i, a] * (q[i, a] - trunk.natural[i, a])
            work.hessian[i * nd + a, i * nd + a] += trunk.stiffness[i, a]


@compiled
def _spread(pull, c, friction, work):
    """Tension of every gap of a cable from the winder's."""
    n_joint = work.gap.shape[0]
    if friction.stiffness == 0:
        work.tension[:, c] = pull
        return
    beyond = 0.0
    for i in range(n_joint - 1, -1, -1):
        beyond += work.gap[i, c]
        work.tension[i, c], work.bow[i, c] = hold(beyond, i, c, friction)
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
    """Stiffness of the sticking holes: a sum over holes m of bow_m dS_m dS_m, each S_m the gaps from m on."""
    n_joint, n_cable = work.gap.shape
    nd = work.first.shape[1]
    for c in range(n_cable):
        stiff = 0.0
        for m in range(n_joint):
            stiff += work.bow[m, c]
            if stiff == 0.0:
                continue
            for j in range(m, n_joint):  # Pairs whose nearer gap is m share every hole up to m.
                for a in range(nd):
                    push = stiff * work.slope[j, c, a]
                    for b in range(a + 1 if j == m else nd):
                        work.hessian[j * nd + a, m * nd + b] += push * work.slope[m, c, b]
