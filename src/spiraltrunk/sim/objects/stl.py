"""A user's STL as an object: read, checked, weighed; what does not enclose a solid is refused."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from spiraltrunk.errors import DesignError, MissingPackage, UnknownName, Words
from spiraltrunk.sim.objects.parts import HIDDEN, Part, Solid, compute_turn
from spiraltrunk.sim.objects.spec import EXTENTS

if TYPE_CHECKING:
    from trimesh import Trimesh

UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 25.4e-3}
"""Units that a file may be in [m]."""

AXES = ("longest", "x", "y", "z")
"""Which direction of a file becomes the object's axis."""

COLLIDES = ("hull", "parts")
"""What a mesh is touched at: its convex hull, or convex parts."""

FILE_MOST = 20_000_000
"""Largest file that is read [bytes]."""

FACES_MOST = 100_000
"""Most triangles of a mesh."""

PARTS_MOST = 24
"""Most convex parts that a mesh is touched at (ours)."""

CONCAVITY = 0.05
"""How hollow a convex part may be, CoACD's default threshold (Wei et al., SIGGRAPH 2022) [-]."""

SAMPLES_MOST = 200
"""Triangles at which the winding number is looked at."""

MERGE_DIGITS = 7
"""Decimals of a metre to which corners are the same."""


def load_stl_solid(path: str, *, unit: str, axis: str = "longest", collide: str = "hull") -> Solid:
    """The solid of uniform density that an STL's surface encloses.

    Volume, centre of mass and inertia are integrals over the surface (divergence theorem), exact for the triangles.
    MuJoCo collides convex shapes alone: with ``collide="hull"`` the whole is touched at its convex hull, and
    ``Solid.excess`` says how much larger that is; with ``"parts"`` at up to `PARTS_MOST` convex parts, for which
    the package coacd is needed. A surface that cuts itself is found at the triangles that are looked at, up to
    `SAMPLES_MOST` of them; a smaller cut can be missed.

    Raises:
        DesignError: for a file that cannot be read or that encloses no solid of a sensible size.
        UnknownName: for a unit, an axis or a way to collide that does not exist.
        MissingPackage: for ``"parts"`` without coacd.
    """
    for what, name, known in (("unit", unit, UNITS), ("axis", axis, AXES), ("way to collide", collide, COLLIDES)):
        if name not in known:
            raise UnknownName(what, name, known)
    mesh = _read(read_bytes(path, "stl"), path)
    mesh.vertices = mesh.vertices * UNITS[unit]
    _check_size(mesh, path, unit)
    _clean(mesh)
    _check_surface(mesh, path)
    return _build(mesh, axis, collide)


def read_bytes(path: str, kind: str) -> bytes:
    """A file of a bearable size.

    Raises:
        DesignError: where there is none.
    """
    try:
        file = Path(path).expanduser()
        size = file.stat().st_size if file.is_file() else -1
        content = file.read_bytes() if 0 <= size <= FILE_MOST else b""
    except (OSError, ValueError, RuntimeError) as error:
        raise DesignError(f"{kind}:path", got=path, allowed="a file that can be read") from error
    if size < 0:
        raise DesignError(f"{kind}:path", got=path, allowed="a file that exists (no comma in its name)")
    if not content:
        allowed = f"a file of 1 byte to {FILE_MOST // 1_000_000} MB"
        raise DesignError(f"{kind}:path", got=Words(f"{path!r} of {size} bytes"), allowed=allowed)
    return content


def winding_numbers(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """How often a surface encloses each point: 1 inside a sound solid, 0 outside, -1 inside one turned inside out.

    The sum of the triangles' solid angles over 4 pi (van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 1983).

    Args:
        points: shape (n, 3) [m].
        corners: corners of the triangles, counter-clockwise from outside, shape (m, 3, 3) [m].
    """
    turns = np.empty(len(points))
    sides = np.ascontiguousarray(corners.transpose(1, 2, 0))  # Coordinates apart: ten times as fast.
    for i, point in enumerate(points):
        a, b, c = sides - point[:, None]
        la, lb, lc = (np.sqrt(_dot(side, side)) for side in (a, b, c))
        volume = _dot(a, np.stack([b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]]))
        turns[i] = 2 * np.arctan2(volume, la * lb * lc + _dot(a, b) * lc + _dot(b, c) * la + _dot(c, a) * lb).sum()
    return turns / (4 * np.pi)


def _dot(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


def _read(content: bytes, path: str) -> Trimesh:
    import trimesh

    try:
        with np.errstate(all="ignore"):  # What is not finite is refused below.
            mesh = trimesh.load_mesh(io.BytesIO(content), file_type="stl", process=False)
        faces = len(mesh.faces)
    except Exception as error:  # The reader raises whatever broken bytes lead it to.
        raise refusal(path, "no STL that can be read", "an STL, binary or ASCII") from error
    if faces == 0:  # With some other packages installed the reader takes any bytes for an empty ASCII file.
        raise refusal(path, "no STL that can be read", "an STL, binary or ASCII, of one triangle or more")
    if not 4 <= faces <= FACES_MOST:
        raise refusal(path, f"of {faces} triangles", f"4 to {FACES_MOST}; a coarser export has fewer")
    if not np.isfinite(mesh.vertices).all():
        raise refusal(path, "not finite in some coordinates", "finite numbers; export it again")
    return mesh


def _check_size(mesh: Trimesh, path: str, unit: str) -> None:
    extents = np.ptp(mesh.vertices, axis=0)
    if not (EXTENTS.holds(float(extents.min())) and EXTENTS.holds(float(extents.max()))):
        measures = " x ".join(f"{1e3 * extent:.4g}" for extent in extents)
        others = ", ".join(name for name in UNITS if name != unit)
        allowed = f"5 mm to below 1 m each way; is its unit not {unit} but one of {others}?"
        raise refusal(path, f"of {measures} mm", allowed)


def _clean(mesh: Trimesh) -> None:
    """Join corners at the same place, and drop triangles that thereby lost a side."""
    mesh.merge_vertices(digits_vertex=MERGE_DIGITS)
    faces = mesh.faces
    keeps = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    mesh.update_faces(keeps)
    mesh.remove_unreferenced_vertices()


def _check_surface(mesh: Trimesh, path: str) -> None:
    """Refuse what does not enclose one solid, the outside of every triangle outside."""
    edges = np.array(mesh.faces)[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    _, both = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    if len(edges) == 0 or (both != 2).any():
        reason = f"not closed: {int((both != 2).sum())} edges do not join two triangles"
        raise refusal(path, reason, "a watertight surface; repair it or export it as a solid")
    _, one_way = np.unique(edges, axis=0, return_counts=True)
    if (one_way != 1).any():
        reason = f"partly inside out: at {int((one_way > 1).sum())} edges neighbours face opposite ways"
        raise refusal(path, reason, "all facing outwards; recompute the normals")
    corners = np.array(mesh.vertices)[np.array(mesh.faces)]  # Without the watch that trimesh keeps over its own.
    volume = float(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6)
    if abs(volume) < 1e-6 * float(np.prod(np.ptp(mesh.vertices, axis=0))):
        raise refusal(path, "without volume", "a surface that encloses a solid")
    if volume < 0:
        raise refusal(path, "inside out", "triangles that face outwards; flip the normals")
    _check_winding(corners, path)
    pieces = sum(part.volume > 0 for part in mesh.split(only_watertight=False))
    if pieces != 1:
        raise refusal(path, f"in {pieces} pieces that do not touch", "one piece; unite them or take one")


def _check_winding(corners: np.ndarray, path: str) -> None:
    """Refuse a surface that cuts or overlaps itself: just inside it the winding number is 1, just outside 0."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double_area = np.linalg.norm(normals, axis=1)
    girth = sum(np.linalg.norm(corners[:, i] - corners[:, i - 1], axis=1) for i in range(3))
    depth = 1e-3 * double_area / np.maximum(girth, 1e-12)
    usable = np.flatnonzero(depth > 1e-9)
    if usable.size == 0:
        raise refusal(path, "made of slivers", "triangles of at least some um; export it again")
    chosen = usable[np.linspace(0, usable.size - 1, min(usable.size, SAMPLES_MOST)).astype(int)]
    step = normals[chosen] * (depth[chosen] / double_area[chosen])[:, None]
    middle = corners[chosen].mean(axis=1)
    inside, outside = winding_numbers(middle - step, corners), winding_numbers(middle + step, corners)
    if np.abs(inside - 1).max() > 0.1 or np.abs(outside).max() > 0.1:
        allowed = "a surface that does neither; unite its parts and recompute the normals"
        raise refusal(path, "cutting or overlapping itself, or partly inside out", allowed)


def _build(mesh: Trimesh, axis: str, collide: str) -> Solid:
    """The solid with its origin in the middle and its axis along x."""
    vertices, faces = np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int64)
    mesh.density = 1.0
    volume = float(mesh.volume)
    whole = Part(form="mesh", vertices=vertices, faces=faces)
    parts: tuple[Part, ...] = (whole,)
    if collide == "parts":
        pieces = _decompose(vertices, faces)
        parts = (Part(form="mesh", vertices=vertices, faces=faces, collides=False), *pieces)
    touched = sum(_hull_volume(part) for part in parts if part.collides)
    solid = Solid(
        parts=parts, centroid=np.array(mesh.center_mass), inertia=np.array(mesh.moment_inertia) / volume,
        excess=touched / volume - 1,
    )  # fmt: skip
    return solid.turned(compute_turn((whole,), axis)).centered()


def _hull_volume(part: Part) -> float:
    from scipy.spatial import ConvexHull

    return float(ConvexHull(part.vertices).volume)


def _decompose(vertices: np.ndarray, faces: np.ndarray) -> tuple[Part, ...]:
    """Convex parts that together are about the mesh; the same mesh gives the same parts."""
    try:
        import coacd
    except ImportError as error:
        raise MissingPackage("convex parts need coacd: pip install 'spiraltrunk[objects]'") from error
    coacd.set_log_level("error")
    pieces = coacd.run_coacd(coacd.Mesh(vertices, faces), threshold=CONCAVITY, max_convex_hull=PARTS_MOST, seed=0)
    return tuple(
        Part(form="mesh", vertices=np.asarray(corners, dtype=float), faces=np.asarray(sides), group=HIDDEN)
        for corners, sides in pieces
    )


def refusal(path: str, reason: str, allowed: str) -> DesignError:
    """The error for a file that cannot be an object; ``reason`` goes on from "is"."""
    return DesignError(f"the file {Path(path).name!r}", got=Words(reason), allowed=allowed)
