"""Measurement of the trunk on the kernel's solids, to be compared with the design.

Section lengths and gaps follow from the cones of the printed body (apex and lean), holes from its cylinders, stroke
from both; volume, centroid and moments from the solid of each section's outline, shell included.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.cad.geometry.csg import Revolved
from spiraltrunk.cad.geometry.occ import build_solid, measure_bulk
from spiraltrunk.cad.geometry.part import Part
from spiraltrunk.design.trunk import TrunkDesign

_NEAR = 0.3
"""Largest distance of a face or hole from its designed place [mm]."""


@final
@dataclass(frozen=True, kw_only=True)
class MeasuredTrunk:
    """Dimensions of the solids in SI; NaN where the body has no such face."""

    section_length: np.ndarray
    """Distance between the apexes of each section's two cones, shape (n_section,) [m]."""
    gap: np.ndarray
    """Angle between neighbouring faces, shape (n_joint,) [rad]."""
    hole: np.ndarray
    """Axial and radial coordinate of each hole's ends from the proximal joint, shape (n_section, n_cable, 2, 2) [m]."""
    stroke: float
    """Sum of the distances between the holes of one cable across all gaps [m]."""
    volume: np.ndarray
    """Volume of each section's outline, shape (n_section,) [m^3]."""
    center: np.ndarray
    """Axial coordinate of each outline's centroid, from the proximal joint, shape (n_section,) [m]."""
    gyration: np.ndarray
    """Squared radii of gyration about the centroid, axial and across, shape (n_section, 2) [m^2]."""


def place_faces(part: Part, cones: np.ndarray, cylinders: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """A piece as it stands in the robot: height on the axis [mm], `occ.measure_cones`, `occ.measure_cylinders`."""
    if math.cos(part.turn) > 0.0:
        return part.at[2], cones, cylinders
    x, y, low, high = cylinders.T
    return part.at[2], cones * [-1.0, 1.0], np.stack([x, -y, -high, -low], axis=-1)


def measure_trunk(design: TrunkDesign, pieces: Sequence[tuple[float, np.ndarray, np.ndarray]]) -> MeasuredTrunk:
    """Measure the trunk.

    Args:
        design: gives the places at which faces and holes are looked for.
        pieces: height, cones and cable holes of each printed piece, as `place_faces` gives them.
    """
    cones = np.concatenate([faces + np.array([at, 0.0]) for at, faces, _ in pieces])
    joints = 1e3 * np.concatenate([[0.0], np.cumsum(design.section_length)])
    is_near = np.abs(cones[:, 0] - joints[:, None]) < _NEAR
    count = is_near.sum(axis=1)
    apexes = np.where(count, is_near @ cones[:, 0] / np.maximum(count, 1), math.nan)
    if not count[-1]:  # The gripper's plate replaces the last face.
        apexes[-1] = joints[-1]
    gap = np.where(count == 2, is_near @ cones[:, 1], math.nan)[1:-1]
    holes = np.concatenate([own + np.array([0.0, 0.0, at, at]) for at, _, own in pieces])
    hole = _find_holes(design, holes)
    bulk = _measure_outlines(design)
    across = hole[1:, 0, 0] - hole[:-1, 0, 1]
    starts = 1e-3 * apexes[:-1]
    axial = starts[1:] + hole[1:, 0, 0, 0] - starts[:-1] - hole[:-1, 0, 1, 0]
    return MeasuredTrunk(
        section_length=1e-3 * np.diff(apexes), gap=gap, hole=hole,
        stroke=float(np.hypot(axial, across[:, 1]).sum()), volume=bulk[:, 0], center=bulk[:, 1], gyration=bulk[:, 2:],
    )  # fmt: skip


def _find_holes(design: TrunkDesign, found: np.ndarray) -> np.ndarray:
    """Both ends of each hole from the section's proximal joint, shape (n_section, n_cable, 2, 2) [m]."""
    starts = 1e3 * np.concatenate([[0.0], np.cumsum(design.section_length)])
    ends = np.full((design.n_section, design.n_cable, 2, 2), math.nan)
    for n in range(design.n_section):
        radial = 1e3 * design.hole_position[n, 0, 1]
        middle = (found[:, 2] + found[:, 3]) / 2
        inside = (middle > starts[n]) & (middle < starts[n + 1])
        for c, angle in enumerate(design.cable.angles):
            place = radial * np.array([math.cos(angle), math.sin(angle)])
            own = found[inside & (np.hypot(*(found[:, :2] - place).T) < _NEAR)]
            if len(own):
                rho = np.hypot(own[:, 0], own[:, 1]).mean()
                ends[n, c] = [[own[:, 2].min() - starts[n], rho], [own[:, 3].max() - starts[n], rho]]
    return 1e-3 * ends


def _measure_outlines(design: TrunkDesign) -> np.ndarray:
    """Volume, centroid and squared radii of gyration of each section's outline, shape (n_section, 4), in SI."""
    rows = []
    for scale in 1e3 * design.scale:
        s = design.solid
        profile = ((0.0, 0.0), (s.radius, s.rim_start), (s.radius, s.rim_end), (0.0, s.length))
        solid = build_solid(Revolved(profile=tuple((float(scale * r), float(scale * z)) for r, z in profile)))
        volume, center, axial, across = measure_bulk(solid)
        rows.append((1e-9 * volume, 1e-3 * center, 1e-6 * axial / volume, 1e-6 * across / volume))
    return np.array(rows)
