"""Compiled: the trunk at rest, each joint's bend the balance of its stiffness and the weight beyond it."""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.model.reference.constants import Table, compiled

_MOST_STEPS = 200
"""Newton steps before the search ends; from straight, a design's own few are enough [-]."""

_SMALL = 1e-8
"""A full Newton step of this size leaves an error of its square [rad]."""

_UNSEEN = 1e-6
"""Step whose fall in energy rounding may hide [rad]."""

_LEFT = 1e-13
"""Error after a full step s that ends the search; with s' the one before it is about s (s / s')^2 [rad]."""

_NOISE = 1e-14
"""Rounding of the energy over the weights' moments [-]."""

_NUDGE = 1e-3
"""Turn that takes a trunk off an equilibrium on which it cannot stay [rad]."""

_NARROW = 0.53
"""Angle up to which the series of cos and sin below are exact to rounding, a little over 30 deg [rad]."""


@compiled
def turns(angle: np.ndarray, widest: float, cos: np.ndarray, sin: np.ndarray) -> None:
    """Cos and sin of angles up to ``widest`` either way [rad]; several at once as far as they are narrow."""
    for n in range(angle.size):
        x = angle[n]
        y = x * x
        c = y * (1 / 40320 - y * (1 / 3628800 - y * (1 / 479001600 - y * (1 / 87178291200))))
        s = y * (1 / 362880 - y * (1 / 39916800 - y * (1 / 6227020800 - y * (1 / 1307674368000))))
        cos[n] = 1.0 - y * (1 / 2 - y * (1 / 24 - y * (1 / 720 - c)))
        sin[n] = x - x * y * (1 / 6 - y * (1 / 120 - y * (1 / 5040 - s)))
    if widest > _NARROW:
        for n in range(angle.size):
            if abs(angle[n]) > _NARROW:
                cos[n], sin[n] = math.cos(angle[n]), math.sin(angle[n])


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
        work: room, shape (6, n_joint).

    Returns:
        Whether it converged.
    """
    for n in range(sag.size):
        sag[n] = 0.0
    tilt, noise, before = (math.cos(theta_0), math.sin(theta_0)), 0.0, 0.0
    for n in range(sag.size):
        noise += _NOISE * t.weight[n]
    energy = _weigh_straight(tilt, t, work)
    for _ in range(_MOST_STEPS):
        is_stable, short = _direction(t, sag, 1.0, work), 1e-5
        is_down = is_stable
        while not is_down:
            short = min(10.0 * short, 1.0)
            is_down = _direction(t, sag, 1.0 - short, work)
        energy, moved, part = _descend(tilt, t, sag, work, energy + noise)
        if moved < _UNSEEN:
            if is_stable and part == 1.0 and (moved < _SMALL or moved**3 <= _LEFT * before**2):
                return True
            if moved < _SMALL and not is_stable:
                for n in range(sag.size):
                    sag[n] = min(sag[n] + _NUDGE, t.limit)
            energy = _weigh(tilt, t, sag, work)
        before = moved
    return False


@compiled
def _weigh_straight(tilt: tuple[float, float], t: Table, work: np.ndarray) -> float:
    """`_weigh` of the straight trunk."""
    pull, bow, total = work[2], work[3], 0.0
    for n in range(t.weight.size):
        pull[n], bow[n] = t.weight[n] * tilt[0], t.weight[n] * tilt[1]
        total -= bow[n]
    return total


@compiled
def _weigh(tilt: tuple[float, float], t: Table, sag: np.ndarray, work: np.ndarray) -> float:
    """Elastic energy and weight [J]; the weights' moments go to ``work[2]``, their change to ``work[3]``.

    ``tilt`` is cos and sin of theta_0.
    """
    pull, bow, cos, sin = work[2], work[3], work[4], work[5]
    turns(sag, t.limit, cos, sin)
    c, s, total = tilt[0], tilt[1], 0.0
    for n in range(sag.size):
        c, s = c * cos[n] - s * sin[n], s * cos[n] + c * sin[n]
        pull[n], bow[n] = t.weight[n] * c, t.weight[n] * s
        total += 0.5 * t.stiffness[n] * sag[n] ** 2 - bow[n]
    return total


@compiled
def _direction(t: Table, sag: np.ndarray, concave: float, work: np.ndarray) -> bool:
    """Newton's step of each bend into ``work[0]``, eliminating from the tip to the base; False where not a minimum.

    The energy of all beyond joint n is kept as curve / 2 d^2 + slope d in the turn d of the section before it. Of the
    weights that make it concave the part ``concave`` is taken; with little enough the step always leads downhill.
    """
    step, slant, pull, bow = work[0], work[1], work[2], work[3]
    curve, slope, torque = 0.0, 0.0, 0.0
    for n in range(sag.size - 1, -1, -1):
        s = t.stiffness[n]
        curve += bow[n] if bow[n] > 0.0 else concave * bow[n]
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
def _descend(
    tilt: tuple[float, float], t: Table, sag: np.ndarray, work: np.ndarray, most: float
) -> tuple[float, float, float]:
    """Go along ``work[0]`` within the limits, half as far until the energy is ``most`` or the step too small to tell.

    Returns:
        The new energy [J], how far [rad] and which part of the whole way.
    """
    step, trial = work[0], work[1]
    part, reached, moved = 1.0, most, 0.0
    while True:
        moved = 0.0
        for n in range(sag.size):
            trial[n] = min(max(sag[n] + part * step[n], -t.limit), t.limit)
            moved = max(moved, abs(trial[n] - sag[n]))
        if moved >= _UNSEEN:
            reached = _weigh(tilt, t, trial, work)
        if reached <= most or moved < _UNSEEN:
            for n in range(sag.size):
                sag[n] = trial[n]
            return reached, moved, part
        part *= 0.5
