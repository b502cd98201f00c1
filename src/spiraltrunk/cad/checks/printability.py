"""What a part must hold before anything is written: closed, of the right volume, sound, thick enough, on the bed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

import numpy as np

from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.geometry.mesh import Mesh
from spiraltrunk.cad.geometry.part import Part

VOLUME_ERROR = 0.01
"""Largest error of a volume [-]."""

PARALLEL = 0.906
"""Cosine of 25 deg: what lies between faces that are this near to parallel is a wall, else it is an edge."""

_STEP = 1e-3
"""How far above a surface a ray starts [mm]."""

_SAMPLES = 20_000


@final
@dataclass(frozen=True, kw_only=True)
class Finding:
    """What was found of one part."""

    watertight: bool
    """Whether its mesh is closed and a manifold, all facing outwards."""
    volume: float
    """Volume of the solid [mm^3]."""
    expected: float
    """Volume of its definition [mm^3]."""
    min_wall: float
    """Thinnest wall [mm]."""
    at: tuple[float, float, float]
    """Where that is, in the part's frame [mm]."""
    area: float
    """Area of its surface [mm^2]."""
    size: tuple[float, float, float]
    """Extent along its axes [mm]."""
    faults: tuple[str, ...]
    """What does not hold, in words; empty where all holds."""

    @property
    def holds(self) -> bool:
        """Whether nothing was found."""
        return not self.faults


def check_part(part: Part, solid: Any, mesh: Mesh, expected: float, options: MakeOptions) -> Finding:
    """Everything that is checked of one part."""
    faults = []
    open_edges = mesh.count_open_edges()
    volume = float(solid.volume)
    if open_edges:
        faults.append(f"its mesh is open at {open_edges} edges; allowed: none")
    if not solid.is_valid:
        faults.append("the kernel finds its boundary unsound; allowed: a sound solid")
    if len(solid.solids()) != 1:
        faults.append(f"it falls into {len(solid.solids())} pieces; allowed: one")
    if not (volume > 0 and abs(volume / expected - 1) <= VOLUME_ERROR):
        faults.append(f"its volume is {volume:.1f} mm^3; allowed: within 1 % of {expected:.1f}")
    elif abs(mesh.volume - volume) > max(VOLUME_ERROR * volume, mesh.area * options.tolerance):
        faults.append(
            f"its mesh encloses {mesh.volume:.1f} mm^3 of {volume:.1f}; allowed: 1 % off, a finer --tolerance-mm"
        )
    crossings, wall, at = probe(mesh)
    if crossings:
        faults.append(f"its surface cuts itself at {crossings} of the points looked at; allowed: none")
    if part.checks_walls and wall < options.least_wall:
        faults.append(
            f"{part.name_place(at[2])}at z = {at[2]:.1f} mm and {np.hypot(at[0], at[1]):.1f} mm from its axis: "
            f"{wall:.2f} mm thick, {options.least_wall - wall:.2f} mm too thin; "
            f"allowed: at least {options.least_wall:g} mm, two nozzles: {part.thinnest}"
        )
    size = np.ptp(mesh.points, axis=0)
    faults += _check_bed(size, options) if part.material.flow else []
    return Finding(
        watertight=open_edges == 0, volume=volume, expected=expected, min_wall=wall, at=at, area=mesh.area,
        size=(float(size[0]), float(size[1]), float(size[2])), faults=tuple(faults),
    )  # fmt: skip


def probe(mesh: Mesh) -> tuple[int, float, tuple[float, float, float]]:
    """Rays into and out of the surface at points spread over it.

    A ray that starts just inside and next leaves has gone through a wall; one that next enters again, or one that
    starts just outside and next leaves, shows that the surface cuts or overlaps itself.

    Returns:
        How many rays show that; the thinnest wall [mm]; where that begins [mm].
    """
    from trimesh import Trimesh
    from trimesh.ray.ray_pyembree import RayMeshIntersector

    normals = mesh.double_area
    size = np.linalg.norm(normals, axis=1)
    chosen, points = _spread(mesh, size)
    outward = normals / np.maximum(size[:, None], 1e-30)
    rays = RayMeshIntersector(Trimesh(mesh.points, mesh.triangles, process=False))
    inward = -outward[chosen]
    start = points + _STEP * inward
    hit, index, place = rays.intersects_id(start, inward, multiple_hits=False, return_locations=True)
    along = np.einsum("ij,ij->i", outward[hit], inward[index])
    depth = np.einsum("ij,ij->i", place - points[index], inward[index])
    back, other, _ = rays.intersects_id(points - _STEP * inward, -inward, multiple_hits=False, return_locations=True)
    toward = np.einsum("ij,ij->i", outward[back], -inward[other])
    within = _count_overlaps(mesh, (place + _STEP * inward[index])[along < 0.0])
    beyond = _count_overlaps(mesh, start[other[toward > 0.0]])
    crossings = within + beyond
    walls = np.flatnonzero((along > PARALLEL) & (depth > 2 * _STEP))
    if not len(walls):
        return crossings, float(np.ptp(mesh.points, axis=0).min()), (0.0, 0.0, 0.0)
    least = walls[np.argmin(depth[walls])]
    x, y, z = (float(value) for value in points[index[least]])
    return crossings, float(depth[least]), (x, y, z)


def _count_overlaps(mesh: Mesh, points: np.ndarray, most: int = 100) -> int:
    """How many of the points, at most so many of them, the surface encloses more than once.

    Near an edge a ray may start on the wrong side of it or slip out through it, so its first hit alone proves nothing:
    one that then is where the surface encloses twice does.
    """
    sides = np.ascontiguousarray(mesh.corners.transpose(1, 2, 0))
    chosen = points[np.linspace(0, len(points) - 1, min(most, len(points))).astype(int)] if len(points) else points
    return sum(_winding(point, sides) > 1.5 for point in chosen)


def _winding(point: np.ndarray, sides: np.ndarray) -> float:
    """How often the surface encloses the point: the triangles' solid angles over 4 pi (van Oosterom, Strackee, 1983).

    Args:
        point: shape (3,) [mm].
        sides: corners of the triangles, coordinates apart, shape (3, 3, m) [mm].
    """
    a, b, c = sides - point[:, None]
    la, lb, lc = (np.sqrt((side * side).sum(axis=0)) for side in (a, b, c))
    volume = (a * np.cross(b, c, axis=0)).sum(axis=0)
    ab, bc, ca = (a * b).sum(axis=0), (b * c).sum(axis=0), (c * a).sum(axis=0)
    return float(np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb).sum() / (2 * np.pi))


def _spread(mesh: Mesh, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The middle of every triangle that is no sliver, and points drawn evenly over the area; the same for one mesh."""
    corners = mesh.corners
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    sound = np.flatnonzero(size > 0.02 * longest)
    random = np.random.default_rng(0)
    drawn = sound[
        np.searchsorted(np.cumsum(size[sound]) / size[sound].sum(), random.random(_SAMPLES)).clip(max=len(sound) - 1)
    ]
    weight = random.dirichlet((1.0, 1.0, 1.0), _SAMPLES)
    middle = corners[sound].mean(axis=1)
    return np.concatenate([sound, drawn]), np.concatenate([middle, np.einsum("ni,nij->nj", weight, corners[drawn])])


def _check_bed(size: np.ndarray, options: MakeOptions) -> list[str]:
    x, y, z = options.bed
    wide, narrow = max(size[:2]), min(size[:2])
    if wide <= max(x, y) and narrow <= min(x, y) and size[2] <= z:
        return []
    measures = " x ".join(f"{value:.1f}" for value in size)
    return [f"it measures {measures} mm; allowed: at most {x:g} x {y:g} x {z:g} mm, the bed: a larger --bed-mm"]
