"""Capstan law of Euler and Eytelwein: friction of a cable at one hole, for statics, calibration and simulation."""

from __future__ import annotations

from typing import Any

import numpy as np

from spiraltrunk.model.statics.kernels import compiled


def tension_ratio(mu: Any, turn: Any) -> Any:
    """T_out / T_in = exp(-mu w) at a hole where the cable slides towards its motor; numbers or arrays [-].

    T_in is the tension on the motor's side [N], ``mu`` the coefficient of friction [-] and ``turn`` the angle w by
    which the cable turns at the hole [rad] (Euler 1769; Eytelwein 1808). Where the cable slides away from its motor
    the ratio is that of ``-mu``.
    """
    return np.exp(-mu * turn)


ratio: Any = compiled(tension_ratio)
"""`tension_ratio` of numbers, for kernels."""


@compiled
def slip_forces(tension, towards, away):
    """Friction at which the cable slips towards its motor, T_in (1 - ratio), and away from it, T_in (ratio - 1) [N].

    ``tension`` is T_in [N]; ``towards`` and ``away`` are the ratios for either direction [-].
    """
    return tension * (1 - towards), tension * (away - 1)
