"""Objects to grasp: geometric solids by name or by their measures."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import mujoco

from spiraltrunk.design.checks import Range, check_number, check_numbers, check_range
from spiraltrunk.design.units import MILLI
from spiraltrunk.errors import DesignError, UnknownName, Words
from spiraltrunk.sim.materials import SOLIMP, SOLREF

_EXTENTS = Range(least=0.005, below=1.0)
"""Extents that an object may have [m]."""

_MASSES = Range(least=0.001, below=20.0)
"""Masses that an object may have [kg]."""

OBJECT_COLOR = [0.85, 0.36, 0.16, 1.0]


@final
@dataclass(frozen=True, kw_only=True)
class ObjectSpec:
    """A solid of uniform density. Its own x axis is the one that a wrap goes round."""

    kind: str
    """cylinder, sphere or box."""
    size: tuple[float, float, float]
    """Extents along its axis, across it and up [m]."""
    mass: float
    """Mass [kg]."""
    friction: float = 0.8
    """Coefficient of friction against everything it touches [-]."""

    def __post_init__(self) -> None:
        if self.kind not in _MEASURES:
            raise UnknownName("kind of object", self.kind, _MEASURES)
        check_numbers("object.size", self.size, count=3)
        for name, extent in zip(("length", "width", "height"), self.size, strict=True):
            check_range(f"object.{name}", extent, _EXTENTS)
        length, width, height = self.size
        if self.kind == "sphere" and not length == width == height:
            raise DesignError("object.size", got=self.size, allowed="three equal extents for a sphere")
        if self.kind == "cylinder" and width != height:
            raise DesignError("object.size", got=self.size, allowed="width equal to height for a cylinder")
        check_range("object.mass", self.mass, _MASSES)
        check_number("object.friction", self.friction, above=0.0, below=5.0)

    @property
    def width(self) -> float:
        """Larger extent across the axis [m]."""
        return max(self.size[1], self.size[2])

    def inertia(self) -> tuple[float, float, float]:
        """Moments about the three axes through the centre [kg m^2]."""
        x, y, z = self.size
        m = self.mass
        if self.kind == "sphere":
            return (m * x**2 / 10,) * 3
        if self.kind == "cylinder":
            across = m * (3 * (y / 2) ** 2 + x**2) / 12
            return m * (y / 2) ** 2 / 2, across, across
        return m * (y**2 + z**2) / 12, m * (x**2 + z**2) / 12, m * (x**2 + y**2) / 12


_MEASURES = {
    "cylinder": ("diameter_mm", "height_mm", "mass_g"),
    "sphere": ("diameter_mm", "mass_g"),
    "box": ("x_mm", "y_mm", "z_mm", "mass_g"),
}
"""Measures that each kind is given by."""

CATALOGUE = {
    "cylinder-33": "cylinder:diameter_mm=33,height_mm=240,mass_g=150",
    "cylinder-60": "cylinder:diameter_mm=60,height_mm=240,mass_g=250",
    "cylinder-90": "cylinder:diameter_mm=90,height_mm=240,mass_g=300",
    "cylinder-120": "cylinder:diameter_mm=120,height_mm=240,mass_g=400",
    "ball-80": "sphere:diameter_mm=80,mass_g=200",
    "box-60": "box:x_mm=240,y_mm=60,z_mm=60,mass_g=250",
}
"""Objects by name, each as its measures."""

DEFAULT_OBJECT = "cylinder-60"


def parse_object(text: str) -> ObjectSpec:
    """An object from a catalogue name or from ``kind:measure=value,...``.

    A cylinder's axis, a box's x, lies across the plane in which the trunk bends.

    Raises:
        UnknownName: for a name or kind that does not exist.
        DesignError: for a missing, doubled, unknown or impossible measure.
    """
    if ":" not in text:
        if text not in CATALOGUE:
            forms = [f"{kind}:{','.join(f'{name}=' for name in names)}" for kind, names in _MEASURES.items()]
            raise UnknownName("object", text, [*CATALOGUE, *forms])
        text = CATALOGUE[text]
    kind, _, rest = text.partition(":")
    if kind not in _MEASURES:
        raise UnknownName("kind of object", kind, _MEASURES)
    values = _parse_measures(kind, rest)
    mass = values["mass_g"]
    if kind == "sphere":
        return ObjectSpec(kind=kind, size=(values["diameter_mm"],) * 3, mass=mass)
    if kind == "cylinder":
        return ObjectSpec(kind=kind, size=(values["height_mm"], *(values["diameter_mm"],) * 2), mass=mass)
    return ObjectSpec(kind=kind, size=(values["x_mm"], values["y_mm"], values["z_mm"]), mass=mass)


def add_object(spec: mujoco.MjSpec, shape: ObjectSpec, name: str = "object") -> mujoco.MjsBody:
    """Add the object as a free body, its axis along the body's x."""
    body = spec.worldbody.add_body(name=name)
    body.add_freejoint(name=name)
    body.explicitinertial = True
    body.mass = shape.mass
    body.ipos = [0, 0, 0]
    body.inertia = shape.inertia()
    length, width, height = shape.size
    geom = body.add_geom(
        name=name, rgba=OBJECT_COLOR, solref=SOLREF, solimp=SOLIMP, condim=3, priority=1,
        friction=[shape.friction, 0.005, 1e-4],
    )  # fmt: skip
    if shape.kind == "sphere":
        geom.type, geom.size = mujoco.mjtGeom.mjGEOM_SPHERE, [length / 2, 0, 0]
    elif shape.kind == "cylinder":
        geom.type, geom.size = mujoco.mjtGeom.mjGEOM_CYLINDER, [width / 2, length / 2, 0]
        geom.quat = [math.sqrt(0.5), 0, math.sqrt(0.5), 0]
    else:
        geom.type, geom.size = mujoco.mjtGeom.mjGEOM_BOX, [length / 2, width / 2, height / 2]
    for side, x in (("left", -length / 2), ("right", length / 2)):
        body.add_site(name=f"{name}_{side}", pos=[x, 0, 0])
    return body


def _parse_measures(kind: str, text: str) -> dict[str, float]:
    """Measures in SI."""
    allowed = _MEASURES[kind]
    form = f"{kind}:{','.join(f'{name}=' for name in allowed)}"
    values: dict[str, float] = {}
    for part in filter(None, (piece.strip() for piece in text.split(","))):
        name, equals, number = part.partition("=")
        if name not in allowed or not equals or name in values:
            raise DesignError("measure of the object", got=part, allowed=f"each measure once: {form}")
        values[name] = _parse_measure(name, number.strip())
    missing = [name for name in allowed if name not in values]
    if missing:
        raise DesignError("object", got=Words(f"without {', '.join(missing)}"), allowed=form)
    return values


def _parse_measure(name: str, text: str) -> float:
    """One measure in SI; a refusal tells it in its own unit."""
    allowed = _MASSES if name == "mass_g" else _EXTENTS
    try:
        value = float(text) if text.isascii() and "_" not in text else math.nan
    except ValueError:
        value = math.nan
    if not allowed.holds(value / 1000.0):
        got = text if math.isnan(value) else Words(text)
        raise DesignError(f"object.{name}", got=got, allowed=allowed.told_in(MILLI))
    return value / 1000.0
