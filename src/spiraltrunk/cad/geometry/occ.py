"""Geometry kernel (build123d): forms become solids, solids become meshes, STEP and 3MF files."""

from __future__ import annotations

import io
import math
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from spiraltrunk.cad.geometry.csg import Common, Cut, Form, Moved, Prism, Revolved, Union
from spiraltrunk.errors import MissingPackage, PartError

if TYPE_CHECKING:
    from build123d import Shape
    from trimesh import Trimesh

ANGLE = 0.25
"""Largest angle between neighbouring facets of a mesh [rad]; the tolerance rules where it is finer (ours)."""

SEAMS = (0.0, 0.4, 1.1)
"""Angles of the seams of round faces, tried in this order [rad] (ours)."""

_ANY = 1e6
"""Tolerance that any triangulation meets [mm]."""


def check_packages() -> None:
    """Import the optional packages of solids.

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

    Where seams of round faces touch, the kernel may leave a face without area: then other seams are tried.
    """
    for seam in SEAMS:
        solid = _build(form, seam)
        if solid.is_valid:
            break
    return solid


def _build(form: Form, seam: float) -> Shape[Any]:
    """The form with the seams of full revolutions at an angle [rad]."""
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
            whole = _build(inner, seam)
            return _single(whole.cut(*(_build(tool, seam) for tool in tools)) if tools else whole)
        case Common(form=inner, other=other):
            return _single(_build(inner, seam).intersect(_build(other, seam)))


def build_mesh(solid: Shape[Any], tolerance: float, remedy: str = "another tolerance") -> Trimesh:
    """Triangulate the surface to within ``tolerance`` [mm]; ``remedy`` is what an error advises.

    On long thin faces the kernel's mesher may exceed the tolerance or leave a face without triangles. Other tolerances
    are tried until every face has triangles and the largest deviation is below twice the tolerance; else the best mesh
    is taken.

    Raises:
        PartError: where a face has no triangles at any tolerance.
    """
    best: tuple[Trimesh, float] | None = None
    for factor in (1.0, 0.5, 0.25, 0.1, 0.7):
        found = _mesh(solid, factor * tolerance, factor * ANGLE)
        if found is not None and (best is None or found[1] < best[1]):
            best = found
        if best is not None and best[1] <= 2 * tolerance:
            break
    if best is None:
        raise PartError(f"the kernel can mesh no whole surface near {tolerance:g} mm; allowed: {remedy}")
    return best[0]


def _mesh(solid: Shape[Any], tolerance: float, angle: float) -> tuple[Trimesh, float] | None:
    """A mesh and its largest deviation at the centres of triangles [mm]; None where a face has no triangles."""
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.BRepTools import BRepTools
    from trimesh import Trimesh
    from trimesh.util import append_faces

    BRepTools.Clean_s(solid.wrapped)
    BRepMesh_IncrementalMesh(solid.wrapped, tolerance, False, angle)
    if not BRepTools.Triangulation_s(solid.wrapped, _ANY):
        return None
    points, triangles, deviation = [], [], 0.0
    for face in solid.faces():
        nodes, corners = face.tessellate(_ANY)  # The triangles that are there.
        points.append(np.array([tuple(node) for node in nodes]))
        triangles.append(np.array(corners))
        deviation = max(deviation, _measure_deviation(face, points[-1], triangles[-1]))
    mesh = Trimesh(*append_faces(points, triangles), process=False)
    mesh.merge_vertices(digits_vertex=5)  # The kernel gives faces that share an edge the same points on it.
    mesh.update_faces((np.diff(np.sort(mesh.faces, axis=1)) > 0).all(axis=1))
    return mesh, deviation


def _measure_deviation(face: Any, points: np.ndarray, triangles: np.ndarray) -> float:
    """Largest distance of the triangles' centres from a cylinder or cone, whose axis the kernel knows; else 0 [mm]."""
    if face.axis_of_rotation is None:
        return 0.0
    origin, axis = np.array(tuple(face.axis_of_rotation.position)), np.array(tuple(face.axis_of_rotation.direction))

    def measure(places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return (places - origin) @ axis, np.linalg.norm(np.cross(places - origin, axis), axis=1)

    slope, start = np.polyfit(*measure(points), 1)  # The corners lie on it.
    along, radius = measure(points[triangles].mean(axis=1))
    return float(np.abs(radius - start - slope * along).max() / math.hypot(1.0, slope))


_WHEN = "1980-01-01T00:00:00"
"""Time stamp of STEP files [-]: fixed, so that the same part gives the same file."""


def write_step(solid: Shape[Any], path: Path, name: str) -> None:
    """Write the solid as STEP, in mm; the same solid gives the same file.

    Raises:
        OSError: where the file cannot be written.
    """
    import build123d as bd

    solid.label = name
    stream = io.BytesIO()  # The writer takes no path that is no UTF-8, and does not say why it fails.
    bd.export_step(solid, stream, timestamp=_WHEN)
    # It counts the files of its process in the name of the assembly's one item.
    item = re.compile(rb"(_USAGE_OCCURRENCE\()'\d+'([^;]*)")
    path.write_bytes(item.sub(lambda found: b"%b'1'%b" % (found[1], found[2].replace(b"\n", b"")), stream.getvalue()))


def write_3mf(mesh: Trimesh, path: Path, name: str) -> None:
    """Write 3MF in mm with lib3mf, which comes with build123d; the same mesh gives the same file.

    Raises:
        OSError: where the file cannot be written.
    """
    from ctypes import c_float, c_uint32
    from uuid import NAMESPACE_OID, uuid5

    import lib3mf

    wrapper = lib3mf.get_wrapper()
    model = wrapper.CreateModel()
    model.SetUnit(lib3mf.ModelUnit.MilliMeter)
    body = model.AddMeshObject()
    body.SetName(name)
    body.SetGeometry(
        [lib3mf.Position((c_float * 3)(*point)) for point in mesh.vertices.tolist()],
        [lib3mf.Triangle((c_uint32 * 3)(*corners)) for corners in mesh.faces.tolist()],
    )
    item = model.AddBuildItem(body, wrapper.GetIdentityTransform())
    for what, write in (("build", model.SetBuildUUID), ("item", item.SetUUID), ("body", body.SetUUID)):
        write(str(uuid5(NAMESPACE_OID, f"{name} {what}")))  # They would be random.
    path.write_bytes(bytes(model.QueryWriter("3mf").WriteToBuffer()))  # Its own writer aborts on a full disc.


def _location(T: Any) -> Any:
    import build123d as bd
    from OCP.gp import gp_Trsf

    move = gp_Trsf()
    move.SetValues(*(float(value) for row in T[:3] for value in row))
    return bd.Location(move)


def _single(result: Any) -> Any:
    """The solid in a result that may be a list or a compound of one."""
    import build123d as bd

    solids = list(result) if isinstance(result, (list, tuple)) else [result]
    if len(solids) == 1 and len(solids[0].solids()) == 1:
        return solids[0].solids()[0]
    return solids[0] if len(solids) == 1 else bd.Compound(children=solids)


def measure_cylinders(solid: Shape[Any], radius: float) -> np.ndarray:
    """Holes along z of one radius: x, y of the axis, lowest and highest end along the axis, shape (n, 4) [mm].

    Where a leaning face cuts the hole, its end is taken at the axis: halfway between the rim's extremes.
    """
    import build123d as bd

    holes: list[tuple[float, float, list[float]]] = []
    face: Any
    for face in solid.faces().filter_by(bd.GeomType.CYLINDER):
        axis = face.axis_of_rotation
        rims = [edge for edge in face.edges() if edge.geom_type != bd.GeomType.LINE]
        if rims and abs(face.radius - radius) < 1e-6 and abs(axis.direction.Z) > 1 - 1e-9:
            heights = [point.Z for edge in rims for point in edge.positions([i / 32 for i in range(33)])]
            holes.append((round(axis.position.X, 4), round(axis.position.Y, 4), heights))
    joined: list[tuple[float, float, list[float]]] = []
    for x, y, heights in sorted(holes, key=lambda hole: (*hole[:2], min(hole[2]))):
        if joined and joined[-1][:2] == (x, y) and min(heights) < max(joined[-1][2]):
            joined[-1][2].extend(heights)  # The same hole, cut by a seam.
        else:
            joined.append((x, y, heights))
    return np.array([(x, y, *_ends(heights)) for x, y, heights in joined]).reshape(-1, 4)


def _ends(heights: list[float]) -> tuple[float, float]:
    """Lower and upper end of a hole, each halfway between the least and the largest height of its rim."""
    middle = (min(heights) + max(heights)) / 2
    low, high = [z for z in heights if z < middle], [z for z in heights if z >= middle]
    return (min(low) + max(low)) / 2, (min(high) + max(high)) / 2


def measure_cones(solid: Shape[Any]) -> np.ndarray:
    """Cones about z: height of the apex [mm], and angle between face and the axis' normal plane [rad], shape (n, 2)."""
    import build123d as bd

    cones = [face.geom_adaptor() for face in solid.faces().filter_by(bd.GeomType.CONE)]
    return np.array([(cone.Apex().Z(), math.pi / 2 - abs(cone.SemiAngle())) for cone in cones]).reshape(-1, 2)


def measure_bulk(solid: Shape[Any]) -> tuple[float, float, float, float]:
    """Volume [mm^3], z of the centroid [mm], and second moments about the centroid, axial and across [mm^5]."""
    moments = solid.matrix_of_inertia
    across = (moments[0][0] + moments[1][1]) / 2
    return float(solid.volume), float(solid.center().Z), float(moments[2][2]), float(across)
