"""MAP estimate of the parameters from measured shapes, with its covariance."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.calibration.fit_problem import FitProblem, split_half
from spiraltrunk.calibration.levenberg_marquardt import ENOUGH, ChainMisfit, Search
from spiraltrunk.calibration.noise_model import NoiseModel
from spiraltrunk.calibration.parameters import Gaussian, keep_positive
from spiraltrunk.calibration.predict_states import State
from spiraltrunk.files.results import Progress, ignore_progress

_LEVELS = (
    NoiseModel(noise=3e-3, discrepancy=10e-3), NoiseModel(noise=1e-3, discrepancy=3e-3),
    NoiseModel(noise=5e-4, discrepancy=1e-3),
)  # fmt: skip
"""Noise models assumed at first, one after the other.

Joints that shut in another order than measured make local minima, which more noise smooths.
"""

MODEL_ERROR = {"friction": 5e-3}
"""Standard deviation of the model's own error of a parameter [-]; its square is added to the variance of the fit.

Pulled softly at 5 mm/s, cables in the simulation still slip a little earlier than in equilibrium: the friction that
fits lay 0.0035 below the truth on the mean (`benchmarks/calibration_worlds.py`).
"""

TWISTED_SLACK = 3e-4
"""Standard deviation added to the slack of a cable that is pulled in a twist alone, for the model's own error [m].

Where a joint has shut the simulation's cable slides along its limit, which the equilibrium does not: the slack of cable
2 came out 0.27 mm too small on the mean of nine virtual trunks (`benchmarks/calibration_files.py`).
"""

TWIST_ALONE = 2.0
"""Factor on the standard deviations that a twist without a bending gives, up to the prior's [-].

The model's error is common to all states of a twist. The parameters absorb it, so that the misfit does not tell it
(`benchmarks/calibration_files.py`).
"""

_ROUNDS = 5
"""Most rounds in which the noise model is brought up to date."""

_NEAR = 2
"""Joints on either side of one that may shut before or after it [-]."""


@final
@dataclass(frozen=True, kw_only=True)
class MapEstimate:
    """Parameters of greatest posterior density."""

    values: np.ndarray
    """Parameter vector, shape (n_parameter,)."""
    covariance: np.ndarray
    """Of its error, shape (n_parameter, n_parameter)."""
    misfits: tuple[ChainMisfit, ...]
    """Misfit of each chain of which points were seen."""
    n_outlier: int
    """Points that count less than half."""
    has_converged: bool
    """Whether the misfit had ceased to fall."""

    @property
    def noise(self) -> float:
        """Standard deviation of each coordinate of each point of one take, fitted [m]."""
        return self.misfits[0].noise_model.noise


def estimate_map(
    problem: FitProblem,
    prior: Gaussian,
    registration: tuple[float, float],
    progress: Progress = ignore_progress,
) -> MapEstimate:
    """MAP estimate by Levenberg-Marquardt, with Huber weights for outliers.

    The odd and the even states are fitted first, from the prior's mean on; all states are then fitted from the better
    of these two estimates, and the noise model with them. A twist without a bending is also fitted from other starts.

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
        progress("fitting half of the steps", odd * len(levels), work)
        halves.append(_search_from(split_half(problem, odd), prior, prior.mean, levels).values)
    searches = [_search_from(problem, prior, begin, levels[-1:]) for begin in halves]
    searches += [_search_from(problem, prior, begin, levels) for begin in list_starts(problem, prior)]
    search = min(searches, key=Search.misfit)
    for done in range(_ROUNDS):
        progress("fitting", 3 * len(levels) + done, work)
        search.update_noise_model(levels[-1])
        has_converged = search.descend() < ENOUGH
        if has_converged:
            break
    search.differentiate()
    covariance = inflate(np.linalg.inv(search.build_normal()[0]), search.values, halves, problem.design.n_joint)
    return MapEstimate(
        values=search.values, covariance=add_model_error(covariance, prior, problem.states),
        misfits=search.measure_misfits(), n_outlier=search.count_outliers(), has_converged=has_converged,
    )  # fmt: skip


def _search_from(problem: FitProblem, prior: Gaussian, begin: np.ndarray, levels: Sequence[NoiseModel]) -> Search:
    """A search under each noise model, one after the other."""
    search = Search(problem, prior, begin, levels[0])
    for level in levels:
        search.assume(level)
        search.descend()
    return search


def list_starts(problem: FitProblem, prior: Gaussian) -> list[np.ndarray]:
    """Further starts for a twist without a bending, which has several minima; none for other recordings.

    Friction is a standard deviation below or above the prior's mean, and the slack of all cables at it or one above.
    """
    if not is_twist_alone(state.kind for state in problem.states):
        return []
    k = prior.names.index("friction")
    slack = [i for i, name in enumerate(prior.names) if name.startswith("slack_")]
    starts = []
    for friction, share in itertools.product((-1.0, 1.0), (0.0, 1.0)):
        begin = prior.mean.copy()
        begin[k] += friction * prior.spread[k]
        begin[slack] += share * prior.spread[slack]
        starts.append(keep_positive(prior.names, begin))
    return starts


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


def is_twist_alone(kinds: Iterable[str]) -> bool:
    """Whether a twist is fitted without a bending."""
    fitted = set(kinds)
    return "twist" in fitted and not fitted & {"bend-dorsal", "bend-ventral"}


def add_model_error(covariance: np.ndarray, prior: Gaussian, states: Sequence[State]) -> np.ndarray:
    """The covariance with the model's own error in these states, which widens no parameter beyond its prior.

    A twist without a bending multiplies standard deviations by `TWIST_ALONE`; variances of `MODEL_ERROR`, and of
    `TWISTED_SLACK` for cables pulled in a twist alone, are added.
    """
    factor = TWIST_ALONE if is_twist_alone(state.kind for state in states) else 1.0
    factors = np.clip(prior.spread / np.sqrt(np.diag(covariance)), 1.0, factor)
    out = covariance * np.outer(factors, factors)
    for name, error in (MODEL_ERROR | dict.fromkeys(_list_twisted_slacks(states), TWISTED_SLACK)).items():
        k = prior.names.index(name)
        out[k, k] = min(out[k, k] + error**2, max(prior.covariance[k, k], out[k, k]))
    return np.asarray(out)


def _list_twisted_slacks(states: Sequence[State]) -> list[str]:
    """Names of the slack of cables that are pulled in a twist and in nothing else."""
    twisted, others = (
        np.isfinite([state.pull for state in states if (state.kind == "twist") == is_twist] or [(np.nan,)]).any(axis=0)
        for is_twist in (True, False)
    )
    return [f"slack_{c + 1}" for c in np.flatnonzero(twisted & ~others)]
