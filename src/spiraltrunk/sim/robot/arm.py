"""The rigid arm: a described one, or any arm's MJCF file.

A described arm is one file with one `ArmDescription`, listed in `ARMS`.
"""

from __future__ import annotations

import math
from functools import lru_cache
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from spiraltrunk.checks import check_type
from spiraltrunk.control.arm_limits import ArmLimits
from spiraltrunk.design.mount import ArmDesign
from spiraltrunk.errors import DesignError, Unquoted
from spiraltrunk.sim.mujoco_log import compile_spec, quiet_mujoco
from spiraltrunk.sim.robot.arm_description import ArmDescription
from spiraltrunk.sim.robot.fr3 import FR3
from spiraltrunk.sim.robot.panda import PANDA
from spiraltrunk.sim.user_files.compile_check import load_mjcf_spec
from spiraltrunk.sim.user_files.regular_file import read_file, refusal

ARMS = {arm.name: arm for arm in (PANDA, FR3)}
"""Arms that a design can name; any other is an MJCF file."""

PREFIX = "arm/"
"""Prefix of every name of the arm in a scene."""

FLANGE = "flange"
"""Site of a described arm to which the housing is fixed."""

FACES = 3000
"""Largest number of triangles of a link in pictures (ours): software rendering takes a third less time per frame, with
no visible difference."""

LENGTH_MOST = 10.0
"""Largest coordinate of a user's arm's links in the one before, and of their parts in the link [m] (ours)."""

MASS_MOST = 1000.0
"""Largest mass of a link of a user's arm [kg] (ours)."""

_VISUAL: dict[str, Any] = {"contype": 0, "conaffinity": 0, "group": 2, "rgba": [0.93, 0.94, 0.95, 1]}
"""Attributes of geoms that are only drawn."""

_COLLISION: dict[str, Any] = {"group": 3, "rgba": [0.6, 0.7, 0.8, 1]}
"""Attributes of geoms that only collide."""

_BOTH: dict[str, Any] = {"group": 2, "rgba": [0.93, 0.94, 0.95, 1]}
"""Attributes of geoms that are drawn and collide."""


def arm_limits(arm: ArmDesign) -> ArmLimits:
    """Limits of the arm: the published ones, or those of position and torque in an MJCF file.

    Raises:
        DesignError: as `arm_spec`.
    """
    described = ARMS.get(arm.model)
    return read_limits(_load_spec(arm).compile()) if described is None else described.limits


def arm_payload(arm: ArmDesign) -> float | None:
    """Rated payload at the flange [kg]; None where it is not known."""
    described = ARMS.get(arm.model)
    return None if described is None else described.payload


def arm_home(arm: ArmDesign, n_joint: int) -> np.ndarray:
    """Joint positions at the start of a trial, shape (n_joint,) [rad].

    Raises:
        DesignError: where the design has another number of joints than the arm.
    """
    home = arm.home
    if home is None:
        home = ARMS[arm.model].home if arm.model in ARMS else (0.0,) * n_joint
    if len(home) != n_joint:
        raise DesignError(
            "arm.home", got=Unquoted(f"{len(home)} numbers"), allowed=f"{n_joint} numbers, one per joint of the arm"
        )
    return np.array(home, float)


def check_arm(arm: ArmDesign) -> None:
    """Check that the arm has the design's mount site, and as many joints as the design has initial positions.

    Raises:
        DesignError: names the field, and what is allowed.
    """
    described = ARMS.get(arm.model)
    if described is None:
        arm_home(arm, _load_spec(arm).compile().nq)
    else:
        _check_flange(arm)
        arm_home(arm, len(described.home))


def arm_spec(arm: ArmDesign, *, is_decimated: bool = False) -> mujoco.MjSpec:
    """The arm alone, its base at the origin, with the site to which the housing is fixed.

    Args:
        arm: the arm of a design.
        is_decimated: whether visual meshes are decimated to `FACES` triangles; collision meshes stay as published.

    Raises:
        DesignError: for a value of another type, and an MJCF that cannot be read, or has no such site, or not one
            position actuator per joint.
        MissingPackage: where the arm's meshes are not installed.
    """
    check_type("arm", arm, ArmDesign)
    described = ARMS.get(arm.model)
    if described is None:
        return _load_spec(arm)
    _check_flange(arm)
    return build_arm_spec(described, is_decimated=is_decimated)


def _check_flange(arm: ArmDesign) -> None:
    """Check that the housing is fixed to the flange of a described arm."""
    if arm.mount_site != FLANGE:
        raise DesignError("arm.mount_site", got=arm.mount_site, allowed=f"{FLANGE} (of the arm {arm.model})")


def add_arm(spec: mujoco.MjSpec, arm: ArmDesign, *, is_decimated: bool = False) -> mujoco.MjsSite:
    """Attach the arm to the world on its pedestal, and return the site to which the housing is fixed.

    The settings of ``spec`` take precedence over those of the arm's file.

    Raises:
        DesignError: as `arm_spec`.
    """
    base = spec.worldbody.add_frame(pos=[0, 0, arm.base_height])
    with quiet_mujoco():
        spec.attach(arm_spec(arm, is_decimated=is_decimated), prefix=PREFIX, frame=base)
    return spec.site(f"{PREFIX}{arm.mount_site}")


def build_arm_spec(arm: ArmDescription, *, is_decimated: bool = False) -> mujoco.MjSpec:
    """Spec of a described arm: bodies link0 onwards, joints and actuators arm_joint1 onwards, site of the flange.

    Raises:
        MissingPackage: where the arm's meshes are not installed.
    """
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
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
            if is_decimated:
                mesh = spec.mesh(f"link{n}_visual")
                mesh.uservert, mesh.userface = _decimate(Path(mesh.file))
                mesh.file = ""
        parent = body
    parent.add_site(name=FLANGE, pos=[0, 0, arm.flange])
    # MuJoCo excludes neighbours only where both move; links two apart share the housing of a joint.
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
    body.gravcomp = 1.0  # The controller compensates gravity.


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


@lru_cache(maxsize=16)
def _decimate(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and faces of a mesh file, reduced to `FACES` triangles by quadric error decimation.

    Garland and Heckbert, "Surface simplification using quadric error metrics", 1997, as implemented in trimesh.
    """
    import trimesh

    mesh = trimesh.load_mesh(path)
    mesh = mesh if len(mesh.faces) <= FACES else mesh.simplify_quadric_decimation(face_count=FACES)
    return np.ravel(mesh.vertices), np.ravel(mesh.faces)


def read_limits(model: mujoco.MjModel) -> ArmLimits:
    """Limits of position and torque of a model with one actuator per joint.

    The torque of a joint is limited by the smaller of the joint's and the actuator's range of forces; an asymmetric
    range counts as no limit.
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
    """Bound of each symmetric range, shape (n,); infinite for an asymmetric one."""
    is_known = is_limited.astype(bool) & (span[:, 0] == -span[:, 1])
    return np.where(is_known, span[:, 1], np.inf)


def _check_sizes(model: mujoco.MjModel, what: str) -> None:
    """Refuse lengths, masses and inertias of an MJCF file that no arm has."""
    positions = model.body_pos, model.body_ipos, model.geom_pos, model.site_pos, model.jnt_pos
    for quantity, unit, arrays, most in (
        ("a position", "m", positions, LENGTH_MOST), ("a mass", "kg", (model.body_mass,), MASS_MOST),
        ("an inertia", "kg m^2", (model.body_inertia,), MASS_MOST * LENGTH_MOST**2),
    ):  # fmt: skip
        largest = max(float(np.abs(array).max(initial=0.0)) for array in arrays)
        if not largest <= most:
            raise refusal(what, f"one with {quantity} of {largest:.3g} {unit}", f"at most {most:g} {unit}")


def _load_spec(arm: ArmDesign) -> mujoco.MjSpec:
    path = Path(arm.model)
    if not path.is_file():
        names = ", ".join(f'"{name}"' for name in ARMS)
        raise DesignError("arm.model", got=arm.model, allowed=f"{names} or the path of an MJCF file")
    what = f"arm.model {path.name!r}"
    spec = load_mjcf_spec(read_file(arm.model, "arm.model"), path, what)
    model = compile_spec(spec)
    _check_sizes(model, what)
    sites = [model.site(i).name for i in range(model.nsite)]
    if arm.mount_site not in sites:
        known = ", ".join(name for name in sites if name) or "none"
        raise DesignError("arm.mount_site", got=arm.mount_site, allowed=f"a site of {path.name}: {known}")
    driven = [int(j) for j, kind in zip(model.actuator_trnid[:, 0], model.actuator_trntype, strict=True) if kind == 0]
    is_driven = model.nq == model.nv == model.nu and sorted(driven) == list(range(model.nv))
    # The gain of a position actuator is the negative of its bias.
    if not (is_driven and (model.actuator_gainprm[:, 0] == -model.actuator_biasprm[:, 1]).all()
            and (model.actuator_gainprm[:, 0] > 0).all()):  # fmt: skip
        allowed = "an arm of hinges and slides with one position actuator on each joint"
        raise DesignError("arm.model", got=f"{arm.model}: {model.nu} actuators, {model.nv} joints", allowed=allowed)
    mount, compiled = spec.site(arm.mount_site), model.site(arm.mount_site)
    # The file may give the orientation as Euler angles or axes, which only the compiler turns into a quaternion.
    mount.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
    mount.pos, mount.quat = compiled.pos, compiled.quat
    return spec
