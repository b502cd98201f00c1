"""The rigid arm: one that is described here, or any arm's MJCF.

A described arm is one file with one `ArmDescription`, which `ARMS` lists.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from spiraltrunk.checks import check_type
from spiraltrunk.control.arm_limits import ArmLimits
from spiraltrunk.design.mount import ArmDesign
from spiraltrunk.errors import DesignError
from spiraltrunk.sim.mujoco_log import quiet_mujoco
from spiraltrunk.sim.robot.arm_description import ArmDescription
from spiraltrunk.sim.robot.fr3 import FR3
from spiraltrunk.sim.robot.mesh_decimation import thin_out
from spiraltrunk.sim.robot.panda import PANDA

ARMS = {arm.name: arm for arm in (PANDA, FR3)}
"""Arms that a design can name; any other is an MJCF file."""

FLANGE = "flange"
"""Site of a described arm that the housing is fixed to."""

_VISUAL: dict[str, Any] = {"contype": 0, "conaffinity": 0, "group": 2, "rgba": [0.93, 0.94, 0.95, 1]}
_COLLISION: dict[str, Any] = {"group": 3, "rgba": [0.6, 0.7, 0.8, 1]}
_BOTH: dict[str, Any] = {"group": 2, "rgba": [0.93, 0.94, 0.95, 1]}
"""Of geoms that are seen, that are touched, and that are both."""

_SIZES = (
    "memory", "nconmax", "njmax", "nkey", "nstack", "nuserdata", "nuser_actuator", "nuser_body", "nuser_cam",
    "nuser_geom", "nuser_jnt", "nuser_sensor", "nuser_site", "nuser_tendon",
)  # fmt: skip
"""Settings of MJCF's element size."""


def arm_limits(arm: ArmDesign) -> ArmLimits:
    """What is known of the arm's limits: as published, or what an MJCF file says of positions and torques.

    Raises:
        DesignError: as `arm_spec`.
    """
    described = ARMS.get(arm.model)
    return read_limits(_load_spec(arm).compile()) if described is None else described.limits


def arm_payload(arm: ArmDesign) -> float | None:
    """Mass that the arm is rated to carry behind its flange [kg]; None where none is known."""
    described = ARMS.get(arm.model)
    return None if described is None else described.payload


def arm_home(arm: ArmDesign, n_joint: int) -> np.ndarray:
    """Joint positions where work starts, shape (n_joint,) [rad].

    Raises:
        DesignError: where the design gives another number of joints than the arm has.
    """
    home = arm.home
    if home is None:
        home = ARMS[arm.model].home if arm.model in ARMS else (0.0,) * n_joint
    if len(home) != n_joint:
        raise DesignError(
            "arm.home", got=f"{len(home)} numbers", allowed=f"{n_joint} numbers, one per joint of the arm"
        )
    return np.array(home, float)


def arm_spec(arm: ArmDesign, *, is_light: bool = False) -> mujoco.MjSpec:
    """The arm alone, its base at the origin, with a site that the housing is fixed to.

    Args:
        arm: which arm.
        is_light: whether meshes that are seen are thinned out, for drawing; what collides stays as published.

    Raises:
        DesignError: for anything but an arm's design, and an MJCF that cannot be read, or has no such site, or not one
            position actuator per joint.
        MissingPackage: where the arm's meshes are not installed.
    """
    check_type("arm", arm, ArmDesign)
    described = ARMS.get(arm.model)
    if described is None:
        return _load_spec(arm)
    if arm.mount_site != FLANGE:
        raise DesignError("arm.mount_site", got=arm.mount_site, allowed=f"{FLANGE} (of the arm {arm.model})")
    return build_arm_spec(described, is_light=is_light)


def build_arm_spec(arm: ArmDescription, *, is_light: bool = False) -> mujoco.MjSpec:
    """A described arm as a spec: bodies link0 onwards, joints and actuators arm_joint1 onwards, and the flange's site.

    Raises:
        MissingPackage: where the arm's meshes are not installed.
    """
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.compiler.autolimits = True
    meshes = None if arm.find_meshes is None else arm.find_meshes()
    parent = spec.worldbody
    for n in range(len(arm.dh) + 1):
        body = parent.add_body(name=f"link{n}")
        if n > 0:
            a, d, alpha = arm.dh[n - 1]
            body.pos = [a, -math.sin(alpha) * d, math.cos(alpha) * d]
            body.quat = [math.cos(alpha / 2), math.sin(alpha / 2), 0, 0]
            _add_joint(spec, body, arm, n)
        _set_inertia(body, arm, n)
        if meshes is None:
            _add_capsules(body, arm, n)
        else:
            _add_meshes(spec, body, n, meshes)
            if is_light:
                _lighten(spec.mesh(f"link{n}_visual"))
        parent = body
    parent.add_site(name=FLANGE, pos=[0, 0, arm.flange])
    # Neighbours touch by design (MuJoCo filters moving ones alone), links two apart share a joint's housing.
    for first, second in ((0, 1), *((n, n + 2) for n in range(len(arm.dh) - 1))):
        spec.add_exclude(bodyname1=f"link{first}", bodyname2=f"link{second}")
    return spec


def _add_joint(spec: mujoco.MjSpec, body: mujoco.MjsBody, arm: ArmDescription, n: int) -> None:
    low, high = (float(end[n - 1]) for end in arm.limits.position)  # type: ignore[union-attr]
    torque = float(arm.limits.torque[n - 1])  # type: ignore[index]
    name = f"arm_joint{n}"
    body.add_joint(
        name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1], limited=True, range=[low, high],
        armature=arm.armature[n - 1], actgravcomp=True, actfrclimited=True, actfrcrange=[-torque, torque],
    )  # fmt: skip
    stiffness, damping = arm.gains[n - 1]
    actuator = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    actuator.set_to_position(kp=stiffness, kv=damping)
    actuator.forcelimited = True
    actuator.forcerange = [-torque, torque]


def _set_inertia(body: mujoco.MjsBody, arm: ArmDescription, n: int) -> None:
    link = arm.inertia[n]
    body.explicitinertial = True
    body.mass, body.ipos, body.fullinertia = link.mass, link.center, link.moments
    body.gravcomp = 1.0  # The controller carries the arm's own weight.


def _add_meshes(spec: mujoco.MjSpec, body: mujoco.MjsBody, n: int, meshes: Path) -> None:
    for kind, look in (("visual", _VISUAL), ("collision", _COLLISION)):
        mesh = spec.add_mesh(name=f"link{n}_{kind}", file=str(meshes / kind / f"link{n}.stl"))
        body.add_geom(name=mesh.name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh.name, **look)


def _add_capsules(body: mujoco.MjsBody, arm: ArmDescription, n: int) -> None:
    for k, capsule in enumerate(arm.capsules[n]):
        body.add_geom(
            name=f"link{n}_{k + 1}", type=mujoco.mjtGeom.mjGEOM_CAPSULE, fromto=[*capsule.first, *capsule.second],
            size=[capsule.radius, 0, 0], **_BOTH,
        )  # fmt: skip


def _lighten(mesh: mujoco.MjsMesh) -> None:
    vertices, faces = thin_out(Path(mesh.file))
    mesh.file, mesh.uservert, mesh.userface = "", vertices.ravel(), faces.ravel()


def read_limits(model: mujoco.MjModel) -> ArmLimits:
    """Limits that the model of an arm with one actuator per joint states: of position and torque, joint by joint.

    A joint's torque is limited by its own range of actuator forces and by the actuator's, whichever is smaller; a range
    that is not the same both ways counts as none.
    """
    position = np.where(model.jnt_limited[:, None], model.jnt_range, [-np.inf, np.inf]).T
    torque = _symmetric(model.jnt_actfrclimited, model.jnt_actfrcrange)
    joints = model.actuator_trnid[:, 0]
    force = _symmetric(model.actuator_forcelimited, model.actuator_forcerange) * np.abs(model.actuator_gear[:, 0])
    torque[joints] = np.minimum(torque[joints], force)
    return ArmLimits(
        position=(position[0], position[1]) if np.isfinite(position).any() else None,
        velocity=None,
        acceleration=None,
        jerk=None,
        torque=torque if np.isfinite(torque).any() else None,
    )


def _symmetric(is_limited: np.ndarray, span: np.ndarray) -> np.ndarray:
    """The bound of each symmetric range, shape (n,); infinite for any other."""
    is_known = is_limited.astype(bool) & (span[:, 0] == -span[:, 1])
    return np.where(is_known, span[:, 1], np.inf)


def _load_spec(arm: ArmDesign) -> mujoco.MjSpec:
    path = Path(arm.model)
    if not path.is_file():
        names = ", ".join(f'"{name}"' for name in ARMS)
        raise DesignError("arm.model", got=arm.model, allowed=f"{names} or the path of an MJCF file")
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
