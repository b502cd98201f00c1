"""An object as the simulation has it: kind, extents, mass, friction; and its body in MuJoCo."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import mujoco
import numpy as np

from spiraltrunk.checks import Range, check_number, check_numbers, check_range
from spiraltrunk.errors import DesignError, UnknownName, Unquoted
from spiraltrunk.sim.objects.parts import Solid, add_part
from spiraltrunk.sim.objects.solids import SOLIDS, bottle
from spiraltrunk.sim.robot.materials import SOLIMP, SOLREF

EXTENTS = Range(least=0.005, below=1.0)
"""Extents that an object may have [m]."""

MASSES = Range(least=0.001, below=20.0)
"""Masses that an object may have [kg]."""

KINDS = (*SOLIDS, "bottle", "mesh", "mjcf")
"""Kinds of object."""

EXCESS_MOST = 0.05
"""By how much what collides may exceed the true volume without a word [-]."""

ROLLING_FRICTION = 1e-3
"""Rolling resistance of objects that would else roll for ever [m] (ours, of the order of balls on felt)."""

SPINNING_FRICTION = 5e-3
"""Resistance against spinning on the spot, for the same objects [m] (MuJoCo's default)."""

OBJECT_COLOR = [0.85, 0.36, 0.16, 1.0]

_ROUND = ("cylinder", "cone", "ring", "bottle")
"""Kinds that are as wide as high."""

_ROLLING = ("sphere", "cone", "ring", "bottle")
"""Kinds with rolling friction against everything. Others have it where they lie on the ground."""


@final
@dataclass(frozen=True, kw_only=True)
class ObjectSpec:
    """A rigid object. Its own x axis is the one that a wrap goes round, its origin the middle of its extents."""

    kind: str
    """cylinder, sphere, box, cone (apex towards +x), ring (round x), bottle (neck towards +x), or mesh or mjcf for
    what a file gave."""
    size: tuple[float, float, float]
    """Extents along its axis, across it and up [m]."""
    mass: float
    """Mass [kg]."""
    friction: float = 0.8
    """Coefficient of friction against everything it touches [-]."""
    neck: float = 0.0
    """Diameter of a bottle's neck, 0 for every other kind [m]."""
    loaded: Solid | None = None
    """What a file gave, None for every other kind."""

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise UnknownName("kind of object", self.kind, KINDS)
        check_numbers("object.size", self.size, count=3)
        for name, extent in zip(("length", "width", "height"), self.size, strict=True):
            check_range(f"object.{name}", extent, EXTENTS)
        check_range("object.mass", self.mass, MASSES)
        check_number("object.friction", self.friction, above=0.0, below=5.0)
        self._check_kind()

    def _check_kind(self) -> None:
        """Refuse extents that the kind cannot have."""
        length, width, height = self.size
        if self.kind == "sphere" and not length == width == height:
            raise DesignError("object.size", got=self.size, allowed="three equal extents for a sphere")
        if self.kind in _ROUND and width != height:
            raise DesignError("object.size", got=self.size, allowed=f"width equal to height for a {self.kind}")
        if self.kind == "ring" and not width > 2 * length:
            raise DesignError("object.size", got=self.size, allowed="a ring more than two tubes wide")
        if self.kind == "bottle":
            check_number("object.neck", self.neck, least=EXTENTS.least, below=width)
        elif self.neck != 0:
            raise DesignError("object.neck", got=self.neck, allowed="0 for anything but a bottle")
        if isinstance(self.loaded, Solid) != (self.kind in {"mesh", "mjcf"}):
            got = Unquoted("missing" if self.loaded is None else "given")
            raise DesignError("object.loaded", got=got, allowed="a Solid for mesh and mjcf, None for the others")
        if self.loaded is not None and not np.allclose(self.loaded.extents(), self.size, rtol=1e-6, atol=0):
            raise DesignError("object.size", got=self.size, allowed=f"the file's extents {self.loaded.extents()}")

    @property
    def length(self) -> float:
        """Extent along the axis [m]."""
        return self.size[0]

    @property
    def width(self) -> float:
        """Larger extent across the axis [m]."""
        return max(self.size[1], self.size[2])

    @cached_property
    def solid(self) -> Solid:
        """Its parts, and the mass distribution of one kilogram of it."""
        if self.loaded is not None:
            return self.loaded
        return bottle(self.size, self.neck) if self.kind == "bottle" else SOLIDS[self.kind](self.size)

    def center(self) -> np.ndarray:
        """Centre of mass in the object's frame, shape (3,) [m]."""
        return self.solid.centroid

    def inertia(self) -> np.ndarray:
        """Inertia about the centre of mass, shape (3, 3) [kg m^2]."""
        return self.mass * self.solid.inertia

    @property
    def warning(self) -> str:
        """What is not as the file says, in one line; empty where nothing is."""
        excess = self.solid.excess
        if abs(excess) <= EXCESS_MOST:
            return ""
        more = "larger" if excess > 0 else "smaller"
        return (
            f"the {self.kind} is touched at convex shapes {100 * abs(excess):.0f} % {more} than itself: hollows are "
            "filled; collide=parts keeps them"
        )


def scaled(shape: ObjectSpec, factor: float) -> ObjectSpec:
    """The same object, ``factor`` times as large and as heavy as before."""
    length, width, height = shape.size
    loaded = None if shape.loaded is None else shape.loaded.scaled(factor)
    size = (length * factor, width * factor, height * factor)
    return replace(shape, size=size, neck=shape.neck * factor, loaded=loaded)


def add_object(spec: mujoco.MjSpec, shape: ObjectSpec, name: str = "object") -> mujoco.MjsBody:
    """Add the object as a free body, its axis along the body's x, its geoms named ``name``, ``name_2`` and on."""
    body = spec.worldbody.add_body(name=name)
    body.add_freejoint(name=name)
    body.explicitinertial = True
    body.mass = shape.mass
    body.ipos = shape.center()
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = shape.inertia()
    body.fullinertia = [xx, yy, zz, xy, xz, yz]
    for i, part in enumerate(shape.solid.parts, start=1):
        geom = add_part(spec, body, part, name if i == 1 else f"{name}_{i}")
        geom.rgba, geom.solref, geom.solimp, geom.priority = OBJECT_COLOR, SOLREF, SOLIMP, 1
        geom.condim = 6 if shape.kind in _ROLLING else 3
        geom.friction = [shape.friction, SPINNING_FRICTION, ROLLING_FRICTION]
    for side, x in (("left", -shape.length / 2), ("right", shape.length / 2)):
        body.add_site(name=f"{name}_{side}", pos=[x, 0, 0])
    return body
