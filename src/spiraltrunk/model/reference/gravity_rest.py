"""Compiled: the trunk at rest under gravity, the minimum of elastic energy and weight within the joint limits.

The gravity moments of the joints are `constants.gravity_moment_term`.
"""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.model.reference.constants import Table, compiled

_MOST_STEPS = 200
"""Largest number of Newton steps [-]."""

_SMALL = 1e-8
"""Full Newton step below which the iteration has converged, since the error left is its square [rad]."""

_UNSEEN = 1e-6
"""Step below which the change of energy is lost in rounding [rad]."""

_LEFT = 1e-13
"""Tolerance of the error after a full step s, estimated by s (s / s')^2 with s' the step before [rad]."""

_NOISE = 1e-14
"""Rounding error of the energy over the moments of the weights [-]."""

_NUDGE = 1e-3
"""Perturbation of every joint at an unstable equilibrium [rad]."""

_NARROW = 0.53
"""Angle up to which the series of `cos_sin` are exact to rounding, a little over 30 deg [rad]."""


@compiled
def cos_sin(angle: np.ndarray, widest: float, cos: np.ndarray, sin: np.ndarray) -> None:
    """Cos and sin of angles within +-``widest`` [rad], by series that vectorise up to `_NARROW`."""
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
def solve_rest(theta_0: float, t: Table, sag: np.ndarray, work: np.ndarray) -> bool:
    """Sag of every joint at rest, by Newton's method with line search on the energy, from the straight trunk.

    (E I / L)_n q_n - (E I / L)_(n+1) q_(n+1) = (m_n K_c + sum of m_i beyond n) g a_n cos(theta_0 + sum of q_i up to n)
    (paper, section "Resting under gravity", without its second K_c). Joints at their limit form an active set; unstable
    equilibria are left by a perturbation. ``sag`` receives the bends q, positive downwards from theta_0 [rad]; ``work``
    is workspace of shape (6, n_joint). Returns whether it converged.
    """
    for n in range(sag.size):
        sag[n] = 0.0
    tilt, noise, before = (math.cos(theta_0), math.sin(theta_0)), 0.0, 0.0
    for n in range(sag.size):
        noise += _NOISE * t.weight[n]
    energy = _energy(tilt, t, sag, work)
    for _ in range(_MOST_STEPS):
        is_stable, short = _newton_step(t, sag, 1.0, work), 1e-5
        is_down = is_stable
        while not is_down:
            short = min(10.0 * short, 1.0)
            is_down = _newton_step(t, sag, 1.0 - short, work)
        energy, moved, part = _line_search(tilt, t, sag, work, energy + noise)
        if moved < _UNSEEN:
            if is_stable and part == 1.0 and (moved < _SMALL or moved**3 <= _LEFT * before**2):
                return True
            if moved < _SMALL and not is_stable:
                for n in range(sag.size):
                    sag[n] = min(sag[n] + _NUDGE, t.limit)
            energy = _energy(tilt, t, sag, work)
        before = moved
    return False


@compiled
def _energy(tilt: tuple[float, float], t: Table, sag: np.ndarray, work: np.ndarray) -> float:
    """Elastic energy and weight [J]; the weights' moments go to ``work[2]``, minus their derivatives to ``work[3]``.

    ``tilt`` is cos and sin of theta_0.
    """
    pull, bow, cos, sin = work[2], work[3], work[4], work[5]
    cos_sin(sag, t.limit, cos, sin)
    c, s, total = tilt[0], tilt[1], 0.0
    for n in range(sag.size):
        c, s = c * cos[n] - s * sin[n], s * cos[n] + c * sin[n]
        pull[n], bow[n] = t.weight[n] * c, t.weight[n] * s
        total += 0.5 * t.stiffness[n] * sag[n] ** 2 - bow[n]
    return total


@compiled
def _newton_step(t: Table, sag: np.ndarray, concave: float, work: np.ndarray) -> bool:
    """Newton step of each bend into ``work[0]``, by elimination from the tip to the base; False where not convex.

    The energy beyond joint n is curve / 2 d^2 + slope d in the turn d of the section before it. Its concave terms are
    scaled by ``concave``; with 0 the step is always one of descent.
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
def _line_search(
    tilt: tuple[float, float], t: Table, sag: np.ndarray, work: np.ndarray, most: float
) -> tuple[float, float, float]:
    """Backtracking along ``work[0]`` within the limits, until the energy is at most ``most`` or the step negligible.

    Returns the new energy [J], the largest change of a bend [rad] and the share of the step [-].
    """
    step, trial = work[0], work[1]
    part, reached, moved = 1.0, most, 0.0
    while True:
        moved = 0.0
        for n in range(sag.size):
            trial[n] = min(max(sag[n] + part * step[n], -t.limit), t.limit)
            moved = max(moved, abs(trial[n] - sag[n]))
        if moved >= _UNSEEN:
            reached = _energy(tilt, t, trial, work)
        if reached <= most or moved < _UNSEEN:
            for n in range(sag.size):
                sag[n] = trial[n]
            return reached, moved, part
        part *= 0.5
