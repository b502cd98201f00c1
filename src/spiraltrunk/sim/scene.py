"""The world of a trial: floor, pedestal, arm, trunk, an object hung on two strings, a table to set it down on."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import final

import mujoco
import numpy as np

from spiraltrunk.design import presets
from spiraltrunk.design.checks import check_number
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError
from spiraltrunk.plant import Goal, Target, Task
from spiraltrunk.sim.arm_spec import arm_spec
from spiraltrunk.sim.materials import SOLIMP, SOLREF
from spiraltrunk.sim.objects import DEFAULT_OBJECT, ObjectSpec, add_object, parse_object
from spiraltrunk.sim.trunk_spec import TrunkOptions, add_trunk, tune_joint_limits

TIMESTEP = 1e-3
"""Step of the physics [s]."""

ARM = "arm/"
"""Prefix of every name of the arm."""

STRING = 1.0
"""Height of the strings' anchors above the object [m]."""

SLOT = 0.06
"""Half the width of the slot in the table, in which the trunk withdraws from under the object [m] (ours)."""

TABLE_DEPTH = 0.30
"""Depth of the table in the direction of the carry [m] (ours)."""

GROOVE = math.radians(8.0)
"""Slope of the table towards its middle [rad] (ours): a round object on a flat table rolls off at the last touch."""

ROLLING_FRICTION = 1e-3
"""Rolling resistance of the table's felt [m] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class SceneOptions:
    """One trial's world: what is known to the robot, and how the truth differs from it."""

    shape: ObjectSpec = field(default_factory=lambda: parse_object(DEFAULT_OBJECT))
    """The object, hung with its axis along the world's x."""
    position: tuple[float, float, float] = (0.45, 0.10, 0.85)
    """Nominal centre of the object, shape (3,) [m]."""
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """True centre minus nominal, unknown to the robot, shape (3,) [m]."""
    aside: float = 0.20
    """Carry along y, not 0 [m]."""
    lift: float = 0.20
    """Height to lift by, above 0 [m]."""
    place_aside: float = 0.35
    """Distance of the table's middle along y from where the object hangs [m]: clear of the curling trunk."""
    place_rise: float = 0.08
    """Height of the place to set down above the object's start [m]; the strings stay slack there."""
    trunk: TrunkOptions = field(default_factory=TrunkOptions)
    """The trunk's simulation."""

    def __post_init__(self) -> None:
        for name in ("aside", "place_aside", "place_rise"):
            check_number(f"scene.{name}", getattr(self, name), above=-1.0, below=1.0)
        check_number("scene.lift", self.lift, above=0.0, below=1.0)
        if self.aside == 0:
            raise DesignError("scene.aside", got=self.aside, allowed="any distance but 0")
        for name in ("position", "offset"):
            for i, value in enumerate(getattr(self, name)):
                check_number(f"scene.{name}[{i}]", value, above=-3.0, below=3.0)


def build_task(design: TrunkDesign, options: SceneOptions) -> Task:
    """The task as the robot is told it."""
    shape, position = options.shape, np.array(options.position)
    target = Target(
        kind=shape.kind, width=shape.width, length=shape.size[0], mass=shape.mass, position=position,
        axis=np.array([1.0, 0.0, 0.0]),
    )  # fmt: skip
    aside = np.array([0.0, options.aside, 0.0])
    place = position + np.array([0.0, options.place_aside, options.place_rise])
    return Task(design=design, target=target, goal=Goal(lift=options.lift, aside=aside, place=place))


def scene_spec(design: TrunkDesign, options: SceneOptions) -> mujoco.MjSpec:
    """The whole world as one spec."""
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.compiler.autolimits = True
    _set_options(spec)
    _set_look(spec)
    _add_surroundings(spec, design)
    base = spec.worldbody.add_frame(pos=[0, 0, design.arm.base_height])
    spec.attach(arm_spec(design.arm), prefix=ARM, frame=base)
    mount = spec.site(f"{ARM}{design.arm.mount_site}")
    add_trunk(spec, mount.parent, design, options.trunk, pos=mount.pos, quat_wxyz=mount.quat)
    spec.add_exclude(bodyname1=mount.parent.name, bodyname2="housing")
    task = build_task(design, options)
    _add_hung_object(spec, options)
    _add_table(spec, options, task)
    return spec


def build_model(design: TrunkDesign | None = None, options: SceneOptions | None = None) -> mujoco.MjModel:
    """The whole world compiled, its joint limits tuned."""
    design = presets.PAPER if design is None else design
    model = scene_spec(design, SceneOptions() if options is None else options).compile()
    tune_joint_limits(model, design)
    return model


def _set_options(spec: mujoco.MjSpec) -> None:
    spec.option.timestep = TIMESTEP
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


def _add_hung_object(spec: mujoco.MjSpec, options: SceneOptions) -> None:
    """The object on two strings that pull and never push: tendons with a longest length."""
    body = add_object(spec, options.shape)
    center = np.array(options.position) + np.array(options.offset)
    body.pos = center
    half = options.shape.size[0] / 2
    for side, x in (("left", -half), ("right", half)):
        anchor = spec.worldbody.add_site(
            name=f"anchor_{side}", pos=center + np.array([x, 0.0, STRING]), size=[0.004] * 3
        )
        string = spec.add_tendon(
            name=f"string_{side}", limited=True, range=[0.0, STRING], width=0.0015, rgba=[0.25, 0.25, 0.25, 1],
            solref_limit=[0.01, 1],
        )  # fmt: skip
        string.wrap_site(anchor.name)
        string.wrap_site(f"object_{side}")


def _add_table(spec: mujoco.MjSpec, options: SceneOptions, task: Task) -> None:
    """A felt-covered table with a shallow groove, in two halves with a slot between.

    The groove keeps a round object from rolling off; the object bridges the slot, in which the trunk withdraws.
    """
    place, half = task.goal.place, options.shape.size[0] / 2
    slot = max(0.0, min(SLOT, half - 0.035))
    wide = (half + 0.02 - slot) / 2
    bottom = float(place[2]) - options.shape.size[2] / 2 / math.cos(GROOVE)
    board = np.array([wide, TABLE_DEPTH / 4 / math.cos(GROOVE), 0.008])
    for side, sign in (("near", -1.0), ("far", 1.0)):
        middle = place[0] + sign * (slot + wide)
        for part, slope in (("front", -1.0), ("back", 1.0)):
            normal = np.array([0.0, -slope * math.sin(GROOVE), math.cos(GROOVE)])
            surface = np.array(
                [middle, place[1] + slope * TABLE_DEPTH / 4, bottom + TABLE_DEPTH / 4 * math.tan(GROOVE)]
            )
            spec.worldbody.add_geom(
                name=f"table_{side}_{part}", type=mujoco.mjtGeom.mjGEOM_BOX, size=board, rgba=[0.62, 0.46, 0.30, 1],
                pos=surface - board[2] * normal, quat=[math.cos(GROOVE / 2), slope * math.sin(GROOVE / 2), 0, 0],
                solref=SOLREF, solimp=SOLIMP, condim=6, priority=2,
                friction=[options.shape.friction, 0.005, ROLLING_FRICTION],
            )  # fmt: skip
        foot = (bottom - 0.016) / 2
        spec.worldbody.add_geom(
            name=f"table_{side}_leg", type=mujoco.mjtGeom.mjGEOM_BOX, size=[wide, 0.02, foot],
            pos=[middle, place[1], foot], rgba=[0.45, 0.34, 0.24, 1],
        )  # fmt: skip
