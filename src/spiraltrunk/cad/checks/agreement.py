"""Do the solids say the same as the design? Everything here is measured on the kernel's solids, nothing is copied.

Lengths and gaps come from the leaning faces of the printed body (apexes and leans of its cones), holes from its
cylinders, stroke from both; volume, centroid and moments from each section's outline, shell included.
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
"""How far from its place a face or hole is looked for [mm]."""


@final
@dataclass(frozen=True, kw_only=True)
class Measured:
    """The trunk as its solids have it, in SI; nan where the body has no such face."""

    section_length: np.ndarray
    """Between the apexes of each section's two leaning faces, shape (n_section,) [m]."""
    gap: np.ndarray
    """Angle between neighbouring faces, shape (n_joint,) [rad]."""
    hole: np.ndarray
    """Axial and radial position of both ends of each hole, shape (n_section, n_cable, 2, 2) [m]."""
    stroke: float
    """Cable between the holes' ends across all gaps of one side [m]."""
    volume: np.ndarray
    """Volume of each section's outline, shape (n_section,) [m^3]."""
    center: np.ndarray
    """Centroid of each outline from its proximal joint, shape (n_section,) [m]."""
    gyration: np.ndarray
    """Squared radii of gyration about the centroid, axial and across, shape (n_section, 2) [m^2]."""

    def inertia(self, mass: np.ndarray) -> np.ndarray:
        """Moments of sections of these masses, spread evenly over the outlines, shape (n_section, 2) [kg m^2]."""
        return np.asarray(mass)[:, None] * self.gyration


def place_faces(part: Part, cones: np.ndarray, cylinders: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """What `measure_trunk` needs of a piece: height, faces and holes, turned as it stands in the robot."""
    if math.cos(part.turn) > 0.0:
        return part.at[2], cones, cylinders
    x, y, low, high = cylinders.T
    return part.at[2], cones * [-1.0, 1.0], np.stack([x, -y, -high, -low], axis=-1)


def measure_trunk(design: TrunkDesign, pieces: Sequence[tuple[float, np.ndarray, np.ndarray]]) -> Measured:
    """Measure the trunk.

    Args:
        design: what is looked for where.
        pieces: of each printed piece the place of its bottom on the axis [mm], its leaning faces and its cable holes,
            as `kernel.measure_cones` and `kernel.measure_cylinders` give them.
    """
    cones = np.concatenate([faces + np.array([at, 0.0]) for at, faces, _ in pieces])
    apexes = _find_apexes(design, cones[:, 0])
    gap = np.full(design.n_joint, math.nan)
    for i in range(design.n_joint):
        near = np.abs(cones[:, 0] - 1e3 * design.section_length[: i + 1].sum()) < _NEAR
        if np.count_nonzero(near) == 2:
            gap[i] = cones[near, 1].sum()
    holes = np.concatenate([own + np.array([0.0, 0.0, at, at]) for at, _, own in pieces])
    hole = _find_holes(design, holes)
    bulk = _measure_outlines(design)
    across = hole[1:, 0, 0] - hole[:-1, 0, 1]
    starts = 1e-3 * apexes[:-1]
    axial = starts[1:] + hole[1:, 0, 0, 0] - starts[:-1] - hole[:-1, 0, 1, 0]
    return Measured(
        section_length=1e-3 * np.diff(apexes), gap=gap, hole=hole,
        stroke=float(np.hypot(axial, across[:, 1]).sum()), volume=bulk[:, 0], center=bulk[:, 1], gyration=bulk[:, 2:],
    )  # fmt: skip


def _find_apexes(design: TrunkDesign, found: np.ndarray) -> np.ndarray:
    """The joint centres from base to tip, as the leaning faces' apexes have them, shape (n_section + 1,) [mm]."""
    wanted = 1e3 * np.concatenate([[0.0], np.cumsum(design.section_length)])
    apexes = np.full(len(wanted), math.nan)
    for i, place in enumerate(wanted):
        near = found[np.abs(found - place) < _NEAR]
        if len(near):
            apexes[i] = near.mean()
    if math.isnan(apexes[-1]):  # The gripper's plate takes the last face's place: its end is the design's.
        apexes[-1] = wanted[-1]
    return apexes


def _find_holes(design: TrunkDesign, found: np.ndarray) -> np.ndarray:
    """Both ends of each hole from the section's joint centre, shape (n_section, n_cable, 2, 2) [m]."""
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
