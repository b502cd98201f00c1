"""What the arm looks like in pictures: its published meshes, thinned out, as nobody sees their 130,000 faces."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import fast_simplification
import numpy as np

FACES = 3000
"""Faces of a link in pictures (ours): drawn in software, a frame takes two thirds of the time, and looks the same."""

_FACET = np.dtype([("normal", "<3f4"), ("corners", "<(3,3)f4"), ("attribute", "<u2")])
"""A triangle in a binary STL file."""

_HEADER = 84
"""Bytes before the triangles of a binary STL file."""


@lru_cache(maxsize=16)
def thin_out(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices, shape (n_vertex, 3), in the file's unit, and faces, shape (n_face, 3), FACES at most.

    Quadric error decimation (Garland and Heckbert, "Surface simplification using quadric error metrics", 1997).

    Args:
        path: a binary STL file.
    """
    corners = np.fromfile(path, dtype=_FACET, offset=_HEADER)["corners"].reshape(-1, 3)
    vertices, index = np.unique(corners, axis=0, return_inverse=True)
    faces = index.reshape(-1, 3).astype(np.int32)
    if len(faces) > FACES:
        vertices, faces = fast_simplification.simplify(vertices, faces, target_count=FACES)
    return vertices, faces
