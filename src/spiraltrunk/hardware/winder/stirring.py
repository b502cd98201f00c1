"""Stirring at the end of homing, as a magnet is demagnetised: the trunk circles, and settles where it is straight.

Dry friction at the drums is larger than the tensions that hold a hanging trunk straight. To equal tensions an
alternating part is added, larger than the friction, shifted from cable to cable by a turn over their number. Friction F
then acts as a damping: of a rotor that is driven to and fro with the speed v it brakes a slow motion u by
F (2/pi) u / v, and so does the back-EMF that is not compensated. So the trunk settles where the tensions are equal.
Light rotors do so within a second: the amplitude falls to zero meanwhile, and where they then rest is the zero.

With the gears of STS servos that takes half a minute, and where each drum stops at the end is left to chance by some
tenths of a newton, each of which holds the trunk 1.5 mm aside. Neither is waited for. The amplitude is kept, and the
mean pulls p of whole cycles follow p_i(t) = z_i + c_i exp(-t / tau), with one time constant for all cables, as the
hanging trunk bends alike in every direction. The limits z_i are fitted by least squares, and are the zeros.
Pure functions; nothing here was tried on a real motor.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.winder.winder import Winder

STIR, STIR_GEARED = 4.0, 8.0
"""Amplitude over the dry friction, of light rotors and of geared ones [-] (ours: the true one may be twice that)."""

STIR_LENGTH, STIR_LENGTH_GEARED = 2.5e-3, 3.5e-3
"""Motion to and fro of a cable without load, likewise [m] (ours)."""

FADE_TIME = 5.0
"""Time in which the amplitude falls to zero, at once with light rotors [s] (ours)."""

GEARED = 8.0
"""Dry friction at the drum from which the zero is fitted [N] (ours: 4 of a GM6020, 15 of an STS3215)."""

STIR_TIME = 20.0
"""Time of stirring where the zero is fitted [s] (ours)."""

LEFT_MOST = 5e-3
"""Length to its zero from which a cable counts as unsettled after that time [m] (ours): something moves it."""

WINDOW = 1.0
"""Time of the cycles over which one mean is taken [s] (ours)."""

_LONGEST = 1.5
"""Largest time constant over the time of stirring [-] (ours: a longer one could not be told from a drift)."""

_CONSTANTS = 60
"""Time constants that are tried [-]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Stirring:
    """Stirring of all cables."""

    elapsed: float = 0.0
    """Time since it began [s]."""
    share: float = 1.0
    """Amplitude over that at the start, 1 to 0 [-]."""
    sums: tuple[float, ...] = ()
    """Sum of the pulls in the present window, one per cable [m]."""
    count: int = 0
    """Periods of control in the present window [-]."""
    means: tuple[tuple[float, ...], ...] = ()
    """Mean pulls of the windows before, one per cable [m]."""
    zeros: tuple[float, ...] = ()
    """Pulls at the straight trunk [m], once they are known."""

    @property
    def is_over(self) -> bool:
        """Whether the zeros are known and the amplitude is zero."""
        return bool(self.zeros) and self.share <= 0.0

    @property
    def is_unsettled(self) -> bool:
        """Whether no zeros were found in that time."""
        return not self.zeros and self.elapsed > STIR_TIME + 2.0 * WINDOW


def step_stirring(winder: Winder, before: Stirring, pulls: Sequence[float], dt: float) -> Stirring:
    """Take in the pulls [m] of one period of control ``dt`` [s]."""
    after = replace(before, elapsed=before.elapsed + dt)
    if before.zeros:
        return replace(after, share=before.share - dt / FADE_TIME)
    if not _is_geared(winder):
        share = 1.0 - after.elapsed / FADE_TIME
        return replace(after, share=share, zeros=() if share > 0.0 else tuple(pulls))
    sums = tuple(old + new for old, new in zip(before.sums or (0.0,) * len(pulls), pulls, strict=True))
    after = replace(after, sums=sums, count=before.count + 1)
    if after.count * dt < _find_window(winder) - dt / 2:
        return after
    means = (*before.means, tuple(one / after.count for one in sums))
    after = replace(after, sums=(), count=0, means=means)
    if after.elapsed < STIR_TIME:
        return after
    zeros, left = fit_settling(means[1:])
    return replace(after, zeros=zeros) if max(map(abs, left)) < LEFT_MOST else after


def compute_torque(winder: Winder, stirring: Stirring, radius: float, tension: float, phase: float) -> float:
    """Torque of the tension [N] at this radius [m] and of the alternating part with this phase [rad] [N m]."""
    turn = 2 * math.pi * stirring.elapsed / _find_period(winder) + phase
    torque = tension * radius + max(0.0, stirring.share) * _find_stir(winder) * winder.friction * math.sin(turn)
    return min(max(torque, -winder.limits.torque_max), winder.limits.torque_max)


def fit_settling(means: Sequence[Sequence[float]]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Limits of values that settle exponentially, and what is left to them at the last one.

    The time constants are tried, up to `_LONGEST` times the time; to each one the best limits belong in closed form.

    Args:
        means: values at equal times, shape (n_time, n_cable); two times or more.
    """
    values = np.asarray(means, float)
    time = np.arange(len(values), dtype=float)
    middle = values.mean(axis=0)
    best, least = (middle, 0.0 * middle), math.inf
    for constant in np.geomspace(0.3, max(0.6, _LONGEST * len(values)), _CONSTANTS):
        decay = np.exp(-time / constant)
        about = decay - decay.mean()
        amplitude = about @ (values - middle) / (about @ about)
        error = float(((values - middle - np.outer(about, amplitude)) ** 2).sum())
        if error < least:
            limit = middle - amplitude * decay.mean()
            best, least = (limit, limit - values[-1]), error
    limit, left = best
    return tuple(limit.tolist()), tuple(left.tolist())


def _is_geared(winder: Winder) -> bool:
    return winder.friction >= GEARED * winder.drum.design.winding_radius


def _find_stir(winder: Winder) -> float:
    """Amplitude over the dry friction [-]."""
    return STIR_GEARED if _is_geared(winder) else STIR


def _find_period(winder: Winder) -> float:
    """Period of the alternating part [s].

    A torque A beyond the friction drives a free rotor to and fro by about A t^2 / (32 J) with the period t.
    """
    length = STIR_LENGTH_GEARED if _is_geared(winder) else STIR_LENGTH
    excess = max((_find_stir(winder) - 1.0) * winder.friction * winder.drum.design.winding_radius, 1e-9)
    return math.sqrt(32.0 * length * winder.inertia / excess)


def _find_window(winder: Winder) -> float:
    """Time of whole cycles next to `WINDOW` [s]."""
    period = _find_period(winder)
    return max(1, round(WINDOW / period)) * period
