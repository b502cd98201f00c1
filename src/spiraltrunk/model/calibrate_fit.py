"""Knobs from measured shapes: the most probable ones, and how far each may be off.

Gauss and Newton's steps on residuals and prior together, whitened by `calibrate_noise`; slopes by differences, each
knob turned a little both ways and the whole protocol played again, on all cores. Points that lie far off the others
of their section count less (Huber).
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, ModelError
from spiraltrunk.model.calibrate_knobs import Knobs, apply_knobs
from spiraltrunk.model.calibrate_noise import Block, Scatter, Whitener, find_scatter
from spiraltrunk.model.calibrate_play import State, place_points, play_statics
from spiraltrunk.model.statics import StaticsOptions

ENOUGH = 0.5
"""Fall of the misfit, a sum of squares of variance 1, at which the search ends [-]."""

_TURN = 0.03
"""Part of its prior width by which a knob is turned for a slope [-]."""
_TRIES = 5
_FARTHEST = 1.5
"""Largest step of a knob over its prior width [-]."""
_COARSE_TURNS, _FINE_TURNS = 3, 6
_COARSE = Scatter(noise=3e-3, discrepancy=10e-3)
"""Scatter at first: joints that shut in another order than measured make local minima, which this smooths [m]."""
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
    options: StaticsOptions | None = None
    """How the equilibria are solved."""

    def predict(self, knobs: np.ndarray) -> np.ndarray:
        """Points of every state, shape (n_state, n_section, 3) [m]."""
        design, slack = apply_knobs(self.design, knobs)
        ends, _ = play_statics(design, self.states, slack, self.options)
        return place_points(design, ends, self.seat)


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
    """Times that slopes were taken [-]."""
    is_settled: bool
    """Whether the misfit had ceased to fall."""


def fit_knobs(task: Task, knobs: Knobs, tell: Callable[[str, int, int], None] | None = None) -> Fit:
    """The most probable knobs of a task.

    Args:
        task: what is fitted.
        knobs: what is known beforehand.
        tell: called with what is being done, how often it was and how often it will be at most.

    Raises:
        ModelError: where nothing was seen.
    """
    search = _Search(task, knobs, tell or (lambda what, done, total: None))
    for _ in range(_COARSE_TURNS):
        search.turn(is_fine=False)
    is_settled = False
    for _ in range(_FINE_TURNS):
        search.look_at_scatter()
        is_settled = search.turn(is_fine=True) < ENOUGH
        if is_settled:
            break
    normal = search.build_normal()[0]
    return Fit(
        knobs=search.knobs, covariance=np.linalg.inv(normal), scatter=search.scatter, far=search.count_far(),
        turns=search.turns, is_settled=is_settled,
    )  # fmt: skip


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
            blocks.append(
                Block(
                    points=predicted[s, n], at=at, along=(along / task.design.length)[n], stroke=stroke[s],
                    weight=task.count[s, n].astype(float),
                )
            )  # fmt: skip
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

    def __init__(self, task: Task, knobs: Knobs, tell: Callable[[str, int, int], None]) -> None:
        self.task, self.prior, self.tell = task, knobs, tell
        self.precision = np.linalg.inv(knobs.covariance)
        self.knobs = knobs.mean.copy()
        self.predicted = task.predict(self.knobs)
        self.blocks = build_blocks(task, self.predicted)
        if not self.blocks:
            raise ModelError("no point was seen in the takes that are fitted; allowed: at least one shape")
        self.scatter, self.turns, self._damping = _COARSE, 0, 1e-2
        self.weights = [block.weight for block in self.blocks]
        self.slopes: np.ndarray = np.empty(0)
        self._is_heard = _find_heard(task, knobs)
        self._whiten()

    def turn(self, *, is_fine: bool) -> float:
        """Take slopes and go where they lead; by how much the misfit fell."""
        self.take_slopes(is_fine=is_fine)
        before = self.misfit(self.predicted, self.knobs)
        return before - self._step(before)

    def take_slopes(self, *, is_fine: bool) -> None:
        """Slopes of all points by every knob, shape (n_knob, n_state, n_section, 3)."""
        self.turns += 1
        self.tell("slopes", self.turns, _COARSE_TURNS + _FINE_TURNS)
        heard = np.flatnonzero(self._is_heard)
        with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
            found = list(pool.map(lambda k: self._slope(int(k), is_fine), heard))
        self.slopes = np.zeros((len(self.knobs), *self.predicted.shape))
        self.slopes[heard] = found

    def _slope(self, knob: int, is_fine: bool) -> np.ndarray:
        size = _TURN * self.prior.spread[knob]
        up, down = self.knobs.copy(), self.knobs.copy()
        up[knob] += size
        if not is_fine:
            return (self.task.predict(up) - self.predicted) / size
        if self.prior.names[knob] != "friction" or self.knobs[knob] >= size:
            down[knob] -= size
        below = self.predicted if down[knob] == self.knobs[knob] else self.task.predict(down)
        return (self.task.predict(up) - below) / (up[knob] - down[knob])

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

    def look_at_scatter(self) -> None:
        """Bring the scatter and the weights up to date with the residuals."""
        rest = [self._residual(block, self.predicted) for block in self.blocks]
        self._weigh(rest)
        slopes = [self._slopes_of(block) for block in self.blocks]
        back = [r + s @ (self.knobs - self.prior.mean) for r, s in zip(rest, slopes, strict=True)]
        self.scatter = find_scatter(self.blocks, back, slopes, self.prior.covariance, self.scatter)
        self._whiten()

    def count_far(self) -> int:
        """Points that count less than half."""
        return int(sum((b.weight < 0.25 * w).sum() for b, w in zip(self.blocks, self.weights, strict=True)))

    def _step(self, now: float) -> float:
        """Go along the slopes, damped until the misfit falls (Levenberg and Marquardt); the misfit there."""
        normal, moment = self.build_normal()
        friction = self.prior.names.index("friction")
        for _ in range(_TRIES):
            step = np.linalg.solve(normal + self._damping * np.diag(np.diag(normal)), moment)
            step *= min(1.0, _FARTHEST / max(float(np.abs(step / self.prior.spread).max()), 1e-12))
            knobs = self.knobs + step
            knobs[friction] = max(knobs[friction], 0.0)
            then = self._try(knobs)
            if then is not None and then[1] < now:
                self.knobs, self.predicted = knobs, then[0]
                self._damping *= 0.1
                return then[1]
            self._damping = max(10 * self._damping, 1e-3)
        return now

    def _try(self, knobs: np.ndarray) -> tuple[np.ndarray, float] | None:
        """Points and misfit with these knobs; None for a trunk that cannot be."""
        try:
            predicted = self.task.predict(knobs)
        except DesignError:  # A hole or a centre outside of the section.
            return None
        return predicted, self.misfit(predicted, knobs)

    def _whiten(self) -> None:
        self.whiteners = [Whitener(block, self.scatter) for block in self.blocks]

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


def _find_heard(task: Task, knobs: Knobs) -> np.ndarray:
    """Which knobs can move any state: a cable that is never pulled says nothing of its slack, (n_knob,) [bool]."""
    pulled = ~np.isnan(np.array([state.pull for state in task.states])).all(axis=0)
    heard = np.ones(len(knobs.names), bool)
    for i, name in enumerate(knobs.names):
        if name.startswith("slack_"):
            heard[i] = pulled[int(name.removeprefix("slack_")) - 1]
        if name in {"friction", "hole"}:
            heard[i] = bool(pulled.any())
    return heard
