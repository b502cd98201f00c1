"""The ground for a strategy or a choice of strategies, and rankings of an object without a trial."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from spiraltrunk.control.messages import Task
from spiraltrunk.control.strategy import Strategy
from spiraltrunk.design import presets
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.sim.objects.catalogue import ObjectSpec
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.robot.arm_ik import ArmReach
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.sim.sensors import SensorOptions
from spiraltrunk.workflows.grasp.choice.auto import Auto, find_orientation
from spiraltrunk.workflows.grasp.choice.choose import STAGES, Candidate
from spiraltrunk.workflows.grasp.choice.ground import choose_ground, list_grounds
from spiraltrunk.workflows.grasp.world import Spread, draw_scene

_AS_ANNOUNCED = Spread(position=0.0, yaw=0.0, size=0.0, mass=0.0, friction=(0.8, 0.8), sensors=SensorOptions())


def rank_object(design: TrunkDesign, shape: ObjectSpec, stage: str = "ground") -> tuple[Candidate, ...]:
    """Candidates for an object on a stage that is as announced: the feasible ones by score, then the others.

    Raises:
        UnknownName: for a stage that does not exist.
    """
    auto = Auto(design, stage, find_orientation(shape))
    scene = set_ground(design, draw_scene(shape, 0, strategy=auto, spread=_AS_ANNOUNCED), auto)
    plant = SimPlant(design, replace(scene, trunk=replace(scene.trunk, stiffness_factor=1.0)))
    return auto.init(plant.reset()).candidates


def announce_task(design: TrunkDesign, shape: ObjectSpec, strategy: Strategy[Any]) -> Task:
    """The task of a strategy with an object that is as announced."""
    return build_task(design, draw_scene(shape, 0, strategy=strategy, spread=_AS_ANNOUNCED))


def set_ground(design: TrunkDesign, options: SceneOptions, strategy: Strategy[Any]) -> SceneOptions:
    """The scene with a ground over which the arm reaches high enough: `choose_ground`.

    A choice among strategies has the ground over which its best candidate scores highest: a lower ground brings the
    fingers into reach over tall objects and puts the standing wraps out of reach.

    Raises:
        ModelError: where the arm reaches high enough over none, or the strategy cannot plan for the object.
    """
    if not isinstance(strategy, Auto):
        return choose_ground(design, options, strategy)
    try:
        if choose_ground(design, options, strategy) is options:
            return options  # All candidates reach over the usual ground, or the scene has its own.
    except ModelError:
        pass  # The arm reaches for all of them over none of the grounds: the ranking tells for which it does.
    scenes = (_over(options, ground) for ground in list_grounds(design, ArmReach(design)))
    return max(scenes, key=lambda scene: _value(design, scene, strategy))


def _over(options: SceneOptions, ground: float) -> SceneOptions:
    return options if ground == options.ground else replace(options, ground=ground)


def _value(design: TrunkDesign, options: SceneOptions, auto: Auto) -> tuple[float, int]:
    """Highest score of the candidates in a scene, and how many are feasible [-]."""
    candidates = auto.init(SimPlant(design, options).reset()).candidates
    return max((each.score for each in candidates), default=0.0), sum(each.feasible for each in candidates)


def find_able(design: TrunkDesign, shape: ObjectSpec) -> tuple[str, ...]:
    """Names of the strategies that can take an object on one of the stages, by their models."""
    found = [each for stage in STAGES for each in rank_object(design, shape, stage) if each.feasible]
    return tuple(each.strategy for each in sorted(found, key=lambda each: -each.score))


def find_alternatives(design: TrunkDesign, shape: ObjectSpec, stage: str) -> dict[str, str]:
    """The best strategy on the other stage, and with larger fingers on the ground, by the option that asks for it."""
    tried = {f"--stage {other}": (design, other) for other in STAGES if other != stage}
    if design == presets.PAPER:
        tried["--design paper-large-grip"] = (presets.get("paper-large-grip"), "ground")
    best = {option: rank_object(robot, shape, where)[0] for option, (robot, where) in tried.items()}
    return {option: each.strategy for option, each in best.items() if each.feasible}
