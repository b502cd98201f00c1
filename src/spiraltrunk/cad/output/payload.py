"""Mass, centre of mass and moments of inertia that the arm carries, for the payload settings of its controller."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.field_docs import explain_fields


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Payload:
    """Housing, neck and straight trunk as one rigid body on the flange."""

    mass: float
    """Mass [kg]."""
    center: float
    """Distance of the centre of mass from the flange, along the trunk [m]."""
    axial: float
    """Moment of inertia about the trunk's axis [kg m^2]."""
    transverse: float
    """Moment of inertia about a cross axis through the centre of mass [kg m^2]."""


def compute_payload(design: TrunkDesign) -> Payload:
    """Payload of the straight trunk, with the masses that the models use; neither gripper, wedges nor objects.

    Housing and neck are homogeneous cylinders, as in the simulation: m r^2 / 2 about the axis, m (3 r^2 + l^2) / 12
    across; the parts are summed with the parallel-axis theorem.
    """
    housing, wide = design.housing, float(design.section_radius[0])
    starts = np.concatenate([[0.0], np.cumsum(design.section_length)[:-1]])
    base = housing.length + housing.neck_length
    mass = np.array([housing.total_mass, housing.total_neck_mass, *design.section_mass])
    at = np.array([housing.length / 2, base - housing.neck_length / 2, *(base + starts + design.section_center)])
    cylinders = [
        (m * r**2 / 2, m * (3 * r**2 + length**2) / 12)
        for m, r, length in zip(mass, (housing.radius, wide), (housing.length, housing.neck_length), strict=False)
    ]
    axial, across = np.vstack([cylinders, design.section_inertia]).T
    center = float(mass @ at / mass.sum())
    transverse = float((across + mass * (at - center) ** 2).sum())
    return Payload(mass=float(mass.sum()), center=center, axial=float(axial.sum()), transverse=transverse)
