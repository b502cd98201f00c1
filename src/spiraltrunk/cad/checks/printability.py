"""Printability checks of a part: closed mesh, volume, valid boundary, wall thickness, size of the bed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, final

import numpy as np

from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.geometry.part import Part

if TYPE_CHECKING:
    from trimesh import Trimesh

VOLUME_ERROR = 0.01
"""Largest error of a volume [-]."""

PARALLEL = 0.906
"""Cosine of 25 deg: faces that are nearer to parallel than this bound a wall, others meet at an edge."""

_STEP = 1e-3
"""Distance of a ray's start from the surface [mm]."""

_SLIVER = 0.02
"""Height of a triangle up to which its normal is not trusted [mm]."""

_SAMPLES, _SUSPECTS = 20_000, 100
"""Number of points drawn, and largest number of winding numbers computed."""


@final
@dataclass(frozen=True, kw_only=True)
class Finding:
    """Result of the checks of one part."""

    watertight: bool
    """Whether its mesh is a closed manifold of consistent orientation."""
    volume: float
    """Volume of the solid [mm^3]."""
    expected: float
    """Volume of its definition [mm^3]."""
    min_wall: float
    """Thinnest wall [mm]."""
    at: tuple[float, float, float]
    """Place of the thinnest wall in the part's frame [mm]."""
    area: float
    """Area of its surface [mm^2]."""
    size: tuple[float, float, float]
    """Extent along its axes [mm]."""
    faults: tuple[str, ...]
    """Messages of the checks that failed."""

    @property
    def holds(self) -> bool:
        """Whether all checks passed."""
        return not self.faults


def check_part(part: Part, solid: Any, mesh: Trimesh, expected: float, options: MakeOptions) -> Finding:
    """Run all checks of one part; ``expected`` is the volume of its definition [mm^3]."""
    faults = []
    is_closed = bool(mesh.is_watertight and mesh.is_winding_consistent)
    volume = float(solid.volume)
    if not is_closed:
        faults.append("its mesh is not closed; allowed: every edge between two triangles of the same sense")
    if not solid.is_valid:
        faults.append("the kernel finds its boundary unsound; allowed: a sound solid")
    if len(solid.solids()) != 1:
        faults.append(f"it falls into {len(solid.solids())} pieces; allowed: one")
    if not (volume > 0 and abs(volume / expected - 1) <= VOLUME_ERROR):
        faults.append(f"its volume is {volume:.1f} mm^3; allowed: within 1 % of {expected:.1f}")
    elif abs(mesh.volume - volume) > max(VOLUME_ERROR * volume, mesh.area * options.tolerance):
        faults.append(
            f"its mesh encloses {mesh.volume:.1f} mm^3 of {volume:.1f}; allowed: 1 % off, {options.remedies.tolerance}"
        )
    crossings, wall, at = probe(mesh)
    if crossings:
        faults.append(f"its surface cuts itself at {crossings} of the points looked at; allowed: none")
    if part.checks_walls and wall < options.least_wall:
        faults.append(
            f"{part.name_place(at[2])}at z = {at[2]:.1f} mm and {np.hypot(at[0], at[1]):.1f} mm from its axis: "
            f"{wall:.2f} mm thick, {options.least_wall - wall:.2f} mm too thin; "
            f"allowed: at least {options.least_wall:g} mm, two nozzles: {part.thinnest or options.remedies.nozzle}"
        )
    size = mesh.extents
    faults += [] if part.material.is_cast else _check_bed(size, options)
    return Finding(
        watertight=is_closed, volume=volume, expected=expected, min_wall=wall, at=at, area=float(mesh.area),
        size=(float(size[0]), float(size[1]), float(size[2])), faults=tuple(faults),
    )  # fmt: skip


def probe(mesh: Trimesh) -> tuple[int, float, tuple[float, float, float]]:
    """Cast rays into and out of the surface at points spread over it.

    A ray that starts just inside and next leaves through a nearly parallel face has gone through a wall. One that next
    enters, or one that starts just outside and next leaves, may have slipped through at an edge; it shows a
    self-intersection where the winding number is 2 or more.

    Returns:
        Number of self-intersections; the thinnest wall [mm]; where that begins [mm].
    """
    chosen, points = _spread(mesh)
    normals = np.asarray(mesh.face_normals)
    inward = -normals[chosen]
    start = points + _STEP * inward
    hit, index, place = mesh.ray.intersects_id(start, inward, multiple_hits=False, return_locations=True)
    along = np.einsum("ij,ij->i", normals[hit], inward[index])
    depth = np.einsum("ij,ij->i", place - points[index], inward[index])
    back, other, _ = mesh.ray.intersects_id(
        points - _STEP * inward, -inward, multiple_hits=False, return_locations=True
    )
    toward = np.einsum("ij,ij->i", normals[back], -inward[other])
    suspects = np.concatenate([(place + _STEP * inward[index])[along < 0.0], start[other[toward > 0.0]]])
    crossings = sum(_winding_number(mesh, point) > 1.5 for point in suspects[:: 1 + len(suspects) // _SUSPECTS])
    walls = np.flatnonzero((along > PARALLEL) & (depth > 2 * _STEP))
    if not len(walls):
        return crossings, float(mesh.extents.min()), (0.0, 0.0, 0.0)
    least = walls[np.argmin(depth[walls])]
    x, y, z = (float(value) for value in points[index[least]])
    return crossings, float(depth[least]), (x, y, z)


def _winding_number(mesh: Trimesh, point: np.ndarray) -> float:
    """Winding number of the surface: solid angles of the triangles over 4 pi (van Oosterom and Strackee, 1983)."""
    a, b, c = np.moveaxis(np.asarray(mesh.triangles) - point, 1, 0)
    la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", one, other) for one, other in ((a, b), (b, c), (c, a)))
    return float(np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb).sum() / (2 * np.pi))


def _spread(mesh: Trimesh) -> tuple[np.ndarray, np.ndarray]:
    """Triangles that are no slivers: the centre of each, and points drawn evenly over their area, from a fixed seed."""
    from trimesh.sample import sample_surface

    is_sound = mesh.nondegenerate_faces(height=_SLIVER)
    points, drawn = sample_surface(mesh, _SAMPLES, face_weight=mesh.area_faces * is_sound, seed=0)
    sound = np.flatnonzero(is_sound)
    return np.concatenate([sound, drawn]), np.concatenate([mesh.triangles_center[sound], points])


def _check_bed(size: np.ndarray, options: MakeOptions) -> list[str]:
    x, y, z = options.bed
    wide, narrow = max(size[:2]), min(size[:2])
    if wide <= max(x, y) and narrow <= min(x, y) and size[2] <= z:
        return []
    measures = " x ".join(f"{value:.1f}" for value in size)
    most = f"{x:g} x {y:g} x {z:g} mm, the bed: {options.remedies.bed}"
    return [f"it measures {measures} mm; allowed: at most {most}"]
