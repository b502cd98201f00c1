"""Noise model of the residuals: measurement noise, model discrepancy, and error of the registration."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.optimize import minimize_scalar

_STROKE_SCALE = 0.03
"""Correlation length of the discrepancy in cable pulled in [m] (ours: a quarter of the paper's stroke)."""

_LEAST_NOISE = 1e-5
"""Least standard deviation of the measurement noise [m]."""

LEAST_DISCREPANCY = 5e-4
"""Least standard deviation of the discrepancy at the tip [m].

Below a millimetre the misfit has several minima, as two joints that shut one after the other fit nearly as well when
they shut the other way round; the intervals take in what lies between them (ours, see docs/validation/calibration.md).
"""

LEAST_TWIST = 1e-2
"""The same for a twist [m].

Where one cable has shut a joint and another pulls it along its limit, models differ that agree in every bend: how the
joint's axes move and how a sticking cable yields decide which joints give way (`benchmarks/calibration_twist.py`).
Twice the 4 to 5 mm that are estimated from a twist without a bending, as the parameters absorb a part (ours).
"""

TWIST_POWER = 2
"""Inverse power of the joint's size with which errors of bends in a twist grow towards the tip [-].

Errors of a joint's moment are in proportion to its size, as the levers of cables are, and its stiffness to the third
power of the size.
"""

_MOST = 0.2
"""Largest standard deviation of noise and of discrepancy [m]."""

_MOST_RESIDUALS = 450
"""Residuals of a chain from which the noise model is fitted; states are left out until there are no more."""

_SWEEPS = 2
"""Sweeps of the coordinate descent over the standard deviations."""

_PENALTY = 0.05
"""Prior of the logarithm of each standard deviation: half the inverse of its variance [-]."""


@final
@dataclass(frozen=True, kw_only=True)
class NoiseModel:
    """Standard deviations of what makes up the residuals."""

    noise: float = 0.5e-3
    """Of each coordinate of each point of one take [m]."""
    discrepancy: float = 1e-3
    """Of the model's error at the tip of the straight trunk, along each axis [m]."""
    turn: float = 2e-3
    """Of the registration's rotation about each axis [rad] (ours: 1 mm over the length of the trunk)."""
    shift: float = 3e-4
    """Of the registration's shift along each axis [m] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class Block:
    """The seen points of one chain of states, m of them: a block of the residuals' block-diagonal covariance."""

    points: np.ndarray
    """Prediction at the start, shape (m, 3) [m]."""
    at: np.ndarray
    """Index of state and section of each, shape (m, 2) [-]."""
    lever: np.ndarray
    """Displacement by the error of each joint's bend, of `compute_levers`, shape (m, n_joint) [-]."""
    stroke: np.ndarray
    """Cable pulled in on the way to the state, shape (m,) [m]."""
    weight: np.ndarray
    """Takes that each is the mean of, less where it is an outlier, shape (m,) [-]."""
    least_discrepancy: float = LEAST_DISCREPANCY
    """Least standard deviation of its discrepancy [m]."""


Part = tuple[Block, np.ndarray, np.ndarray]
"""A chain with its residuals (3 m,) [m] and their Jacobian (3 m, n_parameter)."""

Terms = tuple[float, np.ndarray, np.ndarray]
"""A chain's terms of the likelihood: 1/2 r^T C^-1 r + 1/2 log|C|, J^T C^-1 J and J^T C^-1 r."""

_BY_POINT = ("points", "at", "lever", "stroke", "weight")


def build_covariance(block: Block, model: NoiseModel) -> np.ndarray:
    """Covariance of the residuals of a chain, point by point and axis by axis, shape (3 m, 3 m) [m^2].

    Residuals of neighbouring sections and steps are correlated wherever the model is wrong. With u, v the cable pulled
    in on the way and a_j the levers of `compute_levers`, the covariance of two residuals along the same axis is

        sigma_n^2 [same point] + sigma_d^2 sum_j a_j a_j' exp(-|u - v| / 30 mm) + registration,

    a Gaussian process for the model's discrepancy (Kennedy and O'Hagan, Bayesian calibration of computer models, 2001),
    and for the registration a small rotation and shift of the whole chain.
    """
    alike = block.lever @ block.lever.T
    alike *= np.exp(-np.abs(block.stroke[:, None] - block.stroke) / _STROKE_SCALE)
    same = model.discrepancy**2 * alike + np.diag(model.noise**2 / block.weight)
    whole = np.kron(same, np.eye(3))
    turned = differentiate_rotation(block.points)
    whole += model.turn**2 * turned @ turned.T
    return whole + model.shift**2 * np.kron(np.ones_like(same), np.eye(3))


def compute_levers(along: np.ndarray, joint: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """Displacement of points by independent errors of the joints' bends.

    An error of a bend displaces what is beyond the joint in proportion to the distance.

    Args:
        along: distance of the points from the base over the trunk's length, shape (m,) [-].
        joint: the same of the joints, shape (n_joint,) [-].
        spread: standard deviations of the errors, relative to one another, shape (n_joint,) [-].

    Returns:
        Shape (m, n_joint) [-]; the root of the sum of squares is 1 at the tip.
    """
    levers = np.maximum(along[:, None] - joint, 0.0) * spread
    return np.asarray(levers / np.linalg.norm((1.0 - joint) * spread))


def differentiate_rotation(points: np.ndarray) -> np.ndarray:
    """Jacobian of points by a small rotation of all about the origin, shape (3 m, 3) [m/rad]."""
    x, y, z = points.T
    zero = np.zeros_like(x)
    rows = [[zero, z, -y], [-z, zero, x], [y, -x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=1).reshape(-1, 3)


def factorise(block: Block, model: NoiseModel) -> np.ndarray:
    """Lower Cholesky factor of the covariance, shape (3 m, 3 m) [m]."""
    return np.linalg.cholesky(build_covariance(block, model))


def compute_spread(block: Block, model: NoiseModel) -> np.ndarray:
    """Root mean square distance of each point by the noise model, shape (m,) [m]."""
    return np.asarray(np.sqrt(np.diag(build_covariance(block, model)).reshape(-1, 3).sum(axis=1)))


def whiten(factor: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Whitened residuals or Jacobian L^-1 r, of unit covariance [-]; ``rows`` has shape (3 m, ...) [m]."""
    return solve_triangular(factor, rows, lower=True, check_finite=False)


def fit_noise_models(
    blocks: list[Block],
    residuals: list[np.ndarray],
    jacobians: list[np.ndarray],
    covariance: np.ndarray,
    first: list[NoiseModel],
) -> list[NoiseModel]:
    """Maximum marginal likelihood estimate of the standard deviations, the parameters integrated out.

    The noise is that of all chains, the discrepancy each chain's own. They are found one after the other (coordinate
    descent), with a wide prior about where they begin.

    Args:
        blocks: chains of states.
        residuals: measured minus predicted at the prior's mean, linearised, each (3 m,) [m].
        jacobians: of the predictions by the parameters, each (3 m, n_parameter).
        covariance: of the prior, shape (n_parameter, n_parameter).
        first: where to begin, one a chain, and the registration's errors, which are given.
    """
    fit = _Fit(
        [_thin(*part) for part in zip(blocks, residuals, jacobians, strict=True)], np.linalg.inv(covariance), first
    )
    for _ in range(_SWEEPS):
        fit.fit_noise()
        for i in range(len(blocks)):
            fit.fit_discrepancy(i)
    return fit.models


@final
class _Fit:
    """Coordinate descent over the logarithms of the standard deviations."""

    def __init__(self, parts: list[Part], precision: np.ndarray, first: list[NoiseModel]) -> None:
        self.parts, self.precision, self.first, self.models = parts, precision, first, list(first)
        self.terms = [_compute_terms(part, model) for part, model in zip(parts, first, strict=True)]

    def fit_noise(self) -> None:
        """Fit the noise of all chains."""

        def penalise(log: float) -> float:
            terms = self._compute_all(math.exp(log))
            away = log - math.log(self.first[0].noise)
            return _negative_log_likelihood(terms, self.precision) + _PENALTY * away**2

        noise = math.exp(_minimise(penalise, _LEAST_NOISE))
        self.terms = self._compute_all(noise)
        self.models = [replace(model, noise=noise) for model in self.models]

    def fit_discrepancy(self, i: int) -> None:
        """Fit the discrepancy of chain ``i``."""
        part, model = self.parts[i], self.models[i]

        def penalise(log: float) -> float:
            own = _compute_terms(part, replace(model, discrepancy=math.exp(log)))
            away = log - math.log(self.first[i].discrepancy)
            terms = [*self.terms[:i], own, *self.terms[i + 1 :]]
            return _negative_log_likelihood(terms, self.precision) + _PENALTY * away**2

        self.models[i] = replace(model, discrepancy=math.exp(_minimise(penalise, part[0].least_discrepancy)))
        self.terms[i] = _compute_terms(part, self.models[i])

    def _compute_all(self, noise: float) -> list[Terms]:
        return [
            _compute_terms(part, replace(model, noise=noise))
            for part, model in zip(self.parts, self.models, strict=True)
        ]


def _minimise(function: Callable[[float], float], least: float) -> float:
    """Logarithm of a standard deviation, ``least`` to `_MOST`, at which a function of it has its minimum."""
    bounds = math.log(least), math.log(_MOST)
    found = minimize_scalar(function, bounds=bounds, method="bounded", options={"xatol": 0.05, "maxiter": 14})
    return float(found.x)


def _thin(block: Block, residual: np.ndarray, jacobian: np.ndarray) -> tuple[Block, np.ndarray, np.ndarray]:
    states = np.unique(block.at[:, 0])
    step = max(1, -(-3 * len(block.at) // _MOST_RESIDUALS))
    kept = np.isin(block.at[:, 0], states[:: min(step, len(states))])
    rows = np.repeat(kept, 3)
    return (
        replace(block, **{name: getattr(block, name)[kept] for name in _BY_POINT}),
        residual[rows],
        jacobian[rows],
    )


def _compute_terms(part: Part, model: NoiseModel) -> Terms:
    block, residual, jacobian = part
    factor = factorise(block, model)
    r, j = whiten(factor, residual), whiten(factor, jacobian)
    return 0.5 * float(r @ r) + float(np.log(np.diag(factor)).sum()), j.T @ j, j.T @ r


def _negative_log_likelihood(terms: list[Terms], precision: np.ndarray) -> float:
    """Minus the logarithm of the marginal likelihood of residuals r with Jacobian J, but for a constant.

    1/2 r^T C^-1 r + 1/2 log|C| - 1/2 b^T A^-1 b + 1/2 log|A|, with A = P + J^T C^-1 J, b = J^T C^-1 r and P the prior's
    precision (Rasmussen and Williams, Gaussian processes for machine learning, 2006, section 2.7).
    """
    total = sum(own for own, _, _ in terms)
    lower = cho_factor(precision + sum(normal for _, normal, _ in terms), lower=True)
    moment = np.sum([moment for _, _, moment in terms], axis=0)
    total -= 0.5 * float(moment @ cho_solve(lower, moment))
    return total + float(np.log(np.diag(lower[0])).sum())
