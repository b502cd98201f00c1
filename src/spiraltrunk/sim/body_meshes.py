"""Plain meshes of the visible bodies of a compiled model, and the bodies' poses, for viewers other than MuJoCo's."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, cast, final

import mujoco
import numpy as np

from spiraltrunk.sim.render import VISIBLE_GROUPS

if TYPE_CHECKING:
    from trimesh import Trimesh

FLOOR = 2.5
"""Half width of the piece that is drawn of an endless floor [m] (ours)."""

EDGE = math.radians(25.0)
"""Angle between triangles from which their common edge is drawn as an edge [rad] (ours)."""

_SIDES, _CABLE_SIDES = 48, 6
"""Sides of round shapes, and of cables [-]."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class BodyMesh:
    """A surface of one colour that is fixed to a body."""

    body: int
    """Number of the body, as in `BodyPoses`."""
    vertices: np.ndarray
    """Vertices in the body's frame, shape (n, 3), float32 [m]; an edge has its own on each side."""
    faces: np.ndarray
    """Triangles, counter-clockwise from outside, shape (m, 3), int32."""
    color: tuple[int, int, int]
    """Red, green and blue, 0 to 255."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ModelMeshes:
    """All that is seen of a model."""

    meshes: tuple[BodyMesh, ...]
    """Surfaces."""
    n_body: int
    """Number of bodies, the world among them."""
    string_radius: float
    """Radius of the strings [m]; 0 where there are none."""


@final
class BodyPoses:
    """Poses of the bodies and ends of the strings of a model, from its generalised positions."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model = model
        self._data = mujoco.MjData(model)
        self._strings = np.array([_sites_of(model, tendon) for tendon in _find_strings(model)], int).reshape(-1, 2)

    def compute(self, qpos: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Poses by forward kinematics.

        Args:
            qpos: generalised positions, shape (n_q,) [m, rad].

        Returns:
            Position and quaternion (w first) of each body, shape (n_body, 7) [m, -], and both ends of each string,
            shape (n_string, 2, 3) [m].
        """
        data = self._data
        data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, data)
        return np.hstack([data.xpos, data.xquat]), data.site_xpos[self._strings]


def build_meshes(model: mujoco.MjModel) -> ModelMeshes:
    """Surfaces of the visible geoms, merged by body and colour, and of the cables inside the bodies they run through.

    Args:
        model: a compiled model.
    """
    import trimesh

    parts: dict[tuple[int, tuple[int, int, int]], list[Trimesh]] = {}
    for body, color, mesh in (*_list_geoms(model), *_list_cables(model)):
        parts.setdefault((body, color), []).append(mesh)
    strings = _find_strings(model)
    return ModelMeshes(
        meshes=tuple(
            _finish(body, color, cast("Trimesh", trimesh.util.concatenate(found)))
            for (body, color), found in sorted(parts.items())
        ),
        n_body=model.nbody,
        string_radius=float(model.tendon_width[strings].max()) if strings else 0.0,
    )


def _finish(body: int, color: tuple[int, int, int], mesh: Trimesh) -> BodyMesh:
    import trimesh

    shaded = trimesh.graph.smooth_shade(mesh, angle=EDGE)
    return BodyMesh(
        body=body, vertices=np.asarray(shaded.vertices, np.float32), faces=np.asarray(shaded.faces, np.int32),
        color=color,
    )  # fmt: skip


def _list_geoms(model: mujoco.MjModel) -> Iterator[tuple[int, tuple[int, int, int], Trimesh]]:
    """Body, colour and surface of each visible geom."""
    for g in np.flatnonzero(np.isin(model.geom_group, VISIBLE_GROUPS)):
        if model.geom_rgba[g, 3] == 0.0:
            continue
        mesh = _build_surface(model, int(g))
        mesh.apply_transform(_to_matrix(model.geom_pos[g], model.geom_quat[g]))
        yield int(model.geom_bodyid[g]), _color_of(model, int(g)), mesh


def _build_surface(model: mujoco.MjModel, g: int) -> Trimesh:
    """Surface of a geom in its own frame."""
    import trimesh

    kind, (a, b, c) = int(model.geom_type[g]), (float(value) for value in model.geom_size[g])
    types, create = mujoco.mjtGeom, trimesh.creation
    if kind == types.mjGEOM_MESH:
        return _read_mesh(model, int(model.geom_dataid[g]))
    if kind == types.mjGEOM_PLANE:
        return create.box(extents=(2 * (a or FLOOR), 2 * (b or FLOOR), 2e-3), transform=_to_matrix([0, 0, -1e-3]))
    if kind == types.mjGEOM_BOX:
        return create.box(extents=(2 * a, 2 * b, 2 * c))
    if kind == types.mjGEOM_CYLINDER:
        return create.cylinder(radius=a, height=2 * b, sections=_SIDES)
    if kind == types.mjGEOM_CAPSULE:
        return create.capsule(height=2 * b, radius=a, count=[_SIDES, _SIDES // 2])
    ball = create.icosphere(subdivisions=3)
    ball.apply_scale((a, b, c) if kind == types.mjGEOM_ELLIPSOID else (a, a, a))
    return ball


def _read_mesh(model: mujoco.MjModel, m: int) -> Trimesh:
    import trimesh

    vertices = model.mesh_vert[model.mesh_vertadr[m] :][: model.mesh_vertnum[m]]
    faces = model.mesh_face[model.mesh_faceadr[m] :][: model.mesh_facenum[m]]
    mesh = trimesh.Trimesh(np.array(vertices, float), np.array(faces), process=False)
    mesh.merge_vertices()
    return mesh


def _list_cables(model: mujoco.MjModel) -> Iterator[tuple[int, tuple[int, int, int], Trimesh]]:
    """Pieces of the cables between two sites of one body, which move with it."""
    import trimesh

    for tendon in np.flatnonzero(np.isin(model.tendon_group, VISIBLE_GROUPS)):
        sites, color = _sites_of(model, int(tendon)), _to_color(model.tendon_rgba[tendon])
        for one, other in pairwise(sites):
            body, ends = int(model.site_bodyid[one]), model.site_pos[[one, other]]
            if body == model.site_bodyid[other] and np.ptp(ends, axis=0).max() > 0.0:
                piece = trimesh.creation.cylinder(
                    radius=float(model.tendon_width[tendon]), segment=ends, sections=_CABLE_SIDES
                )
                yield body, color, piece


def _find_strings(model: mujoco.MjModel) -> list[int]:
    """Visible tendons between two sites of different bodies: the strings of a hung object."""
    shown = (int(t) for t in np.flatnonzero(np.isin(model.tendon_group, VISIBLE_GROUPS)))
    pairs = ((tendon, _sites_of(model, tendon)) for tendon in shown)
    return [t for t, sites in pairs if len(sites) == 2 and np.ptp(model.site_bodyid[sites]) > 0]


def _sites_of(model: mujoco.MjModel, tendon: int) -> list[int]:
    """Sites that a tendon runs through, in order."""
    first = int(model.tendon_adr[tendon])
    wraps = range(first, first + int(model.tendon_num[tendon]))
    return [int(model.wrap_objid[w]) for w in wraps if model.wrap_type[w] == mujoco.mjtWrap.mjWRAP_SITE]


def _color_of(model: mujoco.MjModel, g: int) -> tuple[int, int, int]:
    """Colour of a geom; of one with a texture, the mean."""
    material = int(model.geom_matid[g])
    if material < 0:
        return _to_color(model.geom_rgba[g])
    color = np.array(model.mat_rgba[material])
    texture = int(model.mat_texid[material].max())
    if texture >= 0:
        size = int(model.tex_height[texture] * model.tex_width[texture] * model.tex_nchannel[texture])
        pixels = model.tex_data[model.tex_adr[texture] :][:size].reshape(-1, int(model.tex_nchannel[texture]))
        color[:3] *= pixels[:, :3].mean(axis=0) / 255.0
    return _to_color(color)


def _to_color(rgba: Iterable[float]) -> tuple[int, int, int]:
    red, green, blue = (round(255 * float(value)) for value in list(rgba)[:3])
    return red, green, blue


def _to_matrix(position: Iterable[float], quat_wxyz: np.ndarray | None = None) -> np.ndarray:
    """Homogeneous matrix of a pose, shape (4, 4)."""
    matrix, turn = np.eye(4), np.eye(3).ravel()
    if quat_wxyz is not None:
        mujoco.mju_quat2Mat(turn, quat_wxyz)
    matrix[:3, :3], matrix[:3, 3] = turn.reshape(3, 3), list(position)
    return matrix
