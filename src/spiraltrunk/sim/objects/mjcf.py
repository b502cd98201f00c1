"""Objects from MJCF files: geoms and mass distribution of one rigid body."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
from scipy.spatial import ConvexHull

from spiraltrunk.errors import UnknownName
from spiraltrunk.sim.mujoco_log import compile_spec
from spiraltrunk.sim.objects.geoms import FORMS, Geom, Solid, axis_rotation, geom_volume
from spiraltrunk.sim.objects.meshes.mesh_file import AXES, FACES_MOST
from spiraltrunk.sim.objects.presentation import settle
from spiraltrunk.sim.objects.spec import EXTENTS, ObjectSpec, check_builds
from spiraltrunk.sim.user_files.compile_check import load_mjcf_spec
from spiraltrunk.sim.user_files.regular_file import read_file, refusal

GEOMS_MOST = 200
"""Largest number of geoms of a body."""


def load_mjcf(path: str, *, axis: str = "longest", mass: float | None = None) -> ObjectSpec:
    """The one rigid body of an MJCF file, with the mass and inertia of the file, oriented as in the file's world.

    With a ``mass`` [kg] of its own, the inertia changes in the same proportion. Geoms of the world, such as a floor,
    and lights are left out. Friction, contact constants and colours are those of every object. Geoms that collide with
    nothing are only drawn.

    Raises:
        DesignError: for a file that exceeds a limit of `load_mjcf_spec` or that MuJoCo does not load, or that is not
            one rigid body of 5 mm to 1 m.
        UnknownName: for an axis that does not exist.
    """
    if axis not in AXES:
        raise UnknownName("axis", axis, AXES)
    what = f"the file {Path(path).name!r}"
    model = _compile(load_mjcf_spec(read_file(path, "mjcf:path"), Path(path), what))
    _check_body(model, what)
    data = _at_origin(model)
    geoms = tuple(_geom(model, data, g, what) for g in range(model.ngeom) if model.geom_bodyid[g] > 0)
    if not any(geom.collides for geom in geoms):
        raise refusal(what, "without a geom that collides", "at least one, its contype or conaffinity not 0")
    if (count := sum(0 if geom.faces is None else len(geom.faces) for geom in geoms)) > FACES_MOST:
        raise refusal(what, f"of {count} triangles", f"up to {FACES_MOST}; a coarser export has fewer")
    stated = float(model.body_subtreemass[1])
    if not stated > 0:
        raise refusal(what, f"of {1e3 * stated:g} g", "some mass: give it a density or an inertial")
    xx, yy, zz, xy, xz, yz = data.crb[1, :6] / stated  # About the centre of mass, along the world's axes.
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    solid = Solid(geoms=geoms, centroid=data.subtree_com[1].copy(), inertia=inertia, excess=_find_excess(geoms))
    _check_extents(solid, what)
    up = axis_rotation(axis, solid.extents())[:, 2]
    solid = solid.aligned(axis)
    _check_inertia(solid, what)
    shape = ObjectSpec(kind="mjcf", size=solid.extents(), mass=stated if mass is None else mass, loaded=solid)
    shape = check_builds(shape, path)
    return settle(shape, up) if axis == "longest" else shape


def _compile(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """The model with the exact mass distribution of closed meshes; of others MuJoCo's own, right for convex ones."""
    model = compile_spec(spec)
    closed = [
        mesh for mesh in spec.meshes
        if mesh.inertia == mujoco.mjtMeshInertia.mjMESH_INERTIA_LEGACY and _is_closed(*_read_mesh(model, mesh.id))
    ]  # fmt: skip
    for mesh in closed:
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_EXACT
    return compile_spec(spec) if closed else model


def _read_mesh(model: mujoco.MjModel, number: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices, shape (n, 3) [m], and triangles, shape (m, 3), of a mesh."""
    mesh = model.mesh(number)
    vertices = model.mesh_vert[mesh.vertadr[0] :][: mesh.vertnum[0]].astype(float)
    return vertices, model.mesh_face[mesh.faceadr[0] :][: mesh.facenum[0]].astype(np.int64)


def _is_closed(vertices: np.ndarray, faces: np.ndarray) -> bool:
    """Whether triangles enclose a volume and all face outwards."""
    import trimesh

    mesh = trimesh.Trimesh(vertices, faces)  # Its corners are merged.
    return bool(mesh.is_watertight and mesh.is_winding_consistent and mesh.volume > 0)


def _check_body(model: mujoco.MjModel, what: str) -> None:
    tops = [b for b in range(1, model.nbody) if model.body_parentid[b] == 0]
    if len(tops) != 1:
        raise refusal(what, f"of {len(tops)} bodies on the world", "one")
    free = [j for j in range(model.njnt) if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE]
    if len(free) != model.njnt:
        raise refusal(
            what, f"of {model.njnt - len(free)} joints that bend or slide", "one rigid body, a free joint or none"
        )
    if model.ngeom > GEOMS_MOST:
        raise refusal(what, f"of {model.ngeom} geoms", f"at most {GEOMS_MOST}")


def _check_extents(solid: Solid, what: str) -> None:
    extents = solid.extents()
    if not all(EXTENTS.holds(extent) for extent in extents):
        measures = " x ".join(f"{1e3 * extent:.4g}" for extent in extents)
        allowed = '5 mm to below 1 m each way; of a mesh in mm, scale="0.001 0.001 0.001" makes m'
        raise refusal(what, f"of {measures} mm", allowed)


def _find_excess(geoms: tuple[Geom, ...]) -> float:
    """What the convex hulls of closed meshes add, over the volume of all geoms that collide [-]."""
    own = added = 0.0
    for geom in geoms:
        if not geom.collides:
            continue
        own += geom_volume(geom)
        if geom.vertices is not None and geom.faces is not None and _is_closed(geom.vertices, geom.faces):
            added += max(0.0, float(ConvexHull(geom.vertices).volume) - geom_volume(geom))
    return added / own if added > 0 else 0.0


def _check_inertia(solid: Solid, what: str) -> None:
    """Refuse a mass that does not lie in or about the geoms, or spreads farther than they do."""
    size = np.array(solid.extents())
    if (np.abs(solid.centroid) > size / 2).any():
        away = float(np.linalg.norm(solid.centroid))
        raise refusal(
            what, f"one with its centre of mass {away:.3g} m from its middle", "a centre of mass in its geoms"
        )
    gyration, most = math.sqrt(np.trace(solid.inertia) / 2), float(np.linalg.norm(size))
    if not 1e-3 * most < gyration < most:
        allowed = f"{1e-3 * most:.3g} m to {most:.3g} m, by its extents"
        raise refusal(what, f"one with a radius of gyration of {gyration:.3g} m", allowed)


def _at_origin(model: mujoco.MjModel) -> mujoco.MjData:
    """Poses and composite inertia of the body, its origin moved to the world's and its orientation that of the file."""
    data = mujoco.MjData(model)
    model.body_pos[1] = data.mocap_pos[:] = 0
    if model.njnt:
        data.qpos[:] = [0, 0, 0, *model.body_quat[1]]
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_crb(model, data)
    return data


def _geom(model: mujoco.MjModel, data: mujoco.MjData, g: int, what: str) -> Geom:
    form = next((name for name, kind in FORMS.items() if int(kind) == model.geom_type[g]), None)
    if form is None:
        kind = mujoco.mjtGeom(int(model.geom_type[g])).name.removeprefix("mjGEOM_").lower()
        raise refusal(what, f"of geoms such as {kind}", f"geoms of type {', '.join(FORMS)}")
    vertices = faces = None
    if form == "mesh":
        vertices, faces = _read_mesh(model, int(model.geom_dataid[g]))
    a, b, c = (float(value) for value in model.geom_size[g])
    return Geom(
        form=form, size=(a, b, c), position=data.geom_xpos[g].copy(),
        rotation=data.geom_xmat[g].reshape(3, 3).copy(), vertices=vertices, faces=faces,
        collides=bool(model.geom_contype[g] or model.geom_conaffinity[g]), group=int(model.geom_group[g]),
    )  # fmt: skip
