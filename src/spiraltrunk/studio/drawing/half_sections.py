"""Surfaces of a section's two halves, so that each joint can colour what lies on both sides of it."""

from __future__ import annotations

from spiraltrunk.design.section import SectionSolid
from spiraltrunk.report.solids.trunk_mesh import Surface, revolve

_FACETS = 36
"""Facets round a section [-]."""


def build_halves(solid: SectionSolid) -> tuple[Surface, Surface]:
    """Proximal and distal half of a section, its axis along x from the proximal joint; edges stay sharp."""
    middle = (solid.rim_start + solid.rim_end) / 2
    proximal = [(0.0, 0.0), (solid.rim_start, solid.radius), (middle, solid.radius)]
    distal = [(middle, solid.radius), (solid.rim_end, solid.radius), (solid.length, 0.0)]
    return revolve(proximal, _FACETS), revolve(distal, _FACETS)
