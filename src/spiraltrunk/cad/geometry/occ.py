"""The one place that speaks to build123d: forms become solids, solids become meshes and STEP files."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from spiraltrunk.cad.geometry.csg import Common, Cut, Form, Moved, Prism, Revolved, Union
from spiraltrunk.cad.geometry.mesh import Mesh, weld
from spiraltrunk.errors import MissingPackage, PartError

if TYPE_CHECKING:
    from build123d import Shape

ANGLE = 0.25
"""Largest angle between neighbouring facets of a mesh [rad]; the tolerance rules where it is finer (ours)."""


SEAMS = (0.0, 0.4, 1.1)
"""Angles at which round faces may have their seam, one after the other [rad] (ours)."""


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


def build_solid(form: Form) -> Shape[Any]:
    """The form as the kernel's boundary representation, in mm.

    Where two seams of round faces touch, the kernel may leave a face of no area: then the solid is built once more with
    its seams elsewhere.
    """
    for seam in SEAMS:
        solid = _build(form, seam)
        if solid.is_valid:
            break
    return solid


def _build(form: Form, seam: float) -> Shape[Any]:
    """The form with the seams of whole turns at an angle [rad]."""
    import build123d as bd

    match form:
        case Revolved(profile=profile, start=start, arc=arc):
            wire = bd.Wire.make_polygon([bd.Vector(r, 0, z) for r, z in profile], close=True)
            solid = bd.Solid.revolve(bd.Face(wire), math.degrees(arc), bd.Axis.Z)
            begin = start if arc < 2 * math.pi else start + seam
            return solid if begin == 0.0 else solid.rotate(bd.Axis.Z, math.degrees(begin))
        case Prism(corners=corners, bottom=bottom, top=top):
            wire = bd.Wire.make_polygon([bd.Vector(x, y, bottom) for x, y in corners], close=True)
            return bd.Solid.extrude(bd.Face(wire), bd.Vector(0, 0, top - bottom))
        case Moved(form=inner, T=T):
            return _build(inner, seam).moved(_location(T))
        case Union(forms=forms):
            first, *others = (_build(part, seam) for part in forms)
            return _single(first.fuse(*others) if others else first)
        case Cut(form=inner, tools=tools):
            return _single(
                _build(inner, seam).cut(*(_build(tool, seam) for tool in tools)) if tools else _build(inner, seam)
            )
        case Common(form=inner, other=other):
            return _single(_build(inner, seam).intersect(_build(other, seam)))


def build_mesh(solid: Shape[Any], tolerance: float) -> Mesh:
    """The solid's surface as triangles, hardly anywhere further from it than ``tolerance`` [mm].

    On long thin faces the kernel's mesher now and then spans chords far wider than it was told. So the middles of all
    triangles are held against the round faces that they stand for, and what is too far off is meshed more finely; so is
    what has a face that the mesher gave up on, as it does at one tolerance and not at another.

    Raises:
        PartError: where it gives up on a face at every tolerance.
    """
    meshes = (_mesh(solid, finer * tolerance, finer * ANGLE) for finer in (1.0, 0.5, 0.25, 0.1, 0.7))
    best: tuple[Mesh, float] | None = None
    for found in meshes:
        if found is not None and (best is None or found[1] < best[1]):
            best = found
        if best is not None and best[1] <= 2 * tolerance:
            break
    if best is None:
        raise PartError(f"the kernel can mesh no whole surface near {tolerance:g} mm; allowed: another --tolerance-mm")
    return best[0]


def _mesh(solid: Shape[Any], tolerance: float, angle: float) -> tuple[Mesh, float] | None:
    """A mesh, and how far the middle of a triangle is from its round face at most [mm]; None where a face has none."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.BRepTools import BRepTools
    from OCP.IMeshTools import IMeshTools_Parameters
    from OCP.TopAbs import TopAbs_Orientation
    from OCP.TopLoc import TopLoc_Location

    settings = IMeshTools_Parameters()
    settings.Deflection, settings.Angle, settings.Relative = tolerance, angle, False
    BRepTools.Clean_s(solid.wrapped)
    BRepMesh_IncrementalMesh(solid.wrapped, settings)
    points: list[np.ndarray] = []
    triangles: list[np.ndarray] = []
    count, error = 0, 0.0
    for face in solid.faces():
        place = TopLoc_Location()
        facets = BRep_Tool.Triangulation_s(face.wrapped, place)
        if facets is None:
            return None
        move = place.Transformation()
        nodes = (facets.Node(i).Transformed(move) for i in range(1, facets.NbNodes() + 1))
        own = np.array([(node.X(), node.Y(), node.Z()) for node in nodes])
        sides = np.array([facets.Triangle(i).Get() for i in range(1, facets.NbTriangles() + 1)]) - 1
        if face.wrapped.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
            sides = sides[:, [0, 2, 1]]
        error = max(error, _miss(face, own[sides].mean(axis=1)))
        points.append(own)
        triangles.append(sides + count)
        count += len(own)
    return weld(np.concatenate(points), np.concatenate(triangles)), error


def _miss(face: Any, middles: np.ndarray) -> float:
    """Largest distance of points from the cylinder or cone that a face lies on; 0 for other faces [mm]."""
    import build123d as bd
    from OCP.BRepAdaptor import BRepAdaptor_Surface

    if face.geom_type == bd.GeomType.CYLINDER:
        surface = BRepAdaptor_Surface(face.wrapped).Cylinder()
        radius, lean = surface.Radius(), 0.0
    elif face.geom_type == bd.GeomType.CONE:
        surface = BRepAdaptor_Surface(face.wrapped).Cone()
        radius, lean = surface.RefRadius(), surface.SemiAngle()
    else:
        return 0.0
    origin, axis = surface.Location(), surface.Axis().Direction()
    direction = np.array([axis.X(), axis.Y(), axis.Z()])
    from_origin = middles - [origin.X(), origin.Y(), origin.Z()]
    along = from_origin @ direction
    across = np.linalg.norm(from_origin - along[:, None] * direction, axis=1)
    wanted = np.abs(radius + along * math.tan(lean))
    return float((np.abs(across - wanted) * math.cos(lean)).max())


_WHEN = "1980-01-01T00:00:00"
"""Time that STEP files tell [-]: always the same, so that the same part is the same file."""


def write_step(solid: Shape[Any], path: Path, name: str) -> None:
    """Write the solid as STEP, in mm; the same solid gives the same file."""
    import build123d as bd

    solid.label = name
    if not bd.export_step(solid, str(path), timestamp=_WHEN):
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


def measure_cylinders(solid: Shape[Any], radius: float) -> np.ndarray:
    """Holes along z of one radius: x, y of the axis, lowest and highest end along the axis, shape (n, 4) [mm].

    An end that a leaning face cuts counts at the axis: halfway between its rim's lowest and highest point.
    """
    import build123d as bd
    from OCP.BRepAdaptor import BRepAdaptor_Surface

    rims: dict[tuple[float, float], list[list[float]]] = {}
    for face in solid.faces():
        if face.geom_type != bd.GeomType.CYLINDER:
            continue
        cylinder = BRepAdaptor_Surface(face.wrapped).Cylinder()
        if abs(cylinder.Radius() - radius) > 1e-6 or abs(cylinder.Axis().Direction().Z()) < 1 - 1e-9:
            continue
        place = cylinder.Location()
        heights = [
            point.Z for edge in face.edges() if edge.geom_type != bd.GeomType.LINE for point in edge.positions(_ALONG)
        ]
        if heights:
            rims.setdefault((round(place.X(), 4), round(place.Y(), 4)), []).append(heights)
    return np.array([(*axis, *_ends(heights)) for axis, faces in rims.items() for heights in _joined(faces)]).reshape(
        -1, 4
    )


_ALONG = [i / 32 for i in range(33)]
"""Where along an edge its height is taken."""


def _joined(faces: list[list[float]]) -> list[list[float]]:
    """Heights of the rims of each hole: faces that overlap along one axis are one hole, cut by a seam."""
    holes: list[list[float]] = []
    for heights in sorted(faces, key=min):
        if holes and min(heights) < max(holes[-1]):
            holes[-1] += heights
        else:
            holes.append(list(heights))
    return holes


def _ends(heights: list[float]) -> tuple[float, float]:
    """Lower and upper end of a hole, each halfway between the least and the largest height of its rim."""
    middle = (min(heights) + max(heights)) / 2
    low, high = [z for z in heights if z < middle], [z for z in heights if z >= middle]
    return (min(low) + max(low)) / 2, (min(high) + max(high)) / 2


def measure_cones(solid: Shape[Any]) -> np.ndarray:
    """Leaning faces about z: where their apex is on the axis [mm], and their lean from the axis' normal [rad]."""
    import build123d as bd
    from OCP.BRepAdaptor import BRepAdaptor_Surface

    rows = []
    for face in solid.faces():
        if face.geom_type == bd.GeomType.CONE:
            cone = BRepAdaptor_Surface(face.wrapped).Cone()
            rows.append((cone.Apex().Z(), math.pi / 2 - abs(cone.SemiAngle())))
    return np.array(rows).reshape(-1, 2)


def measure_bulk(solid: Shape[Any]) -> tuple[float, float, float, float]:
    """Volume [mm^3], z of the centroid [mm], and second moments about the centroid, axial and across [mm^5]."""
    moments = solid.matrix_of_inertia
    across = (moments[0][0] + moments[1][1]) / 2
    return float(solid.volume), float(solid.center().Z), float(moments[2][2]), float(across)
