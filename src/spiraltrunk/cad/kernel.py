"""The one place that speaks to build123d: forms become solids, solids become meshes and STEP files."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from spiraltrunk.cad.forms import Common, Cut, Form, Moved, Prism, Revolved, Union
from spiraltrunk.cad.mesh import Mesh, weld
from spiraltrunk.errors import MissingPackage

if TYPE_CHECKING:
    from build123d import Shape

ANGLE = 0.25
"""Largest angle between neighbouring facets of a mesh [rad]; the tolerance rules where it is finer (ours)."""


def check_packages() -> None:
    """Load what solids need.

    Raises:
        MissingPackage: which extra to install.
    """
    try:
        import build123d  # noqa: F401
        import embreex  # noqa: F401
    except ImportError as error:
        raise MissingPackage(f"solids need {error.name}: pip install 'spiraltrunk[cad]'") from error


def build_solid(form: Form) -> Shape:
    """The form as the kernel's boundary representation, in mm."""
    import build123d as bd

    match form:
        case Revolved(profile=profile, start=start, arc=arc):
            wire = bd.Wire.make_polygon([bd.Vector(r, 0, z) for r, z in profile], close=True)
            solid = bd.Solid.revolve(bd.Face(wire), math.degrees(arc), bd.Axis.Z)
            return solid if start == 0.0 else solid.rotate(bd.Axis.Z, math.degrees(start))
        case Prism(corners=corners, bottom=bottom, top=top):
            wire = bd.Wire.make_polygon([bd.Vector(x, y, bottom) for x, y in corners], close=True)
            return bd.Solid.extrude(bd.Face(wire), bd.Vector(0, 0, top - bottom))
        case Moved(form=inner, T=T):
            return build_solid(inner).moved(_location(T))
        case Union(forms=forms):
            first, *others = (build_solid(part) for part in forms)
            return _single(first.fuse(*others) if others else first)
        case Cut(form=inner, tools=tools):
            return _single(build_solid(inner).cut(*(build_solid(tool) for tool in tools)) if tools else build_solid(inner))
        case Common(form=inner, other=other):
            return _single(build_solid(inner).intersect(build_solid(other)))


def build_mesh(solid: Shape, tolerance: float) -> Mesh:
    """The solid's surface as triangles, nowhere further from it than ``tolerance`` [mm]."""
    points, triangles = solid.tessellate(tolerance, ANGLE)
    return weld(np.array([(p.X, p.Y, p.Z) for p in points]), np.array(triangles))


def write_step(solid: Shape, path: Path, name: str) -> None:
    """Write the solid as STEP, in mm."""
    import build123d as bd

    solid.label = name
    if not bd.export_step(solid, str(path)):
        raise OSError(f"the STEP writer failed at {path.name}")


def read_step_volume(path: Path) -> float:
    """Volume of what a STEP file holds [mm^3]."""
    import build123d as bd

    return float(bd.import_step(str(path)).volume)


def _location(T: Any) -> Any:
    import build123d as bd
    from OCP.gp import gp_Trsf

    move = gp_Trsf()
    move.SetValues(*(float(value) for row in T[:3] for value in row))
    return bd.Location(move)


def _single(result: Any) -> Any:
    """The one solid in a result that may be a list or a compound of one."""
    solids = list(result) if isinstance(result, (list, tuple)) else [result]
    if len(solids) == 1 and len(solids[0].solids()) == 1:
        return solids[0].solids()[0]
    return solids[0] if len(solids) == 1 else _compound(solids)


def _compound(solids: list[Any]) -> Any:
    import build123d as bd

    return bd.Compound(children=solids)
