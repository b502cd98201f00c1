"""Sensing without a camera: load and contact from the arm's torques and the cables' lengths."""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.control.messages import Observation
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import TrunkDesign, ventral_cables
from spiraltrunk.errors import ModelError

LAG = 5.0
"""Tension below the commanded one of a cable that is held back by its bound [N] (ours): 17 N on the twin of a robot."""


def find_ventral(design: TrunkDesign) -> np.ndarray:
    """Which cables pull ventral, shape (n_cable,).

    Raises:
        ModelError: where none does.
    """
    ventral = ventral_cables(design)
    if not ventral.any():
        raise ModelError("no cable pulls ventral; allowed: a design with a cable more than 90 deg from dorsal")
    return ventral


def base_directions(observation: Observation) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors along the trunk's base (down, where it hangs) and to its ventral side, in the world, each (3,)."""
    return observation.T_world_base[:3, 0], -observation.T_world_base[:3, 1]


def seen_position(observation: Observation) -> np.ndarray:
    """Position of the object by the camera, or the announced one where no camera looks, shape (3,) [m]."""
    return observation.task.target.position if observation.camera is None else observation.camera.position


def limit_ventral_lead(observation: Observation, lead: float, wanted: np.ndarray | None = None) -> np.ndarray:
    """Upper bounds of the cable pulls that keep the ventral cables together, shape (n_cable,) [m].

    No ventral cable may lead the least pulled one by more than ``lead`` times the cable stroke [-]. A real winder slows
    down before a bound. Where that is the lag of the least pulled cable, which has a tension by more than `LAG` below
    its ``wanted`` one, shape (n_cable,) [N], cables that lead by less than half of that lead have no bound.
    """
    design = observation.task.design
    ventral = ventral_cables(design)
    bound, pull = np.full(ventral.shape, np.inf), np.where(ventral, observation.cable_pull, np.inf)
    last, most = int(pull.argmin()), lead * design.cable_stroke
    bound[ventral] = pull[last] + most
    if wanted is not None and wanted[last] - observation.cable_tension[last] > LAG:
        bound[pull - pull[last] < most / 2] = np.inf
    return bound


def weight(observation: Observation) -> float:
    """Weight of the trunk and of its load [N]."""
    return -float(observation.base_force[2])


def load_fraction(observation: Observation, weight: float, weight_empty: float) -> float:
    """Measured load over the object's announced weight [-], from weights with and without the load [N]."""
    return (weight - weight_empty) / (observation.task.target.mass * GRAVITY)


def lever(observation: Observation) -> float:
    """Offset of the load from the base along the object's axis [m].

    A force f at r about the base has the torque t = r x f; for an axis a square to f, a . r = a . (f x t) / |f|^2.
    """
    fx, fy, fz = observation.base_force.tolist()
    tx, ty, tz = observation.base_torque.tolist()
    ax, ay, az = observation.task.target.axis.tolist()
    triple = ax * (fy * tz - fz * ty) + ay * (fz * tx - fx * tz) + az * (fx * ty - fy * tx)
    return float(triple / max(fx**2 + fy**2 + fz**2, 1e-6))


def ventral_pull(observation: Observation) -> float:
    """Mean pull of the ventral cables since the straight trunk [m]."""
    return float(observation.cable_pull[ventral_cables(observation.task.design)].mean())


def measure_lean(observation: Observation) -> float:
    """Mean pull of the dorsal cables minus that of the ventral ones [m]: it grows as something bends the trunk back."""
    direction, pull = observation.task.design.cable_direction[:, 1], observation.cable_pull
    return float(pull[direction > 0].mean() - pull[direction < 0].mean())


def ventral_tension(observation: Observation) -> float:
    """Mean tension of the ventral cables [N]."""
    return float(observation.cable_tension[ventral_cables(observation.task.design)].mean())


def tipping_displacement(length: float, width: float, height: float, offset: float = math.inf) -> float:
    """Horizontal displacement of an object's centre while it tips flat about the end that touched first [m].

    A rectangle of half length l and half width r is tilted by t on its low corner: its centre is l sin t + r cos t
    above the table and l cos t - r sin t beside the corner. Flat, it is r above and l beside. The heights give the
    tilt, and the tilt the displacement l - l cos t + r sin t; it is 0 at the level height or lower. A loaded trunk
    sags, so that wide objects seem to touch higher than any tilt allows: the offset of the centre then bounds the tilt,
    at most r sin t.

    Args:
        length: extent along the object's axis [m].
        width: extent across [m].
        height: height of the centre at touch-down above that of a level object [m].
        offset: horizontal distance of the centre from what carries it [m].
    """
    half, radius = length / 2, width / 2
    sine = min(1.0, (height + radius) / math.hypot(half, radius))
    tilt = math.asin(max(0.0, sine)) - math.atan2(radius, half)
    if sine == 1.0:
        tilt = min(tilt, math.asin(min(1.0, abs(offset) / radius)))
    return half - half * math.cos(tilt) + radius * math.sin(tilt) if tilt > 0 else 0.0
