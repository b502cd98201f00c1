"""Objects from MJCF files: geoms and mass distribution of one rigid body."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np

from spiraltrunk.errors import UnknownName
from spiraltrunk.sim.mujoco_log import quiet_mujoco
from spiraltrunk.sim.objects.geoms import FORMS, Geom, Solid, compute_turn
from spiraltrunk.sim.objects.stl import AXES, FACES_MOST, read_bytes, refusal

GEOMS_MOST = 200
"""Largest number of geoms of a body."""


def load_mjcf_solid(path: str, *, axis: str = "longest") -> tuple[Solid, float]:
    """The one rigid body of a file and its mass [kg].

    Floor and lights of the file are left out. Friction, contact parameters and colours are those of all objects. Geoms
    that do not collide are only drawn.

    Raises:
        DesignError: for a file that MuJoCo does not load, or that is not one rigid body.
        UnknownName: for an axis that does not exist.
    """
    if axis not in AXES:
        raise UnknownName("axis", axis, AXES)
    read_bytes(path, "mjcf")
    model = _load(path)
    _check_body(model, path)
    data = _at_origin(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    geoms = tuple(_read_geom(model, data, g, path) for g in range(model.ngeom) if model.geom_bodyid[g] > 0)
    touched = tuple(geom for geom in geoms if geom.collides)
    if not touched or sum(0 if geom.faces is None else len(geom.faces) for geom in geoms) > FACES_MOST:
        raise refusal(path, "without a geom that collides, or too fine", f"a geom, {FACES_MOST} triangles")
    centroid, inertia, mass = _weigh(model, data)
    if not mass > 0:
        raise refusal(path, f"of {1e3 * mass:g} g", "some mass: give it a density or an inertial")
    solid = Solid(geoms=geoms, centroid=centroid, inertia=inertia)
    return solid.turned(compute_turn(touched, axis)).centered(), mass


def _load(path: str) -> mujoco.MjModel:
    try:
        with quiet_mujoco():
            return mujoco.MjSpec.from_file(str(Path(path).expanduser())).compile()
    except (ValueError, mujoco.FatalError) as error:
        said = " ".join(str(error).split())[:200]
        raise refusal(path, "no MJCF that MuJoCo loads", f"what it loads; it says: {said}") from error


def _check_body(model: mujoco.MjModel, path: str) -> None:
    tops = [b for b in range(1, model.nbody) if model.body_parentid[b] == 0]
    if len(tops) != 1:
        raise refusal(path, f"of {len(tops)} bodies on the world", "one")
    free = [j for j in range(model.njnt) if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE]
    if len(free) != model.njnt:
        raise refusal(
            path, f"of {model.njnt - len(free)} joints that bend or slide", "one rigid body, a free joint or none"
        )
    if model.ngeom > GEOMS_MOST:
        raise refusal(path, f"of {model.ngeom} geoms", f"at most {GEOMS_MOST}")


def _at_origin(model: mujoco.MjModel) -> mujoco.MjData:
    """Data with the body's frame at the world's origin."""
    data = mujoco.MjData(model)
    model.body_pos[1], model.body_quat[1] = 0, [1, 0, 0, 0]
    if model.njnt:
        data.qpos[:] = [0, 0, 0, 1, 0, 0, 0]
    return data


def _read_geom(model: mujoco.MjModel, data: mujoco.MjData, g: int, path: str) -> Geom:
    form = next((name for name, kind in FORMS.items() if int(kind) == model.geom_type[g]), None)
    if form is None:
        kind = mujoco.mjtGeom(int(model.geom_type[g])).name.removeprefix("mjGEOM_").lower()
        raise refusal(path, f"of geoms such as {kind}", f"geoms of type {', '.join(FORMS)}")
    vertices = faces = None
    if form == "mesh":
        mesh = model.mesh(model.geom_dataid[g])
        vertices = model.mesh_vert[mesh.vertadr[0] :][: mesh.vertnum[0]].astype(float)
        faces = model.mesh_face[mesh.faceadr[0] :][: mesh.facenum[0]].astype(np.int64)
    a, b, c = (float(value) for value in model.geom_size[g])
    return Geom(
        form=form, size=(a, b, c), position=data.geom_xpos[g].copy(),
        rotation=data.geom_xmat[g].reshape(3, 3).copy(), vertices=vertices, faces=faces,
        collides=bool(model.geom_contype[g] or model.geom_conaffinity[g]), group=int(model.geom_group[g]),
    )  # fmt: skip


def _weigh(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[np.ndarray, np.ndarray, float]:
    """Centre of mass, inertia about it per mass, and mass, of all bodies together (parallel axes)."""
    masses, centers = model.body_mass[1:], data.xipos[1:]
    total = float(masses.sum())
    if not total > 0:
        return np.zeros(3), np.zeros((3, 3)), total
    middle = masses @ centers / total
    inertia = np.zeros((3, 3))
    for mass, center, principal, frame in zip(masses, centers, model.body_inertia[1:], data.ximat[1:], strict=True):
        turn, arm = frame.reshape(3, 3), center - middle
        inertia += turn @ np.diag(principal) @ turn.T + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return middle, inertia / total, total
