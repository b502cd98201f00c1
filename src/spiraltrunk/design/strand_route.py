"""Route of the gripper's two cable groups through the trunk: along the axis where joints are hollow, else beside it.

A cable on the axis has a constant length and bends nothing. Beside a solid joint a cable at the distance a from the
axis bends it with the torque T a. Of two legs with half the tension each, on opposite sides of the axis, the torques
cancel in the straight trunk; T then reduces the joint's bending stiffness by about T a tan(delta_theta / 2) / 2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.checks import check_count, check_number
from spiraltrunk.design.trunk import TrunkDesign

BORE_RADIUS = 0.75e-3
"""Radius of the bore of a hollow joint [m] (ours: two cables of 0.5 mm with play)."""

WALL = 0.9e-3
"""Least wall of a hollow joint [m] (ours: two lines of a nozzle of 0.4 mm with their play)."""

LEG_GAP = 0.7e-3
"""Distance of a leg's middle from the surface of the thickest solid joint [m] (ours: hole and clearance)."""


@final
@dataclass(frozen=True, kw_only=True)
class StrandRoute:
    """Where the gripper's cables run."""

    first_solid: int
    """First joint that is solid, counted from 0 at the base; ``n_joint`` where all are hollow."""
    aside: float
    """Distance of the legs from the axis beside the solid joints [m]."""

    def __post_init__(self) -> None:
        check_count("route.first_solid", self.first_solid, least=0, most=1000)
        check_number("route.aside", self.aside, least=0.0, below=1.0)

    def leg_directions(self) -> np.ndarray:
        """Unit vectors (dorsal, lateral) to one leg of the closing and the opening group, shape (2, 2) [-].

        The other leg of each is on the opposite side of the axis.
        """
        half = math.sqrt(0.5)
        return np.array([[half, half], [-half, half]])


def find_strand_route(design: TrunkDesign) -> StrandRoute:
    """The route in a printed trunk with the default bore, wall and cable of the printed parts.

    A printed joint of outer radius R fills the gap between two faces, R (tan lean_proximal + tan lean_distal), and has
    the design's I / L: it has room for the bore where a tube of the least wall is no stiffer than that.
    """
    slope = math.tan(design.solid.lean_proximal) + math.tan(design.solid.lean_distal)
    wanted = slope * design.joint.radius**4 / design.joint.length * design.scale[:-1] ** 3
    least = BORE_RADIUS + WALL
    is_hollow = wanted >= (least**4 - BORE_RADIUS**4) / least
    first_solid = int(np.argmin(is_hollow)) if not is_hollow.all() else design.n_joint
    thickest = float(wanted[first_solid]) ** (1 / 3) if first_solid < design.n_joint else 0.0
    return StrandRoute(first_solid=first_solid, aside=thickest + LEG_GAP)
