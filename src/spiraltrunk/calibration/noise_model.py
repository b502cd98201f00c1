"""Noise model of the residuals: measurement noise, model discrepancy, and error of the registration."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import final

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.optimize import minimize

_LENGTH_SCALE, _STROKE_SCALE = 0.3, 0.03
"""Correlation lengths of the discrepancy: along the trunk over its length [-], and in cable pulled in [m] (ours: a
third of the trunk, and a quarter of the paper's stroke)."""

_LEAST_NOISE = 1e-5
"""Least standard deviation of the measurement noise [m]."""

LEAST_DISCREPANCY = 5e-4
"""Least standard deviation of the discrepancy at the tip [m].

Below a millimetre the misfit has several minima, as two joints that shut one after the other fit nearly as well when
they shut the other way round; the intervals take in what lies between them (ours, see docs/validation/calibration.md).
"""

_MOST_RESIDUALS = 450
"""Residuals of a chain from which the noise model is fitted; states are left out until there are no more."""


@final
@dataclass(frozen=True, kw_only=True)
class NoiseModel:
    """Standard deviations of what makes up the residuals."""

    noise: float = 0.5e-3
    """Of each coordinate of each point of one take [m]."""
    discrepancy: float = 1e-3
    """Of the model's error at the tip, along each axis [m]."""
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
    along: np.ndarray
    """Distance along the trunk over its length, shape (m,) [-]."""
    stroke: np.ndarray
    """Cable pulled in on the way to the state, shape (m,) [m]."""
    weight: np.ndarray
    """Takes that each is the mean of, less where it is an outlier, shape (m,) [-]."""


def build_covariance(block: Block, model: NoiseModel) -> np.ndarray:
    """Covariance of the residuals of a chain, point by point and axis by axis, shape (3 m, 3 m) [m^2].

    Residuals of neighbouring sections and steps are correlated wherever the model is wrong. With s, t the distances
    along the trunk over its length and u, v the cable pulled in on the way, the covariance of two residuals along the
    same axis is

        sigma_n^2 [same point] + sigma_d^2 s t exp(-(s - t)^2 / (2 * 0.3^2)) exp(-|u - v| / 30 mm) + registration,

    a Gaussian process for the model's discrepancy (Kennedy and O'Hagan, Bayesian calibration of computer models, 2001),
    and for the registration a small rotation and shift of the whole chain.
    """
    apart = block.along[:, None] - block.along
    alike = np.outer(block.along, block.along) * np.exp(-(apart**2) / (2 * _LENGTH_SCALE**2))
    alike *= np.exp(-np.abs(block.stroke[:, None] - block.stroke) / _STROKE_SCALE)
    same = model.discrepancy**2 * alike + np.diag(model.noise**2 / block.weight)
    whole = np.kron(same, np.eye(3))
    turned = differentiate_rotation(block.points)
    whole += model.turn**2 * turned @ turned.T
    return whole + model.shift**2 * np.kron(np.ones_like(same), np.eye(3))


def differentiate_rotation(points: np.ndarray) -> np.ndarray:
    """Jacobian of points by a small rotation of all about the origin, shape (3 m, 3) [m/rad]."""
    x, y, z = points.T
    zero = np.zeros_like(x)
    rows = [[zero, z, -y], [-z, zero, x], [y, -x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=1).reshape(-1, 3)


def factorise(block: Block, model: NoiseModel) -> np.ndarray:
    """Lower Cholesky factor of the covariance, shape (3 m, 3 m) [m]."""
    return np.linalg.cholesky(build_covariance(block, model))


def whiten(factor: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Whitened residuals or Jacobian L^-1 r, of unit covariance [-]; ``rows`` has shape (3 m, ...) [m]."""
    return solve_triangular(factor, rows, lower=True, check_finite=False)


def fit_noise_model(
    blocks: list[Block],
    residuals: list[np.ndarray],
    jacobians: list[np.ndarray],
    covariance: np.ndarray,
    first: NoiseModel,
) -> NoiseModel:
    """Maximum marginal likelihood estimate of the standard deviations, the parameters integrated out.

    Args:
        blocks: chains of states.
        residuals: measured minus predicted at the prior's mean, linearised, each (3 m,) [m].
        jacobians: of the predictions by the parameters, each (3 m, n_parameter).
        covariance: of the prior, shape (n_parameter, n_parameter).
        first: where to begin, and the registration's errors, which are given.
    """
    thinned = [_thin(*parts) for parts in zip(blocks, residuals, jacobians, strict=True)]
    precision = np.linalg.inv(covariance)

    def penalise(logs: np.ndarray) -> float:
        model = replace(first, noise=float(np.exp(logs[0])), discrepancy=float(np.exp(logs[1])))
        return _negative_log_likelihood(thinned, model, precision) + 0.05 * float(((logs - begin) ** 2).sum())

    begin = np.log([first.noise, first.discrepancy])
    corners = [begin + np.array([0.7 * a, 0.7 * b]) for a, b in ((0, 0), (1, 0), (0, 1))]
    best = minimize(
        penalise, begin, method="Nelder-Mead",
        options={"initial_simplex": corners, "xatol": 0.03, "fatol": 0.1, "maxfev": 60},
    ).x  # fmt: skip
    noise, discrepancy = np.exp(np.clip(best, np.log([_LEAST_NOISE, LEAST_DISCREPANCY]), np.log(0.1))).tolist()
    return replace(first, noise=noise, discrepancy=discrepancy)


def _thin(block: Block, residual: np.ndarray, jacobian: np.ndarray) -> tuple[Block, np.ndarray, np.ndarray]:
    states = np.unique(block.at[:, 0])
    step = max(1, -(-3 * len(block.at) // _MOST_RESIDUALS))
    kept = np.isin(block.at[:, 0], states[:: min(step, len(states))])
    rows = np.repeat(kept, 3)
    return (
        Block(**{part.name: getattr(block, part.name)[kept] for part in fields(Block)}),
        residual[rows],
        jacobian[rows],
    )


def _negative_log_likelihood(
    parts: list[tuple[Block, np.ndarray, np.ndarray]], model: NoiseModel, precision: np.ndarray
) -> float:
    """Minus the logarithm of the marginal likelihood of residuals r with Jacobian J, but for a constant.

    1/2 r^T C^-1 r + 1/2 log|C| - 1/2 b^T A^-1 b + 1/2 log|A|, with A = P + J^T C^-1 J, b = J^T C^-1 r and P the prior's
    precision (Rasmussen and Williams, Gaussian processes for machine learning, 2006, section 2.7).
    """
    normal, moment, total = precision.copy(), np.zeros(len(precision)), 0.0
    for block, residual, jacobian in parts:
        factor = factorise(block, model)
        r, j = whiten(factor, residual), whiten(factor, jacobian)
        total += 0.5 * float(r @ r) + float(np.log(np.diag(factor)).sum())
        normal += j.T @ j
        moment += j.T @ r
    lower = cho_factor(normal, lower=True)
    total -= 0.5 * float(moment @ cho_solve(lower, moment))
    return total + float(np.log(np.diag(lower[0])).sum())
