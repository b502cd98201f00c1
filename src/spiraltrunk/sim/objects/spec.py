"""Specification of an object: kind, extents, mass and friction; and its body in MuJoCo."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import mujoco
import numpy as np

from spiraltrunk.checks import Range, check_number, check_numbers, check_range
from spiraltrunk.errors import DesignError, UnknownName
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.sim.mujoco_log import first_line
from spiraltrunk.sim.objects.geoms import Solid, add_geom
from spiraltrunk.sim.objects.solids import SOLIDS, bottle
from spiraltrunk.sim.robot.materials import SOLIMP, SOLREF

EXTENTS = Range(least=0.005, below=1.0)
"""Allowed extents of an object [m]."""

MASSES = Range(least=0.001, below=20.0)
"""Allowed masses of an object [kg]."""

UPS = ("x", "z")
"""Directions of an object's frame that can be up."""

KINDS = (*SOLIDS, "bottle", "mesh", "mjcf", "solid")
"""Kinds of object."""

EXCESS_MOST = 0.05
"""Relative deviation of the colliding from the true volume above which there is a warning [-]."""

ROLLING_FRICTION = 1e-3
"""Coefficient of rolling friction [m] (ours, of the order of balls on felt)."""

SPINNING_FRICTION = 5e-3
"""Coefficient of torsional friction [m] (MuJoCo's default)."""

OBJECT_COLOR = [0.85, 0.36, 0.16, 1.0]

_ROLLING = ("sphere", "cone", "ring", "bottle")
"""Kinds with rolling friction in every contact; others have it on the ground alone."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class ObjectSpec:
    """A rigid object. Wraps encircle its x axis; its origin is the middle of its extents."""

    kind: str
    """cylinder, sphere, box, cone (apex towards +x), ring (about x) or bottle (neck towards +x); mesh or mjcf for an
    object from a file; solid for a generated shape, and for another solid in a pose other than along its axis."""
    size: tuple[float, float, float]
    """Extents along its axis, across it and upwards, shape (3,) [m]."""
    mass: float
    """Mass [kg]."""
    friction: float = 0.8
    """Coefficient of sliding friction in every contact [-]."""
    neck: float = 0.0
    """Diameter of a bottle's neck, 0 for every other kind [m]."""
    loaded: Solid | None = None
    """Solid of a mesh, mjcf or solid, None for every other kind."""
    up: str = "x"
    """Direction of its frame that is up where it stands on the ground as its measures or its file say: x or z."""
    pose: str = ""
    """Pose on the ground that was asked for; empty leaves it to the strategy whether it stands or lies."""
    notes: tuple[str, ...] = ()
    """What was guessed, repaired or replaced when it was read, a line each."""
    turned: str = ""
    """Kind of the solid that was turned into another pose, of a solid that was; empty for every other."""

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise UnknownName("kind of object", self.kind, KINDS)
        check_numbers("object.size", self.size, count=3)
        for name, extent in zip(("length", "width", "height"), self.size, strict=True):
            check_range(f"object.{name}", extent, EXTENTS)
        check_range("object.mass", self.mass, MASSES)
        if self.up not in UPS:
            raise UnknownName("direction that is up", self.up, UPS)
        check_number("object.friction", self.friction, above=0.0, below=5.0)

    @property
    def contact_kind(self) -> str:
        """Kind that its contacts have: that of its shape, whatever its pose."""
        return self.turned or self.kind

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
        """Geoms, and mass distribution per unit mass."""
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
        """Deviations from the file and guesses, in one line; empty for none."""
        return "; ".join(self.warnings)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Deviations from the file and guesses, a line each."""
        excess = self.solid.excess
        if abs(excess) <= EXCESS_MOST:
            return self.notes
        more = "larger" if excess > 0 else "smaller"
        told = f"the {self.kind} collides as convex shapes, {100 * abs(excess):.0f} % {more} than it"
        can_have_parts = self.kind == "mesh" and sum(geom.collides for geom in self.solid.geoms) == 1
        return (*self.notes, f"{told}: hollows are filled{'; collide=parts keeps them' if can_have_parts else ''}")


def scaled(shape: ObjectSpec, factor: float) -> ObjectSpec:
    """The object scaled by ``factor``, with the same mass."""
    length, width, height = shape.size
    loaded = None if shape.loaded is None else shape.loaded.transformed(factor=factor)
    size = (length * factor, width * factor, height * factor)
    return replace(shape, size=size, neck=shape.neck * factor, loaded=loaded)


def check_builds(shape: ObjectSpec, path: str) -> ObjectSpec:
    """The object from a file, unchanged.

    Raises:
        DesignError: where MuJoCo cannot compile it.
    """
    spec = mujoco.MjSpec()
    add_object(spec, shape)
    try:
        spec.compile()
    except ValueError as error:
        allowed = f"what MuJoCo can build; it says: {first_line(error)}"
        raise DesignError("object", got=path, allowed=allowed) from error
    return shape


def add_object(spec: mujoco.MjSpec, shape: ObjectSpec, name: str = "object") -> mujoco.MjsBody:
    """Add the object as a free body, its axis along the body's x, with geoms ``name``, ``name_2`` and so on."""
    body = spec.worldbody.add_body(name=name)
    body.add_freejoint(name=name)
    body.explicitinertial = True
    body.mass = shape.mass
    body.ipos = shape.center()
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = shape.inertia()
    body.fullinertia = [xx, yy, zz, xy, xz, yz]
    for i, part in enumerate(shape.solid.geoms, start=1):
        geom = add_geom(spec, body, part, name if i == 1 else f"{name}_{i}")
        geom.rgba, geom.solref, geom.solimp, geom.priority = OBJECT_COLOR, SOLREF, SOLIMP, 1
        geom.condim = 6 if shape.contact_kind in _ROLLING else 3
        geom.friction = [shape.friction, SPINNING_FRICTION, ROLLING_FRICTION]
    for side, x in (("left", -shape.length / 2), ("right", shape.length / 2)):
        body.add_site(name=f"{name}_{side}", pos=[x, 0, 0])
    return body
