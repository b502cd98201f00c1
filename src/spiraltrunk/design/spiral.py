"""The logarithmic spiral r = a exp(b theta) in closed form.

Source: Huang et al., "Grasping by Spiraling", npj Robotics 2025, equations 1 and 2. The paper draws it as
x = -r cos(theta), y = r sin(theta); so do we.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.checks import check_number
from spiraltrunk.field_docs import explain_fields


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Spiral:
    """Logarithmic spiral r = a exp(b theta)."""

    a: float
    """Radius at theta = 0 [m] (paper, equation 1)."""
    b: float
    """Growth per radian [-] (paper, equation 1)."""

    def __post_init__(self) -> None:
        check_number("spiral.a", self.a, above=0.0, below=1e3)
        check_number("spiral.b", self.b, above=0.0, below=2.0)


def radius(spiral: Spiral, theta: ArrayLike) -> np.ndarray:
    """Distance from the pole at angles ``theta`` [rad], shape of ``theta`` [m]."""
    return spiral.a * np.exp(spiral.b * np.asarray(theta, float))


def points(spiral: Spiral, theta: ArrayLike) -> np.ndarray:
    """Points (-r cos, r sin) of the curve at ``theta`` [rad], shape (..., 2) [m] (paper, equation 2)."""
    theta = np.asarray(theta, float)
    return radius(spiral, theta)[..., None] * np.stack([-np.cos(theta), np.sin(theta)], axis=-1)


def arc_length(spiral: Spiral, theta_from: ArrayLike, theta_to: ArrayLike) -> np.ndarray:
    """Length of the curve from ``theta_from`` to ``theta_to`` [rad], signed, broadcast shape [m].

    It is sqrt(1 + b^2) / b times the difference of the two radii.
    """
    growth = np.sqrt(1.0 + spiral.b**2) / spiral.b
    return growth * (radius(spiral, theta_to) - radius(spiral, theta_from))


def chord(spiral: Spiral, theta_from: ArrayLike, theta_to: ArrayLike) -> np.ndarray:
    """Straight distance between two points of the curve, angles in [rad], broadcast shape [m]."""
    r_from, r_to = radius(spiral, theta_from), radius(spiral, theta_to)
    turn = np.asarray(theta_to, float) - np.asarray(theta_from, float)
    return np.sqrt((r_to - r_from) ** 2 + 4.0 * r_from * r_to * np.sin(turn / 2.0) ** 2)
