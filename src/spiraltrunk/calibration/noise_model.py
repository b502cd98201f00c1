"""How measured points scatter about the model: noise, error of the model itself, and error of the registration.

Residuals of neighbouring sections and steps are alike wherever the model is wrong, so that a thousand of them do not
tell a thousand times as much as one. With s, t the distances along the trunk over its length and u, v the cable pulled
in on the way, the covariance of two residuals of one chain of states, along the same axis, is

    sigma_n^2 [same point] + sigma_d^2 s t exp(-(s - t)^2 / (2 * 0.3^2)) exp(-|u - v| / 30 mm) + registration,

a Gaussian process for the model's discrepancy (Kennedy and O'Hagan, Bayesian calibration of computer models, 2001),
and for the registration a small rotation and shift of the whole chain. Both sigmas are those of greatest marginal
likelihood. The two lengths are ours: a third of the trunk, and a quarter of the paper's stroke.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.optimize import minimize

_ALONG, _STROKE = 0.3, 0.03
_LEAST_NOISE = 1e-5
LEAST_DISCREPANCY = 5e-4
"""Error of the model at the tip that is always reckoned with [m].

Below a millimetre the misfit has several minima, as two joints that shut one after the other fit nearly as well when
they shut the other way round; the intervals take in what lies between them (ours, see docs/validation/calibration.md).
"""
_FEW = 450
"""Residuals of a chain of which the sigmas are found: steps are left out until there are no more."""


@final
@dataclass(frozen=True, kw_only=True)
class Scatter:
    """How far residuals are expected to lie from zero."""

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
    """The seen points of one chain of states, m of them."""

    points: np.ndarray
    """Where they are predicted at the start, shape (m, 3) [m]."""
    at: np.ndarray
    """Index of state and section of each, shape (m, 2) [-]."""
    along: np.ndarray
    """Distance along the trunk over its length, shape (m,) [-]."""
    stroke: np.ndarray
    """Cable pulled in on the way to the state, shape (m,) [m]."""
    weight: np.ndarray
    """Takes that each is the mean of, less where it lies far off, shape (m,) [-]."""


def build_covariance(block: Block, scatter: Scatter) -> np.ndarray:
    """Covariance of the residuals of a chain, point by point and axis by axis, shape (3 m, 3 m) [m^2]."""
    apart = block.along[:, None] - block.along
    alike = np.outer(block.along, block.along) * np.exp(-(apart**2) / (2 * _ALONG**2))
    alike *= np.exp(-np.abs(block.stroke[:, None] - block.stroke) / _STROKE)
    same = scatter.discrepancy**2 * alike + np.diag(scatter.noise**2 / block.weight)
    whole = np.kron(same, np.eye(3))
    turned = turn_points(block.points)
    whole += scatter.turn**2 * turned @ turned.T
    return whole + scatter.shift**2 * np.kron(np.ones_like(same), np.eye(3))


def turn_points(points: np.ndarray) -> np.ndarray:
    """Motion of points with a small rotation of all about the origin, shape (3 m, 3) [m/rad]."""
    x, y, z = points.T
    zero = np.zeros_like(x)
    rows = [[zero, z, -y], [-z, zero, x], [y, -x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=1).reshape(-1, 3)


@final
class Whitener:
    """Turns residuals of a chain into independent ones of variance 1."""

    def __init__(self, block: Block, scatter: Scatter) -> None:
        self._lower = np.linalg.cholesky(build_covariance(block, scatter))

    def whiten(self, rows: np.ndarray) -> np.ndarray:
        """Residuals or slopes, shape (3 m, ...) [m]."""
        return solve_triangular(self._lower, rows, lower=True, check_finite=False)


def find_scatter(
    blocks: list[Block], residuals: list[np.ndarray], slopes: list[np.ndarray], covariance: np.ndarray, first: Scatter
) -> Scatter:
    """The sigmas of noise and discrepancy of greatest likelihood, knobs integrated out.

    Args:
        blocks: chains of states.
        residuals: measured minus predicted with all knobs where they are expected, linear, each (3 m,) [m].
        slopes: of the predictions by the knobs, each (3 m, n_knob).
        covariance: of the knobs beforehand, shape (n_knob, n_knob).
        first: where to begin, and the registration's errors, which are taken as told.
    """
    few = [_thin(*parts) for parts in zip(blocks, residuals, slopes, strict=True)]
    precision = np.linalg.inv(covariance)

    def miss(logs: np.ndarray) -> float:
        scatter = Scatter(
            noise=float(np.exp(logs[0])), discrepancy=float(np.exp(logs[1])), turn=first.turn, shift=first.shift
        )
        return _unlikeliness(few, scatter, precision) + 0.05 * float(((logs - begin) ** 2).sum())

    begin = np.log([first.noise, first.discrepancy])
    corners = [begin + np.array([0.7 * a, 0.7 * b]) for a, b in ((0, 0), (1, 0), (0, 1))]
    best = minimize(
        miss, begin, method="Nelder-Mead",
        options={"initial_simplex": corners, "xatol": 0.03, "fatol": 0.1, "maxfev": 60},
    ).x  # fmt: skip
    noise, discrepancy = np.exp(np.clip(best, np.log([_LEAST_NOISE, LEAST_DISCREPANCY]), np.log(0.1))).tolist()
    return Scatter(noise=noise, discrepancy=discrepancy, turn=first.turn, shift=first.shift)


def _thin(block: Block, residual: np.ndarray, slope: np.ndarray) -> tuple[Block, np.ndarray, np.ndarray]:
    states = np.unique(block.at[:, 0])
    step = max(1, -(-3 * len(block.at) // _FEW))
    kept = np.isin(block.at[:, 0], states[:: min(step, len(states))])
    fewer = Block(
        points=block.points[kept], at=block.at[kept], along=block.along[kept], stroke=block.stroke[kept],
        weight=block.weight[kept],
    )  # fmt: skip
    rows = np.repeat(kept, 3)
    return fewer, residual[rows], slope[rows]


def _unlikeliness(few: list[tuple[Block, np.ndarray, np.ndarray]], scatter: Scatter, precision: np.ndarray) -> float:
    """Minus the logarithm of the marginal likelihood, but for a constant."""
    normal, moment, total = precision.copy(), np.zeros(len(precision)), 0.0
    for block, residual, slope in few:
        whitener = Whitener(block, scatter)
        r, s = whitener.whiten(residual), whitener.whiten(slope)
        total += 0.5 * float(r @ r) + float(np.log(np.diag(whitener._lower)).sum())
        normal += s.T @ s
        moment += s.T @ r
    factor = cho_factor(normal, lower=True)
    total -= 0.5 * float(moment @ cho_solve(factor, moment))
    return total + float(np.log(np.diag(factor[0])).sum())
