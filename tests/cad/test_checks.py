"""The checks find what is wrong with a mesh, and find nothing wrong with a sound one."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.cad.components.options import Flange, MakeOptions, Motor, Remedies, Servo
from spiraltrunk.cad.geometry.csg import Common, Cut, Union, box, compute_volume, rod, shifted
from spiraltrunk.cad.geometry.part import Part
from spiraltrunk.cad.housing.winder import find_arm
from spiraltrunk.cad.output.make_part import make_part
from spiraltrunk.design import presets
from spiraltrunk.design.materials import PETG
from spiraltrunk.errors import DesignError, PartError

pytest.importorskip("build123d", reason="solids need the extra cad")
pytest.importorskip("embreex", reason="walls need the extra cad")

import build123d
import lib3mf
import trimesh
from trimesh.util import concatenate

from spiraltrunk.cad.checks.printability import _winding_number, check_part, probe
from spiraltrunk.cad.geometry.occ import build_mesh, build_solid, measure_bulk, measure_cylinders, write_3mf, write_step

OPTIONS = MakeOptions()


def check(form, options=OPTIONS, expected=None):
    part = Part(
        name="thing",
        group="wedge",
        what="",
        material=PETG,
        form=form,
        thinnest="more of it",
        landmarks=((0.0, "foot"),),
    )
    solid = build_solid(form)
    mesh = build_mesh(solid, options.tolerance)
    return check_part(part, solid, mesh, compute_volume(form) if expected is None else expected, options)


def tube(wall: float) -> Cut:
    return Cut(form=rod(5.0, (0, 0, 0), (0, 0, 10)), tools=(rod(5.0 - wall, (0, 0, -1), (0, 0, 11)),))


@pytest.mark.parametrize("wall", [0.5, 0.75, 0.85, 2.0])
def test_a_wall_is_measured(wall):
    finding = check(tube(wall))
    assert finding.min_wall == pytest.approx(wall, abs=2 * OPTIONS.tolerance)
    assert finding.holds == (wall >= OPTIONS.least_wall)


def test_a_thin_wall_is_told_with_place_and_remedy():
    fault = check(tube(0.5)).faults[0]
    assert fault.startswith("foot, at z = ")
    assert "too thin; allowed: at least 0.8 mm, two nozzles: more of it" in fault


def test_a_hole_that_breaks_out_is_told():
    """Its wall is nothing, and the definition's volume still agrees."""
    plate = Cut(form=box((20, 20, 10), (0, 0, 0)), tools=(rod(2.0, (7.7, 0, -9), (7.7, 0, 9)),))
    assert check(plate).min_wall == pytest.approx(0.3, abs=0.02)
    assert not check(plate).holds


def test_two_pieces_are_no_part():
    apart = Union(forms=(box((2, 2, 2), (0, 0, 0)), box((2, 2, 2), (9, 0, 0))))
    assert any("pieces" in fault for fault in check(apart).faults)


def test_a_wrong_volume_is_told():
    assert any("allowed: within 1 %" in fault for fault in check(box((9, 9, 9), (0, 0, 0)), expected=700.0).faults)


def test_a_part_larger_than_the_bed_is_told():
    small = replace(OPTIONS, bed=(50.0, 40.0, 45.0))
    assert check(box((40, 50, 45), (0, 0, 0)), small).holds
    assert any("the bed" in fault for fault in check(box((51, 40, 45), (0, 0, 0)), small).faults)


@pytest.mark.parametrize("fault", ["", "open", "turned"])
def test_an_open_mesh_is_told(fault):
    form = box((4, 4, 4), (0, 0, 0))
    solid = build_solid(form)
    mesh = build_mesh(solid, 0.05)
    if fault == "open":
        mesh.update_faces(np.arange(len(mesh.faces)) > 0)
    elif fault == "turned":
        mesh.faces[0] = mesh.faces[0, ::-1]
    finding = check_part(Part(name="a", group="b", what="", material=PETG, form=form), solid, mesh, 64.0, OPTIONS)
    assert finding.watertight == (not fault)
    assert any("mesh is not closed" in fault for fault in finding.faults) == bool(fault)


def test_a_mesh_that_cuts_itself_is_told():
    one = build_mesh(build_solid(rod(4.0, (0, 0, 0), (0, 0, 10))), 0.05)
    other = one.copy().apply_translation((3.0, 0.5, 1.0))
    assert probe(one)[0] == 0
    assert probe(concatenate([one, other]))[0] > 10


def test_the_winding_number_counts_the_bodies_round_a_point():
    """Of two spheres in one mesh: none outside, one in either, two where they overlap, minus one turned inside out."""
    one, other = trimesh.creation.icosphere(radius=2.0), trimesh.creation.icosphere(radius=2.0)
    other.apply_translation((3.0, 0.0, 0.0))
    both = concatenate([one, other])
    for x, count in ((-3.0, 0), (-1.0, 1), (1.5, 2), (4.0, 1), (5.5, 0)):
        assert _winding_number(both, np.array([x, 0.1, 0.2])) == pytest.approx(count, abs=1e-9)
    one.invert()
    assert _winding_number(one, np.array([0.1, 0.2, 0.3])) == pytest.approx(-1.0)


def test_a_mesh_has_the_kernels_volume_and_area():
    solid = build_solid(tube(2.0))
    mesh = build_mesh(solid, 0.02)
    assert mesh.volume == pytest.approx(solid.volume, rel=5e-3)
    assert mesh.area == pytest.approx(solid.area, rel=5e-3)


def test_long_thin_faces_are_meshed_as_finely_as_asked():
    """The kernel's mesher spans this ridge by chords a hundred times coarser than it is told."""
    from spiraltrunk.cad.geometry.csg import Revolved

    ring = Revolved(profile=((28.2165, -2.0), (30.6165, -2.0), (30.6165, 5.8425), (28.2165, 5.8425)))
    ridge = Revolved(
        profile=((26.6364, 4.3029), (28.5326, 3.6709), (28.5326, 4.935)), start=0.0019367, arc=2.0914194
    )  # fmt: skip
    mesh = build_mesh(build_solid(Union(forms=(ring, ridge))), 0.05)
    middle = mesh.triangles_center
    assert np.hypot(middle[:, 0], middle[:, 1]).min() > 26.6364 - 0.1


def test_a_flat_cone_needs_no_finer_mesh_than_a_steep_one():
    """Chords deviate across the surface by their sagitta in its plane times the cosine of its slope."""
    from spiraltrunk.cad.geometry.csg import Revolved

    meshes = {}
    for height in (1.0, 60.0):
        cone = build_solid(Revolved(profile=((0.0, 0.0), (30.0, 0.0), (0.0, height))))
        meshes[height] = build_mesh(cone, 0.05)
        x, y, z = meshes[height].triangles_center[meshes[height].face_normals[:, 2] > 0.1].T
        across = (30.0 - np.hypot(x, y) - 30.0 * z / height) / np.hypot(1.0, 30.0 / height)
        assert np.abs(across).max() < 0.05
    assert len(meshes[1.0].faces) <= len(meshes[60.0].faces)


def test_an_intersection_of_several_bodies_keeps_each():
    pair = Union(forms=(box((2, 2, 2), (0, 0, 0)), box((2, 2, 2), (9, 0, 0))))
    other = Union(forms=(box((2, 2, 2), (1, 0, 0)), box((2, 2, 2), (9, 0, 0))))
    both = build_solid(Common(form=pair, other=other))
    assert both.volume == pytest.approx(4.0 + 8.0)
    assert len(both.solids()) == 2
    assert isinstance(build_solid(Cut(form=pair, tools=(box((3, 3, 3), (9, 0, 0)),))), build123d.Solid)


def test_files_hold_the_same_solid(tmp_path):
    """STEP read again by the kernel, STL and 3MF by another reader."""
    solid = build_solid(shifted(tube(2.0), (1, 2, 3)))
    mesh = build_mesh(solid, 0.02)
    write_step(solid, tmp_path / "thing.step", "thing")
    assert build123d.import_step(tmp_path / "thing.step").volume == pytest.approx(solid.volume, rel=1e-6)
    for again in ("again.step", "once more.step"):
        write_step(solid, tmp_path / again, "thing")
        assert (tmp_path / again).read_bytes() == (tmp_path / "thing.step").read_bytes()
    mesh.export(tmp_path / "thing.stl")
    write_3mf(mesh, tmp_path / "thing.3mf", 'a <name> & "more"')
    first = (tmp_path / "thing.3mf").read_bytes()
    write_3mf(mesh, tmp_path / "again.3mf", 'a <name> & "more"')
    assert (tmp_path / "again.3mf").read_bytes() == first
    model = lib3mf.get_wrapper().CreateModel()
    model.QueryReader("3mf").ReadFromFile(str(tmp_path / "thing.3mf"))
    assert model.GetUnit() == lib3mf.ModelUnit.MilliMeter
    objects = model.GetMeshObjects()
    assert objects.MoveNext()
    read = objects.GetCurrentMeshObject()
    assert read.GetName() == 'a <name> & "more"'
    assert (read.GetVertexCount(), read.GetTriangleCount()) == (len(mesh.vertices), len(mesh.faces))
    assert read.IsManifoldAndOriented()
    stl = trimesh.load_mesh(tmp_path / "thing.stl")
    assert stl.is_watertight
    assert stl.volume == pytest.approx(mesh.volume, rel=1e-5)
    assert stl.bounds == pytest.approx(mesh.bounds, abs=1e-4)


def test_a_hole_through_leaning_faces_is_measured_at_its_axis():
    from spiraltrunk.cad.geometry.csg import Revolved

    lens = Revolved(profile=((0.0, 0.0), (10.0, 3.0), (10.0, 8.0), (0.0, 12.0)))
    drilled = Cut(form=lens, tools=tuple(rod(0.5, (6 * c, 6 * s, -1), (6 * c, 6 * s, 13)) for c, s in ((1, 0), (0, 1))))
    found = measure_cylinders(build_solid(drilled), 0.5)
    assert sorted(map(tuple, found.round(3))) == [(0.0, 6.0, 1.8, 9.6), (6.0, 0.0, 1.8, 9.6)]


def test_a_surface_without_a_mesh_names_the_remedy_of_the_options(monkeypatch):
    from spiraltrunk.cad.geometry import occ

    monkeypatch.setattr(occ, "_mesh", lambda *_: None)
    part = Part(name="ball", group="horn", what="a rod", material=PETG, form=rod(4.0, (0, 0, 0), (0, 0, 10)))
    told = r"can mesh no whole surface near 0.05 mm; allowed: a finer mesh \(set by the command export\)"
    options = replace(OPTIONS, remedies=Remedies(tolerance="a finer mesh (set by the command export)"))
    with pytest.raises(PartError, match=told):
        make_part(part, options, (), None, "paper")


def test_bulk_of_a_cylinder():
    volume, center, axial, across = measure_bulk(build_solid(rod(3.0, (0, 0, 0), (0, 0, 8))))
    assert volume == pytest.approx(72 * np.pi)
    assert center == pytest.approx(4.0)
    assert axial == pytest.approx(volume * 9 / 2)
    assert across == pytest.approx(volume * (9 / 4 + 64 / 12))


@pytest.mark.parametrize(
    "change",
    [{"nozzle": float("nan")}, {"tolerance": 0.0}, {"bed": (1.0, 2.0)}, {"seed": -1}, {"bed": (9, 9, float("inf"))}],
)
def test_bad_options_are_refused(change):
    with pytest.raises(DesignError, match="allowed"):
        MakeOptions(**change)


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: Motor(height=math.nan), "motor.height is nan; allowed: a finite number, above 0, below 1000"),
        (lambda: Motor(diameter=-1.0), "motor.diameter is -1.0; allowed: a finite number, above 0"),
        (lambda: Motor(current=0.0), "motor.current is 0.0; allowed"),
        (lambda: Servo(turn=0.0), "servo.turn is 0.0; allowed: a finite number, at least 10, at most 180"),
        (lambda: Servo(shaft_offset=30.0), "servo.shaft_offset is 30.0; allowed: a finite number, at least 0, at most"),
        (lambda: Flange(dowel=math.inf), "flange.dowel is inf; allowed"),
        (lambda: MakeOptions(cable=0.0), "cable is 0.0; allowed: a finite number, above 0"),
        (lambda: MakeOptions(hole_play=-0.1), "hole_play is -0.1; allowed: a finite number, at least 0"),
        (lambda: MakeOptions(shell_depth=1.0), "shell_depth is 1.0; allowed: a finite number, above 0, below 1"),
        (lambda: MakeOptions(n_wrinkle=1.5), "n_wrinkle is 1.5; allowed: a whole number"),
    ],
)
def test_bad_components_are_refused(make, told):
    with pytest.raises(DesignError, match=f"^{re.escape(told)}"):
        make()


@pytest.mark.parametrize("turn", [90.0, 120.0, 180.0])
def test_a_servo_that_turns_further_needs_no_longer_arm(turn):
    """Beyond 90 deg the arm winds no more."""
    assert find_arm(presets.PAPER, MakeOptions(servo=Servo(turn=turn))) == find_arm(presets.PAPER, OPTIONS)
    assert find_arm(presets.PAPER, MakeOptions(servo=Servo(turn=30.0))) == pytest.approx(
        2 * find_arm(presets.PAPER, OPTIONS)
    )
