"""Corners and faces of a Wavefront OBJ file; everything else that it may hold is left out."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from spiraltrunk.sim.user_files.regular_file import refusal

CORNERS_MOST = 1000
"""Largest number of corners of one polygon (ours)."""

FACING = 1e-12
"""Least area of a triangle of a fan that faces as its polygon does, over the polygon's area (ours) [-]."""


def read_obj(content: bytes, what: str, *, most: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices, shape (n, 3), and triangles, shape (m, 3), of all objects and groups of the file together.

    Negative indices count back from the vertex last read, textures, normals, materials, points, lines and free-form
    curves are left out (Wavefront, Advanced Visualizer, appendix B1).

    Args:
        content: what the file holds.
        what: name of the file in errors.
        most: number of triangles above which the file is of no use; its polygons are then not looked at.

    Raises:
        DesignError: with the number of the first line that cannot be read.
    """
    vertices: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    counts: list[int] = []
    lines = enumerate(content.decode("utf-8-sig", errors="replace").splitlines(), start=1)
    for number, line in lines:
        words, goes_on = _split(line)
        if not words or words[0] not in {"v", "f"}:
            continue
        while goes_on:
            more, goes_on = _split(next(lines, (0, ""))[1])
            words += more
        try:
            if words[0] == "v":
                x, y, z = words[1:4]
                vertices.append([float(x), float(y), float(z)])
            else:
                triangles += _fan([_index(word, len(vertices)) for word in words[1:]])
                counts.append(len(triangles))
        except (ValueError, OverflowError):
            allowed = "v with three numbers, f with three or more vertices of lines before it"
            raise refusal(what, f"no OBJ that can be read, at line {number}", allowed) from None
    points, faces = np.array(vertices, float).reshape(-1, 3), np.array(triangles, np.int64).reshape(-1, 3)
    if 0 < len(faces) <= most:
        _clip_ears(points, faces, np.array([0, *counts]))
    return points, faces


def _split(line: str) -> tuple[list[str], bool]:
    """Words of a line without its comment, and whether the line goes on in the next one."""
    if line.endswith("\\") and "#" not in line:
        return line[:-1].split(), True
    return line.split("#", 1)[0].split(), False


def _index(word: str, count: int) -> int:
    """Place of a vertex, from 0, of a word such as 7, 7/1, 7//2 or -3."""
    index = int(word.split("/", 1)[0])
    place = index - 1 if index > 0 else count + index
    if index == 0 or not 0 <= place < count:
        raise ValueError(word)
    return place


def _fan(corners: list[int]) -> list[tuple[int, int, int]]:
    if not 3 <= len(corners) <= CORNERS_MOST:
        raise ValueError(len(corners))
    return [(corners[0], second, third) for second, third in itertools.pairwise(corners[1:])]


def _clip_ears(points: np.ndarray, faces: np.ndarray, bounds: np.ndarray) -> None:
    """Replace the fans that are not right, in place: those of concave polygons, whose triangles overlap or vanish.

    Args:
        points: vertices, shape (n, 3).
        faces: triangles, shape (m, 3).
        bounds: first triangle of each polygon, and m, shape (number of polygons + 1,).
    """
    for first, end, normal in _find_wrong_fans(points, faces, bounds):
        fan = faces[first:end]
        corners = np.array([fan[0, 0], *fan[:, 1], fan[-1, 2]])
        found = _triangulate(points[corners], normal)
        if len(found) == len(fan):
            faces[first:end] = corners[found]


def _find_wrong_fans(
    points: np.ndarray, faces: np.ndarray, bounds: np.ndarray
) -> Iterator[tuple[int, int, np.ndarray]]:
    """First triangle and end of each fan of which one triangle does not face as the whole, and the whole's normal.

    The normal is the sum of those of the triangles, each as long as twice the area (Newell's method).
    """
    with np.errstate(all="ignore"):  # Coordinates that are not finite are refused by the caller.
        corner, second, third = (points[faces[:, i]] for i in range(3))
        normals = np.cross(second - corner, third - corner)
        whole = np.add.reduceat(normals, bounds[:-1])
        square = np.einsum("ij,ij->i", whole, whole)
        facing = np.einsum("ij,ij->i", normals, np.repeat(whole, np.diff(bounds), axis=0))
        least = np.minimum.reduceat(facing, bounds[:-1])
        wrong = (np.diff(bounds) > 1) & np.isfinite(square) & (square > 0) & (least <= FACING * square)
    for i in np.flatnonzero(wrong):
        yield int(bounds[i]), int(bounds[i + 1]), whole[i] / np.sqrt(square[i])


def _triangulate(corners: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Triangles of a polygon as places among its corners, by ear clipping in the plane of its unit normal."""
    import manifold3d

    side = np.eye(3)[int(np.argmin(np.abs(normal)))]
    ahead = np.cross(normal, side)
    ahead /= np.linalg.norm(ahead)
    flat = (corners - corners[0]) @ np.stack([ahead, np.cross(normal, ahead)], axis=1)
    return np.asarray(manifold3d.triangulate([flat], allow_convex=False))
