"""Design of the robot: spiral, rules, trunk, gripper, files, presets."""

from spiraltrunk.design import presets
from spiraltrunk.design.gripper import GripperDesign
from spiraltrunk.design.mount import ArmDesign, HousingDesign
from spiraltrunk.design.parts import CableDesign, JointDesign, MassDesign
from spiraltrunk.design.rules import GraspableRange, design_from_rules, graspable_range, payload
from spiraltrunk.design.section import SectionSolid
from spiraltrunk.design.sizing import design_from_sizes
from spiraltrunk.design.spiral import Spiral
from spiraltrunk.design.toml import format_design, load_design, write_design
from spiraltrunk.design.trunk import TrunkDesign

__all__ = [
    "ArmDesign",
    "CableDesign",
    "GraspableRange",
    "GripperDesign",
    "HousingDesign",
    "JointDesign",
    "MassDesign",
    "SectionSolid",
    "Spiral",
    "TrunkDesign",
    "design_from_rules",
    "design_from_sizes",
    "format_design",
    "graspable_range",
    "load_design",
    "payload",
    "presets",
    "write_design",
]
