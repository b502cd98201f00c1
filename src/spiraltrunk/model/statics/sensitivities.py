"""Sensitivities of an equilibrium with friction, by implicit differentiation.

At an equilibrium the moments about every free bend q vanish, and a taut cable has the length that its winder leaves:

    G = K q + dV/dq + sum_k T_k dL_k/dq = 0,   sum_k L_k(q) = l + c T_0,

with K the joints' stiffness, V the potential of weight and loads, L_k the length of gap k and T_k its tension, l the
length that the winder leaves, c the compliance of winder and cable, and T_0 the tension at the winder. Where the cable
slides, T_k follows from T_(k-1) by `kernels.laws.capstan_law`; where it sticks, it is T_(k-1) less a constant, or,
with a stiffness of sticking holes, changes with the cable beyond the hole. By the implicit function theorem a
parameter p moves bends and tensions by

    [ dG/dq   dG/dT_0 ] [ dq/dp   ]     [ dG/dp           ]
    [ dL/dq   -c      ] [ dT_0/dp ] = - [ d(L - l - cT)/dp ].

A joint pressed against its limit moves along the rim of its cone only: the equations are reduced to the free
directions, and the reaction times the rim's curvature is added to dG/dq. What a sticking hole remembers of the loading
history is differentiated in `spiraltrunk.calibration.sensitivities`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np
from scipy.linalg import block_diag

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.model.kinematics.cables import hole_positions
from spiraltrunk.model.kinematics.frames import base_orientation, bend_rotation
from spiraltrunk.model.kinematics.shape import Shape
from spiraltrunk.model.statics.equilibrium import SHUT, StaticsOptions, get_trunk
from spiraltrunk.model.statics.kernels.laws.cable_gaps import find_hole_turns
from spiraltrunk.model.statics.kernels.laws.capstan_law import tension_ratio
from spiraltrunk.model.statics.kernels.laws.energy import Case, Control, Friction, Work, linearise, room_for_work
from spiraltrunk.model.statics.loads import Loads, read_angle, read_forces

__all__ = ["ByCables", "Equilibrium", "Gaps", "by_cables"]

_STEP = 1e-5
"""Step of the central differences of turns by bends [rad], and of holes by their fraction [-]."""

_NO_FRICTION = 1e-6
"""Coefficient of friction below which every cable counts as sliding towards its winder [-]."""

SLIDES = 0.02
"""Largest relative deviation of the exponent mu w from the capstan law's at which a cable counts as sliding [-]."""

_OPTIONS = StaticsOptions()


@final
@dataclass(frozen=True, kw_only=True)
class ByCables:
    """Derivatives of a shape by the inputs of its winders."""

    points_by_tension: np.ndarray
    """Section ends by tension, all cables held by tension, shape (n_section, 3, n_cable) [m/N]."""
    points_by_pull: np.ndarray
    """Section ends by cable pulled in, the others held by length; 0 for slack cables, (n_section, 3, n_cable) [-]."""
    pull_by_tension: np.ndarray
    """Cable pulled in by tension; symmetric without friction, shape (n_cable, n_cable) [m/N]."""
    tension_by_pull: np.ndarray
    """The inverse for the taut cables, 0 for the others, shape (n_cable, n_cable) [N/m]."""


def by_cables(
    design: TrunkDesign, shape: Shape, *, theta_0: float = np.pi / 2, roll: float = 0.0, loads: Loads | None = None
) -> ByCables:
    """Derivatives by tensions and by cable lengths, cables inextensible.

    Args:
        design: the trunk.
        shape: one equilibrium from `statics.solve` with the design's friction, without torsion or hinges.
        theta_0: as solved [rad].
        roll: as solved [rad].
        loads: as solved.

    Raises:
        ModelError: where the shape is no equilibrium of this trunk as it stands, or is a batch.
    """
    if shape.history is None or shape.forces is None or shape.points.shape != (design.n_section, 3):
        raise ModelError(f"shape has points of shape {shape.points.shape}; allowed: one shape from statics.solve")
    base = base_orientation(read_angle("theta_0", theta_0), read_angle("roll", roll))
    if base.shape != (3, 3):
        raise ModelError("theta_0 or roll is a batch; allowed: one number each")
    state = Equilibrium(design, shape, base, loads)
    matrix, free = state.equations(np.arange(design.n_cable), 0.0)
    left = float(np.abs(free.T @ state.moment()).max())
    if left > 1e-5:
        raise ModelError(
            f"shape has moments of {left:.3g} N m left; allowed: an equilibrium of this trunk, with the theta_0, roll "
            "and loads it was solved with"
        )
    size, taut = free.shape[1], np.flatnonzero(state.winder_tension > 0)
    bend = -np.linalg.solve(matrix[:size, :size], matrix[:size, size:])
    pull_by_tension = -matrix[size:, :size] @ bend
    tension_by_pull = np.zeros_like(pull_by_tension)
    tension_by_pull[np.ix_(taut, taut)] = np.linalg.inv(pull_by_tension[np.ix_(taut, taut)])
    by_tension = np.moveaxis(state.move(free @ bend), 0, -1)
    return ByCables(
        points_by_tension=by_tension, points_by_pull=by_tension @ tension_by_pull, pull_by_tension=pull_by_tension,
        tension_by_pull=tension_by_pull,
    )  # fmt: skip


@final
class Gaps(NamedTuple):
    """Cables of one shape at each joint's gap, first axes (n_joint, n_cable)."""

    length: np.ndarray
    slope: np.ndarray
    """Of the length by the joint's bends, shape (n_joint, n_cable, 2) [m/rad]."""
    turn: np.ndarray
    """Turn before the gap [rad]."""


@final
class Equilibrium:
    """One equilibrium and the terms of its linear equations."""

    def __init__(
        self, design: TrunkDesign, shape: Shape, base: np.ndarray, loads: Loads | None, slides: float = SLIDES
    ) -> None:
        assert shape.history is not None  # An equilibrium has both.
        assert shape.forces is not None
        self.design, self.bend, self.base, self.loads = design, shape.history.bend.copy(), base, loads
        self.trunk = get_trunk(design, _OPTIONS)[0]
        self.tension, self.winder_tension = shape.forces.gap_tension, shape.forces.cable_tension
        self.reaction = shape.forces.limit_reaction
        self.work = self.linearise(design)
        self.gaps = self.measure(design)
        self.mode = self._find_modes(slides)
        self.sticking = np.zeros_like(self.mode)
        """Stiffness of sticking holes [N/m]; 0 holds their friction forces as they are."""
        self.elastic = self.trunk.stiffness[:, :2] * self.bend[:, :2]

    def free_soft_joints(self, softness: float) -> None:
        """Set the reactions below this part of the elastic moment to 0."""
        elastic = self.trunk.stiffness[:, 0] * np.linalg.norm(self.bend[:, :2], axis=1)
        self.reaction = np.where(self.reaction > softness * elastic, self.reaction, 0.0)

    def linearise(self, design: TrunkDesign) -> Work:
        """Gradient and Hessian of elasticity and weight alone: cables without tension."""
        fields = read_forces(design, self.loads)
        nothing, idle = np.zeros(design.n_cable), np.zeros((design.n_joint, design.n_cable))
        parts = [np.array(part, order="C") for part in (fields.direction, fields.factor, fields.moment)]
        control = Control(np.full(design.n_cable, True), nothing, nothing, nothing)
        case = Case(self.base, self.trunk, (parts[0], parts[1], parts[2]), control, Friction(idle, idle, idle, 0.0))
        work = room_for_work(design.n_joint, design.n_cable, 2)
        linearise(self.bend, case, nothing, work)
        return work

    def measure(self, design: TrunkDesign) -> Gaps:
        beyond, before = hole_positions(design)
        across = np.einsum("jxy,jcy->jcx", self.work.rotation, beyond) - before
        length = np.sqrt((across**2).sum(axis=-1) + SHUT**2)
        turned = np.einsum("jaxy,jcy->jcax", self.work.first, beyond)
        slope = np.einsum("jcx,jcax->jca", across, turned) / length[..., None]
        turn, at_beyond = find_hole_turns(self.work.rotation, before, beyond)
        turn[1:] += at_beyond[:-1]
        return Gaps(length, slope, turn)

    def _find_modes(self, slides: float) -> np.ndarray:
        """1 where a cable slides to its winder, -1 where it slides away, 0 where it sticks, (n_joint, n_cable) [-]."""
        if self.design.cable.friction < _NO_FRICTION:
            return np.where(self.tension > 0, 1.0, 0.0)
        before = np.vstack([self.winder_tension, self.tension[:-1]])
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.log(before / self.tension) / (self.design.cable.friction * self.gaps.turn)
        return np.where(np.abs(share - 1) < slides, 1.0, np.where(np.abs(share + 1) < slides, -1.0, 0.0))

    def ratio(self, turn: np.ndarray) -> np.ndarray:
        """Tension beyond over tension before each hole; 1 where it sticks, shape of ``turn`` [-]."""
        return np.asarray(tension_ratio(self.mode * self.design.cable.friction, turn))

    def carry_tension(self, change: np.ndarray) -> np.ndarray:
        """Changes of the gap tensions by those at each hole, dT_k = T_k / T_(k-1) dT_(k-1) + change_k.

        ``change`` has the shape (n_joint, n_cable, ...) [N over any unit], and so has what is returned.
        """
        out, ratio = np.array(change, float), self.ratio(self.gaps.turn)
        for k in range(1, len(out)):
            out[k] += ratio[k].reshape(-1, *[1] * (out.ndim - 2)) * out[k - 1]
        return out

    def tension_by_bend(self) -> np.ndarray:
        """Tension of gap k of cable c by bend a of joint j, shape (n_joint k, n_cable, n_joint j, 2) [N/rad]."""
        count = self.design.n_joint
        beyond, before = hole_positions(self.design)
        near, far = np.zeros((count, self.design.n_cable, 2)), np.zeros((count, self.design.n_cable, 2))
        for a in range(2):
            bends = (self.bend[:, :2] + side * _STEP * np.eye(2)[a] for side in (1.0, -1.0))
            ends = [find_hole_turns(bend_rotation(bend), before, beyond) for bend in bends]
            near[..., a], far[..., a] = ((up - down) / (2 * _STEP) for up, down in zip(*ends, strict=True))
        by_turn = -(self.mode * self.design.cable.friction * self.tension)[..., None]
        change = self.sticking[..., None, None] * self.cable_beyond_by_bend()
        k = np.arange(count)
        change[k, :, k] += by_turn * near
        change[k[1:], :, k[:-1]] += by_turn[1:] * far[:-1]
        return self.carry_tension(change)

    def cable_beyond_by_bend(self) -> np.ndarray:
        """Cable beyond hole k, the gaps from k on, by bend a of joint j, shape as `tension_by_bend` [m/rad]."""
        is_beyond = np.triu(np.ones((self.design.n_joint, self.design.n_joint)))
        return np.einsum("kj,jca->kcja", is_beyond, self.gaps.slope)

    def moment(self) -> np.ndarray:
        """G without the reactions of the pressed joints, shape (2 n_joint,) [N m]."""
        return (self.work.gradient + np.einsum("kc,kca->ka", self.tension, self.gaps.slope)).ravel()

    def equations(self, held: np.ndarray, compliance: float) -> tuple[np.ndarray, np.ndarray]:
        """Matrix of the equations in free bends and tensions of the cables ``held``; all bends per free bend."""
        count = self.design.n_joint
        lower = np.tril(self.work.hessian)
        hessian = lower + np.tril(lower, -1).T
        curve = np.einsum("kc,kcab->kab", self.tension, self.work.curve)
        bowed = np.tril(curve) + np.swapaxes(np.tril(curve, -1), -1, -2)
        free = []
        for k in range(count):
            rows = slice(2 * k, 2 * k + 2)
            hessian[rows, rows] += bowed[k]
            axes, rim = _free_axes(self.bend[k, :2], float(self.reaction[k]))
            hessian[rows, rows] += rim
            free.append(axes)
        hessian += np.einsum("kca,kcjb->kajb", self.gaps.slope, self.tension_by_bend()).reshape(2 * count, -1)
        basis = block_diag(*free)
        slope = self.gaps.slope[:, held].transpose(1, 0, 2).reshape(len(held), 2 * count)
        by_winder = np.cumprod(self.ratio(self.gaps.turn), axis=0)
        lever = by_winder[:, held].T.repeat(2, axis=1) * slope
        top = np.hstack([basis.T @ hessian @ basis, basis.T @ lever.T])
        return np.vstack([top, np.hstack([slope @ basis, -compliance * np.eye(len(held))])]), basis

    def move(self, bend: np.ndarray) -> np.ndarray:
        """Displacement of the section ends per column of bends, shape (columns, n_section, 3)."""
        work, count = self.work, self.design.n_joint
        spun = np.einsum("jaik,jlk->jail", work.first, work.rotation)
        vector = np.stack([spun[..., 2, 1], spun[..., 0, 2], spun[..., 1, 0]], axis=-1)
        turning = np.einsum("jxy,jay->jax", work.frames[:-1], vector)
        turned = np.einsum("jax,jap->pjx", turning, bend.reshape(count, 2, -1))
        total = np.cumsum(turned, axis=1)
        moved = np.zeros((bend.shape[1], count + 1, 3))
        along = work.frames[1:, :, 0] * self.trunk.length[1:, None]
        moved[:, 1:] = np.cumsum(np.cross(total, along[None]), axis=1)
        return moved


def _free_axes(bend: np.ndarray, reaction: float) -> tuple[np.ndarray, np.ndarray]:
    """Free directions of a joint's bend, as columns, and the reaction times the curvature of the rim [N m/rad]."""
    if reaction <= 0.0:
        return np.eye(2), np.zeros((2, 2))
    size = float(np.hypot(*bend))
    tangent = np.array([[-bend[1]], [bend[0]]]) / size
    return tangent, reaction / size * (tangent @ tangent.T)
