"""Rankings of an object on a stage, without a trial."""

from __future__ import annotations

from dataclasses import replace

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.objects.catalogue import ObjectSpec
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.sensors import SensorOptions
from spiraltrunk.workflows.grasp.auto import Auto, find_orientation
from spiraltrunk.workflows.grasp.choose import STAGES, Candidate
from spiraltrunk.workflows.grasp.world import Spread, draw_scene

_AS_ANNOUNCED = Spread(position=0.0, yaw=0.0, size=0.0, mass=0.0, friction=(0.8, 0.8), sensors=SensorOptions())


def rank_object(design: TrunkDesign, shape: ObjectSpec, stage: str = "ground") -> tuple[Candidate, ...]:
    """Candidates for an object on a stage that is as announced: the feasible ones by score, then the others.

    Raises:
        UnknownName: for a stage that does not exist.
    """
    auto = Auto(design, stage, find_orientation(shape))
    scene = draw_scene(shape, 0, strategy=auto, spread=_AS_ANNOUNCED)
    plant = SimPlant(design, replace(scene, trunk=replace(scene.trunk, stiffness_factor=1.0)))
    return auto.init(plant.reset()).candidates


def find_able(design: TrunkDesign, shape: ObjectSpec) -> tuple[str, ...]:
    """Names of the strategies that can take an object on one of the stages, by their models."""
    found = [each for stage in STAGES for each in rank_object(design, shape, stage) if each.feasible]
    return tuple(each.strategy for each in sorted(found, key=lambda each: -each.score))
