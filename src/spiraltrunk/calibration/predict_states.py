"""Cable states of the measured shapes, and the marker positions that the models predict for them.

Takes that repeat the same commands share their states, so that each state is solved once. With friction a state is
reached from the one before it, as it was when it was recorded.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy.optimize import brentq

from spiraltrunk.calibration.parameters import Winders
from spiraltrunk.design.trunk import TrunkDesign, ventral_cables
from spiraltrunk.errors import SpiralTrunkError
from spiraltrunk.model import reference, statics
from spiraltrunk.model.kinematics.cables import PULL_MARGIN
from spiraltrunk.model.kinematics.measured_shapes import MeasuredShapes
from spiraltrunk.model.kinematics.shape import Shape, Status
from spiraltrunk.model.reference.constants import prepare

_SAME = 1e-7
"""Pulls that differ by less are one command [m]."""

_OPTIONS = statics.StaticsOptions(steps_most=2_000)
"""Fewer steps than by default: pulled past full curl by two cables a trunk may not settle."""

_RIGID = 1e-9
"""Compliance up to which a cable counts as inextensible [m/N]: 60 nm at 60 N."""


@final
@dataclass(frozen=True, kw_only=True)
class State:
    """What the cables were brought to, and from where."""

    theta_0: float
    """Angle of the base axis below the horizontal [rad]."""
    pull: tuple[float, ...]
    """Cable pulled in since the straight trunk; not a number for a relaxed cable, (n_cable,) [m]."""
    before: int
    """State from which the cables went on; -1 for slack cables at rest."""
    kind: str
    """What was pulled, of `measured_shapes.KINDS`."""
    chain: int
    """States of one chain were reached one from another; a rest is a chain of its own."""


def find_states(shapes: MeasuredShapes) -> tuple[tuple[State, ...], np.ndarray]:
    """Distinct cable states, predecessors first, and the index of each shape's state, shape (n,)."""
    known: dict[tuple[object, ...], int] = {}
    states: list[State] = []
    of_shape: list[int] = []
    for kind, follows, theta_0, pull in zip(
        shapes.kind, shapes.follows.tolist(), shapes.theta_0.tolist(), shapes.pull.tolist(), strict=True
    ):
        is_rest = all(map(math.isnan, pull))
        before = -1 if follows < 0 or is_rest else of_shape[int(follows)]
        if before >= 0 and all(map(math.isnan, states[before].pull)):
            before = -1
        key = (before, round(theta_0 / 1e-6), *(None if math.isnan(p) else round(p / _SAME) for p in pull))
        if key not in known:
            chain = len(states) if before < 0 else states[before].chain
            known[key] = len(states)
            states.append(State(theta_0=theta_0, pull=tuple(pull), before=before, kind=kind, chain=chain))
        of_shape.append(known[key])
    return tuple(states), np.array(of_shape, int)


def select_states(states: tuple[State, ...], kept: Sequence[int]) -> tuple[State, ...]:
    """The states ``kept``, in their order, each reached from the nearest state before it that is kept."""
    place = {s: i for i, s in enumerate(kept)}
    selected = []
    for s in kept:
        before = states[s].before
        while before >= 0 and before not in place:
            before = states[before].before
        selected.append(replace(states[s], before=place.get(before, -1)))
    return tuple(selected)


def compute_step(state: State, states: tuple[State, ...]) -> float:
    """Largest change of a cable's pull on the way to a state [m]."""
    begin = 0.0 if state.before < 0 else np.nan_to_num(np.array(states[state.before].pull))
    return float(np.abs(np.nan_to_num(np.array(state.pull)) - begin).max())


def is_one_increment(state: State, states: tuple[State, ...]) -> bool:
    """Whether `predict_statics` loads a state in one increment from the one before."""
    return compute_step(state, states) <= _OPTIONS.increment + 1e-8


@final
@dataclass(frozen=True, kw_only=True)
class Equilibria:
    """Equilibria of all states."""

    shapes: tuple[Shape, ...]
    """One a state."""
    length: np.ndarray
    """Sum of the gaps that each winder left; not a number for a relaxed cable, shape (n_state, n_cable) [m]."""

    @property
    def points(self) -> np.ndarray:
        """Section ends, shape (n_state, n_section, 3) [m]."""
        return np.array([shape.points for shape in self.shapes])

    @property
    def has_failed(self) -> np.ndarray:
        """States whose equilibrium did not converge, shape (n_state,) [bool]."""
        return np.array([int(shape.status) == Status.NOT_CONVERGED for shape in self.shapes])


def predict_statics(
    design: TrunkDesign, states: tuple[State, ...], winders: Winders, options: statics.StaticsOptions = _OPTIONS
) -> Equilibria:
    """The equilibrium of every state, with the design's friction.

    A cable begins to pull when its slack has been taken in, and lengthens in proportion to its tension.
    """
    stiffness = 1 / winders.compliance if winders.compliance > _RIGID else math.inf
    shapes: list[Shape] = []
    lengths = []
    most = PULL_MARGIN * design.cable_stroke
    for state in states:
        commanded = np.array(state.pull)
        is_relaxed = np.isnan(commanded)
        pull = np.clip(np.where(is_relaxed, 0.0, commanded - winders.slack), -most, most)
        # As many increments whatever the slack is, or else the prediction would jump with it.
        step = compute_step(state, states)
        increment = 1.5 * max(step / max(math.ceil(step / options.increment - 1e-6), 1), 1e-4)
        shapes.append(
            statics.solve(
                design, pull=pull, tension=np.where(is_relaxed, 0.0, design.cable.tension_max),
                by_tension=is_relaxed, theta_0=state.theta_0,
                start=None if state.before < 0 else shapes[state.before],
                options=replace(options, cable_stiffness=stiffness, increment=increment),
            )
        )  # fmt: skip
        lengths.append(np.where(is_relaxed, np.nan, design.cable_stroke - pull))
    return Equilibria(shapes=tuple(shapes), length=np.array(lengths))


def predict_reference(design: TrunkDesign, states: tuple[State, ...]) -> np.ndarray:
    """Section ends of every state by the paper's forward model, not a number where it has no answer.

    Shape (n_state, n_section, 3) [m].
    """
    out = np.full((len(states), design.n_section, 3), np.nan)
    for i, state in enumerate(states):
        try:
            out[i] = _solve_reference(design, state).points
        except SpiralTrunkError:  # Outside of what its algorithms know: no cable mirrored, pulled past full curl.
            continue
    return out


def _solve_reference(design: TrunkDesign, state: State) -> Shape:
    pull, rest = np.array(state.pull), reference.rest(design, state.theta_0)
    if np.isnan(pull).all():
        return rest
    if state.kind == "bend-ventral":
        return _solve_ventral(design, pull, state.theta_0)
    first = max(pull[0] - rest.cable_change[0], 0.0)
    bent = reference.bend_dorsal(design, first, state.theta_0)
    if state.kind == "bend-dorsal":
        return bent
    second = 0.0 if np.isnan(pull[1]) else max(pull[1] - bent.cable_change[1], 0.0)
    return reference.twist(design, first, second, state.theta_0)


def _solve_ventral(design: TrunkDesign, pull: np.ndarray, theta_0: float) -> Shape:
    """The bend with the ventral cables pulled in so far; the model is driven by what the dorsal cable pays out."""
    most, pulled = PULL_MARGIN * prepare(design).ventral_stroke, ventral_cables(design) & ~np.isnan(pull)
    mean = float(pull[pulled].mean())

    def exceed(lengthening: float) -> float:
        return float(reference.bend_ventral(design, lengthening, theta_0).cable_change[pulled].mean()) - mean

    if exceed(0.0) >= 0.0:
        return reference.bend_ventral(design, 0.0, theta_0)
    lengthening = most if exceed(most) <= 0.0 else float(brentq(exceed, 0.0, most, xtol=1e-7))
    return reference.bend_ventral(design, lengthening, theta_0)


def place_markers(design: TrunkDesign, ends: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """Markers at distances ``offset`` (n_section,) [m] from the sections' proximal joints, by the sections' ends.

    Shapes (..., n_section, 3) [m].
    """
    start = np.concatenate([np.zeros_like(ends[..., :1, :]), ends[..., :-1, :]], axis=-2)
    part = (np.asarray(offset, float) / design.section_length)[:, None]
    return start + part * (ends - start)
