"""The rolled trunk, curled as far as it goes, as a pusher: position of its front and its height.

Every joint is at its ventral limit, which is the spiral itself. Pushed on its front, the roll opens only where the
push's moment exceeds what the cables hold beyond the elastic joints' moment. The base is tilted towards the push, and
turned about its axis until the plane of the curl is as flat as the tilt allows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign


@final
@dataclass(frozen=True, kw_only=True)
class RolledTrunk:
    """Where a rolled trunk touches what it pushes, from its base."""

    forward: float
    """Distance of the front ahead of the base, in the direction of the push [m]."""
    lateral: float
    """Distance of the front beside the base, to the ventral side [m]."""
    below: float
    """Depth of the front's middle below the base [m]."""
    bottom: float
    """Depth of the lowest point below the base [m]."""
    radius: float
    """Radius of the section in front [m]."""
    curve: float
    """Radius of curvature of the front seen from above [m]."""


def predict_rolled_trunk(design: TrunkDesign, tilt: float) -> RolledTrunk:
    """The rolled trunk, its base tilted by ``tilt`` [rad] from hanging towards the push, its curl sideways.

    A section's surface is a cylinder about its axis; the section whose surface reaches farthest ahead is the front.
    """
    down, aside = _section_middles(design)
    ahead = down * math.sin(tilt) + design.section_radius
    front = int(np.argmax(ahead))
    below = down * math.cos(tilt)
    return RolledTrunk(
        forward=float(ahead[front]),
        lateral=float(aside[front]),
        below=float(below[front]),
        bottom=float(np.max(below + design.section_radius)),
        radius=float(design.section_radius[front]),
        curve=_curvature_radius(design, ahead, aside, front),
    )


def _section_middles(design: TrunkDesign) -> tuple[np.ndarray, np.ndarray]:
    """Middles of the sections along the base's axis and to the ventral side, two of shape (n_section,) [m]."""
    angle = design.joint_limit * np.arange(design.n_section)
    steps = design.section_length * np.exp(1j * angle)
    middles = np.cumsum(steps) - steps / 2
    return middles.real, middles.imag


def _curvature_radius(design: TrunkDesign, ahead: np.ndarray, aside: np.ndarray, front: int) -> float:
    """Radius of the front seen from above: of the circle through three foremost points, a b c / (4 area) [m]."""
    i = min(max(front, 1), design.n_section - 2)
    a, b, c = (complex(aside[j], ahead[j]) for j in (i - 1, i, i + 1))
    area = ((b - a) * (c - a).conjugate()).imag / 2
    return abs(a - b) * abs(b - c) * abs(c - a) / max(4 * abs(area), 1e-9)
