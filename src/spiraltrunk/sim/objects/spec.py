"""Object of the simulation: kind, extents, mass, friction, and its MuJoCo body."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import mujoco
import numpy as np

from spiraltrunk.checks import Range, check_number, check_numbers, check_range
from spiraltrunk.errors import DesignError, UnknownName, Unquoted
from spiraltrunk.sim.objects.geoms import Solid, add_geom
from spiraltrunk.sim.objects.solids import SOLIDS, bottle
from spiraltrunk.sim.robot.materials import SOLIMP, SOLREF

EXTENTS = Range(least=0.005, below=1.0)
"""Allowed extents [m]."""

MASSES = Range(least=0.001, below=20.0)
"""Allowed masses [kg]."""

KINDS = (*SOLIDS, "bottle", "mesh", "mjcf")
"""Kinds of object."""

EXCESS_MOST = 0.05
"""Relative excess of the collision volume from which a warning is given [-]."""

ROLLING_FRICTION = 1e-3
"""Rolling friction of objects that would otherwise roll for ever [m] (ours, about that of balls on felt)."""

SPINNING_FRICTION = 5e-3
"""Torsional friction of the same objects [m] (MuJoCo's default)."""

OBJECT_COLOR = [0.85, 0.36, 0.16, 1.0]

_ROUND = ("cylinder", "cone", "ring", "bottle")
"""Kinds of equal width and height."""

_ROLLING = ("sphere", "cone", "ring", "bottle")
"""Kinds with rolling friction in all contacts; the others have it on the ground."""


@final
@dataclass(frozen=True, kw_only=True)
class ObjectSpec:
    """A rigid object. Wraps go around its x axis; its origin is the middle of its extents."""

    kind: str
    """cylinder, sphere, box, cone (apex towards +x), ring (around x), bottle (neck towards +x), or mesh or mjcf from a
    file."""
    size: tuple[float, float, float]
    """Extents along its axis, across it and up [m]."""
    mass: float
    """Mass [kg]."""
    friction: float = 0.8
    """Coefficient of friction in all contacts [-]."""
    neck: float = 0.0
    """Diameter of a bottle's neck, 0 for every other kind [m]."""
    loaded: Solid | None = None
    """Solid from a file, None for the other kinds."""

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
        """Its geoms and mass distribution."""
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
        """Difference between collision geometry and file in one line; empty if there is none."""
        excess = self.solid.excess
        if abs(excess) <= EXCESS_MOST:
            return ""
        more = "larger" if excess > 0 else "smaller"
        return (
            f"the {self.kind} is touched at convex shapes {100 * abs(excess):.0f} % {more} than itself: hollows are "
            "filled; collide=parts keeps them"
        )


def scaled(shape: ObjectSpec, factor: float) -> ObjectSpec:
    """The same object scaled by ``factor``, with the same mass."""
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
    for i, own in enumerate(shape.solid.geoms, start=1):
        geom = add_geom(spec, body, own, name if i == 1 else f"{name}_{i}")
        geom.rgba, geom.solref, geom.solimp, geom.priority = OBJECT_COLOR, SOLREF, SOLIMP, 1
        geom.condim = 6 if shape.kind in _ROLLING else 3
        geom.friction = [shape.friction, SPINNING_FRICTION, ROLLING_FRICTION]
    for side, x in (("left", -shape.length / 2), ("right", shape.length / 2)):
        body.add_site(name=f"{name}_{side}", pos=[x, 0, 0])
    return body
