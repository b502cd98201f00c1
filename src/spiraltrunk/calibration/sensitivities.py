"""Derivatives of a loading sequence's equilibria by the parameters of a calibration, by implicit differentiation.

A parameter p moves the bends q and the tensions T_0 at the winders of an equilibrium as `statics.sensitivities` says.
Where a hole slides, the tension beyond it follows the capstan law. Where it sticks, the hole keeps the cable that was
beyond it when it last slid: with S_k the cable beyond hole k and h the stiffness of a sticking hole,

    T_k = T_(k-1) + h (S_k - a_k),   so that   dT_k/dp = dT_(k-1)/dp + h (dS_k/dp - da_k/dp),

and the anchor that an equilibrium leaves to the next is a_k = S_k - (T_k - T_(k-1)) / h. The derivatives of a sequence
are therefore carried on from state to state. The force of a sticking hole is no constant: in a twist cable 1 is held
while cable 2 is pulled, and most of its holes stick.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.model.kinematics.cables import hole_positions
from spiraltrunk.model.kinematics.frames import base_orientation
from spiraltrunk.model.kinematics.shape import Shape
from spiraltrunk.model.statics.equilibrium import StaticsOptions
from spiraltrunk.model.statics.sensitivities import SLIDES, Equilibrium

_STEP = 1e-5
"""Step of the central differences by the hole fraction [-]."""

_STALLED = 1e-5
"""Cable left over from which a winder has reached its largest tension before its length [m]."""

_SLIDES = 1e-3
"""Largest relative deviation of the exponent mu w from the capstan law's at which a cable counts as sliding [-]; less
than `SLIDES` where all that a hole remembers is known, so that one that nearly slides is differentiated as it is."""

_STIFFNESS = StaticsOptions().hole_stiffness
"""Stiffness of a sticking hole in the predicted equilibria [N/m]."""


@final
@dataclass(frozen=True, kw_only=True)
class Sensitivities:
    """Derivatives of one equilibrium by the parameter vector."""

    points: np.ndarray
    """Section ends, shape (n_parameter, n_section, 3) [m over the parameter's unit]."""
    anchor: np.ndarray
    """Cable beyond each hole at which the hole holds nothing, shape (n_joint, n_cable, n_parameter) [same unit]."""


def by_parameters(
    design: TrunkDesign,
    shape: Shape,
    *,
    theta_0: float,
    length: np.ndarray,
    compliance: float,
    softness: float = 0.0,
    before: Sensitivities | None = None,
    is_direct: bool = False,
) -> Sensitivities:
    """Derivatives of an equilibrium by the parameters of a calibration.

    Args:
        design: the trunk as solved.
        shape: its equilibrium by `statics.solve` with the default options but the compliance.
        theta_0: as solved [rad].
        length: sum of the gaps that each winder leaves without tension, not a number for a relaxed cable, shape
            (n_cable,) [m].
        compliance: of each winder with its cable [m/N].
        softness: a pressed joint counts as free where its reaction is below this part of its elastic moment [-], so
            that a search feels that the joint should not have shut yet.
        before: of the equilibrium from which loading continued; None where it began at rest, slack: what sticking holes
            hold is then constant.
        is_direct: whether loading went on from there in one increment, so that no hole slid on the way and then stuck.

    Returns:
        Derivatives by the logarithm of each joint's stiffness, the logarithm of the mass, the centre of mass over the
        section's length, the friction coefficient, the slack of each cable, the hole fraction and the compliance; 0 for
        the slack of a cable out of play.
    """
    slides = _SLIDES if is_direct else SLIDES
    state = Equilibrium(design, shape, base_orientation(theta_0), None, slides)
    state.free_soft_joints(softness)
    if before is not None:
        state.sticking = _STIFFNESS * ((state.mode == 0.0) & (state.winder_tension > 0.0))
    with np.errstate(invalid="ignore"):
        left = shape.gap.sum(axis=0) - compliance * state.winder_tension - length
        held = np.flatnonzero((state.winder_tension > 0) & (np.abs(left) < _STALLED))
    explicit = _Explicit(state, before)
    matrix, free = state.equations(held, compliance)
    right = -np.vstack([free.T @ explicit.moment, explicit.length[held]])
    solved = np.linalg.lstsq(matrix, right, rcond=1e-13)[0] if matrix.size else right
    bend, size = free @ solved[: free.shape[1]], free.shape[1]
    tension = np.zeros((design.n_cable, bend.shape[1]))
    tension[held] = solved[size:]
    return Sensitivities(points=state.move(bend), anchor=explicit.move_anchors(bend, tension))


@final
class _Explicit:
    """Derivatives by the parameters with bends and winder tensions held.

    Its arrays: ``tension`` of the gaps, shape (n_joint, n_cable, n_parameter) [N]; ``cable`` beyond each hole, same
    shape [m]; ``moment`` about the bends, shape (2 n_joint, n_parameter) [N m]; ``length`` of the gaps together less
    that which the winder leaves, shape (n_cable, n_parameter) [m].
    """

    def __init__(self, state: Equilibrium, before: Sensitivities | None) -> None:
        self.state, design = state, state.design
        joints, cables, size = design.n_joint, design.n_cable, design.n_joint + 5 + design.n_cable
        self.cable, self.length = np.zeros((joints, cables, size)), np.zeros((cables, size))
        self.moment, change = np.zeros((2 * joints, size)), np.zeros((joints, cables, size))
        for k in range(joints):
            self.moment[2 * k : 2 * k + 2, k] = state.elastic[k]
        self.moment[:, joints] = (state.work.gradient - state.elastic).ravel()
        self.moment[:, joints + 1] = _differentiate_by_center(state)
        change[..., joints + 2] = -state.mode * state.gaps.turn * state.tension
        self.length[range(cables), range(joints + 3, joints + 3 + cables)] = -1.0
        self.length[:, -1] = -state.winder_tension
        gap, slope, turn, self.length[:, -2] = _differentiate_by_holes(state)
        self.moment[:, -2] = np.einsum("kc,kca->ka", state.tension, slope).ravel()
        self.cable[..., -2] = np.cumsum(gap[::-1], axis=0)[::-1]
        change[..., -2] = -state.mode * design.cable.friction * state.tension * turn
        if before is not None:
            change += state.sticking[..., None] * (self.cable - before.anchor)
        self.tension = state.carry_tension(change)
        self.moment += np.einsum("kcp,kca->kap", self.tension, state.gaps.slope).reshape(2 * joints, size)

    def move_anchors(self, bend: np.ndarray, tension: np.ndarray) -> np.ndarray:
        """Anchors after bends (2 n_joint, n_parameter) and winder tensions (n_cable, n_parameter) have moved too."""
        state, shape = self.state, self.cable.shape
        turned = bend.reshape(shape[0], 2, -1)
        along = np.cumprod(state.ratio(state.gaps.turn), axis=0)[..., None] * tension
        gap_tension = self.tension + np.einsum("kcja,jap->kcp", state.tension_by_bend(), turned) + along
        cable = self.cable + np.einsum("kcja,jap->kcp", state.cable_beyond_by_bend(), turned)
        held = gap_tension - np.concatenate([tension[None], gap_tension[:-1]])
        is_taut = (state.winder_tension > 0.0)[:, None]
        return np.asarray(cable - np.where(is_taut, held, 0.0) / _STIFFNESS)


def _differentiate_by_center(state: Equilibrium) -> np.ndarray:
    """Moments by the centre of mass over the section's length, linear in it, shape (2 n_joint,) [N m]."""
    design = state.design
    fraction = float(design.section_center[0] / design.section_length[0])
    other = replace(design, mass=replace(design.mass, center_fraction=0.5 * fraction))
    return (state.linearise(other).gradient - state.work.gradient).ravel() / (-0.5 * fraction)


def _differentiate_by_holes(state: Equilibrium) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Derivatives by the hole fraction: gaps, their slopes, turns at holes, cable less that of the straight trunk."""
    ends = []
    for step in (_STEP, -_STEP):
        cable = state.design.cable
        other = replace(state.design, cable=replace(cable, hole_fraction=cable.hole_fraction + step))
        gaps, (beyond, before) = state.measure(other), hole_positions(other)
        straight = np.linalg.norm(beyond - before, axis=-1).sum(axis=0)
        ends.append((gaps.length, gaps.slope, gaps.turn, gaps.length.sum(axis=0) - straight))
    gap, slope, turn, length = ((up - down) / (2 * _STEP) for up, down in zip(*ends, strict=True))
    return gap, slope, turn, length
