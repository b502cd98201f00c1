"""Rasterisation of triangles with a depth buffer."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from spiraltrunk.model.jit import compiler, hash_files


@compiler(hash_files([Path(__file__)]), is_alone=True)
def rasterise(corners: np.ndarray, width: int, height: int) -> tuple[np.ndarray, np.ndarray]:
    """Depth and index of the visible triangle at each pixel.

    Args:
        corners: triangles, counter-clockwise from outside, z towards the camera, shape (n, 3, 3) [px].
        width: of the picture [px].
        height: of the picture [px].

    Returns:
        Depth, minus infinity where there is nothing, and index of the triangle, -1 there; both of shape
        (height, width), the first row the lowest y.
    """
    depth, face = np.full((height, width), -np.inf), np.full((height, width), -1)
    for k in range(len(corners)):
        ax, ay, az = corners[k, 0]
        bx, by, bz = corners[k, 1] - corners[k, 0]
        cx, cy, cz = corners[k, 2] - corners[k, 0]
        area = bx * cy - by * cx
        if area <= 0.0:
            continue
        left, right = int(ax + min(0.0, bx, cx) - 0.5), int(ax + max(0.0, bx, cx) + 0.5)
        low, high = int(ay + min(0.0, by, cy) - 0.5), int(ay + max(0.0, by, cy) + 0.5)
        for y in range(max(0, low), min(height - 1, high) + 1):
            for x in range(max(0, left), min(width - 1, right) + 1):
                px, py = x + 0.5 - ax, y + 0.5 - ay
                u, v = (px * cy - py * cx) / area, (py * bx - px * by) / area
                if u >= -1e-6 and v >= -1e-6 and u + v <= 1.0 + 1e-6:
                    z = az + u * bz + v * cz
                    if z > depth[y, x]:
                        depth[y, x] = z
                        face[y, x] = k
    return depth, face
