"""Surfaces with faults: repaired where that changes nothing, else replaced by their convex hull."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, final

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from spiraltrunk.sim.objects.meshes.surface import (
    BODIES_MOST,
    VOLUME_LEAST,
    count_bodies,
    estimate_volume,
    find_fault,
    label_bodies,
    signed_volume,
)
from spiraltrunk.sim.user_files.regular_file import refusal

if TYPE_CHECKING:
    from trimesh import Trimesh

CHANGE_MOST = 0.01
"""Largest relative change of volume and hull by a repair (ours) [-]."""

HULL_MOST = 0.15
"""Largest relative excess of a hull that takes the place of a surface with faults (ours) [-]."""

MERGE_DIGITS = 7
"""Decimals of a metre to which equal vertices are merged."""

MERGE_SHARES = (1e-6, 1e-5, 1e-4)
"""Distances at which a repair merges vertices, over the diagonal of the extents (ours) [-]."""

BOUNDARY_MOST = 5000
"""Largest number of edges round holes that are filled (ours)."""

GROWTH = 0.001
"""Share by which closed bodies that touch are enlarged to overlap, where their union has a fault without (ours) [-]:
the pieces of a convex decomposition share faces but for rounding. Of 56 such files none was united as it is, each so.
"""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Repaired:
    """A surface that encloses one solid."""

    mesh: Trimesh
    """The surface, or its convex hull."""
    is_hull: bool = False
    """Whether it is the hull."""
    volume: float = 0.0
    """Volume of the solid, estimated where the hull is taken [m^3]."""
    note: str = ""
    """What was changed, in one line; empty for nothing."""


def repair(mesh: Trimesh, what: str) -> Repaired:
    """The surface as it is, else repaired, else its convex hull.

    Closed bodies that overlap, such as a cup and its handle, are united, which changes nothing; those that only touch,
    such as the pieces of a convex decomposition, once each is larger by `GROWTH`. Repairs are: merging close vertices,
    leaving out doubled triangles and internal walls, turning triangles outwards, and filling holes.
    They count where hull and volume change by less than `CHANGE_MOST`.

    Args:
        mesh: the surface, which is cleaned in place [m].
        what: name of the file in errors.

    Raises:
        DesignError: where the hull's volume exceeds that of the surface by more than `HULL_MOST`.
    """
    as_filed = mesh.copy()
    clean(mesh)
    fault = find_fault(mesh) if len(mesh.faces) else "without volume"
    if not fault:
        return Repaired(mesh=mesh, volume=float(mesh.volume))
    if (union := _unite(mesh) or _unite(as_filed)) is not None:  # Cleaned, bodies that share corners are one.
        return union
    hull = _hull(mesh, what)
    best = mesh
    for share in MERGE_SHARES:
        candidate, change = _mend(mesh, share * float(np.linalg.norm(mesh.extents)))
        if not len(candidate.faces):
            break
        best = candidate
        if not find_fault(candidate):
            if change < CHANGE_MOST and abs(ConvexHull(candidate.vertices).volume / hull.volume - 1) < CHANGE_MOST:
                note = f"the surface is {fault}: it is repaired, which changes its volume by {_percent(change)}"
                return Repaired(mesh=candidate, volume=float(candidate.volume), note=note)
            break
        if change < CHANGE_MOST and (union := _unite(candidate)) is not None:
            return union
    if (count := count_bodies(best)) > BODIES_MOST:
        raise refusal(what, f"{fault}, in {count} pieces", f"one surface, or up to {BODIES_MOST} pieces of one thing")
    return _take_hull(hull, estimate_volume(best), fault, what)


def _unite(mesh: Trimesh) -> Repaired | None:
    """The union of closed bodies that overlap or touch; None where one of them has a fault, or they are apart."""
    if not 2 <= count_bodies(mesh) <= BODIES_MOST:  # As filed, the triangles of an STL file are a body each.
        return None
    bodies = list(mesh.split(only_watertight=False))
    for body in bodies:
        clean(body)
    if any(not len(body.faces) or find_fault(body) for body in bodies):
        return None
    count = f"the surface is {len(bodies)} closed bodies that"
    if (union := _find_union(bodies)) is not None:
        return Repaired(mesh=union, volume=float(union.volume), note=f"{count} overlap: they are united")
    for body in bodies:
        body.vertices = body.center_mass + (1.0 + GROWTH) * (body.vertices - body.center_mass)
    if (union := _find_union(bodies)) is not None:
        note = f"{count} touch: each is enlarged by {100 * GROWTH:g} %, and they are united"
        return Repaired(mesh=union, volume=float(union.volume), note=note)
    return None


def _find_union(bodies: list[Trimesh]) -> Trimesh | None:
    """The union of closed bodies; None where it has a fault."""
    import trimesh

    union: Trimesh = trimesh.boolean.union(bodies, engine="manifold")
    clean(union)
    return union if len(union.faces) and not find_fault(union) else None


def clean(mesh: Trimesh) -> None:
    """Merge equal vertices, and remove triangles that degenerate."""
    mesh.merge_vertices(digits_vertex=MERGE_DIGITS)
    _drop_degenerate(mesh)


def _drop_degenerate(mesh: Trimesh) -> None:
    mesh.update_faces((np.diff(np.sort(mesh.faces, axis=1)) > 0).all(axis=1))
    mesh.remove_unreferenced_vertices()


def _mend(mesh: Trimesh, distance: float) -> tuple[Trimesh, float]:
    """A copy with all repairs, its vertices merged to a grid of ``distance`` [m], and what filling holes changed.

    What filling may have changed is told by `_measure_doubt`.
    """
    import trimesh

    trimesh_repair: Any = trimesh.repair  # Untyped.
    copy, change = mesh.copy(), 0.0
    copy.merge_vertices(digits_vertex=max(0, int(np.floor(-np.log10(distance)))))
    _drop_degenerate(copy)
    if not len(copy.faces):
        return copy, change
    _drop_doubles(copy)
    trimesh_repair.fix_winding(copy)
    _, count = np.unique(copy.edges_sorted, axis=0, return_counts=True)
    if 3 <= np.count_nonzero(count == 1) <= BOUNDARY_MOST:
        n_face = len(copy.faces)
        trimesh_repair.fill_holes(copy, use_fan=True)
        change = _measure_doubt(copy, n_face)
    trimesh_repair.fix_normals(copy, multibody=count_bodies(copy) <= BODIES_MOST)
    return copy, change


def _measure_doubt(mesh: Trimesh, n_face: int) -> float:
    """Volume of a half ball over each hole that was filled, all together, over the signed volume [-].

    What was there may have bulged as far. A hole of three edges, where that is less than `CHANGE_MOST` of the volume,
    counts as one triangle that is missing, and leaves no doubt.

    Args:
        mesh: the surface.
        n_face: number of triangles before; those from there on fill holes.
    """
    joined = mesh.face_adjacency[(mesh.face_adjacency >= n_face).all(axis=1)] - n_face
    labels = label_bodies(joined, len(mesh.faces) - n_face)
    areas = np.bincount(labels, weights=mesh.area_faces[n_face:])
    shares = 2 / 3 * areas * np.sqrt(areas / np.pi) / max(abs(signed_volume(mesh)), 1e-15)
    return float(shares[(np.bincount(labels) > 1) | (shares > CHANGE_MOST)].sum())


def _drop_doubles(mesh: Trimesh) -> None:
    """Keep one of equal triangles; of two that face each other, an internal wall, none.

    Where that would leave out most triangles, a surface with two sides, one of each is kept.
    """
    faces = np.asarray(mesh.faces)
    order = np.argsort(faces, axis=1)
    even = ((order[:, 1] - order[:, 0]) % 3 == 1).astype(int)  # Even permutations are cyclic ones.
    _, first, group = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_inverse=True)
    group = group.reshape(-1)
    balance = np.bincount(group, weights=2 * even - 1, minlength=len(first))
    kept = np.zeros(len(faces), bool)
    for sign in (1, 0):
        places = np.flatnonzero((even == sign) & (np.sign(balance[group]) == (1 if sign else -1)))
        _, firsts = np.unique(group[places], return_index=True)
        kept[places[firsts]] = True
    if 2 * kept.sum() < len(first):
        kept[:] = False
        kept[first] = True
    mesh.update_faces(kept)
    mesh.remove_unreferenced_vertices()


def _hull(mesh: Trimesh, what: str) -> Trimesh:
    import trimesh

    trimesh_repair: Any = trimesh.repair
    try:
        if len(mesh.vertices) < 4:
            raise ValueError("no solid")
        hull = trimesh.Trimesh(mesh.vertices, ConvexHull(mesh.vertices).simplices, process=False)
    except (QhullError, ValueError):
        raise refusal(what, "without volume", "a surface that encloses a solid") from None
    hull.remove_unreferenced_vertices()
    trimesh_repair.fix_normals(hull)
    return hull


def _percent(share: float) -> str:
    return "less than 0.1 %" if share < 1e-3 else f"up to {100 * share:.1f} %"


def _take_hull(hull: Trimesh, volume: float, fault: str, what: str) -> Repaired:
    volume = min(volume, float(hull.volume))
    if not volume > VOLUME_LEAST * float(np.prod(hull.extents)):
        raise refusal(what, f"{fault}, and encloses no volume", "a surface that encloses a solid")
    excess = float(hull.volume) / volume - 1
    if excess > HULL_MOST:
        allowed = f"a closed surface, or one whose convex hull is at most {100 * HULL_MOST:.0f} % larger than what it "
        raise refusal(what, fault, f"{allowed}encloses, not {100 * excess:.0f} %; repair it or export it as a solid")
    note = f"the surface is {fault}: its convex hull is taken, {100 * excess:.1f} % larger than its estimated volume"
    return Repaired(mesh=hull, is_hull=True, volume=volume, note=note)
