"""The rigid arm: Franka's Panda from published numbers, or any arm's MJCF.

Kinematics: Denavit-Hartenberg table in Craig's convention, Franka Control Interface documentation. Inertias: Gaz,
Cognetti, Oliva, Robuffo Giordano, De Luca, "Dynamic Identification of the Franka Emika Panda Robot with Retrieval of
Feasible Parameters Using Penalty-Based Optimization", RA-L 2019, as published in franka_description. Meshes:
gymnasium-robotics.
"""

from __future__ import annotations

import importlib.util
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import mujoco
import numpy as np

from spiraltrunk.checks import check_type
from spiraltrunk.design.mount import ArmDesign
from spiraltrunk.errors import DesignError, MissingPackage
from spiraltrunk.sim.mujoco_log import quiet_mujoco
from spiraltrunk.sim.robot.mesh_decimation import thin_out

# Per joint: a [m], d [m], alpha [rad] of Craig's table.
_DH = (
    (0.0, 0.333, 0.0), (0.0, 0.0, -math.pi / 2), (0.0, 0.316, math.pi / 2), (0.0825, 0.0, math.pi / 2),
    (-0.0825, 0.384, -math.pi / 2), (0.0, 0.0, math.pi / 2), (0.088, 0.0, math.pi / 2),
)  # fmt: skip

_FLANGE_OFFSET = 0.107

# Per link 0 to 7: mass [kg], centre of mass [m], inertia xx, yy, zz, xy, xz, yz about it [kg m^2].
_INERTIA = (
    (0.629769, (-0.041018, -0.00014, 0.049974), (0.00315, 0.00388, 0.004285, 8.2904e-7, 0.00015, 8.2299e-6)),
    (4.970684, (0.003875, 0.002081, -0.04762), (0.70337, 0.70661, 0.009117, -0.000139, 0.006772, 0.019169)),
    (0.646926, (-0.003141, -0.02872, 0.003495), (0.007962, 0.02811, 0.025995, -0.003925, 0.010254, 0.000704)),
    (3.228604, (0.027518, 0.039252, -0.066502), (0.037242, 0.036155, 0.01083, -0.004761, -0.011396, -0.012805)),
    (3.587895, (-0.05317, 0.104419, 0.027454), (0.025853, 0.019552, 0.028323, 0.007796, -0.001332, 0.008641)),
    (1.225946, (-0.011953, 0.041065, -0.038437), (0.035549, 0.029474, 0.008627, -0.002117, -0.004037, 0.000229)),
    (1.666555, (0.060149, -0.014117, -0.010517), (0.001964, 0.004354, 0.005433, 0.000109, -0.001158, 0.000341)),
    (0.735522, (0.010517, -0.004252, 0.061597), (0.012516, 0.010027, 0.004815, -0.000428, -0.001196, -0.000741)),
)

_GAINS = ((4500, 450), (4500, 450), (3500, 350), (3500, 350), (2000, 200), (2000, 200), (2000, 200))
"""Stiffness [N m/rad] and damping [N m s/rad] of the joint position control (ours)."""

_SIZES = (
    "memory", "nconmax", "njmax", "nkey", "nstack", "nuserdata", "nuser_actuator", "nuser_body", "nuser_cam",
    "nuser_geom", "nuser_jnt", "nuser_sensor", "nuser_site", "nuser_tendon",
)  # fmt: skip
"""Settings of MJCF's element size."""


@final
@dataclass(frozen=True, kw_only=True)
class ArmLimits:
    """What the arm may do, joint by joint; None where nothing is published."""

    position: tuple[np.ndarray, np.ndarray] | None
    """Least and largest joint positions [rad]."""
    velocity: np.ndarray | None
    """Speed [rad/s]."""
    acceleration: np.ndarray | None
    """Acceleration [rad/s^2]."""
    jerk: np.ndarray | None
    """Jerk [rad/s^3]."""
    torque: np.ndarray | None
    """Torque [N m]."""


_PANDA_RANGE = (
    (-2.8973, 2.8973), (-1.7628, 1.7628), (-2.8973, 2.8973), (-3.0718, -0.0698), (-2.8973, 2.8973), (-0.0175, 3.7525),
    (-2.8973, 2.8973),
)  # fmt: skip
"""Joint ranges of the Panda [rad] (Franka Control Interface documentation)."""

PANDA_LIMITS = ArmLimits(
    position=(np.array(_PANDA_RANGE)[:, 0], np.array(_PANDA_RANGE)[:, 1]),
    velocity=np.array([2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61]),
    acceleration=np.array([15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0]),
    jerk=np.array([7500.0, 3750.0, 5000.0, 6250.0, 7500.0, 10000.0, 10000.0]),
    torque=np.array([87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0]),
)
"""Limits of the Panda (Franka Control Interface documentation)."""

_NO_LIMITS = ArmLimits(position=None, velocity=None, acceleration=None, jerk=None, torque=None)

PANDA_HOME = (0.0, -math.pi / 4, 0.0, -3 * math.pi / 4, 0.0, math.pi / 2, math.pi / 4)
"""The Panda's usual ready posture [rad]."""


def arm_limits(arm: ArmDesign) -> ArmLimits:
    """What is published of the arm's limits; nothing for an arm of the user's."""
    return PANDA_LIMITS if arm.model == "panda" else _NO_LIMITS


def arm_home(arm: ArmDesign, n_joint: int) -> np.ndarray:
    """Joint positions where work starts, shape (n_joint,) [rad].

    Raises:
        DesignError: where the design gives another number of joints than the arm has.
    """
    home = arm.home
    if home is None:
        home = PANDA_HOME if arm.model == "panda" else (0.0,) * n_joint
    if len(home) != n_joint:
        raise DesignError(
            "arm.home", got=f"{len(home)} numbers", allowed=f"{n_joint} numbers, one per joint of the arm"
        )
    return np.array(home, float)


def arm_spec(arm: ArmDesign, *, is_light: bool = False) -> mujoco.MjSpec:
    """The arm alone, its base at the origin, with a site that the housing is fixed to.

    Args:
        arm: which arm.
        is_light: whether the Panda's looks are thinned out, for drawing; what collides stays as published.

    Raises:
        DesignError: for anything but an arm's design, and an MJCF that cannot be read, or has no such site, or not one
            position actuator per joint.
        MissingPackage: where the Panda's meshes are not installed.
    """
    check_type("arm", arm, ArmDesign)
    return _panda_spec(arm, is_light) if arm.model == "panda" else _load_spec(arm)


def _panda_spec(arm: ArmDesign, is_light: bool) -> mujoco.MjSpec:
    if arm.mount_site != "flange":
        raise DesignError("arm.mount_site", got=arm.mount_site, allowed="flange (the Panda's)")
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.compiler.autolimits = True
    meshes = _mesh_folder()
    parent = spec.worldbody
    for n in range(8):
        body = parent.add_body(name=f"link{n}")
        if n > 0:
            a, d, alpha = _DH[n - 1]
            body.pos = [a, -math.sin(alpha) * d, math.cos(alpha) * d]
            body.quat = [math.cos(alpha / 2), math.sin(alpha / 2), 0, 0]
            _add_joint(spec, body, n)
        _add_link(spec, body, n, meshes)
        if is_light:
            _lighten(spec.mesh(f"link{n}_visual"))
        parent = body
    parent.add_site(name="flange", pos=[0, 0, _FLANGE_OFFSET])
    # Neighbours touch by design (MuJoCo filters moving ones alone), links two apart share a joint's housing.
    for first, second in ((0, 1), (0, 2), (1, 3), (2, 4), (3, 5), (4, 6), (5, 7)):
        spec.add_exclude(bodyname1=f"link{first}", bodyname2=f"link{second}")
    return spec


def _add_joint(spec: mujoco.MjSpec, body: mujoco.MjsBody, n: int) -> None:
    torque = float(PANDA_LIMITS.torque[n - 1])  # type: ignore[index]
    name = f"arm_joint{n}"
    body.add_joint(
        name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1], limited=True, range=_PANDA_RANGE[n - 1],
        armature=0.1, actgravcomp=True, actfrclimited=True, actfrcrange=[-torque, torque],
    )  # fmt: skip
    stiffness, damping = _GAINS[n - 1]
    actuator = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    actuator.set_to_position(kp=stiffness, kv=damping)
    actuator.forcelimited = True
    actuator.forcerange = [-torque, torque]


def _add_link(spec: mujoco.MjSpec, body: mujoco.MjsBody, n: int, meshes: Path) -> None:
    mass, center, moments = _INERTIA[n]
    body.explicitinertial = True
    body.mass, body.ipos, body.fullinertia = mass, center, moments
    body.gravcomp = 1.0  # The Panda's controller carries its own weight.
    looks: tuple[tuple[str, dict[str, Any]], ...] = (
        ("visual", {"contype": 0, "conaffinity": 0, "group": 2, "rgba": [0.93, 0.94, 0.95, 1]}),
        ("collision", {"group": 3, "rgba": [0.6, 0.7, 0.8, 1]}),
    )
    for kind, look in looks:
        mesh = spec.add_mesh(name=f"link{n}_{kind}", file=str(meshes / kind / f"link{n}.stl"))
        body.add_geom(name=mesh.name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh.name, **look)


def _lighten(mesh: mujoco.MjsMesh) -> None:
    vertices, faces = thin_out(Path(mesh.file))
    mesh.file, mesh.uservert, mesh.userface = "", vertices.ravel(), faces.ravel()


def _mesh_folder() -> Path:
    """Folder of the Panda's meshes; the package is looked up, not imported: importing it prints a notice."""
    found = importlib.util.find_spec("gymnasium_robotics")
    if found is None or not found.submodule_search_locations:
        raise MissingPackage("the Panda's meshes are missing: pip install gymnasium-robotics")
    folder = Path(next(iter(found.submodule_search_locations)))
    return folder / "envs" / "assets" / "kitchen_franka" / "franka_assets" / "meshes"


def _load_spec(arm: ArmDesign) -> mujoco.MjSpec:
    path = Path(arm.model)
    if not path.is_file():
        raise DesignError("arm.model", got=arm.model, allowed='"panda" or the path of an MJCF file')
    try:
        with quiet_mujoco():
            spec = mujoco.MjSpec.from_file(str(path))
            model = spec.compile()
    except (ValueError, mujoco.FatalError) as error:
        first = str(error).strip().splitlines()[0] if str(error).strip() else "no reason given"
        raise DesignError("arm.model", got=arm.model, allowed=f"an MJCF file that MuJoCo reads ({first})") from None
    sites = [model.site(i).name for i in range(model.nsite)]
    if arm.mount_site not in sites:
        known = ", ".join(name for name in sites if name) or "none"
        raise DesignError("arm.mount_site", got=arm.mount_site, allowed=f"a site of {path.name}: {known}")
    driven = [int(j) for j, kind in zip(model.actuator_trnid[:, 0], model.actuator_trntype, strict=True) if kind == 0]
    is_driven = model.nq == model.nv == model.nu and sorted(driven) == list(range(model.nv))
    # A position actuator pulls back to its target with the stiffness that it pushes with.
    if not (is_driven and (model.actuator_gainprm[:, 0] == -model.actuator_biasprm[:, 1]).all()
            and (model.actuator_gainprm[:, 0] > 0).all()):  # fmt: skip
        allowed = "an arm of hinges and slides with one position actuator on each joint"
        raise DesignError("arm.model", got=f"{arm.model}: {model.nu} actuators, {model.nv} joints", allowed=allowed)
    _drop_settings(spec)
    return spec


def _drop_settings(spec: mujoco.MjSpec) -> None:
    """Put options, visuals and sizes back to MuJoCo's defaults: the world's win, and MuJoCo warns of all others."""
    default = mujoco.MjSpec()
    for name in ("option", "visual", "authored"):
        _copy_fields(getattr(spec, name), getattr(default, name))
    for name in _SIZES:
        setattr(spec, name, getattr(default, name))


def _copy_fields(to: Any, source: Any) -> None:
    for name in (name for name in dir(source) if not name.startswith("_")):
        value = getattr(source, name)
        if isinstance(value, (int, float, np.ndarray)):
            setattr(to, name, value)
        elif not callable(value):
            _copy_fields(getattr(to, name), value)
