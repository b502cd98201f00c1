"""Corners and faces of a Wavefront OBJ file; everything else that it may hold is left out."""

from __future__ import annotations

import itertools

import numpy as np

from spiraltrunk.sim.user_files.regular_file import refusal

CORNERS_MOST = 1000
"""Largest number of corners of one polygon (ours)."""


def read_obj(content: bytes, what: str) -> tuple[np.ndarray, np.ndarray]:
    """Vertices, shape (n, 3), and triangles, shape (m, 3), of all objects and groups of the file together.

    Polygons become fans of triangles. Negative indices count back from the vertex last read, textures, normals,
    materials, points, lines and free-form curves are left out (Wavefront, Advanced Visualizer, appendix B1).

    Args:
        content: what the file holds.
        what: name of the file in errors.

    Raises:
        DesignError: with the number of the first line that cannot be read.
    """
    vertices: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    text = content.decode("utf-8", errors="replace").replace("\\\r\n", " ").replace("\\\n", " ")
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split("#", 1)[0].split()
        if not words or words[0] not in {"v", "f"}:
            continue
        try:
            if words[0] == "v":
                x, y, z = words[1:4]
                vertices.append([float(x), float(y), float(z)])
            else:
                triangles += _fan([_index(word, len(vertices)) for word in words[1:]])
        except (ValueError, OverflowError):
            allowed = "v with three numbers, f with three or more vertices of lines before it"
            raise refusal(what, f"no OBJ that can be read, at line {number}", allowed) from None
    return np.array(vertices, float).reshape(-1, 3), np.array(triangles, np.int64).reshape(-1, 3)


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
