"""What a robot without eyes knows of what it holds: from the arm's torques, its posture, and the cables' lengths."""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.control.messages import Observation
from spiraltrunk.design.trunk import ventral_cables


def in_step(observation: Observation, lead: float) -> np.ndarray:
    """Longest pulls that keep the ventral cables together, shape (n_cable,) [m]; the others are free."""
    design = observation.task.design
    ventral = ventral_cables(design)
    bound = np.full(ventral.shape, np.inf)
    bound[ventral] = observation.cable_pull[ventral].min() + lead * design.cable_stroke
    return bound


def weight(observation: Observation) -> float:
    """What hangs on the trunk's base, the trunk included [N]."""
    return -float(observation.base_force[2])


def lever(observation: Observation) -> float:
    """Distance along the object's axis at which a force alone would explain force and torque on the base [m]."""
    fx, fy, fz = observation.base_force.tolist()
    tx, ty, tz = observation.base_torque.tolist()
    ax, ay, az = observation.task.target.axis.tolist()
    triple = ax * (fy * tz - fz * ty) + ay * (fz * tx - fx * tz) + az * (fx * ty - fy * tx)
    return float(triple / max(fx**2 + fy**2 + fz**2, 1e-6))


def ventral_pull(observation: Observation) -> float:
    """Mean pull of the ventral cables since the straight trunk [m]."""
    return float(observation.cable_pull[ventral_cables(observation.task.design)].mean())


def ventral_tension(observation: Observation) -> float:
    """Mean tension of the ventral cables [N]."""
    return float(observation.cable_tension[ventral_cables(observation.task.design)].mean())


def way_to_turn_flat(length: float, width: float, height: float, beside: float = math.inf) -> float:
    """How far an object's centre moves along while it turns flat about the end that touched first [m].

    Plane geometry of a rectangle, half length l and half width r. Tilted by t on its low corner, its centre stands
    l sin t + r cos t above the table and l cos t - r sin t beside the corner; flat, r above and l beside. The heights
    give the tilt, and the tilt the way; 0 where it touched level or lower than expected. A loaded trunk sags, so that
    wide objects seem to touch higher than with a corner below their centre. Such heights tell nothing; but what tilts
    on a loop below it hangs beside that loop by r sin t, and is tilted by no more than that.

    Args:
        length: extent along its axis [m].
        width: extent across [m].
        height: how much higher than a level object its centre was when it touched [m].
        beside: how far its centre hung beside what carries it [m].
    """
    half, radius = length / 2, width / 2
    sine = min(1.0, (height + radius) / math.hypot(half, radius))
    tilt = math.asin(max(0.0, sine)) - math.atan2(radius, half)
    if sine == 1.0:
        tilt = min(tilt, math.asin(min(1.0, abs(beside) / radius)))
    return half - half * math.cos(tilt) + radius * math.sin(tilt) if tilt > 0 else 0.0
