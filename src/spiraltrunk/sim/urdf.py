"""A compiled model's bodies, hinges and meshes as URDF.

URDF has no springs, cables or limits across joints; these stay in the MJCF. Each hinge beyond a body's first gets a
link of its own.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from xml.etree import ElementTree as ET

import mujoco
import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from spiraltrunk.errors import DesignError, Unquoted

BETWEEN_MASS, BETWEEN_INERTIA = 1e-7, 1e-10
"""Mass [kg] and moment of inertia [kg m^2] of a link between two hinges of one body; readers refuse a mass of 0."""

_FORCE, _SPEED = 1000.0, 100.0
"""Effort [N m] and speed [rad/s] of a revolute joint, which URDF requires, where the model limits neither."""

_JOINTS = {mujoco.mjtJoint.mjJNT_HINGE: "revolute", mujoco.mjtJoint.mjJNT_SLIDE: "prismatic"}


def format_urdf(model: mujoco.MjModel, *, name: str, meshes: Mapping[str, str]) -> str:
    """The model's tree as URDF.

    Args:
        model: a compiled model of hinges, slides and fixed bodies.
        name: name of the robot.
        meshes: file of each mesh, relative to the URDF's folder.

    Raises:
        DesignError: for a joint that URDF does not have.
    """
    robot = ET.Element("robot", name=name)
    # Other readers skip this; without it MuJoCo would look for the meshes beside the file.
    compiler = {"strippath": "false", "discardvisual": "false", "fusestatic": "false"}
    ET.SubElement(ET.SubElement(robot, "mujoco"), "compiler", compiler)
    ET.SubElement(robot, "link", name="world")
    for b in range(1, model.nbody):
        _add_body(robot, model, b, meshes)
    ET.indent(robot)
    return '<?xml version="1.0"?>\n' + ET.tostring(robot, encoding="unicode") + "\n"


def _add_body(robot: ET.Element, model: mujoco.MjModel, b: int, meshes: Mapping[str, str]) -> None:
    """Add the joints and links of a body; ``shift`` is the last joint's anchor, the origin of the body's link."""
    parent, own = (_plain(model.body(i).name or f"body_{i}") for i in (model.body_parentid[b], b))
    pos, turn, shift = model.body_pos[b], _rotation(model.body_quat[b]), np.zeros(3)
    first, count = model.body_jntadr[b], model.body_jntnum[b]
    for k, j in enumerate(range(first, first + count), start=1):
        child = own if k == count else f"{own}_{k}"
        joint = _add_joint(robot, model, j)
        _add_ends(joint, parent, child, pos + turn.apply(model.jnt_pos[j] - shift), turn)
        if k < count:
            link = ET.SubElement(robot, "link", name=child)
            _add_inertial(link, BETWEEN_MASS, np.full(3, BETWEEN_INERTIA), np.zeros(3), Rotation.identity())
        parent, pos, turn, shift = child, np.zeros(3), Rotation.identity(), model.jnt_pos[j]
    if count == 0:
        _add_ends(ET.SubElement(robot, "joint", name=f"{own}_fixed", type="fixed"), parent, own, pos, turn)
    link = ET.SubElement(robot, "link", name=own)
    if model.body_mass[b] > 0:
        turn = _rotation(model.body_iquat[b])
        _add_inertial(link, model.body_mass[b], model.body_inertia[b], model.body_ipos[b] - shift, turn)
    for g in range(model.body_geomadr[b], model.body_geomadr[b] + model.body_geomnum[b]):
        _add_geom(link, model, g, meshes, shift)


def _add_joint(robot: ET.Element, model: mujoco.MjModel, j: int) -> ET.Element:
    kind = _JOINTS.get(mujoco.mjtJoint(int(model.jnt_type[j])))
    if kind is None:
        raise DesignError("arm.model", got=Unquoted("with a ball or free joint"), allowed="hinges and slides, for URDF")
    joint = ET.SubElement(robot, "joint", name=_plain(model.joint(j).name), type=kind)
    ET.SubElement(joint, "axis", xyz=_format(model.jnt_axis[j]))
    low, high = model.jnt_range[j] if model.jnt_limited[j] else (-np.pi / 2, np.pi / 2)
    force = model.jnt_actfrcrange[j][1] if model.jnt_actfrclimited[j] else _FORCE
    limit = {"lower": f"{low:.9g}", "upper": f"{high:.9g}", "effort": f"{force:.9g}", "velocity": f"{_SPEED:g}"}
    ET.SubElement(joint, "limit", limit)
    damping = float(np.ravel(model.dof_damping[model.jnt_dofadr[j]])[0])
    ET.SubElement(joint, "dynamics", damping=f"{damping:.9g}", friction="0")
    return joint


def _add_ends(joint: ET.Element, parent: str, child: str, pos: np.ndarray, turn: Rotation) -> None:
    """Put a joint's pose, parent and child before its other elements."""
    ends = ET.Element("origin", _origin(pos, turn)), ET.Element("parent", link=parent), ET.Element("child", link=child)
    for k, end in enumerate(ends):
        joint.insert(k, end)


def _add_inertial(link: ET.Element, mass: float, moments: np.ndarray, pos: np.ndarray, turn: Rotation) -> None:
    inertial = ET.SubElement(link, "inertial")
    ET.SubElement(inertial, "origin", _origin(pos, turn))
    ET.SubElement(inertial, "mass", value=f"{mass:.12g}")
    values = dict(zip(("ixx", "iyy", "izz"), (f"{value:.12g}" for value in moments), strict=True))
    ET.SubElement(inertial, "inertia", {"ixy": "0", "ixz": "0", "iyz": "0", **values})


def _add_geom(link: ET.Element, model: mujoco.MjModel, g: int, meshes: Mapping[str, str], shift: np.ndarray) -> None:
    """Add a geom as visual, collision, or both; a capsule is a cylinder and two spheres."""
    kind, size = mujoco.mjtGeom(int(model.geom_type[g])), model.geom_size[g]
    pos, turn, middle = model.geom_pos[g] - shift, _rotation(model.geom_quat[g]), np.zeros(3)
    radius, length = f"{size[0]:.9g}", f"{2 * size[1]:.9g}"
    shapes: list[tuple[str, dict[str, str], np.ndarray]] = []
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = int(model.geom_dataid[g])
        # The compiler moves a mesh to its own centre and axes; the file still has the old ones.
        turn = turn * _rotation(model.mesh_quat[mesh]).inv()
        pos = pos - turn.apply(model.mesh_pos[mesh])
        attributes = {"filename": meshes[model.mesh(mesh).name]}
        if (scale := model.mesh_scale[mesh]).tolist() != [1.0, 1.0, 1.0]:
            attributes["scale"] = _format(scale)
        shapes.append(("mesh", attributes, middle))
    if kind in (mujoco.mjtGeom.mjGEOM_CYLINDER, mujoco.mjtGeom.mjGEOM_CAPSULE):
        shapes.append(("cylinder", {"radius": radius, "length": length}, middle))
    if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        shapes += [("sphere", {"radius": radius}, np.array([0, 0, end * size[1]])) for end in (-1, 1)]
    if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        shapes.append(("sphere", {"radius": radius}, middle))
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        shapes.append(("box", {"size": _format(2 * size)}, middle))
    for role, is_used in (("visual", model.geom_group[g] < 3), ("collision", model.geom_contype[g] > 0)):
        for tag, attributes, offset in shapes if is_used else []:
            element = ET.SubElement(link, role)
            ET.SubElement(element, "origin", _origin(pos + turn.apply(offset), turn))
            ET.SubElement(ET.SubElement(element, "geometry"), tag, attributes)


def _origin(pos: np.ndarray, turn: Rotation) -> dict[str, str]:
    """Position and roll, pitch, yaw about fixed axes, R = Rz(yaw) Ry(pitch) Rx(roll) [rad]."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # Gimbal lock: the roll is 0.
        yaw, pitch, roll = turn.as_euler("ZYX")
    return {"xyz": _format(pos), "rpy": _format([roll, pitch, yaw])}


def _rotation(quat_wxyz: np.ndarray) -> Rotation:
    return Rotation.from_quat(np.roll(quat_wxyz, -1))


def _plain(name: str) -> str:
    return name.replace("/", "_")


def _format(vector: ArrayLike) -> str:
    return " ".join(f"{value + 0.0:.12g}" for value in np.where(np.abs(vector) < 1e-15, 0.0, vector))
