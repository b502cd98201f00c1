"""Height of the ground of a trial: the usual one, or a lower one where the arm would not reach high enough over it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from spiraltrunk.control.strategy import Strategy
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.sim.robot.arm_ik import ArmReach
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.sim.scene.options import SceneOptions

GROUNDS = (0.60, 0.45, 0.30)
"""Heights of the ground, the usual first, each tried where the arm does not reach over the one before [m] (ours)."""

MARGIN = 0.03
"""Height above the highest planned base that the arm must reach too [m] (ours): near its limit the arm is all but
straight, and the felt weight swings by newtons."""

_REACHED, _STEP, _STEPS = 0.002, 0.1, 150
"""Distance at which a frame counts as reached [m]; period [s] and number of the steps of the inverse kinematics."""


def choose_ground(design: TrunkDesign, options: SceneOptions, strategy: Strategy[Any]) -> SceneOptions:
    """The scene with the first of `GROUNDS` over which the arm carries as high as the strategy plans.

    A scene without a ground, or with another than the usual one, stays as it is, as does one for a strategy that tells
    no height.

    Raises:
        ModelError: where the arm reaches high enough over none of them, or the strategy cannot plan for the object.
    """
    if options.support != "ground" or options.ground != GROUNDS[0]:
        return options
    arm, tops = None, []
    for ground in GROUNDS:
        tried = replace(options, ground=ground)
        task = build_task(design, tried)
        top = strategy.highest_base(task)
        if top is None:
            return options
        arm = ArmReach(design) if arm is None else arm
        places = (task.target.position, task.target.position + task.goal.aside)
        reach = min(_find_reach(arm, place, top + MARGIN) for place in places)
        if reach >= top + MARGIN - _REACHED:
            return tried
        tops.append(top - reach + MARGIN)
    raise ModelError(
        f"the base is {1e2 * tops[-1]:.0f} cm beyond the arm's reach when the object is lifted, over a ground of "
        f"{GROUNDS[-1]:g} m; allowed: lower objects or shorter fingers"
    )


def _find_reach(arm: ArmReach, place: np.ndarray, height: float) -> float:
    """Height that the hanging trunk's base reaches over ``place``, shape (3,) [m], on the way to ``height`` [m]."""
    q = arm.home
    frame = arm.T_base(q)
    frame[:3, 3] = place[0], place[1], height
    for _ in range(_STEPS):
        before, q = q, arm.follow(q, frame, _STEP)
        if np.array_equal(q, before):
            break
    return height - float(np.linalg.norm(arm.T_base(q)[:3, 3] - frame[:3, 3]))
