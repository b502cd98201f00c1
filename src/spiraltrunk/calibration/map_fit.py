"""MAP estimate of the parameters from measured shapes, with its covariance."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.calibration.noise_model import Block, NoiseModel, factorise, fit_noise_model, whiten
from spiraltrunk.calibration.parameters import Gaussian, apply_parameters, keep_positive
from spiraltrunk.calibration.predict_states import (
    Equilibria,
    State,
    compute_step,
    place_markers,
    predict_statics,
    select_states,
)
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, ModelError
from spiraltrunk.files.results import Progress, ignore_progress
from spiraltrunk.model.statics.sensitivities import by_parameters

ENOUGH = 0.5
"""Decrease of the misfit, a sum of squares of variance 1, below which the fit has converged [-]."""

_LEVELS = (
    NoiseModel(noise=3e-3, discrepancy=10e-3), NoiseModel(noise=1e-3, discrepancy=3e-3),
    NoiseModel(noise=5e-4, discrepancy=1e-3),
)  # fmt: skip
"""Noise models assumed at first, one after the other.

Joints that shut in another order than measured make local minima, which more noise smooths.
"""

MODEL_ERROR = {"friction": 5e-3}
"""Standard deviation added to a parameter for the model's own error [-].

Pulled softly at 5 mm/s, cables in the simulation still slip a little earlier than in equilibrium: the friction that
fits lay 0.004 below the truth on the mean (`benchmarks/calibration_worlds.py`).
"""

_SOFTNESS = (0.3, 0.0)
"""Softness of pressed joints in the Jacobian, one after the other [-]: a joint that shut too early does not feel it."""

_STEPS = 6
"""Most steps at each softness."""

_ROUNDS = 5
"""Most rounds in which the noise model is brought up to date."""

_TRIES = 5
"""Most dampings that are tried in a step."""

_FEW_STATES = 4
"""Chains of fewer states are not split."""

_NEAR = 2
"""Joints on either side of one that may shut before or after it [-]."""

_LONGEST_STEP = 1.5
"""Largest step of a parameter over its prior standard deviation [-]."""

_HUBER = 3.0
"""Distance over the median of its section from which a point is an outlier [-]."""


@final
@dataclass(frozen=True, kw_only=True)
class FitProblem:
    """Measured shapes and the states that they were measured in."""

    design: TrunkDesign
    """The trunk, its gripper's mass in the last section."""
    states: tuple[State, ...]
    """What the cables were brought to."""
    marker_offset: np.ndarray
    """Distance of each section's marker from its proximal joint, shape (n_section,) [m]."""
    measured: np.ndarray
    """Mean of the takes; not a number where unseen, shape (n_state, n_section, 3) [m]."""
    count: np.ndarray
    """Takes that each point is the mean of, shape (n_state, n_section) [-]."""

    def predict(self, values: np.ndarray) -> tuple[Equilibria, np.ndarray]:
        """Equilibria with a parameter vector, and the markers, shape (n_state, n_section, 3) [m]."""
        design, winders = apply_parameters(self.design, values)
        equilibria = predict_statics(design, self.states, winders)
        return equilibria, place_markers(design, equilibria.points, self.marker_offset)

    def differentiate(self, values: np.ndarray, equilibria: Equilibria, softness: float) -> np.ndarray:
        """Jacobian of the markers with pressed joints of a softness, shape (n_parameter, n_state, n_section, 3)."""
        design, winders = apply_parameters(self.design, values)
        each = [
            by_parameters(
                design, shape, theta_0=state.theta_0, length=length, compliance=winders.compliance, softness=softness
            )
            for shape, state, length in zip(equilibria.shapes, self.states, equilibria.length, strict=True)
        ]
        return place_markers(design, np.stack(each, axis=1), self.marker_offset)


@final
@dataclass(frozen=True, kw_only=True)
class MapEstimate:
    """Parameters of greatest posterior density."""

    values: np.ndarray
    """Parameter vector, shape (n_parameter,)."""
    covariance: np.ndarray
    """Of its error, shape (n_parameter, n_parameter)."""
    noise_model: NoiseModel
    """Noise model of the residuals, fitted."""
    n_outlier: int
    """Points that count less than half."""
    has_converged: bool
    """Whether the misfit had ceased to fall."""


def estimate_map(
    problem: FitProblem,
    prior: Gaussian,
    registration: tuple[float, float],
    progress: Progress = ignore_progress,
) -> MapEstimate:
    """MAP estimate by Levenberg-Marquardt, with Huber weights for outliers.

    The odd and the even states are fitted first, from the prior's mean on; all states are then fitted from the better
    of these two estimates, and the noise model with them.

    Args:
        problem: what is fitted.
        prior: of the parameter vector.
        registration: standard deviations of its rotation [rad] and shift [m] about each axis.
        progress: called with the step, how many of them are done, and at most how many there are.

    Raises:
        ModelError: where nothing was seen.
    """
    work, halves = 3 * len(_LEVELS) + _ROUNDS, []
    levels = [replace(level, turn=registration[0], shift=registration[1]) for level in _LEVELS]
    for odd in (0, 1):
        half = _Search(split_half(problem, odd), prior, prior.mean, levels[0])
        for i, level in enumerate(levels):
            progress("fitting half of the steps", odd * len(levels) + i, work)
            half.assume(level)
            half.descend()
        halves.append(half.values)
    searches = [_Search(problem, prior, begin, levels[-1]) for begin in halves]
    for search in searches:
        search.descend()
    search = min(searches, key=_Search.misfit)
    for done in range(_ROUNDS):
        progress("fitting", 3 * len(levels) + done, work)
        search.update_noise_model(levels[-1])
        has_converged = search.descend() < ENOUGH
        if has_converged:
            break
    search.differentiate()
    covariance = inflate(np.linalg.inv(search.build_normal()[0]), search.values, halves, problem.design.n_joint)
    return MapEstimate(
        values=search.values, covariance=add_model_error(covariance, prior), noise_model=search.noise_model,
        n_outlier=search.count_outliers(), has_converged=has_converged,
    )  # fmt: skip


def inflate(covariance: np.ndarray, values: np.ndarray, halves: list[np.ndarray], n_joint: int) -> np.ndarray:
    """The covariance, inflated where the estimates from two halves of the states differ by more than it says.

    Each half has twice the variance of the whole, so that half their difference, and what lies between the whole and
    their mean, have that of the whole or less. Where it is more the misfit has several minima, and what lies between
    those that were found counts as unknown. These are mostly joints that shut one after the other, or the other way
    round: a joint is inflated as much as its neighbours.
    """
    spread = np.sqrt(np.diag(covariance))
    apart = np.maximum(np.abs(halves[0] - halves[1]) / 2, np.abs(values - (halves[0] + halves[1]) / 2))
    factor = np.maximum(1.0, apart / spread)
    joints = np.pad(factor[:n_joint], _NEAR, mode="edge")
    factor[:n_joint] = np.lib.stride_tricks.sliding_window_view(joints, 2 * _NEAR + 1).max(axis=1)
    return np.asarray(covariance * np.outer(factor, factor))


def add_model_error(covariance: np.ndarray, prior: Gaussian) -> np.ndarray:
    """The covariance with `MODEL_ERROR`, which widens no parameter beyond its prior."""
    out = covariance.copy()
    for name, error in MODEL_ERROR.items():
        k = prior.names.index(name)
        out[k, k] = min(out[k, k] + error**2, max(prior.covariance[k, k], out[k, k]))
    return out


def split_half(problem: FitProblem, odd: int) -> FitProblem:
    """Every other state of each chain, each reached in one increment, and all states at rest.

    Pulled ever further a cable slides at every hole, and how finely it was pulled does not matter.
    """
    chains = np.array([state.chain for state in problem.states])
    own = [np.flatnonzero(chains == chain) for chain in np.unique(chains)]
    kept = sorted(s for part in own for s in (part if len(part) < _FEW_STATES else part[odd::2]).tolist())
    return replace(
        problem, states=select_states(problem.states, kept), measured=problem.measured[kept], count=problem.count[kept]
    )


def _build_blocks(problem: FitProblem, predicted: np.ndarray) -> list[Block]:
    """The seen points, chain by chain."""
    along = np.cumsum(problem.design.section_length) - problem.design.section_length + problem.marker_offset
    stroke = np.zeros(len(problem.states))
    for i, state in enumerate(problem.states):
        stroke[i] = (0.0 if state.before < 0 else stroke[state.before]) + compute_step(state, problem.states)
    seen = np.isfinite(problem.measured).all(axis=-1)
    chains = np.array([state.chain for state in problem.states])
    parts = [np.argwhere(seen & (chains == chain)[:, None]) for chain in np.unique(chains)]
    blocks = [
        Block(
            points=predicted[s, n], at=np.stack([s, n], axis=-1), along=(along / problem.design.length)[n],
            stroke=stroke[s], weight=problem.count[s, n].astype(float),
        )
        for s, n in (at.T for at in parts if len(at))
    ]  # fmt: skip
    if not blocks:
        raise ModelError("no point was seen in the takes that are fitted; allowed: at least one shape")
    return blocks


@final
class _Search:
    """State of a Levenberg-Marquardt search."""

    def __init__(self, problem: FitProblem, prior: Gaussian, begin: np.ndarray, noise_model: NoiseModel) -> None:
        self.problem, self.prior, self.values = problem, prior, begin.copy()
        self.precision = np.linalg.inv(prior.covariance)
        self.equilibria, self.predicted = problem.predict(self.values)
        self.blocks = _build_blocks(problem, self.predicted)
        self.takes = [block.weight for block in self.blocks]
        self.jacobian: np.ndarray = np.empty(0)
        self.assume(noise_model)

    def assume(self, noise_model: NoiseModel) -> None:
        """Whiten residuals by a noise model."""
        self.noise_model = noise_model
        self.factors = [factorise(block, noise_model) for block in self.blocks]

    def differentiate(self, softness: float = 0.0) -> None:
        """Bring the Jacobian up to date."""
        self.jacobian = self.problem.differentiate(self.values, self.equilibria, softness)

    def descend(self) -> float:
        """Levenberg-Marquardt steps, first with soft, then with exact Jacobians; returns the decrease of the misfit."""
        before = self.misfit()
        for softness in _SOFTNESS:
            self._damping = 1e-3
            for _ in range(_STEPS):
                self.differentiate(softness)
                if self.step() < ENOUGH:
                    break
        return before - self.misfit()

    def build_normal(self) -> tuple[np.ndarray, np.ndarray]:
        """Matrix J^T C^-1 J + P and right-hand side J^T C^-1 r + P (mean - values) of the normal equations."""
        normal, moment = self.precision.copy(), self.precision @ (self.prior.mean - self.values)
        for block, factor in zip(self.blocks, self.factors, strict=True):
            jacobian = whiten(factor, self._jacobian_of(block))
            normal += jacobian.T @ jacobian
            moment += jacobian.T @ whiten(factor, self._residual(block, self.predicted))
        return normal, moment

    def misfit(self, values: np.ndarray | None = None, predicted: np.ndarray | None = None) -> float:
        """Sum of squares of the whitened residuals and of the deviation from the prior, here or elsewhere [-]."""
        away = (self.values if values is None else values) - self.prior.mean
        predicted = self.predicted if predicted is None else predicted
        total = float(away @ self.precision @ away)
        for block, factor in zip(self.blocks, self.factors, strict=True):
            white = whiten(factor, self._residual(block, predicted))
            total += float(white @ white)
        return total

    def update_noise_model(self, first: NoiseModel) -> None:
        """Bring the Huber weights and, from ``first``, the noise model up to date with the residuals."""
        self.differentiate()
        residuals = [self._residual(block, self.predicted) for block in self.blocks]
        self._weigh(residuals)
        jacobians = [self._jacobian_of(block) for block in self.blocks]
        away = self.values - self.prior.mean
        at_mean = [r + j @ away for r, j in zip(residuals, jacobians, strict=True)]
        self.assume(fit_noise_model(self.blocks, at_mean, jacobians, self.prior.covariance, first))

    def count_outliers(self) -> int:
        """Points that count less than half."""
        return int(sum((b.weight < 0.5 * takes).sum() for b, takes in zip(self.blocks, self.takes, strict=True)))

    def step(self) -> float:
        """One step, damped until the misfit falls (Levenberg and Marquardt); returns its decrease."""
        now = self.misfit()
        normal, moment = self.build_normal()
        for _ in range(_TRIES):
            step = np.linalg.solve(normal + self._damping * np.diag(np.diag(normal)), moment)
            step *= min(1.0, _LONGEST_STEP / max(float(np.abs(step / self.prior.spread).max()), 1e-12))
            values = keep_positive(self.prior.names, self.values + step)
            try:
                found = self.problem.predict(values)
                then = self.misfit(values, found[1])
            except DesignError:  # A hole or a centre outside of the section.
                then = np.inf
            if then < now:
                self.values, (self.equilibria, self.predicted) = values, found
                self._damping = max(0.1 * self._damping, 1e-9)
                return now - then
            self._damping = max(10 * self._damping, 1e-4)
        return 0.0

    def _residual(self, block: Block, predicted: np.ndarray) -> np.ndarray:
        s, n = block.at.T
        return (self.problem.measured[s, n] - predicted[s, n]).ravel()

    def _jacobian_of(self, block: Block) -> np.ndarray:
        s, n = block.at.T
        return self.jacobian[:, s, n].reshape(len(self.values), -1).T

    def _weigh(self, residuals: list[np.ndarray]) -> None:
        """Huber weights by the distance from the prediction over the median of the section."""
        away = [np.linalg.norm(r.reshape(-1, 3), axis=1) for r in residuals]
        section, everything = np.concatenate([block.at[:, 1] for block in self.blocks]), np.concatenate(away)
        usual = np.full(self.problem.design.n_section, np.inf)
        for n in np.unique(section):
            usual[n] = max(float(np.median(everything[section == n])), 1e-5)
        self.blocks = [
            replace(block, weight=takes * np.minimum(1.0, _HUBER * usual[block.at[:, 1]] / np.maximum(far, 1e-9)) ** 2)
            for block, takes, far in zip(self.blocks, self.takes, away, strict=True)
        ]
