"""Knobs from measured shapes: the most probable ones, and how far each may be off.

Steps of Levenberg and Marquardt on residuals and prior together, whitened by `calibrate_noise`, with the slopes of
`calibrate_slopes`. Points that lie far off the others of their section count less (Huber).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.calibration.noise_model import Block, Scatter, Whitener, find_scatter
from spiraltrunk.calibration.parameters import Knobs, apply_knobs, keep_positive
from spiraltrunk.calibration.predict_states import Played, State, place_points, play_statics
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, ModelError
from spiraltrunk.model.statics.sensitivities import by_parameters

Tell = Callable[[str, int, int], None]
"""Called with what is being done, how often it was done and how often it will be at most."""

ENOUGH = 0.5
"""Fall of the misfit, a sum of squares of variance 1, at which the search ends [-]."""

_LEVELS = (
    Scatter(noise=3e-3, discrepancy=10e-3), Scatter(noise=1e-3, discrepancy=3e-3),
    Scatter(noise=5e-4, discrepancy=1e-3),
)  # fmt: skip
"""Scatter that is taken for true at first, one after the other.

Joints that shut in another order than measured make local minima, which a larger scatter smooths.
"""

MODEL_ERROR = {"friction": 5e-3}
"""Standard deviation of a knob that no fit tells, as the model is not the trunk.

Pulled softly at 5 mm/s, cables in the simulation still slip a little earlier than in equilibrium: the friction that
fits lay 0.004 below the truth on the mean (`benchmarks/calibration_worlds.py`).
"""

_LEVEL_TURNS, _FINE_TURNS, _TRIES = 6, 5, 5
_SOFT = (0.3, 0.0)
"""Softness of shut joints in the slopes, one after the other [-]: a joint that shut too early does not feel it."""
_FEW_STEPS = 4
_NEAR = 2
"""Joints on either side of one that may shut before or after it [-]."""
_FARTHEST = 1.5
"""Largest step of a knob over its prior width [-]."""
_HUBER = 3.0
"""Distance over the usual one from which a point counts less [-]."""


@final
@dataclass(frozen=True, kw_only=True)
class Task:
    """What is fitted to what."""

    design: TrunkDesign
    """The trunk, its gripper's mass in the last section."""
    states: tuple[State, ...]
    """What the cables were brought to."""
    seat: np.ndarray
    """Where the sections' points sit on them, shape (n_section,) [m]."""
    measured: np.ndarray
    """Mean of the takes; not a number where unseen, shape (n_state, n_section, 3) [m]."""
    count: np.ndarray
    """Takes that each point is the mean of, shape (n_state, n_section) [-]."""

    def predict(self, knobs: np.ndarray) -> tuple[Played, np.ndarray]:
        """Equilibria and points of every state, shape (n_state, n_section, 3) [m]."""
        design, winders = apply_knobs(self.design, knobs)
        played = play_statics(design, self.states, winders)
        return played, place_points(design, played.points, self.seat)

    def slopes(self, knobs: np.ndarray, played: Played, softness: float) -> np.ndarray:
        """Motion of the points per knob, joints that shut as soft as told, shape (n_knob, n_state, n_section, 3)."""
        design, winders = apply_knobs(self.design, knobs)
        each = [
            by_parameters(
                design, shape, theta_0=state.theta_0, length=length, compliance=winders.give, softness=softness
            )
            for shape, state, length in zip(played.shapes, self.states, played.length, strict=True)
        ]
        return place_points(design, np.stack(each, axis=1), self.seat)


@final
@dataclass(frozen=True, kw_only=True)
class Fit:
    """Knobs as the recordings and what was known before have them."""

    knobs: np.ndarray
    """The most probable ones, shape (n_knob,)."""
    covariance: np.ndarray
    """Of those, shape (n_knob, n_knob)."""
    scatter: Scatter
    """How the residuals scatter."""
    far: int
    """Points that count less than half as they lie far off [-]."""
    turns: int
    """Steps after the neighbourhood was found [-]."""
    is_settled: bool
    """Whether the misfit had ceased to fall."""


def fit_knobs(task: Task, knobs: Knobs, registration: tuple[float, float], tell: Tell | None = None) -> Fit:
    """The most probable knobs of a task.

    Args:
        task: what is fitted.
        knobs: what is known beforehand.
        registration: standard deviations of its rotation [rad] and shift [m] about each axis.
        tell: called with what is being done, how often it was and how often it will be at most.

    Raises:
        ModelError: where nothing was seen.
    """
    tell = tell or (lambda what, done, total: None)
    work = 3 * len(_LEVELS) + _FINE_TURNS
    halves = []
    for odd in (0, 1):
        half = _Search(halve(task, odd), knobs, knobs.mean)
        for level, scatter in enumerate(_LEVELS):
            tell("fitting half of the steps", odd * len(_LEVELS) + level, work)
            half.expect(replace(scatter, turn=registration[0], shift=registration[1]))
            half.descend()
        halves.append(half.knobs)
    first = replace(_LEVELS[-1], turn=registration[0], shift=registration[1])
    search = min((_descend_from(task, knobs, begin, first) for begin in halves), key=_Search.present)
    is_settled, turns = False, 0
    while not is_settled and turns < _FINE_TURNS:
        tell("fitting", 3 * len(_LEVELS) + turns, work)
        search.take_slopes()
        search.look_at_scatter(first)
        is_settled = search.descend() < ENOUGH
        turns += 1
    search.take_slopes()
    covariance = widen(np.linalg.inv(search.build_normal()[0]), search.knobs, halves, task.design.n_joint)
    return Fit(
        knobs=search.knobs, covariance=add_model_error(covariance, knobs),
        scatter=search.scatter, far=search.count_far(), turns=turns, is_settled=is_settled,
    )  # fmt: skip


def _descend_from(task: Task, knobs: Knobs, begin: np.ndarray, scatter: Scatter) -> _Search:
    search = _Search(task, knobs, begin)
    search.expect(scatter)
    search.descend()
    return search


def widen(covariance: np.ndarray, knobs: np.ndarray, halves: list[np.ndarray], n_joint: int) -> np.ndarray:
    """The covariance, wider where two halves of the steps differ more than it says.

    Each half has twice the variance of the whole, so that half their difference, and what lies between the whole and
    their mean, have that of the whole or less. Where it is more the misfit has several minima, and what lies between
    those that were found counts as not known. These are mostly joints that shut one after the other, or the other way
    round: a joint is as little known as its neighbours.
    """
    spread = np.sqrt(np.diag(covariance))
    apart = np.maximum(np.abs(halves[0] - halves[1]) / 2, np.abs(knobs - (halves[0] + halves[1]) / 2))
    wider = np.maximum(1.0, apart / spread)
    joints = np.pad(wider[:n_joint], _NEAR, mode="edge")
    wider[:n_joint] = np.lib.stride_tricks.sliding_window_view(joints, 2 * _NEAR + 1).max(axis=1)
    return np.asarray(covariance * np.outer(wider, wider))


def add_model_error(covariance: np.ndarray, knobs: Knobs) -> np.ndarray:
    """The covariance with `MODEL_ERROR`; no knob is less known than before any recording, or than it was."""
    out = covariance.copy()
    for name, error in MODEL_ERROR.items():
        k = knobs.names.index(name)
        out[k, k] = min(out[k, k] + error**2, max(knobs.covariance[k, k], out[k, k]))
    return out


def halve(task: Task, odd: int) -> Task:
    """Every other state of each chain, each reached in one increment, and all states at rest.

    Pulled ever further a cable slides at every hole, and how finely it was pulled does not matter.
    """
    chains = np.array([state.chain for state in task.states])
    kept: list[int] = []
    for chain in np.unique(chains):
        own = np.flatnonzero(chains == chain)
        kept += own.tolist() if len(own) < _FEW_STEPS else own[odd::2].tolist()
    kept.sort()
    place = {s: i for i, s in enumerate(kept)}
    states = []
    for s in kept:
        before = task.states[s].before
        while before >= 0 and before not in place:
            before = task.states[before].before
        states.append(replace(task.states[s], before=place.get(before, -1)))
    return replace(task, states=tuple(states), measured=task.measured[kept], count=task.count[kept])


def build_blocks(task: Task, predicted: np.ndarray) -> list[Block]:
    """The seen points, chain by chain."""
    along = np.cumsum(task.design.section_length) - task.design.section_length + task.seat
    stroke = _strokes(task.states)
    seen = np.isfinite(task.measured).all(axis=-1)
    chains = np.array([state.chain for state in task.states])
    blocks = []
    for chain in np.unique(chains):
        at = np.argwhere(seen & (chains == chain)[:, None])
        if len(at):
            s, n = at.T
            block = Block(
                points=predicted[s, n], at=at, along=(along / task.design.length)[n], stroke=stroke[s],
                weight=task.count[s, n].astype(float),
            )  # fmt: skip
            blocks.append(block)
    return blocks


def _strokes(states: tuple[State, ...]) -> np.ndarray:
    """Cable pulled in or paid out on the way to each state, shape (n_state,) [m]."""
    out = np.zeros(len(states))
    for i, state in enumerate(states):
        now = np.nan_to_num(np.array(state.pull))
        then = np.zeros_like(now) if state.before < 0 else np.nan_to_num(np.array(states[state.before].pull))
        out[i] = (0.0 if state.before < 0 else out[state.before]) + np.abs(now - then).max()
    return out


@final
class _Search:
    """Where the search is, and how the misfit falls from there."""

    def __init__(self, task: Task, knobs: Knobs, begin: np.ndarray) -> None:
        self.task, self.prior, self.knobs = task, knobs, begin.copy()
        self.precision = np.linalg.inv(knobs.covariance)
        self.played, self.predicted = task.predict(self.knobs)
        self.blocks = build_blocks(task, self.predicted)
        if not self.blocks:
            raise ModelError("no point was seen in the takes that are fitted; allowed: at least one shape")
        self.weights = [block.weight for block in self.blocks]
        self.slopes: np.ndarray = np.empty(0)
        self._damping = 1e-2

    def present(self) -> float:
        """Misfit where the search is."""
        return self.misfit(self.predicted, self.knobs)

    def expect(self, scatter: Scatter) -> None:
        """Take a scatter for true."""
        self.scatter = scatter
        self.whiteners = [Whitener(block, scatter) for block in self.blocks]

    def take_slopes(self, softness: float = 0.0) -> None:
        """Slopes of all points by every knob, shape (n_knob, n_state, n_section, 3)."""
        self.slopes = self.task.slopes(self.knobs, self.played, softness)

    def descend(self) -> float:
        """Steps along soft slopes and then along the true ones; by how much the misfit fell."""
        before = self.misfit(self.predicted, self.knobs)
        for softness in _SOFT:
            self._damping = 1e-3
            for _ in range(_LEVEL_TURNS):
                self.take_slopes(softness)
                if self.step() < ENOUGH:
                    break
        return before - self.misfit(self.predicted, self.knobs)

    def build_normal(self) -> tuple[np.ndarray, np.ndarray]:
        """Second derivatives of the misfit by the knobs, halved, and minus its first ones, halved."""
        normal, moment = self.precision.copy(), self.precision @ (self.prior.mean - self.knobs)
        for block, whitener in zip(self.blocks, self.whiteners, strict=True):
            s = whitener.whiten(self._slopes_of(block))
            normal += s.T @ s
            moment += s.T @ whitener.whiten(self._residual(block, self.predicted))
        return normal, moment

    def misfit(self, predicted: np.ndarray, knobs: np.ndarray) -> float:
        """Sum of squares of residuals and prior, each of variance 1 [-]."""
        away = knobs - self.prior.mean
        total = float(away @ self.precision @ away)
        for block, whitener in zip(self.blocks, self.whiteners, strict=True):
            white = whitener.whiten(self._residual(block, predicted))
            total += float(white @ white)
        return total

    def look_at_scatter(self, first: Scatter) -> None:
        """Bring the weights and, from ``first``, the scatter up to date with the residuals."""
        rest = [self._residual(block, self.predicted) for block in self.blocks]
        self._weigh(rest)
        slopes = [self._slopes_of(block) for block in self.blocks]
        back = [r + s @ (self.knobs - self.prior.mean) for r, s in zip(rest, slopes, strict=True)]
        self.expect(find_scatter(self.blocks, back, slopes, self.prior.covariance, first))

    def count_far(self) -> int:
        """Points that count less than half."""
        return int(sum((b.weight < 0.5 * w).sum() for b, w in zip(self.blocks, self.weights, strict=True)))

    def step(self) -> float:
        """Go along the slopes, damped until the misfit falls (Levenberg and Marquardt); by how much it fell."""
        now = self.misfit(self.predicted, self.knobs)
        normal, moment = self.build_normal()
        for _ in range(_TRIES):
            step = np.linalg.solve(normal + self._damping * np.diag(np.diag(normal)), moment)
            step *= min(1.0, _FARTHEST / max(float(np.abs(step / self.prior.spread).max()), 1e-12))
            knobs = keep_positive(self.prior.names, self.knobs + step)
            tried = self._try(knobs)
            if tried is not None and tried[1] < now:
                self.knobs, (self.played, self.predicted) = knobs, tried[0]
                self._damping = max(0.1 * self._damping, 1e-9)
                return now - tried[1]
            self._damping = max(10 * self._damping, 1e-4)
        return 0.0

    def _try(self, knobs: np.ndarray) -> tuple[tuple[Played, np.ndarray], float] | None:
        """Equilibria, points and misfit with these knobs; None for a trunk that cannot be."""
        try:
            found = self.task.predict(knobs)
        except DesignError:  # A hole or a centre outside of the section.
            return None
        return found, self.misfit(found[1], knobs)

    def _residual(self, block: Block, predicted: np.ndarray) -> np.ndarray:
        s, n = block.at.T
        return (self.task.measured[s, n] - predicted[s, n]).ravel()

    def _slopes_of(self, block: Block) -> np.ndarray:
        s, n = block.at.T
        return self.slopes[:, s, n].reshape(len(self.knobs), -1).T

    def _weigh(self, rest: list[np.ndarray]) -> None:
        """Let points that lie far from the others of their section count less."""
        away = [np.linalg.norm(r.reshape(-1, 3), axis=1) for r in rest]
        section = np.concatenate([block.at[:, 1] for block in self.blocks])
        everything = np.concatenate(away)
        usual = np.full(self.task.design.n_section, np.inf)
        for n in np.unique(section):
            usual[n] = max(float(np.median(everything[section == n])), 1e-5)
        self.blocks = [
            replace(block, weight=weight * np.minimum(1.0, _HUBER * usual[block.at[:, 1]] / np.maximum(far, 1e-9)) ** 2)
            for block, weight, far in zip(self.blocks, self.weights, away, strict=True)
        ]
