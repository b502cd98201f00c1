"""The ground for a strategy or a choice of strategies, and rankings of an object without a trial."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from spiraltrunk.control.strategy import Strategy
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.sim.objects.catalogue import ObjectSpec
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.sim.sensors import SensorOptions
from spiraltrunk.workflows.grasp.auto import Auto, find_orientation
from spiraltrunk.workflows.grasp.choose import STAGES, Candidate
from spiraltrunk.workflows.grasp.ground import choose_ground
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


def set_ground(design: TrunkDesign, options: SceneOptions, strategy: Strategy[Any]) -> SceneOptions:
    """The scene with a ground over which the arm reaches high enough: `choose_ground`.

    A choice among strategies stays over the usual ground where the arm reaches high enough over none: its ranking says
    which of them are out of reach.

    Raises:
        ModelError: where the arm reaches high enough over none, or the strategy cannot plan for the object.
    """
    try:
        return choose_ground(design, options, strategy)
    except ModelError:
        if isinstance(strategy, Auto):
            return options
        raise


def find_able(design: TrunkDesign, shape: ObjectSpec) -> tuple[str, ...]:
    """Names of the strategies that can take an object on one of the stages, by their models."""
    found = [each for stage in STAGES for each in rank_object(design, shape, stage) if each.feasible]
    return tuple(each.strategy for each in sorted(found, key=lambda each: -each.score))
