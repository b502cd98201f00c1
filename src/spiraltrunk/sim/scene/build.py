"""Scene of a trial: floor, pedestal, arm, trunk, and an object, hung before a table or on the ground."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from spiraltrunk.checks import check_type
from spiraltrunk.control.messages import Goal, Target, Task
from spiraltrunk.design import presets
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, Unquoted
from spiraltrunk.sim.mujoco_log import compile_spec, first_line
from spiraltrunk.sim.objects.handle import find_handle
from spiraltrunk.sim.objects.presentation import find_longer_side
from spiraltrunk.sim.objects.profile import compute_profile
from spiraltrunk.sim.robot.arm import add_arm
from spiraltrunk.sim.robot.materials import SOLIMP, SOLREF
from spiraltrunk.sim.robot.trunk import add_trunk, tune_joint_limits
from spiraltrunk.sim.scene.options import ASIDE, LIFT, PLACE_ASIDE, PLACE_RISE, SceneOptions
from spiraltrunk.sim.scene.supports import add_ground, add_hung_object, add_table, rest_height

PEDESTAL_SIZE, PEDESTAL_CENTER = (0.13, 0.12), (-0.04, 0.0)
"""Half extents and centre of the pedestal, level [m] (ours)."""

MOST_LENGTH, MOST_MASS = 10.0, 1000.0
"""Largest length of the straight trunk [m] and mass of its sections and gripper [kg] in a simulation (ours)."""

TOLERANCE, TOLERANCE_HARD = 1e-6, 1e-8
"""Tolerances of MuJoCo's solver below and from a hardness of friction of HARD (ours) [-]. At 1e-6 rates are those of
1e-8, with fewer iterations; but forces on a light object in hard friction end short of balance, and it creeps: a ball
of 15 g in fingers by 1.0 mm in a trial's transport, at 1e-8 by 0.7 mm."""
HARD = 30.0
"""Hardness of friction from which TOLERANCE_HARD holds [-]."""


def build_task(design: TrunkDesign, options: SceneOptions) -> Task:
    """The task as announced to the robot."""
    shape = options.announced or options.shape
    is_hung, is_upright = options.support == "hung", options.orientation == "upright"
    position = np.array(options.position)
    if not is_hung:
        position[2] = rest_height(options, shape)
    axis = np.array([math.cos(options.yaw), math.sin(options.yaw), 0.0])
    longer_side, side_yaw = find_longer_side(shape) if is_upright else (0.0, None)
    target = Target(
        kind=shape.kind, width=shape.width, length=shape.size[0], mass=shape.mass, position=position,
        axis=np.array([0.0, 0.0, 1.0]) if is_upright else axis, profile=compute_profile(shape, options.orientation),
        longer_side=longer_side, side_yaw=None if side_yaw is None else side_yaw + options.yaw,
        handle=find_handle(shape, options.yaw) if is_upright else None,
    )  # fmt: skip
    aside = np.array([0.0, ASIDE, 0.0])
    beside = np.array([0.0, PLACE_ASIDE, PLACE_RISE]) if is_hung else aside
    if any(options.push):
        beside = np.array([*options.push, 0.0])
    ground = None if is_hung else options.ground
    goal = Goal(lift=LIFT, aside=aside, place=position + beside, ground=ground)
    for array in (target.position, target.axis, goal.aside, goal.place):
        array.setflags(write=False)  # The verdict depends on them.
    return Task(design=design, target=target, goal=goal)


def build_spec(design: TrunkDesign, options: SceneOptions) -> mujoco.MjSpec:
    """Spec of the scene; joint limits are tuned after it is compiled."""
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    _set_options(spec, options)
    _set_visual(spec)
    _add_surroundings(spec, design)
    mount = add_arm(spec, design.arm, is_decimated=True)
    add_trunk(spec, mount.parent, design, options.trunk, pos=mount.pos, quat_wxyz=mount.quat)
    spec.add_exclude(bodyname1=mount.parent.name, bodyname2="housing")
    if options.support == "hung":
        add_hung_object(spec, options)
        add_table(spec, options, build_task(design, options).goal.place)
    else:
        add_ground(spec, options)
    return spec


def build_model(design: TrunkDesign | None = None, options: SceneOptions | None = None) -> mujoco.MjModel:
    """Compiled model of the scene, with tuned joint limits.

    Args:
        design: the design of the robot; the paper's by default.
        options: the scene of the trial.

    Raises:
        DesignError: for a value of another type, and where MuJoCo cannot compile the scene.
    """
    design = presets.PAPER if design is None else design
    options = SceneOptions() if options is None else options
    check_type("design", design, TrunkDesign)
    check_type("options", options, SceneOptions)
    _check_size(design)
    try:
        model = compile_spec(build_spec(design, options))
    except DesignError:  # Of a file, which is refused before MuJoCo builds anything.
        raise
    except ValueError as error:
        allowed = f"sizes, masses and places that it builds; it says: {first_line(error)}"
        raise DesignError("world", got=Unquoted("one that MuJoCo refuses"), allowed=allowed) from None
    _limit_time_constants(model)
    tune_joint_limits(model, design)
    return model


def _check_size(design: TrunkDesign) -> None:
    """Refuse a trunk so large that only a mistyped number gives it; MuJoCo would warn and never end."""
    for name, value, most, unit in (
        ("length of the trunk", design.length, MOST_LENGTH, "m"),
        ("mass of the trunk", design.total_mass, MOST_MASS, "kg"),
    ):
        if not value <= most:
            raise DesignError(
                name, got=Unquoted(f"{value:.3g} {unit}"), allowed=f"at most {most:g} {unit} in simulation"
            )


def _limit_time_constants(model: mujoco.MjModel) -> None:
    """Raise the time constants of contacts and limits to two time steps, where they are shorter.

    MuJoCo does so too as it steps (flag ``refsafe``), but with the mean of two contacting bodies; here the model holds
    the values that are simulated. Negative values are stiffness and damping, and stay.
    """
    least = 2 * model.opt.timestep
    for field in ("geom_solref", "jnt_solref", "tendon_solref_lim"):
        constant = getattr(model, field)[:, 0]
        constant[(constant > 0) & (constant < least)] = least


def _set_options(spec: mujoco.MjSpec, options: SceneOptions) -> None:
    spec.option.timestep = options.timestep
    spec.option.impratio = options.friction_hardness
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.tolerance = TOLERANCE if options.friction_hardness < HARD else TOLERANCE_HARD
    spec.option.gravity = [0, 0, -GRAVITY]
    # MuJoCo 4.0.0's sparse Cholesky factor is at fault in places; the dense one is not, and no slower here.
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE


def _set_visual(spec: mujoco.MjSpec) -> None:
    """Set light and image quality; supersampling replaces multisampling, which is slow in software."""
    visual = spec.visual
    visual.global_.offwidth, visual.global_.offheight = 1920, 1440
    visual.global_.fovy = 40.0
    visual.headlight.ambient = [0.40, 0.40, 0.40]
    visual.headlight.diffuse = [0.30, 0.30, 0.30]
    visual.headlight.specular = [0.10, 0.10, 0.10]
    visual.quality.offsamples = 0
    visual.quality.shadowsize = 4096
    visual.quality.numslices, visual.quality.numstacks = 20, 8  # Of cylinders, mostly the cables.
    visual.map.znear = 0.02
    visual.map.shadowclip = 0.6  # Near pictures would show coarser shadows as teeth.
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
            name="pedestal", type=mujoco.mjtGeom.mjGEOM_BOX, size=[*PEDESTAL_SIZE, half], pos=[*PEDESTAL_CENTER, half],
            rgba=[0.30, 0.33, 0.38, 1],
        )  # fmt: skip
