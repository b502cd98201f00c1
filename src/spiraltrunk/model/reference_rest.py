"""Compiled: the trunk at rest, each joint's bend the balance of its stiffness and the weight beyond it."""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.model.reference_table import Table, compiled

_MOST_STEPS = 200
"""Newton steps before the search ends; from straight, a design's own few are enough [-]."""

_SMALL = 1e-8
"""A full Newton step of this size leaves an error of its square [rad]."""

_NOISE = 1e-14
"""Rounding of the energy over the weights' moments [-]."""

_NUDGE = 1e-3
"""Turn that takes a trunk off an equilibrium on which it cannot stay [rad]."""


@compiled
def settle(theta_0: float, t: Table, sag: np.ndarray, work: np.ndarray) -> bool:
    """Sag of every joint at rest, by Newton's method on the energy, from the straight trunk.

    (E I / L)_n q_n - (E I / L)_(n+1) q_(n+1) = (m_n K_c + sum of m_i beyond n) g a_n cos(theta_0 + sum of q_i up to n)
    (paper, section "Resting under gravity", without its second K_c). A joint that would pass its limit is held there
    and the others are solved with it rigid. An equilibrium on which the trunk cannot stay is left.

    Args:
        theta_0: angle of the base axis below the horizontal [rad].
        t: numbers of the design.
        sag: filled with the bends q, positive downwards from theta_0, shape (n_joint,) [rad].
        work: room, shape (4, n_joint).

    Returns:
        Whether it converged.
    """
    for n in range(sag.size):
        sag[n] = 0.0
    energy = _weigh(theta_0, t, sag, work)
    for _ in range(_MOST_STEPS):
        is_stable = _direction(t, sag, True, work)
        if not is_stable:
            _direction(t, sag, False, work)
        energy, moved, part = _descend(theta_0, t, sag, work, energy)
        if moved < _SMALL and part == 1.0 and is_stable:
            return True
        if moved < _SMALL and not is_stable:
            for n in range(sag.size):
                sag[n] = min(sag[n] + _NUDGE, t.limit)
            energy = _weigh(theta_0, t, sag, work)
    return False


@compiled
def _weigh(theta_0: float, t: Table, sag: np.ndarray, work: np.ndarray) -> float:
    """Elastic energy and weight [J]; the weights' moments go to ``work[2]``, their change to ``work[3]``."""
    pull, bow = work[2], work[3]
    total, angle = 0.0, theta_0
    for n in range(sag.size):
        angle += sag[n]
        pull[n] = t.weight[n] * math.cos(angle)
        bow[n] = t.weight[n] * math.sin(angle)
        total += 0.5 * t.stiffness[n] * sag[n] ** 2 - bow[n]
    return total


@compiled
def _direction(t: Table, sag: np.ndarray, is_exact: bool, work: np.ndarray) -> bool:
    """Newton's step of each bend into ``work[0]``, eliminating from the tip to the base; False where not a minimum.

    The energy of all beyond joint n is kept as curve / 2 d^2 + slope d in the turn d of the section before it. Without
    ``is_exact`` weights that would make it concave are left out, which always leads downhill.
    """
    step, slant, pull, bow = work[0], work[1], work[2], work[3]
    curve, slope, torque = 0.0, 0.0, 0.0
    for n in range(sag.size - 1, -1, -1):
        s = t.stiffness[n]
        curve += bow[n] if is_exact or bow[n] > 0.0 else 0.0
        slope -= pull[n]
        torque += pull[n]
        excess = torque - s * sag[n]
        step[n], slant[n] = 0.0, 0.0
        if (sag[n] >= t.limit and excess > 0.0) or (sag[n] <= -t.limit and excess < 0.0):
            continue
        stiff = s + curve
        if stiff <= 1e-9 * s:
            return False
        step[n], slant[n] = -(s * sag[n] + slope) / stiff, -curve / stiff
        slope = (slope - curve * sag[n]) * s / stiff
        curve *= s / stiff
    turned = 0.0
    for n in range(sag.size):
        step[n] += slant[n] * turned
        turned += step[n]
    return True


@compiled
def _descend(theta_0: float, t: Table, sag: np.ndarray, work: np.ndarray, energy: float) -> tuple[float, float, float]:
    """Go along ``work[0]`` within the limits, half as far until the energy falls.

    Returns:
        The new energy [J], how far [rad] and which part of the whole way.
    """
    step, trial = work[0], work[1]
    noise = 0.0
    for n in range(sag.size):
        noise += _NOISE * t.weight[n]
    part, reached, moved = 1.0, energy, 0.0
    while True:
        moved = 0.0
        for n in range(sag.size):
            trial[n] = min(max(sag[n] + part * step[n], -t.limit), t.limit)
            moved = max(moved, abs(trial[n] - sag[n]))
        if moved >= _SMALL:
            reached = _weigh(theta_0, t, trial, work)
        if reached <= energy + noise or moved < _SMALL:
            for n in range(sag.size):
                sag[n] = trial[n]
            return reached, moved, part
        part *= 0.5
