"""Objects from STL and OBJ files: reading, unit, repair, convex shapes and mass distribution."""

from __future__ import annotations

import io
import math
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from spiraltrunk.checks import Range
from spiraltrunk.errors import MissingPackage, UnknownName
from spiraltrunk.sim.objects.geoms import HIDDEN, Geom, Solid, axis_rotation
from spiraltrunk.sim.objects.meshes.mesh_repair import repair
from spiraltrunk.sim.objects.meshes.obj_text import read_obj
from spiraltrunk.sim.objects.presentation import settle
from spiraltrunk.sim.objects.spec import EXTENTS, ObjectSpec, check_builds
from spiraltrunk.sim.user_files.limited_process import run_limited
from spiraltrunk.sim.user_files.regular_file import read_file, refusal

if TYPE_CHECKING:
    from trimesh import Trimesh

UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 25.4e-3}
"""Units of a file [m]."""

AXES = ("longest", "x", "y", "z")
"""Directions of a file that can become the object's axis."""

COLLIDES = ("hull", "parts")
"""Collision shapes of a mesh: its convex hull, or convex parts."""

FACES_MOST = 100_000
"""Largest number of triangles of a mesh."""

PARTS_MOST = 24
"""Largest number of convex parts of a mesh (ours)."""

CONCAVITY = 0.05
"""Largest concavity of a part, CoACD's default threshold (Wei et al., SIGGRAPH 2022) [-]."""

DECOMPOSITION_MOST = 120
"""Longest time that the decomposition into convex parts may take [s] (ours)."""

USUAL = 0.12
"""Usual largest extent of a thing to grasp, by which a unit is guessed (ours) [m]."""

RARITY = {"m": 0.0, "mm": 0.0, "cm": 0.4, "in": 0.6}
"""How much less usual a unit is in files, as the logarithm of a ratio of sizes (ours) [-]."""

DENSITIES = Range(least=10.0, below=20_000.0)
"""Densities that an object can be expected to have, from foam to heavy metal (ours) [kg/m^3]."""


def load_mesh(
    path: str, *, mass: float, form: str = "stl", unit: str = "", axis: str = "longest", collide: str = "hull"
) -> ObjectSpec:
    """An object of uniform density with the surface of an STL or OBJ file.

    Volume, centre of mass and inertia are integrals over the surface (divergence theorem), exact for the triangles.
    A surface with faults is repaired, or its convex hull takes its place (`mesh_repair.repair`); the object's ``notes``
    tell it. MuJoCo collides only convex shapes: with ``collide="hull"`` the convex hull of the whole;
    `ObjectSpec.warning` is set where its volume is larger by more than 5 %. With ``"parts"``, up to `PARTS_MOST` convex
    parts, found by the package coacd in at most `DECOMPOSITION_MOST`.

    Args:
        path: the file.
        mass: mass of the object [kg].
        form: stl, binary or ASCII, or obj.
        unit: unit of its coordinates, m, cm, mm or in; empty guesses it from the extents (`guess_unit`).
        axis: direction that becomes the object's axis: longest, x, y or z. With longest, the object rests as in the
            file, else upright, else in its most probable pose (`presentation.settle`).
        collide: hull or parts.

    Raises:
        DesignError: for a file that cannot be read, or whose surface does not enclose one solid of 5 mm to 1 m.
        UnknownName: for a unit, an axis or a way to collide that does not exist.
        MissingPackage: for ``"parts"`` without coacd.
    """
    for what, name, known in (
        ("unit", unit or "m", UNITS),
        ("axis", axis, AXES),
        ("way to collide", collide, COLLIDES),
    ):
        if name not in known:
            raise UnknownName(what, name, known)
    what, notes = f"the file {Path(path).name!r}", []
    mesh = _read(read_file(path, f"{form}:path"), form, what)
    if not unit:
        unit, note = guess_unit(np.ptp(mesh.vertices, axis=0), mass, what)
        notes.append(note)
    mesh.vertices = mesh.vertices * UNITS[unit]
    _check_size(mesh, what, unit)
    with np.errstate(all="ignore"):  # Of surfaces without area or volume, which are refused.
        repaired = repair(mesh, what)
    if repaired.is_hull and collide == "parts":
        raise refusal(what, "without a closed surface, which convex parts need", "collide=hull, or a repaired file")
    notes += [repaired.note] if repaired.note else []
    solid = _build(repaired.mesh, axis, collide, what)
    notes += _doubt_density(mass, float(repaired.mesh.volume))
    shape = ObjectSpec(kind="mesh", size=solid.extents(), mass=mass, loaded=solid, notes=tuple(notes))
    if axis == "longest":
        shape = settle(shape, axis_rotation(axis, repaired.mesh.extents)[:, 2])
    return check_builds(shape, path)


def load_stl(path: str, *, unit: str, mass: float, axis: str = "longest", collide: str = "hull") -> ObjectSpec:
    """`load_mesh` of an STL file."""
    return load_mesh(path, mass=mass, form="stl", unit=unit, axis=axis, collide=collide)


def guess_unit(extents: np.ndarray, mass: float, what: str) -> tuple[str, str]:
    """The most plausible unit of a file without one, and a line that says so.

    Of the units in which every extent is one of an object, that in which the largest is nearest to `USUAL`, as ratios,
    with `RARITY`. Units in which the mass over the box of these extents is none of `DENSITIES` come last.

    Args:
        extents: shape (3,), in the unknown unit.
        mass: mass of the object [kg].
        what: name of the file in errors.

    Raises:
        DesignError: where no unit makes it an object.
    """
    fit = [unit for unit, size in UNITS.items() if all(EXTENTS.holds(float(extent) * size) for extent in extents)]
    if not fit:
        given = " x ".join(f"{extent:.4g}" for extent in extents)
        raise refusal(what, f"of {given} units", f"5 mm to below 1 m each way, in {', '.join(UNITS)}")
    dense = [unit for unit in fit if DENSITIES.holds(mass / float(np.prod(extents * UNITS[unit])))]
    best = min(dense or fit, key=lambda unit: abs(math.log(float(extents.max()) * UNITS[unit] / USUAL)) + RARITY[unit])
    sizes = {unit: " x ".join(f"{1e3 * extent * UNITS[unit]:.4g}" for extent in extents) + " mm" for unit in fit}
    others = "".join(f", not {unit} ({sizes[unit]})" for unit in fit if unit != best)
    return best, f"the unit is guessed from the size: {best}, {sizes[best]}{others}; unit= states it"


def _doubt_density(mass: float, volume: float) -> list[str]:
    """A line where the density is none of `DENSITIES`, else none."""
    density = mass / volume
    if DENSITIES.holds(density):
        return []
    told = f"{density:.3g} kg/m3, {'below' if density < DENSITIES.least else 'above'} what things have"
    return [f"the density is {told}, {DENSITIES.least:g} to {DENSITIES.below:g}: check the unit and mass_g"]


def _read(content: bytes, form: str, what: str) -> Trimesh:
    import trimesh

    with np.errstate(all="ignore"):  # Numbers that are not finite are refused below.
        if form == "obj":
            vertices, triangles = read_obj(content, what, most=FACES_MOST)
            mesh = trimesh.Trimesh(vertices, triangles, process=False)
        else:
            mesh = _read_stl(content, what)
    faces = len(mesh.faces)
    if faces == 0:
        raise refusal(what, "no OBJ, or has no faces", "an OBJ with lines of v and f; an STL is given by stl:path=")
    if faces < 4:
        raise refusal(what, f"of {faces} triangles", f"4 to {FACES_MOST}; fewer enclose no solid")
    if faces > FACES_MOST:
        raise refusal(what, f"of {faces} triangles", f"4 to {FACES_MOST}; a coarser export has fewer")
    mesh.remove_unreferenced_vertices()
    if not np.isfinite(mesh.vertices).all():
        raise refusal(what, "not finite in some coordinates", "finite numbers; export it again")
    return mesh


def _read_stl(content: bytes, what: str) -> Trimesh:
    import trimesh

    content = _cut_binary_stl(content, what)
    try:
        mesh = trimesh.load_mesh(io.BytesIO(content), file_type="stl", process=False)
        if len(mesh.faces) == 0:  # The reader may take any bytes for an empty ASCII file.
            raise ValueError("no triangles")
    except Exception as error:  # The reader raises any kind of error for broken bytes.
        raise refusal(
            what, "no STL that can be read", "an STL, binary or ASCII; an OBJ is given by obj:path="
        ) from error
    return mesh


def _cut_binary_stl(content: bytes, what: str) -> bytes:
    """A binary STL without the few bytes that follow its triangles; another file as it is.

    Raises:
        DesignError: for one that has fewer triangles than it states.
    """
    head, record = 84, 50
    if len(content) < head or (content.lstrip()[:5].lower() == b"solid" and b"facet" in content[:1000].lower()):
        return content
    stated, held = int.from_bytes(content[80:head], "little"), (len(content) - head) // record
    if held == 0 or stated > FACES_MOST:  # What is no STL, or is refused for its size.
        return content
    if held < stated:
        raise refusal(what, f"cut off: it states {stated} triangles and holds {held}", "the whole file")
    return content[: head + record * stated] if held == stated else content  # Of more it is unknown which are meant.


def _check_size(mesh: Trimesh, what: str, unit: str) -> None:
    extents = np.ptp(mesh.vertices, axis=0)
    if not (EXTENTS.holds(float(extents.min())) and EXTENTS.holds(float(extents.max()))):
        measures = " x ".join(f"{1e3 * extent:.4g}" for extent in extents)
        others = ", ".join(name for name in UNITS if name != unit)
        allowed = f"5 mm to below 1 m each way; is its unit not {unit} but one of {others}?"
        raise refusal(what, f"of {measures} mm", allowed)


def _build(mesh: Trimesh, axis: str, collide: str, what: str) -> Solid:
    """The solid with its origin in the middle of its extents and its axis along x."""
    from scipy.spatial import ConvexHull

    whole = Geom(form="mesh", vertices=np.asarray(mesh.vertices, float), faces=np.asarray(mesh.faces, np.int64))
    geoms: tuple[Geom, ...] = (whole,)
    if collide == "parts":
        geoms = (replace(whole, collides=False), *_decompose(mesh, what))
    mesh.density = 1.0
    volume = float(mesh.volume)
    colliding = sum(float(ConvexHull(geom.vertices).volume) for geom in geoms if geom.collides)
    solid = Solid(
        geoms=geoms, centroid=np.array(mesh.center_mass), inertia=np.array(mesh.moment_inertia) / volume,
        excess=colliding / volume - 1,
    )  # fmt: skip
    longest = "xyz"[int(np.argmax(np.round(mesh.extents, 9)))]  # Of the whole, not of its parts.
    return solid.aligned(longest if axis == "longest" else axis)


def _decompose(mesh: Trimesh, what: str) -> tuple[Geom, ...]:
    """Convex decomposition of a mesh; the same mesh gives the same parts."""
    if find_spec("coacd") is None:
        raise MissingPackage("convex parts need coacd: pip install 'spiraltrunk[objects]'")
    sent, parts = io.BytesIO(), []
    for array, kind in ((mesh.vertices, float), (mesh.faces, np.int64), ([CONCAVITY, PARTS_MOST], float)):
        np.save(sent, np.array(array, kind))
    received = run_limited("decompose", sent.getvalue(), seconds=DECOMPOSITION_MOST, what=what)
    stream = io.BytesIO(received)
    while stream.tell() < len(received):
        vertices, faces = np.load(stream), np.load(stream)
        parts.append(Geom(form="mesh", vertices=np.asarray(vertices, float), faces=faces, group=HIDDEN))
    return tuple(parts)
