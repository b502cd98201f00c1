"""What an arm is, as numbers: all that the simulator needs to build, move and judge it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import final

from spiraltrunk.control.arm_limits import ArmLimits
from spiraltrunk.errors import DesignError


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
    """Cylinder with half a ball at each end, in a link's frame."""

    first: tuple[float, float, float]
    """Centre of one ball [m]."""
    second: tuple[float, float, float]
    """Centre of the other [m]."""
    radius: float
    """Radius of cylinder and balls [m]."""


@final
@dataclass(frozen=True, kw_only=True)
class ArmDescription:
    """A serial arm of hinges, whose controller carries the arm's own weight.

    The fields say what is needed and in which unit; the file of an arm says where its numbers come from. Frames are
    those of the Denavit-Hartenberg table in Craig's convention: link n turns with joint n about its own z axis.
    """

    name: str
    """What a design calls it in ``arm.model``: lower-case letters and digits."""
    dh: tuple[tuple[float, float, float], ...]
    """Rows a [m], d [m], alpha [rad], one per joint (Craig, "Introduction to Robotics", modified parameters)."""
    flange: float
    """Distance of the flange from the last joint's frame, along its z axis [m]."""
    inertia: tuple[LinkInertia, ...]
    """Of the fixed link 0 and of each link behind a joint, n_joint + 1 of them."""
    armature: tuple[float, ...]
    """Inertia of each joint's rotor, as felt behind its gear [kg m^2]."""
    limits: ArmLimits
    """What the arm may do; position and torque must be there, as the simulated joints keep them."""
    gains: tuple[tuple[float, float], ...]
    """Stiffness [N m/rad] and damping [N m s/rad] of each joint's position control."""
    home: tuple[float, ...]
    """Joint positions where work starts, unless the design says otherwise [rad]."""
    payload: float | None
    """Mass that the arm is rated to carry behind its flange [kg]; None where none is published."""
    capsules: tuple[tuple[Capsule, ...], ...] = ()
    """What is seen and touched of each link, n_joint + 1 tuples, for an arm without meshes."""
    find_meshes: Callable[[], Path] | None = None
    """Finds the folder of the arm's meshes, ``visual/link0.stl`` and ``collision/link0.stl`` onwards, in m; it may
    raise MissingPackage. None for an arm of capsules."""

    def __post_init__(self) -> None:
        n = len(self.dh)
        counts = {"inertia": n + 1, "armature": n, "gains": n, "home": n}
        counts |= {"capsules": n + 1} if self.find_meshes is None else {}
        for field, count in counts.items():
            if len(getattr(self, field)) != count:
                raise DesignError(f"{self.name}.{field}", got=len(getattr(self, field)), allowed=f"{count} entries")
        if self.limits.position is None or self.limits.torque is None:
            raise DesignError(f"{self.name}.limits", got=self.limits, allowed="limits of position and torque")
