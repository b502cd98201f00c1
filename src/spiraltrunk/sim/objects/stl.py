"""Objects from STL files: reading, checks of the surface and mass distribution."""

from __future__ import annotations

import io
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from spiraltrunk.errors import MissingPackage, UnknownName
from spiraltrunk.sim.objects.geoms import HIDDEN, Geom, Solid
from spiraltrunk.sim.objects.spec import EXTENTS, ObjectSpec, check_builds
from spiraltrunk.sim.user_files.limited_process import run_limited
from spiraltrunk.sim.user_files.regular_file import read_file, refusal

if TYPE_CHECKING:
    from trimesh import Trimesh

UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 25.4e-3}
"""Units of a file [m]."""

AXES = ("longest", "x", "y", "z")
"""Directions of a file that can become the object's axis."""

COLLIDES = ("hull", "parts")
"""Collision shapes of a mesh: its convex hull, or convex parts."""

FACES_MOST = 100_000
"""Largest number of triangles of a mesh."""

PARTS_MOST = 24
"""Largest number of convex parts of a mesh (ours)."""

CONCAVITY = 0.05
"""Largest concavity of a part, CoACD's default threshold (Wei et al., SIGGRAPH 2022) [-]."""

DECOMPOSITION_MOST = 120
"""Longest time that the decomposition into convex parts may take [s] (ours)."""

SAMPLES_MOST = 200
"""Largest number of triangles at which the winding number is computed."""

MERGE_DIGITS = 7
"""Decimals of a metre to which equal vertices are merged."""


def load_stl(path: str, *, unit: str, mass: float, axis: str = "longest", collide: str = "hull") -> ObjectSpec:
    """An object of uniform density with the surface of an STL file.

    Volume, centre of mass and inertia are integrals over the surface (divergence theorem), exact for the triangles.
    MuJoCo collides only convex shapes: with ``collide="hull"`` the convex hull of the whole; `ObjectSpec.warning` is
    set where its volume is larger by more than 5 %. With ``"parts"``, up to `PARTS_MOST` convex parts, found by the
    package coacd in at most `DECOMPOSITION_MOST`. The surface is tested for self-intersection at up to `SAMPLES_MOST`
    triangles; a small intersection can be missed.

    Args:
        path: the file, binary or ASCII.
        unit: unit of its coordinates, m, cm, mm or in; an STL has none.
        mass: mass of the object [kg].
        axis: direction that becomes the object's axis: longest, x, y or z.
        collide: hull or parts.

    Raises:
        DesignError: for a file that cannot be read, or whose surface does not enclose one solid of 5 mm to 1 m.
        UnknownName: for a unit, an axis or a way to collide that does not exist.
        MissingPackage: for ``"parts"`` without coacd.
    """
    for what, name, known in (("unit", unit, UNITS), ("axis", axis, AXES), ("way to collide", collide, COLLIDES)):
        if name not in known:
            raise UnknownName(what, name, known)
    what = f"the file {Path(path).name!r}"
    mesh = _read(read_file(path, "stl:path"), what)
    mesh.vertices = mesh.vertices * UNITS[unit]
    _check_size(mesh, what, unit)
    _clean(mesh)
    _check_surface(mesh, what)
    solid = _build(mesh, axis, collide, what)
    return check_builds(ObjectSpec(kind="mesh", size=solid.extents(), mass=mass, loaded=solid), path)


def winding_numbers(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Winding number of a surface about each point: 1 inside a valid solid, 0 outside, -1 inside an inverted one.

    The sum of the triangles' solid angles over 4 pi (van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 1983).

    Args:
        points: shape (n, 3) [m].
        corners: corners of the triangles, counter-clockwise from outside, shape (m, 3, 3) [m].
    """

    def dot(one: np.ndarray, other: np.ndarray) -> np.ndarray:
        return np.asarray(np.einsum("ij,ij->j", one, other))

    turns = np.empty(len(points))
    sides = np.ascontiguousarray(corners.transpose(1, 2, 0))  # Contiguous coordinates are ten times as fast.
    for i, point in enumerate(points):
        a, b, c = sides - point[:, None]
        la, lb, lc = (np.sqrt(dot(side, side)) for side in (a, b, c))
        volume = dot(a, np.cross(b, c, axis=0))
        turns[i] = 2 * np.arctan2(volume, la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb).sum()
    return turns / (4 * np.pi)


def _read(content: bytes, what: str) -> Trimesh:
    import trimesh

    try:
        with np.errstate(all="ignore"):  # Numbers that are not finite are refused below.
            mesh = trimesh.load_mesh(io.BytesIO(content), file_type="stl", process=False)
        faces = len(mesh.faces)
        if faces == 0:  # The reader may take any bytes for an empty ASCII file.
            raise ValueError("no triangles")
    except Exception as error:  # The reader raises any kind of error for broken bytes.
        raise refusal(what, "no STL that can be read", "an STL, binary or ASCII") from error
    if not 4 <= faces <= FACES_MOST:
        raise refusal(what, f"of {faces} triangles", f"4 to {FACES_MOST}; a coarser export has fewer")
    if not np.isfinite(mesh.vertices).all():
        raise refusal(what, "not finite in some coordinates", "finite numbers; export it again")
    return mesh


def _check_size(mesh: Trimesh, what: str, unit: str) -> None:
    extents = np.ptp(mesh.vertices, axis=0)
    if not (EXTENTS.holds(float(extents.min())) and EXTENTS.holds(float(extents.max()))):
        measures = " x ".join(f"{1e3 * extent:.4g}" for extent in extents)
        others = ", ".join(name for name in UNITS if name != unit)
        allowed = f"5 mm to below 1 m each way; is its unit not {unit} but one of {others}?"
        raise refusal(what, f"of {measures} mm", allowed)


def _clean(mesh: Trimesh) -> None:
    """Merge equal vertices, and remove triangles that degenerate."""
    mesh.merge_vertices(digits_vertex=MERGE_DIGITS)
    mesh.update_faces((np.diff(np.sort(mesh.faces, axis=1)) > 0).all(axis=1))
    mesh.remove_unreferenced_vertices()


def _check_surface(mesh: Trimesh, what: str) -> None:
    """Refuse a surface that does not enclose one solid with outward triangles."""
    if not mesh.is_watertight:
        _, count = np.unique(mesh.edges_sorted, axis=0, return_counts=True)
        reason = f"not closed: {np.count_nonzero(count != 2)} edges do not join two triangles"
        raise refusal(what, reason, "a watertight surface; repair it or export it as a solid")
    if not mesh.is_winding_consistent:
        reason = "partly inside out: neighbours face opposite ways"
        raise refusal(what, reason, "all facing outwards; recompute the normals")
    if abs(mesh.volume) < 1e-6 * np.prod(mesh.extents):
        raise refusal(what, "without volume", "a surface that encloses a solid")
    if mesh.volume < 0:
        raise refusal(what, "inside out", "triangles that face outwards; flip the normals")
    _check_winding(mesh, what)
    pieces = sum(part.volume > 0 for part in mesh.split(only_watertight=False))
    if pieces != 1:
        raise refusal(what, f"in {pieces} pieces that do not touch", "one piece; unite them or take one")


def _check_winding(mesh: Trimesh, what: str) -> None:
    """Refuse a surface that intersects itself: the winding number is 1 just inside each triangle and 0 just outside."""
    corners = np.array(mesh.triangles)
    girth = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).sum(axis=1)
    depth = 2e-3 * mesh.area_faces / girth
    usable = np.flatnonzero(depth > 1e-9)
    chosen = usable[np.linspace(0, usable.size - 1, min(usable.size, SAMPLES_MOST)).astype(int)]
    step, middle = mesh.face_normals[chosen] * depth[chosen, None], mesh.triangles_center[chosen]
    inside, outside = winding_numbers(middle - step, corners), winding_numbers(middle + step, corners)
    if np.abs(inside - 1).max() > 0.1 or np.abs(outside).max() > 0.1:
        allowed = "a surface that does neither; unite its parts and recompute the normals"
        raise refusal(what, "cutting or overlapping itself, or partly inside out", allowed)


def _build(mesh: Trimesh, axis: str, collide: str, what: str) -> Solid:
    """The solid with its origin in the middle of its extents and its axis along x."""
    from scipy.spatial import ConvexHull

    whole = Geom(form="mesh", vertices=np.asarray(mesh.vertices, float), faces=np.asarray(mesh.faces, np.int64))
    geoms: tuple[Geom, ...] = (whole,)
    if collide == "parts":
        geoms = (replace(whole, collides=False), *_decompose(mesh, what))
    mesh.density = 1.0
    volume = float(mesh.volume)
    colliding = sum(float(ConvexHull(geom.vertices).volume) for geom in geoms if geom.collides)
    solid = Solid(
        geoms=geoms, centroid=np.array(mesh.center_mass), inertia=np.array(mesh.moment_inertia) / volume,
        excess=colliding / volume - 1,
    )  # fmt: skip
    longest = "xyz"[int(np.argmax(np.round(mesh.extents, 9)))]  # Of the whole, not of its parts.
    return solid.aligned(longest if axis == "longest" else axis)


def _decompose(mesh: Trimesh, what: str) -> tuple[Geom, ...]:
    """Convex decomposition of a mesh; the same mesh gives the same parts."""
    if find_spec("coacd") is None:
        raise MissingPackage("convex parts need coacd: pip install 'spiraltrunk[objects]'")
    sent, parts = io.BytesIO(), []
    for array, kind in ((mesh.vertices, float), (mesh.faces, np.int64), ([CONCAVITY, PARTS_MOST], float)):
        np.save(sent, np.array(array, kind))
    received = run_limited("decompose", sent.getvalue(), seconds=DECOMPOSITION_MOST, what=what)
    stream = io.BytesIO(received)
    while stream.tell() < len(received):
        vertices, faces = np.load(stream), np.load(stream)
        parts.append(Geom(form="mesh", vertices=np.asarray(vertices, float), faces=faces, group=HIDDEN))
    return tuple(parts)
