"""Levenberg-Marquardt search for the parameters of greatest posterior density, with Huber weights for outliers."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.calibration.fit_problem import FitProblem, build_blocks
from spiraltrunk.calibration.noise_model import (
    LEAST_DISCREPANCY,
    Block,
    NoiseModel,
    compute_spread,
    differentiate_rotation,
    factorise,
    fit_noise_models,
    whiten,
)
from spiraltrunk.calibration.parameters import Gaussian, keep_positive
from spiraltrunk.errors import DesignError

ENOUGH = 0.5
"""Decrease of the misfit, a sum of squares of variance 1, below which the fit has converged [-]."""

_SOFTNESS = (0.3, 0.0)
"""Softness of pressed joints in the Jacobian, one after the other [-]: a joint that shut too early does not feel it."""

_STEPS = 6
"""Most steps at each softness."""

_TRIES = 5
"""Most dampings that are tried in a step."""

_LONGEST_STEP = 1.5
"""Largest step of a parameter over its prior standard deviation [-]."""

_HUBER = 3.0
"""Distance, in standard deviations and over the median of its section, from which a point is an outlier [-]."""


@final
@dataclass(frozen=True, kw_only=True)
class ChainMisfit:
    """How well the model expresses one chain of states."""

    chain: int
    """The chain."""
    rms: float
    """Root mean square distance of the measured from the predicted points [m]."""
    registered_rms: float
    """The same after the small rotation and shift of the chain that fit it best [m]."""
    noise_model: NoiseModel
    """Noise model of its residuals, fitted."""


@final
class Search:
    """State of a Levenberg-Marquardt search."""

    def __init__(self, problem: FitProblem, prior: Gaussian, begin: np.ndarray, noise_model: NoiseModel) -> None:
        self.problem, self.prior, self.values = problem, prior, begin.copy()
        self.precision = np.linalg.inv(prior.covariance)
        self.equilibria, self.predicted = problem.predict(self.values)
        self.blocks = build_blocks(problem, self.predicted)
        self.takes = [block.weight for block in self.blocks]
        self.jacobian: np.ndarray = np.empty(0)
        self.assume(noise_model)

    def assume(self, noise_model: NoiseModel) -> None:
        """Whiten the residuals of all chains by a noise model."""
        self.assume_each(self.scale(noise_model))

    def scale(self, noise_model: NoiseModel) -> list[NoiseModel]:
        """The noise model of each chain, its discrepancy in proportion to the chain's least one."""
        share = [block.least_discrepancy / LEAST_DISCREPANCY for block in self.blocks]
        return [replace(noise_model, discrepancy=part * noise_model.discrepancy) for part in share]

    def assume_each(self, noise_models: list[NoiseModel]) -> None:
        """Whiten the residuals of each chain by a noise model."""
        self.noise_models = noise_models
        self.factors = [factorise(block, model) for block, model in zip(self.blocks, noise_models, strict=True)]

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
        begin = self.scale(first)
        self.assume_each(fit_noise_models(self.blocks, at_mean, jacobians, self.prior.covariance, begin))

    def count_outliers(self) -> int:
        """Points that count less than half."""
        return int(sum((b.weight < 0.5 * takes).sum() for b, takes in zip(self.blocks, self.takes, strict=True)))

    def measure_misfits(self) -> tuple[ChainMisfit, ...]:
        """Misfit of each chain."""
        out = []
        for block, model in zip(self.blocks, self.noise_models, strict=True):
            left = self._residual(block, self.predicted)
            motion = np.hstack([differentiate_rotation(block.points), np.tile(np.eye(3), (len(block.at), 1))])
            still = left - motion @ np.linalg.lstsq(motion, left, rcond=None)[0]
            rms, registered = (math.sqrt(float(r @ r) / len(block.at)) for r in (left, still))
            chain = self.problem.states[block.at[0, 0]].chain
            out.append(ChainMisfit(chain=chain, rms=rms, registered_rms=registered, noise_model=model))
        return tuple(out)

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
        """Huber weights by the distance from the prediction over its standard deviation, and over their median.

        The standard deviation is that of the point's own chain: where the model errs, no single point is an outlier.
        The median is that of the section.
        """
        away = [
            np.linalg.norm(r.reshape(-1, 3), axis=1) / compute_spread(replace(block, weight=takes), model)
            for block, model, takes, r in zip(self.blocks, self.noise_models, self.takes, residuals, strict=True)
        ]
        section, everything = np.concatenate([block.at[:, 1] for block in self.blocks]), np.concatenate(away)
        usual = np.full(self.problem.design.n_section, np.inf)
        for n in np.unique(section):
            usual[n] = max(float(np.median(everything[section == n])), 1e-3)
        self.blocks = [
            replace(block, weight=takes * np.minimum(1.0, _HUBER * usual[block.at[:, 1]] / np.maximum(far, 1e-9)) ** 2)
            for block, takes, far in zip(self.blocks, self.takes, away, strict=True)
        ]
