"""Bodies, hinges and meshes of a compiled model as URDF.

URDF has no springs, cables or limits across joints; these are in the MJCF only. Each hinge of a body after the first
has an additional link.
"""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree import ElementTree as ET

import mujoco
import numpy as np

from spiraltrunk.errors import DesignError, Unquoted

BETWEEN_MASS, BETWEEN_INERTIA = 1e-7, 1e-10
"""Mass [kg] and moment of inertia [kg m^2] of a link between two hinges of one body."""

_FORCE, _SPEED = 1000.0, 100.0
"""Effort [N m] and speed [rad/s], required in URDF, of a joint without limits in the model."""


def format_urdf(model: mujoco.MjModel, *, name: str, meshes: Mapping[str, str]) -> str:
    """The model's tree as URDF.

    Args:
        model: a compiled model of hinges, slides and fixed bodies.
        name: of the robot.
        meshes: file of each mesh, from the URDF's folder.

    Raises:
        DesignError: for a joint that URDF does not have.
    """
    robot = ET.Element("robot", name=name)
    # For MuJoCo, which otherwise looks for meshes in the URDF's folder; other readers skip it.
    ET.SubElement(
        ET.SubElement(robot, "mujoco"), "compiler", strippath="false", discardvisual="false", fusestatic="false"
    )
    ET.SubElement(robot, "link", name="world")
    for b in range(1, model.nbody):
        _add_body(robot, model, b, meshes)
    ET.indent(robot)
    return '<?xml version="1.0"?>\n' + ET.tostring(robot, encoding="unicode") + "\n"


def link_name(model: mujoco.MjModel, b: int) -> str:
    """Name of a body's link."""
    return "world" if b == 0 else _plain(model.body(b).name or f"body_{b}")


def _add_body(robot: ET.Element, model: mujoco.MjModel, b: int, meshes: Mapping[str, str]) -> None:
    parent, own = link_name(model, int(model.body_parentid[b])), link_name(model, b)
    origin = (model.body_pos[b], _to_matrix(model.body_quat[b]))
    joints = [int(model.body_jntadr[b]) + k for k in range(int(model.body_jntnum[b]))]
    shift = np.zeros(3)
    for k, j in enumerate(joints):
        # A joint's frame lies in its anchor; what follows is taken back by as much.
        child = own if k == len(joints) - 1 else f"{own}_{k + 1}"
        place = origin[0] + origin[1] @ (model.jnt_pos[j] - shift)
        _add_joint(robot, model, j, (parent, child), (place, origin[1]))
        parent, origin, shift = child, (np.zeros(3), np.eye(3)), model.jnt_pos[j].copy()
        if child != own:
            _add_between(robot, child)
    if not joints:
        joint = ET.SubElement(robot, "joint", name=f"{own}_fixed", type="fixed")
        _add_ends(joint, (parent, own), origin)
    _add_link(robot, model, b, meshes, shift)


def _add_between(robot: ET.Element, name: str) -> None:
    """A link between two hinges of one body, with nearly zero mass, as readers refuse moving links without mass."""
    inertial = ET.SubElement(ET.SubElement(robot, "link", name=name), "inertial")
    ET.SubElement(inertial, "origin", xyz="0 0 0", rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=f"{BETWEEN_MASS:g}")
    moments = {f"i{axis}{axis}": f"{BETWEEN_INERTIA:g}" for axis in "xyz"}
    ET.SubElement(inertial, "inertia", {"ixy": "0", "ixz": "0", "iyz": "0", **moments})


def _add_joint(
    robot: ET.Element,
    model: mujoco.MjModel,
    j: int,
    ends: tuple[str, str],
    origin: tuple[np.ndarray, np.ndarray],
) -> None:
    kinds = {mujoco.mjtJoint.mjJNT_HINGE: "revolute", mujoco.mjtJoint.mjJNT_SLIDE: "prismatic"}
    kind = kinds.get(mujoco.mjtJoint(int(model.jnt_type[j])))
    if kind is None:
        raise DesignError("arm.model", got=Unquoted("with a ball or free joint"), allowed="hinges and slides, for URDF")
    is_limited = bool(model.jnt_limited[j])
    joint = ET.SubElement(robot, "joint", name=_plain(model.joint(j).name), type=kind)
    _add_ends(joint, ends, origin)
    ET.SubElement(joint, "axis", xyz=_format(model.jnt_axis[j]))
    low, high = model.jnt_range[j] if is_limited else (-np.pi / 2, np.pi / 2)
    force = float(model.jnt_actfrcrange[j][1]) if model.jnt_actfrclimited[j] else _FORCE
    ET.SubElement(
        joint, "limit", lower=f"{low:.9g}", upper=f"{high:.9g}", effort=f"{force:.9g}", velocity=f"{_SPEED:g}"
    )
    damping = float(np.ravel(model.dof_damping[model.jnt_dofadr[j]])[0])
    ET.SubElement(joint, "dynamics", damping=f"{damping:.9g}", friction="0")


def _add_ends(joint: ET.Element, ends: tuple[str, str], origin: tuple[np.ndarray, np.ndarray]) -> None:
    ET.SubElement(joint, "origin", xyz=_format(origin[0]), rpy=_format(_to_rpy(origin[1])))
    ET.SubElement(joint, "parent", link=ends[0])
    ET.SubElement(joint, "child", link=ends[1])


def _add_link(robot: ET.Element, model: mujoco.MjModel, b: int, meshes: Mapping[str, str], shift: np.ndarray) -> None:
    link = ET.SubElement(robot, "link", name=link_name(model, b))
    if model.body_mass[b] > 0:
        inertial = ET.SubElement(link, "inertial")
        turn = _to_matrix(model.body_iquat[b])
        ET.SubElement(inertial, "origin", xyz=_format(model.body_ipos[b] - shift), rpy=_format(_to_rpy(turn)))
        ET.SubElement(inertial, "mass", value=f"{model.body_mass[b]:.12g}")
        moments = {f"i{axis}{axis}": f"{value:.12g}" for axis, value in zip("xyz", model.body_inertia[b], strict=True)}
        ET.SubElement(inertial, "inertia", {"ixy": "0", "ixz": "0", "iyz": "0", **moments})
    first = int(model.body_geomadr[b])
    for g in range(first, first + int(model.body_geomnum[b])):
        _add_geom(link, model, g, meshes, shift)


def _add_geom(link: ET.Element, model: mujoco.MjModel, g: int, meshes: Mapping[str, str], shift: np.ndarray) -> None:
    """A geom as visual, collision or both; a capsule is a cylinder and two spheres."""
    kind, size = mujoco.mjtGeom(int(model.geom_type[g])), model.geom_size[g]
    pos, turn = model.geom_pos[g] - shift, _to_matrix(model.geom_quat[g])
    shapes: list[tuple[str, dict[str, str], np.ndarray]] = []
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = int(model.geom_dataid[g])
        # The compiler moves a mesh to its own centre and axes; the file still has the old ones.
        own = _to_matrix(model.mesh_quat[mesh])
        turn = turn @ own.T
        pos = pos - turn @ model.mesh_pos[mesh]
        shapes.append(("mesh", {"filename": meshes[model.mesh(mesh).name]}, np.zeros(3)))
    elif kind in (mujoco.mjtGeom.mjGEOM_CYLINDER, mujoco.mjtGeom.mjGEOM_CAPSULE):
        shapes.append(("cylinder", {"radius": f"{size[0]:.9g}", "length": f"{2 * size[1]:.9g}"}, np.zeros(3)))
        if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
            shapes += [("sphere", {"radius": f"{size[0]:.9g}"}, np.array([0, 0, end * size[1]])) for end in (-1, 1)]
    elif kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        shapes.append(("sphere", {"radius": f"{size[0]:.9g}"}, np.zeros(3)))
    elif kind == mujoco.mjtGeom.mjGEOM_BOX:
        shapes.append(("box", {"size": _format(2 * size)}, np.zeros(3)))
    roles = (["visual"] if model.geom_group[g] < 3 else []) + (["collision"] if model.geom_contype[g] else [])
    for role in roles:
        for tag, attributes, offset in shapes:
            element = ET.SubElement(link, role)
            ET.SubElement(element, "origin", xyz=_format(pos + turn @ offset), rpy=_format(_to_rpy(turn)))
            ET.SubElement(ET.SubElement(element, "geometry"), tag, attributes)


def _to_matrix(quat_wxyz: np.ndarray) -> np.ndarray:
    flat = np.zeros(9)
    mujoco.mju_quat2Mat(flat, np.asarray(quat_wxyz, float))
    return flat.reshape(3, 3)


def _to_rpy(turn: np.ndarray) -> np.ndarray:
    """Roll, pitch and yaw about fixed axes: R = Rz(yaw) Ry(pitch) Rx(roll) [rad]."""
    pitch = np.arctan2(-turn[2, 0], np.hypot(turn[0, 0], turn[1, 0]))
    if np.hypot(turn[0, 0], turn[1, 0]) < 1e-9:
        return np.array([0.0, pitch, np.arctan2(-turn[0, 1], turn[1, 1])])
    return np.array([np.arctan2(turn[2, 1], turn[2, 2]), pitch, np.arctan2(turn[1, 0], turn[0, 0])])


def _format(vector: np.ndarray) -> str:
    return " ".join(f"{value + 0.0:.12g}" for value in np.where(np.abs(vector) < 1e-15, 0.0, vector))


def _plain(name: str) -> str:
    return name.replace("/", "_")
