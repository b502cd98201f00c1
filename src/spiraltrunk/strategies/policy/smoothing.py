"""Critically damped second-order filter of set points, exact for set points that are held."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import final

import numpy as np


@final
@dataclass(frozen=True, kw_only=True)
class Filtered:
    """Value of the filter and its rate of change."""

    value: np.ndarray
    """Shape (n,), in the set point's unit."""
    rate: np.ndarray
    """Shape (n,), in that unit per second."""


def follow(state: Filtered, goal: np.ndarray, time_constant: float, step: float) -> Filtered:
    r"""State one step [s] later, for a goal held meanwhile, shape (n,).

    The error :math:`e = x - g` obeys :math:`\ddot e + 2 \dot e / \tau + e / \tau^2 = 0`, whose solution is
    :math:`e(t) = (e_0 + (\dot e_0 + e_0 / \tau) t) \exp(-t / \tau)`. Steady motion lags by :math:`2 \tau`.
    """
    error, decay = state.value - goal, math.exp(-step / time_constant)
    slope = state.rate + error / time_constant
    return replace(
        state,
        value=goal + (error + slope * step) * decay,
        rate=(state.rate - slope * step / time_constant) * decay,
    )
