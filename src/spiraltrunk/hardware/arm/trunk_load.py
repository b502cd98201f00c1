"""What hangs on the arm's flange by the design: housing, neck, trunk and gripper."""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.hardware.arm.arm_port import ArmLoad

_Body = tuple[float, np.ndarray, np.ndarray]
"""Mass [kg], centre of mass [m] and inertia about it [kg m^2], in the trunk's frame."""


def trunk_load(design: TrunkDesign) -> ArmLoad:
    """Load of housing and straight trunk in the flange's frame.

    Its z axis points along the trunk and the dorsal side is its x axis rotated about z by ``arm.roll``, as
    `ArmDesign.roll` says. m = sum m_k, c = sum m_k c_k / m, and by the parallel axis theorem
    I = sum I_k + m_k (|d|^2 1 - d d^T) with d = c_k - c. A curled trunk, and what it carries, differ from it.
    """
    bodies = [*_housing_bodies(design), *_section_bodies(design), *_gripper_bodies(design)]
    mass = math.fsum(body[0] for body in bodies)
    center = sum((m * c for m, c, _ in bodies), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for m, c, about_center in bodies:
        d = c - center
        inertia += about_center + m * (d @ d * np.eye(3) - np.outer(d, d))
    turn = _flange_axes(design.arm.roll)
    return ArmLoad(mass=mass, center=turn @ center, inertia=turn @ inertia @ turn.T)


def _flange_axes(roll: float) -> np.ndarray:
    """Columns: along the trunk, dorsal, and their cross product, in the flange's frame, shape (3, 3) [-]."""
    c, s = math.cos(roll), math.sin(roll)
    return np.array([[0.0, c, -s], [0.0, s, c], [1.0, 0.0, 0.0]])


def _housing_bodies(design: TrunkDesign) -> list[_Body]:
    housing = design.housing
    middle = housing.length + housing.neck_length / 2
    neck = float(design.section_radius[0]), housing.neck_length
    return [
        _cylinder(housing.total_mass, (housing.radius, housing.length), [housing.length / 2, 0.0, 0.0]),
        _cylinder(housing.total_neck_mass, neck, [middle, 0.0, 0.0]),
    ]


def _section_bodies(design: TrunkDesign) -> list[_Body]:
    starts = _base(design) + np.concatenate([[0.0], np.cumsum(design.section_length)[:-1]])
    centers = np.zeros((design.n_section, 3))
    centers[:, 0] = starts + design.section_center
    inertias = [np.diag([axial, across, across]) for axial, across in design.section_inertia]
    return list(zip(design.section_mass.tolist(), centers, inertias, strict=True))


def _gripper_bodies(design: TrunkDesign) -> list[_Body]:
    """Phalanges of the straight fingers: cylinders, their masses in proportion to their volumes."""
    gripper = design.gripper
    if gripper is None:
        return []
    share = gripper.phalanx_length * gripper.phalanx_width**2
    masses = gripper.mass / gripper.n_finger * share / share.sum()
    along = _base(design) + design.length + np.cumsum(gripper.phalanx_length) - gripper.phalanx_length / 2
    bodies = []
    for angle in 2 * math.pi * np.arange(gripper.n_finger) / gripper.n_finger:
        aside = gripper.mount_radius * np.array([math.cos(angle), math.sin(angle)])
        sizes = zip(masses, gripper.phalanx_width / 2, gripper.phalanx_length, along, strict=True)
        bodies += [_cylinder(m, (r, length), [x, *aside]) for m, r, length, x in sizes]
    return bodies


def _base(design: TrunkDesign) -> float:
    """Distance of the trunk's base from the flange [m]."""
    return design.housing.length + design.housing.neck_length


def _cylinder(mass: float, size: tuple[float, float], center: list[float]) -> _Body:
    """Solid cylinder of radius and length ``size`` [m] along x: m r^2 / 2 about x, m (3 r^2 + l^2) / 12 across."""
    radius, length = size
    across = mass * (3 * radius**2 + length**2) / 12
    return float(mass), np.array(center), np.diag([mass * radius**2 / 2, across, across])
