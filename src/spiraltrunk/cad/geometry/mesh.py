"""Triangles: the mesh that is printed, what it encloses, and the files that slicers read."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import final
from xml.sax.saxutils import quoteattr

import numpy as np

_SAME = 1e-5
"""Distance within which corners are one [mm]: the kernel gives faces that share an edge the same points on it."""

_HEAD = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<model unit="millimeter" xml:lang="en-US" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">\n'
)

_TYPES = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)

_LINKS = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    '<Relationship Target="/3D/3dmodel.model" Id="rel0" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
)


@final
@dataclass(frozen=True, kw_only=True)
class Mesh:
    """A surface of triangles, corners counter-clockwise from outside."""

    points: np.ndarray
    """Corners, shape (n, 3) [mm]."""
    triangles: np.ndarray
    """Three corners each, shape (m, 3)."""

    @property
    def corners(self) -> np.ndarray:
        """Shape (m, 3, 3) [mm]."""
        return self.points[self.triangles]

    @property
    def double_area(self) -> np.ndarray:
        """Outward normals as long as twice the area, shape (m, 3) [mm^2]."""
        a, b, c = self.corners.transpose(1, 0, 2)
        return np.cross(b - a, c - a)

    @property
    def area(self) -> float:
        """Area of the surface [mm^2]."""
        return float(np.linalg.norm(self.double_area, axis=1).sum() / 2)

    @property
    def volume(self) -> float:
        """Volume that is enclosed (divergence theorem) [mm^3]."""
        a, b, c = self.corners.transpose(1, 0, 2)
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)

    def count_open_edges(self) -> int:
        """Edges that do not join exactly two triangles of opposite sense; 0 for a closed manifold."""
        ends = self.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        _, index, count = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True, return_counts=True)
        sense = np.where(ends[:, 0] < ends[:, 1], 1, -1)
        balance = np.bincount(index.ravel(), weights=sense, minlength=len(count))
        return int(np.count_nonzero((count != 2) | (balance != 0)))


def weld(points: np.ndarray, triangles: np.ndarray) -> Mesh:
    """The mesh with corners at the same place joined, and without triangles that thereby have no area."""
    _, first, index = np.unique(
        np.round(points / _SAME).astype(np.int64), axis=0, return_index=True, return_inverse=True
    )
    joined = index.ravel()[triangles]
    a, b, c = joined.T
    return Mesh(points=points[first], triangles=joined[(a != b) & (b != c) & (c != a)])


def write_stl(mesh: Mesh, path: Path) -> None:
    """Write binary STL, in mm."""
    rows = np.zeros(len(mesh.triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("flags", "<u2")])
    normal = mesh.double_area
    rows["normal"] = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    rows["corners"] = mesh.corners
    with path.open("wb") as file:
        file.write(b"spiraltrunk, mm".ljust(80, b" "))
        file.write(np.uint32(len(rows)).tobytes())
        file.write(rows.tobytes())


def write_3mf(mesh: Mesh, path: Path, name: str) -> None:
    """Write 3MF (core specification 1.3), in mm; the archive is the same for the same mesh."""
    points = "".join(f'<vertex x="{x:.6g}" y="{y:.6g}" z="{z:.6g}"/>' for x, y, z in mesh.points.tolist())
    sides = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in mesh.triangles.tolist())
    model = (
        f'{_HEAD}<resources><object id="1" type="model" name={quoteattr(name)}><mesh><vertices>{points}</vertices>'
        f'<triangles>{sides}</triangles></mesh></object></resources><build><item objectid="1"/></build></model>'
    )
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=3) as archive:
        for inside, text in (("[Content_Types].xml", _TYPES), ("_rels/.rels", _LINKS), ("3D/3dmodel.model", model)):
            archive.writestr(zipfile.ZipInfo(inside), text, zipfile.ZIP_DEFLATED, 3)
