"""Height of the ground of a trial: the usual one, or a lower one.

It is lower where the hanging trunk would touch it at the start, or where the arm would not reach high enough over it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from spiraltrunk.checks import check_type
from spiraltrunk.control.strategy import Strategy
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.robot.arm_ik import ArmReach
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.workflows.grasp.choice.auto import Auto
from spiraltrunk.workflows.grasp.choice.candidates import Candidate
from spiraltrunk.workflows.grasp.choice.place import choose_place, place_for_wrap, place_hung

GROUNDS = (0.60, 0.45, 0.30)
"""Heights of the ground, the usual first, each tried where the arm does not reach over the one before [m] (ours)."""

LEAST_GROUND = 0.01
"""Least height of the ground above the floor [m] (ours)."""

MARGIN = 0.03
"""Height above the highest planned base that the arm must reach too [m] (ours): near its limit the arm is all but
straight, and the felt weight swings by newtons."""

START_GAP = 0.01
"""Gap between the ground and the straight fingers of the trunk at its start [m] (ours)."""

_REACHED, _STEP, _STEPS = 0.002, 0.1, 150
"""Distance at which a frame counts as reached [m]; period [s] and number of the steps of the inverse kinematics."""


def set_ground(design: TrunkDesign, options: SceneOptions, strategy: Strategy[Any]) -> SceneOptions:
    """The scene with the ground for a strategy (`choose_ground`), or for a choice among strategies.

    A hung object hangs clear of the trunk's start (`place_hung`).

    A choice among strategies takes the ground on which its best candidate scores highest: a lower ground brings tall
    objects into reach of the fingers, and takes the standing wraps out of the arm's reach. Where a wrap is to come to
    the object from its side, the object's place suits that (`place_for_wrap`).

    Raises:
        DesignError: for anything but a design.
        ModelError: where the arm reaches high enough over no ground, or the strategy cannot plan for the object.
    """
    check_type("design", design, TrunkDesign)
    if not isinstance(strategy, Auto):
        hangs = options.support == "hung"
        return place_hung(design, options, ArmReach(design)) if hangs else choose_ground(design, options, strategy)
    scenes = list_scenes(design, options, strategy)
    if len(scenes) == 1:
        return scenes[0]
    return max(scenes, key=lambda scene: compare_grounds(rank_scene(design, scene, strategy)))


def list_scenes(design: TrunkDesign, options: SceneOptions, auto: Auto) -> tuple[SceneOptions, ...]:
    """Scenes among which a choice takes the one with the best candidate, the usual ground first.

    There is one where all candidates reach over the usual ground, and where the ground is not to be chosen.
    """
    if options.support == "hung":
        return (place_hung(design, options, ArmReach(design)),)
    if not _is_usual(options):
        return (options,)
    options = place_for_wrap(design, options, auto)
    try:
        if choose_ground(design, options, auto) is options:
            return (options,)
    except ModelError:
        pass  # Over no ground does the arm reach high enough for all candidates; the ranking finds for which it does.
    return tuple(_with_ground(options, ground) for ground in list_grounds(design, ArmReach(design)))


def rank_scene(design: TrunkDesign, options: SceneOptions, auto: Auto) -> tuple[Candidate, ...]:
    """The candidates of a choice in a scene, before anything moves."""
    return auto.init(SimPlant(design, options).reset()).candidates


def compare_grounds(candidates: tuple[Candidate, ...]) -> tuple[float, int]:
    """What makes a ground better than another: the highest score [-], and the number of feasible candidates [-]."""
    return max((each.score for each in candidates), default=0.0), sum(each.feasible for each in candidates)


def choose_ground(design: TrunkDesign, options: SceneOptions, strategy: Strategy[Any]) -> SceneOptions:
    """The scene with the first of `list_grounds` over which the arm reaches the strategy's highest base.

    A strategy that plans no height of the base gets the first of all, and `choose_place` chooses the object's place. A
    scene without a ground, or with another ground than the usual one, is returned as it is.

    Raises:
        ModelError: where the arm reaches high enough over none of them, or the strategy cannot plan for the object.
    """
    if not _is_usual(options):
        return options
    arm, tops = ArmReach(design), []
    grounds = list_grounds(design, arm)
    for ground in grounds:
        tried = _with_ground(options, ground)
        task = strategy.grasp_task(build_task(design, tried))
        top = strategy.highest_base(task)
        if top is None:
            return choose_place(design, tried, strategy, arm)
        places = (task.target.position, task.target.position + task.goal.aside)
        reach = min(_find_reach(arm, place, top + MARGIN) for place in places)
        if reach >= top + MARGIN - _REACHED:
            return tried
        tops.append(top - reach + MARGIN)
    raise ModelError(
        f"the base is {1e2 * tops[-1]:.0f} cm beyond the arm's reach when the object is lifted, over a ground of "
        f"{grounds[-1]:g} m; allowed: lower objects or shorter fingers"
    )


def _is_usual(options: SceneOptions) -> bool:
    """Whether a scene has the usual ground: not another one of its own, and no strings."""
    return options.support == "ground" and options.ground == GROUNDS[0]


def list_grounds(design: TrunkDesign, arm: ArmReach) -> tuple[float, ...]:
    """`GROUNDS`, each lowered where the trunk that hangs at the start would touch it [m].

    Raises:
        ModelError: where it would touch the floor.
    """
    long = design.length + (0.0 if design.gripper is None else design.gripper.finger_length)
    base = float(arm.T_base(arm.home)[2, 3])
    most = base - long - START_GAP
    if most < LEAST_GROUND:
        allowed = f"up to {base - START_GAP - LEAST_GROUND:.2f} m, to hang above a ground at the start"
        raise ModelError(f"trunk and fingers are {long:.3g} m long; allowed: {allowed}")
    return tuple(dict.fromkeys(min(ground, most) for ground in GROUNDS))


def _find_reach(arm: ArmReach, place: np.ndarray, height: float) -> float:
    """Height that the hanging trunk's base reaches over ``place``, shape (3,) [m], on the way to ``height`` [m]."""
    q = arm.home
    frame = arm.T_base(q)
    frame[:3, 3] = place[0], place[1], height
    for reached in arm.steps(q, frame, _STEP, _STEPS):
        before, q = q, reached
        if np.array_equal(q, before):
            break
    return height - float(np.linalg.norm(arm.T_base(q)[:3, 3] - frame[:3, 3]))


def _with_ground(options: SceneOptions, ground: float) -> SceneOptions:
    return options if ground == options.ground else replace(options, ground=ground)
