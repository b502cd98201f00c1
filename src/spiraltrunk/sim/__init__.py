"""How the robot moves: MuJoCo models of trunk, arm and objects, and the plant over them."""

from spiraltrunk.sim.arm_spec import arm_spec
from spiraltrunk.sim.objects import ObjectSpec, parse_object
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.scene import SceneOptions, build_model
from spiraltrunk.sim.trunk_spec import TrunkOptions, trunk_spec

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
