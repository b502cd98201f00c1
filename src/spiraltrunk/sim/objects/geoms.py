"""Geoms of an object, and the mass distribution of the whole."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import final

import mujoco
import numpy as np

FORMS = {
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
    "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
    "ellipsoid": mujoco.mjtGeom.mjGEOM_ELLIPSOID,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "mesh": mujoco.mjtGeom.mjGEOM_MESH,
}
"""Forms of a geom and MuJoCo's types."""

_EYE, _ZERO = np.eye(3), np.zeros(3)

HIDDEN = 3
"""MuJoCo's first group of geoms that are not drawn; those that are drawn inexactly collide in it."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Geom:
    """One convex shape of an object, and its pose in the object's frame."""

    form: str
    """One of `FORMS`."""
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """MuJoCo's geom size for the form; unused for a mesh [m]."""
    position: np.ndarray = field(default_factory=lambda: np.zeros(3))
    """Position of its middle, shape (3,) [m]."""
    rotation: np.ndarray = field(default_factory=lambda: np.eye(3))
    """Rotation, its axes as columns, shape (3, 3) [-]."""
    vertices: np.ndarray | None = None
    """Vertices of a mesh in its own frame, shape (n, 3) [m]."""
    faces: np.ndarray | None = None
    """Triangles of a mesh, counter-clockwise from outside, shape (m, 3)."""
    collides: bool = True
    """Whether it collides; a mesh collides by its convex hull."""
    group: int = 0
    """MuJoCo's geom group; 0 to 2 are drawn."""

    def reach(self, direction: np.ndarray) -> float:
        """Support function: largest coordinate along a unit ``direction``, from the object's origin [m]."""
        own = self.rotation.T @ direction
        a, b, c = self.size
        if self.vertices is not None:
            far = float((self.vertices @ own).max())
        elif self.form == "sphere":
            far = a
        elif self.form == "capsule":
            far = a + b * abs(own[2])
        elif self.form == "cylinder":
            far = a * float(np.hypot(own[0], own[1])) + b * abs(own[2])
        elif self.form == "ellipsoid":
            far = float(np.linalg.norm(np.array([a, b, c]) * own))
        else:
            far = float(np.array([a, b, c]) @ np.abs(own))
        return float(self.position @ direction) + far

    def transformed(self, *, rotation: np.ndarray = _EYE, factor: float = 1.0, offset: np.ndarray = _ZERO) -> Geom:
        """The geom of an object that is rotated about its origin, scaled and then moved by ``offset`` [m]."""
        a, b, c = self.size
        return replace(
            self, size=(a * factor, b * factor, c * factor), position=rotation @ self.position * factor + offset,
            rotation=rotation @ self.rotation, vertices=None if self.vertices is None else self.vertices * factor,
        )  # fmt: skip


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Solid:
    """Geoms and their mass distribution per unit mass; the origin is the middle of the colliding geoms."""

    geoms: tuple[Geom, ...]
    """Shapes that collide or are drawn."""
    centroid: np.ndarray
    """Centre of mass, shape (3,) [m]."""
    inertia: np.ndarray
    """Inertia about the centre of mass over the mass, shape (3, 3) [m^2]."""
    excess: float = 0.0
    """Relative excess of the colliding volume over the true volume [-]."""
    volume: float | None = None
    """True volume, where it is not that of the geoms [m^3]."""

    def extents(self) -> tuple[float, float, float]:
        """Extents along x, y and z [m]."""
        low, high = compute_bounds(self.geoms)
        return tuple((high - low).tolist())

    def transformed(self, *, rotation: np.ndarray = _EYE, factor: float = 1.0, offset: np.ndarray = _ZERO) -> Solid:
        """The solid rotated about its origin, scaled and then moved by ``offset`` [m]."""
        geoms = (geom.transformed(rotation=rotation, factor=factor, offset=offset) for geom in self.geoms)
        centroid = rotation @ self.centroid * factor + offset
        return replace(
            self, geoms=tuple(geoms), centroid=centroid, inertia=rotation @ self.inertia @ rotation.T * factor**2,
            volume=None if self.volume is None else self.volume * factor**3,
        )  # fmt: skip

    def aligned(self, axis: str) -> Solid:
        """The solid with ``axis`` (x, y, z or longest) turned onto x and the origin in the middle of its extents.

        The two other axes follow in turn. The longest is that of the extents, the first of equals.
        """
        turned = self.transformed(rotation=axis_rotation(axis, self.extents()))
        low, high = compute_bounds(turned.geoms)
        return turned.transformed(offset=-(low + high) / 2)


def axis_rotation(axis: str, extents: tuple[float, float, float]) -> np.ndarray:
    """Rotation that turns ``axis`` (x, y, z or longest) onto x, the others following in turn, shape (3, 3) [-]."""
    first = "xyz".index(axis) if axis != "longest" else int(np.argmax(np.round(extents, 9)))
    return np.roll(np.eye(3), -first, axis=0)


def compute_bounds(geoms: tuple[Geom, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest coordinates of all colliding geoms, two of shape (3,) [m]."""
    axes, colliding = np.eye(3), [geom for geom in geoms if geom.collides]
    high = np.array([max(geom.reach(axis) for geom in colliding) for axis in axes])
    low = np.array([-max(geom.reach(-axis) for geom in colliding) for axis in axes])
    return low, high


def add_geom(spec: mujoco.MjSpec, body: mujoco.MjsBody, geom: Geom, name: str) -> mujoco.MjsGeom:
    """Add the geom to a body, without mass of its own."""
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, geom.rotation.ravel())
    added = body.add_geom(name=name, type=FORMS[geom.form], pos=geom.position, quat=quat, group=geom.group, mass=0)
    if geom.vertices is not None and geom.faces is not None:
        spec.add_mesh(name=name, uservert=geom.vertices.ravel(), userface=geom.faces.ravel())
        added.meshname = name
    else:
        added.size = geom.size
    if not geom.collides:
        added.contype = added.conaffinity = 0
    return added


def geom_volume(geom: Geom) -> float:
    """Volume of a geom, of a mesh that of its triangles, which is its own where they enclose one solid [m^3]."""
    a, b, c = geom.size
    if geom.vertices is not None and geom.faces is not None:
        corners = geom.vertices[geom.faces]
        return abs(float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])))) / 6
    ball = 4 / 3 * math.pi
    return {
        "sphere": ball * a**3,
        "capsule": ball * a**3 + 2 * math.pi * a**2 * b,
        "ellipsoid": ball * a * b * c,
        "cylinder": 2 * math.pi * a**2 * b,
        "box": 8 * a * b * c,
    }[geom.form]
