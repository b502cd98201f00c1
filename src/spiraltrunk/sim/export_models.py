"""Export of the robot for other simulators: MJCF with its meshes, and URDF of the same compiled model.

The bodies are those of the simulation. The simulated joint limits, tendons through sites with a softness tuned after
compilation, cannot be written to a file: here a limit is a polygon of `N_SIDES` sides in the plane of a joint's two
angles.
"""

from __future__ import annotations

import math
import re
import shutil
from pathlib import Path

import mujoco
import numpy as np
from trimesh.convex import convex_hull

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.mujoco_log import compile_spec
from spiraltrunk.sim.robot.arm import add_arm, arm_home
from spiraltrunk.sim.robot.trunk import TrunkOptions, add_trunk, cable_name, hinge_names
from spiraltrunk.sim.urdf import format_urdf

N_SIDES = 12
"""Sides of the polygon that represents a joint's limit [-]; its corners lie outside by 3.5 %."""

ASSETS = "assets"
"""Name of the folder of meshes and textures, beside the models."""

KINDS = ("trunk", "hybrid")
"""Models: the trunk alone, hanging; the trunk on its arm."""

TRUNK_HEIGHT = 1.0
"""Height of the base of the trunk alone [m] (ours)."""


def build_file_spec(design: TrunkDesign, kind: str) -> mujoco.MjSpec:
    """Spec of a file: the robot, light and gravity, without floor and object."""
    spec = mujoco.MjSpec()
    spec.modelname = f"spiraltrunk_{kind}"
    spec.compiler.degree = False
    spec.option.timestep = 1e-3
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.visual.headlight.ambient = [0.4, 0.4, 0.4]
    if kind == "trunk":
        # Downwards: the trunk points along the mount's z axis.
        parent, pos, quat = spec.worldbody, [0.0, 0.0, TRUNK_HEIGHT], [0.0, 1.0, 0.0, 0.0]
    else:
        mount = add_arm(spec, design.arm)
        parent, pos, quat = mount.parent, mount.pos, mount.quat
    add_trunk(spec, parent, design, TrunkOptions(), pos=pos, quat_wxyz=quat)
    if kind == "hybrid":
        spec.add_exclude(bodyname1=parent.name, bodyname2="housing")
    _replace_limits(spec, design)
    return spec


def write_models(design: TrunkDesign, folder: Path, formats: tuple[str, ...]) -> list[Path]:
    """Write trunk and hybrid as MJCF and URDF, with their meshes and textures, and return the paths.

    Raises:
        DesignError: for an arm that cannot be read, or that URDF cannot represent.
        OSError: where a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    written: list[Path] = []
    for kind in KINDS:
        spec = build_file_spec(design, kind)
        written += _write_assets(spec, folder / ASSETS)
        model = compile_spec(spec)
        if "mjcf" in formats:
            _add_keyframe(spec, model, design, kind)
            compile_spec(spec)
            path = folder / f"{kind}.xml"
            path.write_text(re.sub(r'(file\w*)="[^"]*/([^"/]+)"', rf'\1="{ASSETS}/\2"', spec.to_xml()))
            written.append(path)
        if "urdf" in formats:
            path = folder / f"{kind}.urdf"
            meshes = {mesh.name: f"{ASSETS}/{Path(mesh.file).name}" for mesh in spec.meshes}
            path.write_text(format_urdf(model, name=f"spiraltrunk_{kind}", meshes=meshes))
            written.append(path)
    return sorted(set(written))


def _replace_limits(spec: mujoco.MjSpec, design: TrunkDesign) -> None:
    """Replace the tendons through sites by polygons of joint tendons."""
    for i in range(design.n_joint):
        spec.delete(spec.tendon(f"limit_{i + 1:02d}"))
        about_y, about_z = hinge_names(i)
        for k in range(N_SIDES // 2):
            angle = 2 * math.pi * k / N_SIDES
            side = spec.add_tendon(
                name=f"limit_{i + 1:02d}_{k + 1}", limited=True, range=[-design.joint_limit, design.joint_limit],
                solref_limit=[0.003, 1], solimp_limit=[0.95, 0.999, 0.005, 0.5, 2], group=4,
            )  # fmt: skip
            if abs(math.cos(angle)) > 1e-9:
                side.wrap_joint(about_y, math.cos(angle))
            if abs(math.sin(angle)) > 1e-9:
                side.wrap_joint(about_z, math.sin(angle))


def _add_keyframe(spec: mujoco.MjSpec, model: mujoco.MjModel, design: TrunkDesign, kind: str) -> None:
    """Add the keyframe "home": the trunk straight and slack, the arm at its home posture."""
    qpos, ctrl = model.qpos0.copy(), np.zeros(model.nu)
    for c in range(design.n_cable):
        ctrl[model.actuator(cable_name(c)).id] = model.tendon_length0[model.tendon(cable_name(c)).id]
    if kind == "hybrid":
        driven = [i for i in range(model.nu) if model.actuator_trntype[i] == mujoco.mjtTrn.mjTRN_JOINT]
        home = arm_home(design.arm, len(driven))
        for i, angle in zip(driven, home, strict=True):
            ctrl[i] = angle
            qpos[model.jnt_qposadr[model.actuator_trnid[i, 0]]] = angle
    spec.add_key(name="home", qpos=qpos, ctrl=ctrl)


def _write_assets(spec: mujoco.MjSpec, folder: Path) -> list[Path]:
    """Write every mesh, and every other file of a user's arm, beside the models; the spec then refers to these."""
    folder.mkdir(exist_ok=True)
    written = [_write_mesh(spec, mesh, folder) for mesh in spec.meshes]
    for item in (*spec.textures, *spec.hfields):
        if item.file:
            written.append(_write_file(spec, item.file, folder))
            item.file = str(written[-1])
    for texture in spec.textures:
        for side, file in enumerate(texture.cubefiles):
            if file:
                written.append(_write_file(spec, file, folder))
                texture.cubefiles[side] = str(written[-1])
    return written


def _write_mesh(spec: mujoco.MjSpec, mesh: mujoco.MjsMesh, folder: Path) -> Path:
    """Write a mesh: the file that it is from, or the hull of its vertices."""
    path = folder / f"{mesh.name.replace('/', '_')}.stl"
    if mesh.file in spec.assets:
        path = _write_file(spec, mesh.file, folder)
    elif mesh.file:
        shutil.copyfile(mesh.file, path)
    else:
        convex_hull(np.array(mesh.uservert, float).reshape(-1, 3)).export(path, file_type="stl")
        mesh.uservert = np.zeros(0)
    mesh.file = str(path)
    return path


def _write_file(spec: mujoco.MjSpec, file: str, folder: Path) -> Path:
    """Write a file that a user's MJCF names, whose content the spec holds."""
    path = folder / file.replace("/", "_")
    path.write_bytes(spec.assets[file])
    return path
