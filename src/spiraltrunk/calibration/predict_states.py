"""The protocol played on a model: one shape for every state that the cables were brought into.

Takes that repeat the same commands share their states, so that each is solved once. With friction a state is reached
from the one before it, as it was in the laboratory.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy.optimize import brentq

from spiraltrunk.calibration.parameters import Winders
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError, SpiralTrunkError
from spiraltrunk.model import reference, statics
from spiraltrunk.model.kinematics.cables import PULL_MARGIN
from spiraltrunk.model.kinematics.measured_shapes import MeasuredShapes
from spiraltrunk.model.kinematics.shape import Shape, Status

_SAME = 1e-7
"""Pulls that differ by less are one command [m]."""

_OPTIONS = statics.StaticsOptions(steps_most=2_000)
"""Pulled past full curl by two cables a trunk may not settle: that is not waited for."""

_RIGID = 1e-9
"""Give up to which a cable counts as inextensible [m/N]: 60 nm at 60 N."""

_MOST_STATES = 2_000
"""More different states than any session has."""


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
    """What was pulled, of `measured.KINDS`."""
    chain: int
    """States of one chain were reached one from another; a rest is a chain of its own."""


@final
@dataclass(frozen=True, kw_only=True)
class States:
    """All states of a session, each before those that go on from it."""

    states: tuple[State, ...]
    """The different ones."""
    of_shape: np.ndarray
    """State of each measured shape, shape (n,) [-]."""


def find_states(shapes: MeasuredShapes) -> States:
    """The different states of the measured shapes.

    Raises:
        ModelError: where a shape goes on from a later one, or there are too many.
    """
    known: dict[tuple[object, ...], int] = {}
    states: list[State] = []
    of_shape: list[int] = []
    for i, kind in enumerate(shapes.kind):
        follows, theta_0, pull = int(shapes.follows[i]), float(shapes.theta_0[i]), shapes.pull[i]
        if follows >= i:
            raise ModelError(f"shape {i} goes on from shape {follows}; allowed: -1 or an earlier shape")
        is_rest = bool(np.isnan(pull).all())
        before = -1 if follows < 0 or is_rest else of_shape[follows]
        if before >= 0 and np.isnan(states[before].pull).all():
            before = -1
        key = (before, round(theta_0 / 1e-6), *(None if np.isnan(p) else round(p / _SAME) for p in pull.tolist()))
        if key not in known:
            chain = len(states) if before < 0 else states[before].chain
            known[key] = len(states)
            states.append(State(theta_0=theta_0, pull=tuple(pull.tolist()), before=before, kind=kind, chain=chain))
        of_shape.append(known[key])
    if len(states) > _MOST_STATES:
        raise ModelError(f"{len(states)} different states given; allowed: up to {_MOST_STATES}")
    return States(states=tuple(states), of_shape=np.array(of_shape, int))


@final
@dataclass(frozen=True, kw_only=True)
class Played:
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


def play_statics(design: TrunkDesign, states: tuple[State, ...], winders: Winders) -> Played:
    """The equilibrium of every state, with the design's friction.

    A cable with slack begins to pull when so much has been taken in, and gives under its tension.
    """
    stiffness = 1 / winders.give if winders.give > _RIGID else math.inf
    shapes: list[Shape] = []
    lengths = []
    most = PULL_MARGIN * design.cable_stroke
    for state in states:
        told = np.array(state.pull)
        is_relaxed = np.isnan(told)
        pull = np.clip(np.where(is_relaxed, 0.0, told - winders.slack), -most, most)
        shapes.append(
            statics.solve(
                design, pull=pull, tension=np.where(is_relaxed, 0.0, design.cable.tension_max),
                by_tension=is_relaxed, theta_0=state.theta_0,
                start=None if state.before < 0 else shapes[state.before],
                options=replace(
                    _OPTIONS, cable_stiffness=stiffness, increment=_find_increment(state, states, _OPTIONS.increment)
                ),
            )
        )  # fmt: skip
        lengths.append(np.where(is_relaxed, np.nan, design.cable_stroke - pull))
    return Played(shapes=tuple(shapes), length=np.array(lengths))


def _find_increment(state: State, states: tuple[State, ...], most: float) -> float:
    """Largest increment that takes the told step in as many parts whatever the slack is: else slopes would jump [m]."""
    then = 0.0 if state.before < 0 else np.nan_to_num(np.array(states[state.before].pull))
    step = float(np.abs(np.nan_to_num(np.array(state.pull)) - then).max())
    return 1.5 * max(step / max(math.ceil(step / most - 1e-6), 1), 1e-4)


def play_reference(design: TrunkDesign, states: tuple[State, ...]) -> np.ndarray:
    """Section ends of every state by the paper's forward model; not a number where it has no answer, or none is known.

    Shape (n_state, n_section, 3) [m].
    """
    out = np.full((len(states), design.n_section, 3), np.nan)
    for i, state in enumerate(states):
        try:
            out[i] = _refer(design, state, states).points
        except SpiralTrunkError:  # Outside of what its algorithms know: no cable mirrored, pulled past full curl.
            continue
    return out


def _refer(design: TrunkDesign, state: State, states: tuple[State, ...]) -> Shape:
    pull = np.array(state.pull)
    if np.isnan(pull).all():
        return reference.rest(design, state.theta_0)
    rest = reference.rest(design, state.theta_0).cable_change
    if state.kind == "bend-dorsal":
        return reference.bend_dorsal(design, max(pull[0] - rest[0], 0.0), state.theta_0)
    if state.kind == "bend-ventral":
        return _refer_ventral(design, float(np.nanmean(pull[1:])), state.theta_0)
    first = max(pull[0] - rest[0], 0.0)
    bent = reference.bend_dorsal(design, first, state.theta_0)
    second = 0.0 if np.isnan(pull[1]) else max(pull[1] - bent.cable_change[1], 0.0)
    return reference.twist(design, first, second, state.theta_0)


def _refer_ventral(design: TrunkDesign, pull: float, theta_0: float) -> Shape:
    """The bend in which the ventral cables have come in so far: the model is driven by what the dorsal one pays out."""
    from spiraltrunk.model.reference.constants import prepare

    most = PULL_MARGIN * prepare(design).ventral_stroke

    def miss(lengthening: float) -> float:
        return float(reference.bend_ventral(design, lengthening, theta_0).cable_change[1:].mean()) - pull

    if miss(0.0) >= 0.0 or miss(most) <= 0.0:
        return reference.bend_ventral(design, 0.0 if miss(0.0) >= 0.0 else most, theta_0)
    return reference.bend_ventral(design, float(brentq(miss, 0.0, most, xtol=1e-7)), theta_0)


def place_points(design: TrunkDesign, ends: np.ndarray, seat: np.ndarray) -> np.ndarray:
    """The sections' measured points from their ends, shapes (..., n_section, 3) [m]."""
    start = np.concatenate([np.zeros_like(ends[..., :1, :]), ends[..., :-1, :]], axis=-2)
    part = (np.asarray(seat, float) / design.section_length)[:, None]
    return start + part * (ends - start)
