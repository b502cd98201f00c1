"""Place of a standing object: the usual one, or one further ahead where the arm would come near its limits.

The base of a trunk that wraps a standing object stands behind it, by more the longer the trunk is.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from spiraltrunk.control.messages import Observation, Task
from spiraltrunk.control.strategy import Strategy
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.robot.arm_ik import ArmReach
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.sim.scene.options import SceneOptions

AHEAD = (0.0, 0.05, 0.10, 0.15, 0.20)
"""Displacements of the object along the world's y, ahead of a standing wrap's base, in the order in which they are
tried [m] (ours)."""

MARGIN = np.radians(13.0)
"""Distance of every joint from the ends of its range, on the way of an object that stands where it is announced [rad]
(ours): the object's true place, 30 mm off, and the search for the touch take up to 12 deg of it."""

GEARING = 3.3
"""Largest share of its speed that a joint may use for 1 m/s of the base, on the same way [s/m] (ours): at 4.1, a curl
passed the arm's limit of acceleration. The paper's trunk needs 3.2."""

_PERIOD, _STEPS = 0.1, 60
"""Period [s] and largest number of steps of the inverse kinematics on the way from one frame to the next."""


def choose_place(design: TrunkDesign, options: SceneOptions, strategy: Strategy[Any], arm: ArmReach) -> SceneOptions:
    """The scene with the object at the first place at which the arm keeps `MARGIN` and `GEARING`, else at the best one.

    A scene for a strategy that tells no path of the base, or of an arm whose joints have no range, stays as it is.

    Raises:
        ModelError: where the strategy cannot plan for the object.
    """
    best, most = options, -np.inf
    for ahead in AHEAD:
        x, y, z = options.position
        tried = options if ahead == 0.0 else replace(options, position=(x, y + ahead, z))
        ease = _find_ease(design, tried, strategy, arm)
        if ease is None or ease >= 1.0:
            return tried
        if ease > most:
            best, most = tried, ease
    return best


def _find_ease(design: TrunkDesign, options: SceneOptions, strategy: Strategy[Any], arm: ArmReach) -> float | None:
    """Ease of the planned path for the arm: from 1 on it keeps `MARGIN` and `GEARING` [-]; None where none is known.

    Least distance of a joint from the ends of its range over `MARGIN`, or `GEARING` over the largest one, whichever is
    less.
    """
    path = strategy.base_path(_observe_start(strategy.grasp_task(build_task(design, options)), arm))
    if path is None or arm.limits.position is None:
        return None
    low, high = arm.limits.position
    q, ease = arm.home, np.inf
    for frame in path:
        for _ in range(_STEPS):
            before, q = q, arm.follow(q, frame, _PERIOD)
            margin = float(np.minimum(q - low, high - q).min())
            ease = min(ease, margin / MARGIN, GEARING / max(arm.find_gearing(q), 1e-9))
            if np.abs(q - before).max() < 1e-3:
                break
    return ease


def _observe_start(task: Task, arm: ArmReach) -> Observation:
    """What a robot at its start observes without a camera: the object is where it is announced."""
    none = np.zeros(task.design.n_cable)
    return Observation(
        time=0.0, task=task, T_world_base=arm.T_base(arm.home), arm_position=arm.home,
        arm_velocity=0.0 * arm.home, cable_pull=none, cable_tension=none, base_force=np.zeros(3),
        base_torque=np.zeros(3),
    )  # fmt: skip
