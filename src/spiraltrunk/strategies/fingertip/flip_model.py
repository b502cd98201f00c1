"""Planning model of the distal flip: tension and pull of the ventral cables for a turn of the trunk's tip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.optimize import brentq

from spiraltrunk.checks import check_number
from spiraltrunk.design.trunk import TrunkDesign, ventral_cables
from spiraltrunk.errors import ModelError
from spiraltrunk.model import statics
from spiraltrunk.model.kinematics.shape import Shape
from spiraltrunk.model.statics.loads import Loads
from spiraltrunk.model.statics.pull_sequences import carry_gripper

_CLOSE = 0.01
"""Tolerance of the tension [N]."""


@final
@dataclass(frozen=True, kw_only=True)
class Flip:
    """The hanging trunk, curled from its tip by its ventral cables alone."""

    tension: np.ndarray
    """Tension of the cables, 0 for those that do not pull ventral, shape (n_cable,) [N]."""
    pull: np.ndarray
    """Cable pulled in since the straight trunk, negative where paid out, shape (n_cable,) [m]."""
    bend: np.ndarray
    """Bend of each joint, shape (n_joint,) [rad]."""


def find_flip(design: TrunkDesign, mass: float, turn: float) -> Flip:
    """The curl in which the tip, ``mass`` [kg] in its gripper, has turned by ``turn`` [rad] from hanging.

    Raises:
        ModelError: where no cable pulls ventral, or none pulls hard enough.
    """
    check_number("turn", turn, above=0.0)
    ventral, trunk = ventral_cables(design).astype(float), carry_gripper(design)
    if not ventral.any():
        raise ModelError("no cable pulls ventral; allowed: a design with a cable more than 90 deg from dorsal")

    def shape(tension: float) -> Shape:
        return statics.solve(trunk, tension=tension * ventral, loads=Loads(mass=mass), friction=0.0)

    def lack(tension: float) -> float:
        return turn - float(shape(tension).joint_angle.sum())

    most = design.cable.tension_max
    if lack(most) > 0:
        widest = float(np.degrees(turn - lack(most)))
        raise ModelError(
            f"the tip turns by {widest:.0f} deg at {most:g} N, not by {np.degrees(turn):.0f}; try a lighter object"
        )
    tension = float(brentq(lack, 0.0, most, xtol=_CLOSE))
    found = shape(tension)
    return Flip(tension=tension * ventral, pull=found.cable_change, bend=found.joint_angle)
