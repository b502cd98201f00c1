"""Simulation: MuJoCo models of trunk, arm and objects, and the simulated plant."""

from spiraltrunk.sim.objects.catalogue import ObjectSpec, parse_object
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.robot.arm import arm_spec
from spiraltrunk.sim.robot.trunk import TrunkOptions, trunk_spec
from spiraltrunk.sim.scene.build import build_model
from spiraltrunk.sim.scene.options import SceneOptions

__all__ = [
    "ObjectSpec",
    "SceneOptions",
    "SimPlant",
    "TrunkOptions",
    "arm_spec",
    "build_model",
    "parse_object",
    "trunk_spec",
]
