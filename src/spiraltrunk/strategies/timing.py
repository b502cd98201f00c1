"""Durations of moves, from their way, the speed that is wanted, and the sway of the hanging trunk.

The base moves along minimum-jerk paths. Over a way d in a time T their greatest speed is 15/8 d / T and their greatest
acceleration 10 / sqrt(3) d / T^2 (Flash and Hogan 1985).
"""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import TrunkDesign

PEAK_SPEED = 15 / 8
"""Greatest over mean speed of a minimum-jerk path [-]."""

PEAK_ACCELERATION = 10 / math.sqrt(3)
"""Greatest acceleration of a minimum-jerk path, times its time squared over its way [-]."""

# All of these are ours. The arm would bear more: at these it uses a third of its speed and a fifth of its acceleration.
SPEED = 0.4
"""Greatest speed of the base [m/s]."""
ACCELERATION = 1.2
"""Greatest acceleration of the base [m/s^2]: an eighth of gravity, by which the load of trunk and object varies."""
LEAST_TIME = 0.1
"""Least duration of a move [s]."""
SWAY_PERIODS = 1.7
"""Duration of a level move of the hanging trunk, over the period of its sway [-]: its tip then comes to rest with the
base, to 3 % of the way in simulation; to 10 % after 1.3 periods, and to 30 % after 1.1."""

LENGTH = 0.51
"""Length of the trunk up to which fixed durations of moves hold [m]: turning a wrap's head with it, the arm's joint 2
uses all but 2 % of its allowed speed."""


def stretch(design: TrunkDesign) -> float:
    """Factor of fixed durations for a trunk [-]: its length over LENGTH, at least 1; so much longer are its ways."""
    return max(1.0, design.length / LENGTH)


def travel_time(way: np.ndarray, *, speed: float = SPEED, acceleration: float = ACCELERATION) -> float:
    """Least duration of a minimum-jerk move along ``way``, shape (3,) [m], within speed and acceleration [s]."""
    distance = float(np.linalg.norm(way))
    return max(LEAST_TIME, PEAK_SPEED * distance / speed, math.sqrt(PEAK_ACCELERATION * distance / acceleration))


def sway_period(design: TrunkDesign, load: float = 0.0) -> float:
    """Period of the trunk that hangs straight from its base, with a ``load`` at its tip [kg] [s].

    A cone of mass m and length L on its broad end has its centre of mass at L / 4 and the moment of inertia m L^2 / 10:
    2 pi sqrt((0.1 m + M) / (0.25 m + M) L / g) with a mass M at the tip. The joints' stiffness shortens it a little:
    0.8 s simulated for 0.9 s without a load.
    """
    trunk = float(design.section_mass.sum())
    return 2 * math.pi * math.sqrt((0.1 * trunk + load) / (0.25 * trunk + load) * design.length / GRAVITY)


def still_time(design: TrunkDesign, way: np.ndarray, load: float = 0.0) -> float:
    """Least duration of a move along ``way``, shape (3,) [m], after which the hanging trunk does not sway [s].

    ``load`` is the mass of what it holds at its tip [kg].
    """
    return max(travel_time(way), SWAY_PERIODS * sway_period(design, load))
