"""Surfaces of a section's two halves, so that each joint can colour what lies on both sides of it."""

from __future__ import annotations

import numpy as np

from spiraltrunk.design.section import SectionSolid

_FACETS = 36
"""Facets round a section [-]."""

Surface = tuple[np.ndarray, np.ndarray]
"""Vertices (n, 3) [m] and triangles (m, 3)."""


def build_halves(solid: SectionSolid) -> tuple[Surface, Surface]:
    """Proximal and distal half of a section, its axis along x from the proximal joint; edges stay sharp."""
    middle = (solid.rim_start + solid.rim_end) / 2
    proximal = [
        [(0.0, 0.0), (solid.rim_start, solid.radius)],
        [(solid.rim_start, solid.radius), (middle, solid.radius)],
    ]
    distal = [
        [(middle, solid.radius), (solid.rim_end, solid.radius)],
        [(solid.rim_end, solid.radius), (solid.length, 0.0)],
    ]
    return _revolve(proximal), _revolve(distal)


def _revolve(segments: list[list[tuple[float, float]]]) -> Surface:
    """Segments of a profile (axial, radial) [m] turned about x, each with vertices of its own."""
    angle = np.linspace(0.0, 2 * np.pi, _FACETS, endpoint=False)
    around = np.stack([np.zeros(_FACETS), np.cos(angle), np.sin(angle)], axis=-1)
    points, faces, first = [], [], 0
    here = np.arange(_FACETS)
    beside = np.roll(here, -1)
    for segment in segments:
        rings = [np.array([axial, 0.0, 0.0]) + radial * around for axial, radial in segment]
        points += rings
        a, b, c, d = first + here, first + beside, first + _FACETS + here, first + _FACETS + beside
        faces += [np.stack([a, b, c], axis=-1), np.stack([b, d, c], axis=-1)]
        first += 2 * _FACETS
    return np.concatenate(points), np.concatenate(faces)
