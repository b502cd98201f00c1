"""The world of a trial: floor, pedestal, arm, trunk, and an object, hung before a table or resting on the ground."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import final

import mujoco
import numpy as np

from spiraltrunk.checks import check_number, check_numbers, check_type
from spiraltrunk.control.messages import Goal, Target, Task
from spiraltrunk.design import presets
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, UnknownName, Words
from spiraltrunk.sim.arm_spec import arm_spec
from spiraltrunk.sim.materials import SOLIMP, SOLREF
from spiraltrunk.sim.objects import DEFAULT_OBJECT, ObjectSpec, parse_object
from spiraltrunk.sim.sensors import SensorOptions
from spiraltrunk.sim.stage import add_ground, add_hung_object, add_table
from spiraltrunk.sim.trunk_spec import TrunkOptions, add_trunk, tune_joint_limits

TIMESTEP = 1e-3
"""Step of the physics [s]."""

ARM = "arm/"
"""Prefix of every name of the arm."""

STAGES, STANCES = ("hung", "ground"), ("lying", "upright")
"""What an object may rest on, and how."""


@final
@dataclass(frozen=True, kw_only=True)
class SceneOptions:
    """One trial's world: what is known to the robot, and how the truth differs from it."""

    shape: ObjectSpec = field(default_factory=lambda: parse_object(DEFAULT_OBJECT))
    """The object as it truly is."""
    told: ObjectSpec | None = None
    """The object as the robot is told of it; None tells the truth."""
    stage: str = "hung"
    """What the object rests on: "hung" on two strings, or on the "ground"."""
    stance: str = "lying"
    """How it rests: "lying", its axis horizontal, or "upright"; what hangs, lies."""
    yaw: float = 0.0
    """Turn of its axis about the vertical from the world's x, as the robot is told [rad]."""
    yaw_error: float = 0.0
    """True turn minus the one that is told [rad]."""
    ground: float = 0.60
    """Height of the ground [m]: where arm and trunk reach it both from above and from the side."""
    position: tuple[float, float, float] = (0.45, 0.10, 0.85)
    """Nominal centre of the object, shape (3,) [m]; on the ground, its height follows from the object."""
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """True centre minus nominal, unknown to the robot, shape (3,) [m]."""
    aside: float = 0.20
    """Carry along y, not 0 [m]."""
    lift: float = 0.20
    """Height to lift by, above 0 [m]."""
    push: tuple[float, float] = (0.0, 0.0)
    """Way from where it lies on the ground to where it shall be pushed (x, y) [m]; none where it shall be lifted."""
    place_aside: float = 0.35
    """Distance of the table's middle along y from where the object hangs [m]: clear of the curling trunk."""
    place_rise: float = 0.08
    """Height of the place to set down above the object's start [m]; the strings stay slack there."""
    trunk: TrunkOptions = field(default_factory=TrunkOptions)
    """The trunk's simulation."""
    sensors: SensorOptions = field(default_factory=SensorOptions)
    """What the robot reads wrongly, and when."""
    friction_hardness: float = 1.0
    """How much harder friction is than the contact that it acts in [-]: what soft friction holds creeps out."""
    timestep: float = TIMESTEP
    """Step of the physics [s]."""

    def __post_init__(self) -> None:
        for name in ("aside", "place_aside", "place_rise"):
            check_number(f"scene.{name}", getattr(self, name), above=-1.0, below=1.0)
        check_number("scene.lift", self.lift, above=0.0, below=1.0)
        check_number("scene.ground", self.ground, above=0.0, below=2.0)
        check_number("scene.friction_hardness", self.friction_hardness, above=0.0, below=1e3)
        check_number("scene.timestep", self.timestep, above=0.0, below=0.0101)
        for name in ("yaw", "yaw_error"):
            check_number(f"scene.{name}", getattr(self, name), above=-7.0, below=7.0)
        if self.stage not in STAGES:
            raise UnknownName("stage", self.stage, STAGES)
        if self.stance not in STANCES:
            raise UnknownName("stance", self.stance, STANCES)
        if self.stage == "hung" and self.stance != "lying":
            raise DesignError("scene.stance", got=self.stance, allowed='"lying", as what hangs, lies')
        if self.aside == 0:
            raise DesignError("scene.aside", got=self.aside, allowed="any distance but 0")
        for name, count in (("position", 3), ("offset", 3), ("push", 2)):
            check_numbers(f"scene.{name}", getattr(self, name), count=count)
            for i, value in enumerate(getattr(self, name)):
                check_number(f"scene.{name}[{i}]", value, above=-3.0, below=3.0)
        if self.stage == "hung" and any(self.push):
            raise DesignError("scene.push", got=self.push, allowed="(0, 0), as what hangs is lifted")
        check_type("scene.shape", self.shape, ObjectSpec)
        if self.told is not None:
            check_type("scene.told", self.told, ObjectSpec)
        check_type("scene.trunk", self.trunk, TrunkOptions)
        check_type("scene.sensors", self.sensors, SensorOptions)


def build_task(design: TrunkDesign, options: SceneOptions) -> Task:
    """The task as the robot is told it.

    Raises:
        DesignError: for anything but a design and options.
    """
    check_type("design", design, TrunkDesign)
    check_type("options", options, SceneOptions)
    shape = options.shape if options.told is None else options.told
    is_hung, is_upright = options.stage == "hung", options.stance == "upright"
    position = np.array(options.position)
    if not is_hung:
        position[2] = options.ground + shape.size[0 if is_upright else 2] / 2
    axis = np.array([math.cos(options.yaw), math.sin(options.yaw), 0.0])
    target = Target(
        kind=shape.kind, width=shape.width, length=shape.size[0], mass=shape.mass, position=position,
        axis=np.array([0.0, 0.0, 1.0]) if is_upright else axis,
    )  # fmt: skip
    aside = np.array([0.0, options.aside, 0.0])
    beside = np.array([0.0, options.place_aside, options.place_rise]) if is_hung else aside
    if any(options.push):
        beside = np.array([*options.push, 0.0])
    ground = None if is_hung else options.ground
    goal = Goal(lift=options.lift, aside=aside, place=position + beside, ground=ground)
    for array in (target.position, target.axis, goal.aside, goal.place):
        array.setflags(write=False)  # The verdict goes by them.
    return Task(design=design, target=target, goal=goal)


def scene_spec(design: TrunkDesign, options: SceneOptions) -> mujoco.MjSpec:
    """The whole world as one spec.

    Raises:
        DesignError: for anything but a design and options.
    """
    check_type("design", design, TrunkDesign)
    check_type("options", options, SceneOptions)
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.compiler.autolimits = True
    _set_options(spec, options)
    _set_look(spec)
    _add_surroundings(spec, design)
    base = spec.worldbody.add_frame(pos=[0, 0, design.arm.base_height])
    spec.attach(arm_spec(design.arm, is_light=True), prefix=ARM, frame=base)
    mount = spec.site(f"{ARM}{design.arm.mount_site}")
    add_trunk(spec, mount.parent, design, options.trunk, pos=mount.pos, quat_wxyz=mount.quat)
    spec.add_exclude(bodyname1=mount.parent.name, bodyname2="housing")
    if options.stage == "hung":
        add_hung_object(spec, options)
        add_table(spec, options, build_task(design, options))
    else:
        add_ground(spec, options)
    return spec


def build_model(design: TrunkDesign | None = None, options: SceneOptions | None = None) -> mujoco.MjModel:
    """The whole world compiled, its joint limits tuned.

    Raises:
        DesignError: for anything but a design and options, and where MuJoCo cannot build their world.
    """
    design = presets.PAPER if design is None else design
    spec = scene_spec(design, SceneOptions() if options is None else options)
    try:
        model = spec.compile()
    except ValueError as error:
        allowed = f"sizes, masses and places that it builds; it says: {' '.join(str(error).split())[:150]}"
        raise DesignError("world", got=Words("one that MuJoCo refuses"), allowed=allowed) from None
    tune_joint_limits(model, design)
    return model


def _set_options(spec: mujoco.MjSpec, options: SceneOptions) -> None:
    spec.option.timestep = options.timestep
    spec.option.impratio = options.friction_hardness
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.tolerance = 1e-6  # Fewer iterations than at 1e-8, for the same rate of success.
    spec.option.gravity = [0, 0, -9.81]
    # MuJoCo 4.0.0's sparse Cholesky factor is at fault in places; the dense one is not, and no slower here.
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE


def _set_look(spec: mujoco.MjSpec) -> None:
    """Light and image quality; pictures are drawn larger and shrunk, as multisampling is slow in software."""
    visual = spec.visual
    visual.global_.offwidth, visual.global_.offheight = 1920, 1440
    visual.global_.fovy = 40.0
    visual.headlight.ambient = [0.40, 0.40, 0.40]
    visual.headlight.diffuse = [0.30, 0.30, 0.30]
    visual.headlight.specular = [0.10, 0.10, 0.10]
    visual.quality.offsamples = 0
    visual.quality.shadowsize = 2048
    visual.quality.numslices, visual.quality.numstacks = 20, 8  # Of round things, of which the cables are most.
    visual.map.znear = 0.02
    visual.map.shadowclip = 1.2
    visual.map.haze = 0.6
    visual.rgba.haze = [0.90, 0.92, 0.94, 1]


def _add_surroundings(spec: mujoco.MjSpec, design: TrunkDesign) -> None:
    world = spec.worldbody
    spec.add_texture(
        name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.90, 0.92, 0.94], rgb2=[0.66, 0.74, 0.84], width=64, height=384,
    )  # fmt: skip
    spec.add_texture(
        name="tiles", type=mujoco.mjtTexture.mjTEXTURE_2D, builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=[0.86, 0.86, 0.85], rgb2=[0.80, 0.81, 0.81], width=256, height=256,
    )  # fmt: skip
    tiles = spec.add_material(name="tiles", texrepeat=[2, 2], texuniform=True, specular=0.0)
    tiles.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "tiles"
    world.add_light(
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, pos=[1.3, -0.6, 3.0], dir=[-0.45, 0.30, -1], castshadow=True,
        diffuse=[0.52, 0.51, 0.49], specular=[0.2, 0.2, 0.2],
    )  # fmt: skip
    world.add_geom(
        name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05], material="tiles",
        solref=SOLREF, solimp=SOLIMP,
    )  # fmt: skip
    half = design.arm.base_height / 2
    if half > 0:
        world.add_geom(
            name="pedestal", type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.13, 0.12, half], pos=[-0.04, 0, half],
            rgba=[0.30, 0.33, 0.38, 1],
        )  # fmt: skip
