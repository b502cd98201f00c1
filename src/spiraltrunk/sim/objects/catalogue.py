"""Objects to grasp: by name, by their measures, or from a file."""

from __future__ import annotations

import math
from difflib import get_close_matches
from pathlib import PurePath

from spiraltrunk.checks import check_type
from spiraltrunk.errors import DesignError, UnknownName, Unquoted
from spiraltrunk.sim.objects.everyday import FAMILIES, parse_everyday
from spiraltrunk.sim.objects.meshes.mesh_file import AXES, COLLIDES, UNITS, load_mesh, load_stl
from spiraltrunk.sim.objects.mjcf import load_mjcf
from spiraltrunk.sim.objects.presentation import take_pose
from spiraltrunk.sim.objects.spec import EXTENTS, MASSES, ObjectSpec, add_object, scaled

__all__ = [
    "CATALOGUE",
    "DEFAULT_OBJECT",
    "MEASURES",
    "SOLIDS",
    "ObjectSpec",
    "add_object",
    "load_mesh",
    "load_mjcf",
    "load_stl",
    "parse_object",
    "scaled",
]

CATALOGUE = {
    "cylinder-33": "cylinder:diameter_mm=33,height_mm=240,mass_g=150",
    "cylinder-60": "cylinder:diameter_mm=60,height_mm=240,mass_g=250",
    "cylinder-60-heavy": "cylinder:diameter_mm=60,height_mm=240,mass_g=1500",
    "cylinder-90": "cylinder:diameter_mm=90,height_mm=240,mass_g=300",
    "cylinder-120": "cylinder:diameter_mm=120,height_mm=240,mass_g=400",
    "cylinder-150": "cylinder:diameter_mm=150,height_mm=240,mass_g=500",
    "ball-60": "sphere:diameter_mm=60,mass_g=100",
    "ball-80": "sphere:diameter_mm=80,mass_g=200",
    "ball-100": "sphere:diameter_mm=100,mass_g=250",
    "ball-120": "sphere:diameter_mm=120,mass_g=300",
    "box-60": "box:x_mm=60,y_mm=60,z_mm=240,mass_g=250",
    "box-80": "box:x_mm=80,y_mm=80,z_mm=240,mass_g=300",
    "box-100": "box:x_mm=100,y_mm=100,z_mm=240,mass_g=400",
    "box-120": "box:x_mm=120,y_mm=120,z_mm=240,mass_g=500",
    "cone-90": "cone:diameter_mm=90,height_mm=160,mass_g=200",
    "disc-80x20": "cylinder:diameter_mm=80,height_mm=20,mass_g=80",
    "disc-120x20": "cylinder:diameter_mm=120,height_mm=20,mass_g=150",
    "ring-90": "ring:outer_mm=90,tube_mm=15,mass_g=40",
    "bottle-70": "bottle:diameter_mm=70,height_mm=220,neck_mm=30,mass_g=350",
    "rod-10": "cylinder:diameter_mm=10,height_mm=150,mass_g=30",
    "rod-20": "cylinder:diameter_mm=20,height_mm=150,mass_g=60",
    "bar-12x20": "box:x_mm=20,y_mm=12,z_mm=150,mass_g=40",
    "bar-20x20": "box:x_mm=20,y_mm=20,z_mm=150,mass_g=60",
    "ball-30": "sphere:diameter_mm=30,mass_g=15",
    "cube-28": "box:x_mm=28,y_mm=28,z_mm=28,mass_g=20",
    "cylinder-32": "cylinder:diameter_mm=32,height_mm=40,mass_g=30",
    "cone-35": "cone:diameter_mm=35,height_mm=45,mass_g=20",
}
"""Measures of the named objects: for wraps, flat and hollow ones, for the pinch, for the tip's gripper."""

DEFAULT_OBJECT = "cylinder-60"

LIKE = 0.7
"""Least similarity of a catalogue name to an unknown one for an error to name it (`difflib`, ours) [-]."""

MEASURES = {
    "cylinder": ("diameter_mm", "height_mm", "mass_g"),
    "sphere": ("diameter_mm", "mass_g"),
    "box": ("x_mm", "y_mm", "z_mm", "mass_g"),
    "cone": ("diameter_mm", "height_mm", "mass_g"),
    "ring": ("outer_mm", "tube_mm", "mass_g"),
    "bottle": ("diameter_mm", "height_mm", "neck_mm", "mass_g"),
    "stl": ("path", "mass_g"),
    "obj": ("path", "mass_g"),
    "mjcf": ("path",),
    "everyday": ("seed",),
}
"""Required measures of each kind."""

_WORDS = {
    "path": "FILE", "unit": "|".join(UNITS), "axis": "|".join(AXES), "collide": "|".join(COLLIDES),
    "pose": "upright|lying|0|1|...", "seed": "N", "kind": "|".join(FAMILIES),
}  # fmt: skip
"""Measures that are words, and their allowed values."""

SOLIDS = {kind: measures for kind, measures in MEASURES.items() if not _WORDS.keys() & set(measures)}
"""Measures of the kinds that numbers alone describe."""

_OPTIONS = {
    "stl": ("unit", "axis", "collide"),
    "obj": ("unit", "axis", "collide"),
    "mjcf": ("mass_g", "axis"),
    "everyday": ("kind",),
}
"""Optional measures of each kind, besides the pose."""


def parse_object(text: str) -> ObjectSpec:
    """An object from a catalogue name, with ``,pose=`` or without, or from ``kind:measure=value,...``.

    Solids stand as their measures say, z up; objects from files as in the file where they stand so, else upright, else
    in their most probable stable pose. ``pose=`` says otherwise.

    Raises:
        UnknownName: for a name or kind that does not exist.
        DesignError: for a missing, repeated, unknown or impossible measure, or an unsuitable file.
    """
    check_type("object", text, str)
    name, comma, more = text.partition(",")
    if name.strip() in CATALOGUE:
        text = CATALOGUE[name.strip()] + comma + more
        _check_free(name.strip(), more)
    kind, colon, rest = text.partition(":")
    if not colon:
        raise _refuse_name(name.strip())
    if kind not in MEASURES:
        raise UnknownName("kind of object", kind, MEASURES)
    given = _split_measures(kind, rest)
    words = {name: value for name, value in given.items() if name in _WORDS}
    values = {name: _parse_measure(name, value) for name, value in given.items() if name not in _WORDS}
    pose = words.pop("pose", None)
    shape = _build(kind, words, values)
    return shape if pose is None else take_pose(shape, pose)


def _check_free(name: str, more: str) -> None:
    """Refuse a measure after the name of an object of the catalogue, which has it already."""
    kind = CATALOGUE[name].partition(":")[0]
    for part in more.split(","):
        measure = part.partition("=")[0].strip()
        if measure in MEASURES[kind]:
            allowed = f"pose= after a name, or all measures: {CATALOGUE[name]}"
            raise DesignError(f"{measure} of {name!r}", got=Unquoted("that of the catalogue"), allowed=allowed)


_FORMS = {
    ".stl": "stl:path={},mass_g=GRAMS",
    ".obj": "obj:path={},mass_g=GRAMS",
    ".xml": "mjcf:path={}",
    ".mjcf": "mjcf:path={}",
}
"""How files are given, by their ending."""


def _refuse_name(name: str) -> UnknownName | DesignError:
    """The error about a name that is not in the catalogue: names that are like it, the kinds, where all names are."""
    near = get_close_matches(name, CATALOGUE, n=3, cutoff=LIKE)
    kinds = ", ".join(f"{kind}:" for kind in MEASURES)
    form = _FORMS.get(PurePath(name).suffix.lower())
    if form is not None:
        return DesignError("object", got=name, allowed=f"{form.format(name)}, which reads the file")
    return UnknownName(
        "object", name, [*near, f"solids and files ({kinds}) and the catalogue, which spiraltrunk object lists"]
    )


def _build(kind: str, words: dict[str, str], values: dict[str, float]) -> ObjectSpec:
    if kind == "everyday":
        return parse_everyday(_parse_seed(words["seed"]), words.get("kind"))
    if kind == "mjcf":
        return load_mjcf(**words, mass=values.get("mass_g"))
    mass = values["mass_g"]
    if kind in {"stl", "obj"}:
        if words.get("unit") == "":
            raise UnknownName("unit", "", UNITS)
        return load_mesh(form=kind, **words, mass=mass)
    if kind == "box":
        return _build_box(values["x_mm"], values["y_mm"], values["z_mm"], mass)
    if kind == "ring":
        if not values["outer_mm"] > 2 * values["tube_mm"]:
            got, allowed = f"{1e3 * values['outer_mm']:g}", f"more than twice the tube's {1e3 * values['tube_mm']:g}"
            raise DesignError("object.outer_mm", got=Unquoted(got), allowed=allowed)
        return ObjectSpec(kind=kind, size=(values["tube_mm"], values["outer_mm"], values["outer_mm"]), mass=mass)
    width, neck = values["diameter_mm"], values.get("neck_mm", 0.0)
    if not neck < width:
        got, allowed = f"{1e3 * neck:g}", f"less than the diameter's {1e3 * width:g}"
        raise DesignError("object.neck_mm", got=Unquoted(got), allowed=allowed)
    return ObjectSpec(kind=kind, size=(values.get("height_mm", width), width, width), mass=mass, neck=neck)


def _parse_seed(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) <= 18):
        raise DesignError("object.seed", got=text, allowed="a whole number, at least 0, of at most 18 digits")
    return int(text)


def _build_box(x: float, y: float, z: float, mass: float) -> ObjectSpec:
    """A box that stands on its x-y face, its longest extent along the frame's x axis."""
    if z >= max(x, y):
        return ObjectSpec(kind="box", size=(z, y, x), mass=mass)
    return ObjectSpec(kind="box", size=(max(x, y), min(x, y), z), mass=mass, up="z")


def _form(kind: str) -> str:
    """Text form of a kind, with the allowed values of its words."""
    return f"{kind}:" + ",".join(f"{name}={_WORDS.get(name, '')}" for name in MEASURES[kind])


def _split_measures(kind: str, text: str) -> dict[str, str]:
    """Value of each measure, as text."""
    options = (*_OPTIONS.get(kind, ()), "pose")
    allowed = (*MEASURES[kind], *options)
    given: dict[str, str] = {}
    for part in text.split(",") if text.strip() else ():
        name, equals, value = (piece.strip() for piece in part.partition("="))
        if equals and name not in allowed:
            raise UnknownName(f"measure of {kind}", name, allowed)
        if not equals or name in given:
            more = "".join(f"[,{name}={_WORDS.get(name, '')}]" for name in options)
            got = part.strip() or Unquoted("empty, between or after commas")
            form = f"name=value, each measure once: {_form(kind)}{more}"
            if not equals and "path" in given:
                form += "; a path has no comma"
            raise DesignError("measure of the object", got=got, allowed=form)
        given[name] = value
    missing = [name for name in MEASURES[kind] if name not in given]
    if missing:
        raise DesignError("object", got=Unquoted(f"without {', '.join(missing)}"), allowed=_form(kind))
    return given


def _parse_measure(name: str, text: str) -> float:
    """One measure in SI [m or kg]; an error states it in mm or g."""
    allowed = MASSES if name == "mass_g" else EXTENTS
    try:
        value = float(text) if text.isascii() and "_" not in text else math.nan
    except ValueError:
        value = math.nan
    if not allowed.holds(value / 1000.0):
        got = text if math.isnan(value) else Unquoted(text)
        raise DesignError(f"object.{name}", got=got, allowed=allowed.in_unit(1e-3))
    return value / 1000.0
