"""How the points of an equilibrium with friction move with every knob, by the implicit function theorem.

At an equilibrium the moments along every free bend q and the lengths of the taut cables satisfy

    K q + weight(q) + sum_k T_k dL_k/dq = 0,   sum_k L_k(q) = l + c T_0,

with c the give of winder and cable, L_k the length of gap k and T_k its tension: T_(k-1) exp(-mu w_k) where the cable
slides to the motor, T_(k-1) exp(mu w_k) where it slides away, w_k the turn at the hole (Euler and Eytelwein's capstan),
and T_(k-1) less a constant where it sticks. Joints pressed against their limit move along their rim alone. What a
sticking hole remembers of the way to the state is left out of the slopes, not of the equilibria.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.model.kinematics.cables import hole_positions
from spiraltrunk.model.kinematics.frames import base_orientation, bend_rotation
from spiraltrunk.model.kinematics.shape import Shape
from spiraltrunk.model.statics.equilibrium import SHUT, StaticsOptions, get_trunk
from spiraltrunk.model.statics.kernels.cable_gaps import NARROW
from spiraltrunk.model.statics.kernels.capstan_law import tension_ratio
from spiraltrunk.model.statics.kernels.energy import Case, Control, Friction, Trunk, Work, linearise, room_for_work
from spiraltrunk.model.statics.loads import read_fields

_H = 1e-5
"""Step of the central differences of turns by bends [rad], and of holes and centres by their fractions [-]."""

_NO_FRICTION = 1e-6
_STALLED = 1e-5
"""Cable left over from which a winder has reached its largest tension before its length [m]."""


@final
@dataclass(frozen=True, kw_only=True)
class _Gaps:
    """Cables of one shape, arrays by joint and cable."""

    length: np.ndarray
    """Shape (n_joint, n_cable) [m]."""
    slope: np.ndarray
    """By the joint's bends, shape (n_joint, n_cable, 2) [m/rad]."""
    turn: np.ndarray
    """Turn before the joint's gap, shape (n_joint, n_cable) [rad]."""


def slopes_of_state(
    design: TrunkDesign, shape: Shape, theta_0: float, winders: tuple[np.ndarray, float], *, softness: float = 0.0
) -> np.ndarray:
    """Motion of the section ends per knob, in the order of `calibrate_knobs.name_knobs`.

    Args:
        design: the trunk as solved.
        shape: its equilibrium by `statics.solve` with the default options but the give.
        theta_0: as solved [rad].
        winders: sum of the gaps that each leaves without tension, not a number for a relaxed cable, shape (n_cable,)
            [m], and what each gives per tension [m/N].
        softness: joints count as free though they are pressed against their limit, where the faces bear less than this
            part of the elastic moment [-]: so a search learns that a joint should not have shut yet.

    Returns:
        Shape (n_knob, n_section, 3) [m]; those of a slack that is out of play are 0.
    """
    assert shape.history is not None  # An equilibrium has both.
    assert shape.forces is not None
    state, (length, give) = _State(design, shape, theta_0), winders
    state.free(softness)
    with np.errstate(invalid="ignore"):
        left = shape.gap.sum(axis=0) - give * shape.forces.cable_tension - length
        held = (shape.forces.cable_tension > 0) & (np.abs(left) < _STALLED)
    matrix, free = state.equations(np.flatnonzero(held), give)
    right = state.right_hand_sides(np.flatnonzero(held), free)
    solved = np.linalg.lstsq(matrix, right, rcond=1e-13)[0] if matrix.size else right
    return state.move(free @ solved[: free.shape[1]])


@final
class _State:
    """One equilibrium and what it is made of."""

    def __init__(self, design: TrunkDesign, shape: Shape, theta_0: float) -> None:
        assert shape.history is not None
        assert shape.forces is not None
        self.design, self.bend = design, shape.history.bend.copy()
        self.trunk = get_trunk(design, _OPTIONS)[0]
        self.base = base_orientation(theta_0)
        self.tension, self.first = shape.forces.gap_tension, shape.forces.cable_tension
        self.reaction = shape.forces.limit_reaction
        self.work = self._linearise(design, self.trunk)
        self.rotation = self.work.rotation
        self.gaps = self._measure(design)
        self.mode = self._find_modes()
        self.weight = self.work.gradient.ravel() - (self.trunk.stiffness[:, :2] * self.bend[:, :2]).ravel()

    def free(self, softness: float) -> None:
        """Forget the faces that bear less than this part of the elastic moment."""
        elastic = self.trunk.stiffness[:, 0] * np.linalg.norm(self.bend[:, :2], axis=1)
        self.reaction = np.where(self.reaction > softness * elastic, self.reaction, 0.0)

    def _linearise(self, design: TrunkDesign, trunk: Trunk) -> Work:
        """Elasticity and weight alone: cables without tension."""
        fields = read_fields(design, None)
        nothing, idle = np.zeros(design.n_cable), np.zeros((design.n_joint, design.n_cable))
        parts = [np.array(part, order="C") for part in (fields.direction, fields.factor, fields.moment)]
        case = Case(
            self.base, trunk, (parts[0], parts[1], parts[2]),
            Control(np.full(design.n_cable, True), nothing, nothing, nothing), Friction(idle, idle, idle, 0.0),
        )  # fmt: skip
        work = room_for_work(design.n_joint, design.n_cable, 2)
        linearise(self.bend, case, nothing, work)
        return work

    def _measure(self, design: TrunkDesign) -> _Gaps:
        beyond, before = hole_positions(design)
        across = np.einsum("jxy,jcy->jcx", self.rotation, beyond) - before
        length = np.sqrt((across**2).sum(axis=-1) + SHUT**2)
        turned = np.einsum("jaxy,jcy->jcax", self.work.first, beyond)
        slope = np.einsum("jcx,jcax->jca", across, turned) / length[..., None]
        return _Gaps(length=length, slope=slope, turn=_add_turns(*_hole_turns(self.rotation, before, beyond)))

    def _find_modes(self) -> np.ndarray:
        """1 where a cable slides to the motor, -1 where it slides away, 0 where it sticks, (n_joint, n_cable) [-]."""
        if self.design.cable.friction < _NO_FRICTION:  # What little there would be works against the motor.
            return np.where(self.tension > 0, 1.0, 0.0)
        before = np.vstack([self.first, self.tension[:-1]])
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.log(before / self.tension) / (self.design.cable.friction * self.gaps.turn)
        return np.where(np.abs(share - 1) < 0.02, 1.0, np.where(np.abs(share + 1) < 0.02, -1.0, 0.0))

    def tensions(self, turn: np.ndarray, friction: float) -> np.ndarray:
        """Tensions of the gaps at other turns and friction, the motors' and what sticking holes hold as they are."""
        last, out = self.first.copy(), np.empty_like(self.tension)
        held = np.vstack([self.first, self.tension[:-1]]) - self.tension
        for k, mode in enumerate(self.mode):
            last = np.where(mode == 0.0, last - held[k], last * tension_ratio(mode * friction, turn[k]))
            out[k] = last
        return out

    def by_motors(self) -> np.ndarray:
        """Tension of each gap per tension of its motor, shape (n_joint, n_cable) [-]."""
        slides = tension_ratio(self.mode * self.design.cable.friction, self.gaps.turn)
        return np.cumprod(np.where(self.mode == 0.0, 1.0, slides), axis=0)

    def _by_bends(self) -> np.ndarray:
        """Tension of gap k of cable c per bend a of joint j, shape (n_joint k, n_cable, n_joint j, 2) [N/rad]."""
        count = self.design.n_joint
        beyond, before = hole_positions(self.design)
        near, far = np.zeros((count, self.design.n_cable, 2)), np.zeros((count, self.design.n_cable, 2))
        for a in range(2):
            step = np.zeros(2)
            step[a] = _H
            ends = [_hole_turns(bend_rotation(self.bend[:, :2] + side * step), before, beyond) for side in (1.0, -1.0)]
            near[..., a], far[..., a] = ((up - down) / (2 * _H) for up, down in zip(*ends, strict=True))
        out, mu = np.zeros((count, self.design.n_cable, count, 2)), self.design.cable.friction
        last = np.zeros(out.shape[1:])
        for k in range(count):
            turned = np.zeros_like(last)
            turned[:, k] = near[k]
            if k:
                turned[:, k - 1] = far[k - 1]
            mode = self.mode[k][:, None, None]
            slides = tension_ratio(mode * mu, self.gaps.turn[k][:, None, None])
            here = last * slides - mode * mu * self.tension[k][:, None, None] * turned
            last = np.where(mode == 0.0, last, here)
            out[k] = last
        return out

    def equations(self, held: np.ndarray, give: float) -> tuple[np.ndarray, np.ndarray]:
        """The linear equations in free bends and motors' tensions, and all bends per free bend."""
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
        hessian += np.einsum("kca,kcjb->kajb", self.gaps.slope, self._by_bends()).reshape(2 * count, -1)
        basis = np.zeros((2 * count, sum(axes.shape[1] for axes in free)))
        column = 0
        for k, axes in enumerate(free):
            basis[2 * k : 2 * k + 2, column : column + axes.shape[1]] = axes
            column += axes.shape[1]
        slope = self.gaps.slope[:, held].transpose(1, 0, 2).reshape(len(held), 2 * count)
        lever = self.by_motors()[:, held].T.repeat(2, axis=1) * slope
        top = np.hstack([basis.T @ hessian @ basis, basis.T @ lever.T])
        return np.vstack([top, np.hstack([slope @ basis, -give * np.eye(len(held))])]), basis

    def right_hand_sides(self, held: np.ndarray, free: np.ndarray) -> np.ndarray:
        """Minus what each knob adds to moments and lengths, shape (n_equation, n_knob)."""
        joints, cables = self.design.n_joint, self.design.n_cable
        size = joints + 5 + cables
        moment, length = np.zeros((2 * joints, size)), np.zeros((cables, size))
        elastic = self.trunk.stiffness[:, :2] * self.bend[:, :2]
        for k in range(joints):
            moment[2 * k : 2 * k + 2, k] = elastic[k]
        moment[:, joints] = self.weight
        moment[:, joints + 1] = self._by_center()
        less = np.cumsum(self.mode * self.gaps.turn, axis=0) * self.tension
        moment[:, joints + 2] = -np.einsum("kc,kca->ka", less, self.gaps.slope).ravel()
        length[range(cables), range(joints + 3, joints + 3 + cables)] = -1.0
        length[:, -1] = -self.first
        up, down = (self._at_holes(side * _H) for side in (1.0, -1.0))
        moment[:, -2], length[:, -2] = (up[0] - down[0]) / (2 * _H), (up[1] - down[1]) / (2 * _H)
        return -np.vstack([free.T @ moment, length[held]])

    def _by_center(self) -> np.ndarray:
        """Moments per centre of mass over the section's length, linear in it, shape (2 n_joint,) [N m]."""
        mass, fraction = self.design.mass, float(self.design.section_center[0] / self.design.section_length[0])
        other = replace(self.design, mass=replace(mass, center_fraction=0.5 * fraction))
        less = self._linearise(other, self.trunk).gradient - self.work.gradient
        return np.asarray(less.ravel() / (-0.5 * fraction))

    def _at_holes(self, change: float) -> tuple[np.ndarray, np.ndarray]:
        """Moments of the cables, and length over that of the straight trunk, with other holes [N m], [m]."""
        cable = self.design.cable
        other = replace(self.design, cable=replace(cable, hole_fraction=cable.hole_fraction + change))
        gaps = self._measure(other)
        tension = self.tensions(gaps.turn, cable.friction)
        beyond, before = hole_positions(other)
        straight = np.linalg.norm(beyond - before, axis=-1).sum(axis=0)
        return np.einsum("kc,kca->ka", tension, gaps.slope).ravel(), gaps.length.sum(axis=0) - straight

    def move(self, bend: np.ndarray) -> np.ndarray:
        """Motion of the section ends per column of bends, shape (columns, n_section, 3)."""
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


_OPTIONS = StaticsOptions()


def _free_axes(bend: np.ndarray, reaction: float) -> tuple[np.ndarray, np.ndarray]:
    """Directions in which a joint may bend, as columns, and the curvature that its reaction adds."""
    if reaction <= 0.0:
        return np.eye(2), np.zeros((2, 2))
    size = float(np.hypot(*bend))
    tangent = np.array([[-bend[1]], [bend[0]]]) / size
    return tangent, reaction / size * (tangent @ tangent.T)


def _hole_turns(rotation: np.ndarray, before: np.ndarray, beyond: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Turns of every cable at the holes before and beyond each joint, as `kernels.gaps.hole_turns` [rad]."""
    across = np.einsum("jxy,jcy->jcx", rotation, beyond) - before
    size = np.linalg.norm(across, axis=-1, keepdims=True)
    near, far = np.array([1.0, 0.0, 0.0]), rotation[:, None, :, 0]
    mean = near + far
    across = across + NARROW * np.exp(-((size / NARROW) ** 2)) * mean / np.linalg.norm(mean, axis=-1, keepdims=True)
    along = across / np.linalg.norm(across, axis=-1, keepdims=True)
    return _angle(along, near), _angle(along, far)


def _angle(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.asarray(2 * np.arctan2(np.linalg.norm(one - other, axis=-1), np.linalg.norm(one + other, axis=-1)))


def _add_turns(before: np.ndarray, beyond: np.ndarray) -> np.ndarray:
    """Turn before each gap: at the hole beyond the gap before it, and at its own first hole."""
    return before + np.vstack([np.zeros_like(beyond[:1]), beyond[:-1]])
