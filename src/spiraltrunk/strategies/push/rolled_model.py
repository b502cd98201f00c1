"""The trunk rolled up as far as it goes, as a fist that pushes: where its front is, and how low it lies.

Every joint stands at its ventral limit, which is the spiral itself. Pushed on its front, the roll cannot close further;
it opens only where the push's moment exceeds what the cables hold beyond the elastic joints' moment. The base is tilted
towards the push, and rolled until the plane of the curl lies as flat as the tilt allows, so that the front is low.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.checks import check_number
from spiraltrunk.design.trunk import TrunkDesign


@final
@dataclass(frozen=True, kw_only=True)
class Fist:
    """Where a rolled-up trunk touches what it pushes, from its base."""

    forward: float
    """How far the front lies ahead of the base, in the direction of the push [m]."""
    lateral: float
    """How far the front lies beside the base, to the ventral side [m]."""
    below: float
    """How far the front's middle lies below the base [m]."""
    bottom: float
    """How far the lowest point lies below the base [m]."""
    radius: float
    """Radius of the section in front [m]."""
    curve: float
    """Radius of the front seen from above, about which it turns away to both sides [m]."""


def predict_fist(design: TrunkDesign, tilt: float) -> Fist:
    """The rolled-up trunk, its base tilted by ``tilt`` from hanging towards the push and its curl sideways.

    A section's surface is a cylinder about its axis; the one whose surface reaches farthest ahead is the front.
    """
    check_number("tilt", tilt, least=0.0, below=math.pi)
    down, aside = _section_middles(design)
    ahead = down * math.sin(tilt) + design.section_radius
    front = int(np.argmax(ahead))
    below = down * math.cos(tilt)
    return Fist(
        forward=float(ahead[front]),
        lateral=float(aside[front]),
        below=float(below[front]),
        bottom=float(np.max(below + design.section_radius)),
        radius=float(design.section_radius[front]),
        curve=_curve(design, ahead, aside, front),
    )


def fist_orientation(way: np.ndarray, tilt: float) -> np.ndarray:
    """Orientation of the base for a push along the horizontal unit vector ``way``, shape (3, 3) [-].

    The trunk's axis x points down and ahead; ventral, -y, points level to the right of the push.
    """
    ahead = np.array([way[0], way[1], 0.0])
    along = math.sin(tilt) * ahead - np.array([0.0, 0.0, math.cos(tilt)])
    dorsal = np.array([-way[1], way[0], 0.0])
    return np.stack([along, dorsal, np.cross(along, dorsal)], axis=1)


def _section_middles(design: TrunkDesign) -> tuple[np.ndarray, np.ndarray]:
    """Middles of the sections along the base's axis and to the ventral side, two of shape (n_section,) [m]."""
    angle = design.joint_limit * np.arange(design.n_section)
    steps = design.section_length * np.exp(1j * angle)
    middles = np.cumsum(steps) - steps / 2
    return middles.real, middles.imag


def _curve(design: TrunkDesign, ahead: np.ndarray, aside: np.ndarray, front: int) -> float:
    """Radius of the circle through the front and its neighbours' foremost points, seen from above [m]."""
    i = min(max(front, 1), design.n_section - 2)
    a, b, c = (complex(aside[j], ahead[j]) for j in (i - 1, i, i + 1))
    area = ((b - a) * (c - a).conjugate()).imag / 2
    return abs(a - b) * abs(b - c) * abs(c - a) / max(4 * abs(area), 1e-9)
