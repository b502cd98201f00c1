"""Geoms of an object: convex collision shapes, and the mass distribution of the whole."""

from __future__ import annotations

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

HIDDEN = 3
"""MuJoCo's group of geoms that collide and are not drawn."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Geom:
    """One shape of an object and its pose."""

    form: str
    """One of `FORMS`."""
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """MuJoCo's geom size for the form; unused for a mesh [m]."""
    position: np.ndarray = field(default_factory=lambda: np.zeros(3))
    """Its middle in the object's frame, shape (3,) [m]."""
    rotation: np.ndarray = field(default_factory=lambda: np.eye(3))
    """Its axes in the object's frame, as columns, shape (3, 3) [-]."""
    vertices: np.ndarray | None = None
    """Corners of a mesh in its own frame, shape (n, 3) [m]."""
    faces: np.ndarray | None = None
    """Triangles of a mesh, counter-clockwise from outside, shape (m, 3)."""
    collides: bool = True
    """Whether it collides; a mesh collides by its convex hull."""
    group: int = 0
    """MuJoCo's geom group; 0 to 2 are drawn."""

    def reach(self, direction: np.ndarray) -> float:
        """Support function: largest coordinate of the geom along a unit ``direction``, from the object's origin [m]."""
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

    def moved(self, offset: np.ndarray) -> Geom:
        """The geom shifted by ``offset`` [m]."""
        return replace(self, position=self.position + offset)

    def turned(self, rotation: np.ndarray) -> Geom:
        """The geom rotated about the object's origin."""
        return replace(self, position=rotation @ self.position, rotation=rotation @ self.rotation)

    def scaled(self, factor: float) -> Geom:
        """The geom scaled about the object's origin."""
        a, b, c = self.size
        vertices = None if self.vertices is None else self.vertices * factor
        return replace(
            self, size=(a * factor, b * factor, c * factor), position=self.position * factor, vertices=vertices
        )


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
    """Volume of the colliding geoms over the true volume, less one [-]."""

    def extents(self) -> tuple[float, float, float]:
        """Extents along x, y and z [m]."""
        low, high = compute_bounds(self.geoms)
        return tuple((high - low).tolist())

    def centered(self) -> Solid:
        """The same solid with the origin in the middle of its extents."""
        low, high = compute_bounds(self.geoms)
        middle = (low + high) / 2
        return replace(self, geoms=tuple(geom.moved(-middle) for geom in self.geoms), centroid=self.centroid - middle)

    def turned(self, rotation: np.ndarray) -> Solid:
        """The same solid turned about its origin."""
        geoms = tuple(geom.turned(rotation) for geom in self.geoms)
        return replace(
            self, geoms=geoms, centroid=rotation @ self.centroid, inertia=rotation @ self.inertia @ rotation.T
        )

    def scaled(self, factor: float) -> Solid:
        """The same solid, ``factor`` times as large."""
        geoms = tuple(geom.scaled(factor) for geom in self.geoms)
        return replace(self, geoms=geoms, centroid=self.centroid * factor, inertia=self.inertia * factor**2)


def compute_bounds(geoms: tuple[Geom, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest coordinates of all colliding geoms, two of shape (3,) [m]."""
    axes, touched = np.eye(3), [geom for geom in geoms if geom.collides]
    high = np.array([max(geom.reach(axis) for geom in touched) for axis in axes])
    low = np.array([-max(geom.reach(-axis) for geom in touched) for axis in axes])
    return low, high


def compute_turn(geoms: tuple[Geom, ...], axis: str) -> np.ndarray:
    """Rotation that brings ``axis`` (x, y, z or longest) onto x, the other two following in turn, shape (3, 3).

    The longest is that of the extents, the first of equals.
    """
    low, high = compute_bounds(geoms)
    first = "xyz".index(axis) if axis in {"x", "y", "z"} else int(np.argmax(np.round(high - low, 9)))
    return np.roll(np.eye(3), -first, axis=0)


def add_geom(spec: mujoco.MjSpec, body: mujoco.MjsBody, shape: Geom, name: str) -> mujoco.MjsGeom:
    """Add the geom to a body, without mass."""
    geom = body.add_geom(name=name, type=FORMS[shape.form], pos=shape.position, group=shape.group, mass=0)
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, shape.rotation.ravel())
    geom.quat = quat
    if shape.vertices is not None and shape.faces is not None:
        spec.add_mesh(name=name, uservert=shape.vertices.ravel(), userface=shape.faces.ravel())
        geom.meshname = name
    else:
        geom.size = shape.size
    if not shape.collides:
        geom.contype = geom.conaffinity = 0
    return geom
