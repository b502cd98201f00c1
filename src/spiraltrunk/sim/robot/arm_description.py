"""Description of an arm: kinematics, inertias, limits, control gains and geometry."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import final

from spiraltrunk.control.arm_limits import ArmLimits
from spiraltrunk.field_docs import explain_fields


@final
@dataclass(frozen=True, kw_only=True)
class LinkInertia:
    """Mass and its distribution in a link's frame."""

    mass: float
    """Mass [kg]."""
    center: tuple[float, float, float]
    """Centre of mass [m]."""
    moments: tuple[float, float, float, float, float, float]
    """Inertia xx, yy, zz, xy, xz, yz about the centre of mass, along the link's axes [kg m^2]."""


@final
@dataclass(frozen=True, kw_only=True)
class Capsule:
    """Capsule in a link's frame."""

    first: tuple[float, float, float]
    """Centre of one end cap [m]."""
    second: tuple[float, float, float]
    """Centre of the other end cap [m]."""
    radius: float
    """Radius [m]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class ArmDescription:
    """A serial arm of hinges with gravity compensation.

    The module of an arm names the sources of its numbers. Frames are those of the Denavit-Hartenberg table in Craig's
    convention: link n rotates with joint n about its own z axis.
    """

    name: str
    """Name in a design's ``arm.model``: lower-case letters and digits."""
    dh: tuple[tuple[float, float, float], ...]
    """Rows a [m], d [m], alpha [rad], one per joint (Craig, "Introduction to Robotics", modified parameters)."""
    flange: float
    """Distance of the flange from the last joint's frame, along its z axis [m]."""
    inertia: tuple[LinkInertia, ...]
    """Inertia of the fixed link 0 and of the link behind each joint, n_joint + 1 entries."""
    armature: tuple[float, ...]
    """Rotor inertia of each joint, reflected through its gear [kg m^2]."""
    limits: ArmLimits
    """Limits; those of position and torque are required, as the simulated joints have them."""
    gains: tuple[tuple[float, float], ...]
    """Stiffness [N m/rad] and damping [N m s/rad] of each joint's position control."""
    home: tuple[float, ...]
    """Joint positions at the start of a trial, unless the design sets others [rad]."""
    payload: float | None
    """Rated payload at the flange [kg]; None where none is published."""
    capsules: tuple[tuple[Capsule, ...], ...] = ()
    """Capsules of each link, drawn and colliding, n_joint + 1 tuples, for an arm without meshes."""
    find_meshes: Callable[[], Path] | None = None
    """Finds the folder of the arm's meshes, ``visual/link0.stl`` and ``collision/link0.stl`` onwards [m]; raises
    MissingPackage where it is not installed. None for an arm of capsules."""
