"""Motion of a winder in one step."""

from __future__ import annotations

import math
from typing import NamedTuple, final

MOST_PERIODS = 3.0
"""A late step is taken as this many periods at most, so that lateness makes no jump [-] (ours)."""


@final
class Motion(NamedTuple):
    """Where the winder is, and how it moves."""

    pull: float
    """Cable pulled in since the straight trunk [m]."""
    speed: float
    """Its rate [m/s]."""
    radius: float
    """Radius of the drum there [m]."""
    mass: float
    """J / r^2 [kg]."""
    dt: float
    """Step [s]."""
    is_turning: bool
    """Whether the motor turns, as far as its encoder resolves that."""


def low_pass(exponent: float) -> float:
    """Share of the way that a first-order low-pass goes in a step of ``exponent`` time constants [-]."""
    return -math.expm1(-exponent)
