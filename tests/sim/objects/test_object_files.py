"""Objects from files: exact mass distributions, frames, hulls, and every bad file refused in one line."""

import dataclasses
import math
import os
import pickle
import re
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from spiraltrunk.errors import DesignError, MissingPackage, SpiralTrunkError, UnknownName
from spiraltrunk.sim.objects.catalogue import add_object, load_mjcf, load_stl, parse_object, scaled
from spiraltrunk.sim.objects.description import describe_object
from spiraltrunk.sim.objects.meshes import mesh_file
from spiraltrunk.sim.objects.meshes.obj_text import read_obj
from spiraltrunk.sim.objects.meshes.surface import winding_numbers

BOX = (240.0, 50.0, 90.0)
"""Extents of the test box [mm]."""


@pytest.fixture
def put(tmp_path):
    """Writes a mesh and returns its path."""

    def write(mesh, name="object.stl", *, ascii=False):
        file = tmp_path / name
        mesh.export(file, file_type="stl_ascii" if ascii else "stl")
        return str(file)

    return write


def l_prism():
    """An L-shaped prism: neither convex nor symmetric. Extents 60 x 40 x 20 mm."""
    outline = [(0, 0), (60, 0), (60, 15), (20, 15), (20, 40), (0, 40)]
    corners = np.array([(x, y, z) for z in (0, 20) for x, y in outline], dtype=float)
    cap = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)])
    sides = [f for i in range(6) for f in ((i, (i + 1) % 6, i + 6), ((i + 1) % 6, (i + 1) % 6 + 6, i + 6))]
    return trimesh.Trimesh(corners, np.vstack([cap[:, ::-1], cap + 6, sides]), process=False)


def boxes(*placed):
    """Inertia of axis-parallel boxes (size, centre) of equal density: centre and inertia over mass."""
    volumes = np.array([np.prod(size) for size, _ in placed])
    share = volumes / volumes.sum()
    centers = np.array([center for _, center in placed])
    middle = share @ centers
    inertia = np.zeros((3, 3))
    for part, (size, center) in zip(share, placed, strict=True):
        squares = np.square(size)
        arm = np.subtract(center, middle)
        inertia += part * (np.diag(squares.sum() - squares) / 12 + arm @ arm * np.eye(3) - np.outer(arm, arm))
    return middle, inertia


def mujoco_inertia(body):
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, body.iquat)
    return turn.reshape(3, 3) @ np.diag(body.inertia) @ turn.reshape(3, 3).T


@pytest.mark.parametrize("ascii", [False, True])
@pytest.mark.parametrize(("unit", "factor"), [("mm", 1.0), ("cm", 0.1), ("m", 1e-3), ("in", 1 / 25.4)])
def test_a_box_from_a_file_is_a_box_in_every_unit(put, unit, factor, ascii):
    mesh = trimesh.creation.box(extents=np.array(BOX) * factor)
    mesh.apply_translation([3.0 * factor, -70.0 * factor, 1.0 * factor])
    shape = parse_object(f"stl:path={put(mesh, ascii=ascii)},unit={unit},mass_g=250")
    same = parse_object("box:x_mm=240,y_mm=50,z_mm=90,mass_g=250")
    np.testing.assert_allclose(shape.size, same.size, rtol=1e-6)
    np.testing.assert_allclose(shape.inertia(), same.inertia(), rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(shape.center(), 0, atol=1e-7)
    assert shape.mass == 0.25
    assert shape.kind == "mesh"
    assert not shape.warning


def test_centre_and_inertia_of_a_mesh_are_the_integrals_over_it(put):
    solid = load_stl(put(l_prism()), unit="mm", mass=0.1).solid
    middle, inertia = boxes(((60, 15, 20), (30, 7.5, 10)), ((20, 25, 20), (10, 27.5, 10)))
    np.testing.assert_allclose(solid.centroid, (middle - [30, 20, 10]) * 1e-3, atol=1e-9)
    np.testing.assert_allclose(solid.inertia, inertia * 1e-6, rtol=1e-6, atol=1e-12)


def test_mujoco_integrates_the_same_mesh_to_the_same_inertia(put):
    shape = load_stl(put(l_prism()), unit="mm", mass=0.1)
    spec = mujoco.MjSpec()
    body = add_object(spec, shape)
    stated = spec.compile().body("object")
    body.explicitinertial = False
    body.geoms[0].mass = shape.mass
    spec.meshes[0].inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_EXACT
    integrated = spec.compile().body("object")
    for body in (stated, integrated):
        assert body.mass[0] == pytest.approx(0.1, rel=1e-9)
        np.testing.assert_allclose(body.ipos, shape.center(), atol=1e-8)
        np.testing.assert_allclose(mujoco_inertia(body), shape.inertia(), rtol=1e-5, atol=1e-11)


def test_a_mesh_with_a_closed_hollow_weighs_its_walls_alone(put):
    mesh = trimesh.creation.box(extents=(60, 40, 50))
    hollow = trimesh.creation.box(extents=(40, 20, 30))
    hollow.invert()
    solid = load_stl(put(trimesh.util.concatenate([mesh, hollow])), unit="mm", mass=0.1).solid
    full, empty = 60 * 40 * 50, 40 * 20 * 30
    xx = (full * (40**2 + 50**2) - empty * (20**2 + 30**2)) / 12 / (full - empty) * 1e-6
    assert solid.inertia[0, 0] == pytest.approx(xx, rel=1e-6)


@pytest.mark.parametrize(("axis", "size"), [("longest", (240, 50, 90)), ("x", (240, 50, 90)), ("y", (50, 90, 240)),
                                            ("z", (90, 240, 50))])  # fmt: skip
def test_the_axis_is_the_longest_side_or_the_one_named(put, axis, size):
    shape = parse_object(f"stl:path={put(trimesh.creation.box(extents=BOX))},unit=mm,mass_g=250,axis={axis}")
    np.testing.assert_allclose(shape.size, np.array(size) * 1e-3, rtol=1e-6)


def test_turning_the_axis_is_a_rotation_of_the_whole_object(put):
    """The part of an L that is off the middle stays on its side: extents, centre and inertia turn together."""
    path = put(l_prism())
    plain, turned = (load_stl(path, unit="mm", mass=0.1, axis=axis).solid for axis in "xy")
    turn = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])
    assert np.linalg.det(turn) == pytest.approx(1)
    np.testing.assert_allclose(turned.centroid, turn @ plain.centroid, atol=1e-12)
    np.testing.assert_allclose(turned.inertia, turn @ plain.inertia @ turn.T, atol=1e-15)
    np.testing.assert_allclose(turned.extents(), turn @ plain.extents(), rtol=1e-12)


def test_a_hull_that_is_larger_than_the_solid_is_told(put):
    shape = load_stl(put(l_prism()), unit="mm", mass=0.1)
    volume, hull = 60 * 15 * 20 + 20 * 25 * 20, (60 * 40 - 25 * 40 / 2) * 20
    assert shape.solid.excess == pytest.approx(hull / volume - 1, rel=1e-6)
    assert shape.warning == (
        "the mesh collides as convex shapes, 36 % larger than it: hollows are filled; collide=parts keeps them"
    )


@given(factor=st.floats(0.9, 1.1))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=10)
def test_a_scaled_mesh_keeps_its_mass_and_its_inertia_goes_with_the_square(put, factor):
    shape = load_stl(put(l_prism()), unit="mm", mass=0.1)
    larger = scaled(shape, factor)
    assert larger.mass == 0.1
    np.testing.assert_allclose(larger.size, factor * np.array(shape.size))
    np.testing.assert_allclose(larger.inertia(), factor**2 * shape.inertia(), rtol=1e-12, atol=0)
    spec = mujoco.MjSpec()
    add_object(spec, larger)
    assert spec.compile().body("object").mass[0] == pytest.approx(0.1)


def test_a_loaded_object_survives_replace_and_pickle(put):
    shape = load_stl(put(l_prism()), unit="mm", mass=0.1)
    other = pickle.loads(pickle.dumps(dataclasses.replace(shape, friction=1.1)))
    assert other.friction == 1.1
    np.testing.assert_array_equal(other.inertia(), shape.inertia())


def flipped():
    mesh = trimesh.creation.box(extents=BOX)
    mesh.faces[3] = mesh.faces[3][::-1]
    return mesh


def opened():
    mesh = trimesh.creation.box(extents=BOX)
    mesh.update_faces(np.arange(len(mesh.faces)) != 2)
    return mesh


def inside_out():
    mesh = trimesh.creation.box(extents=BOX)
    mesh.invert()
    return mesh


def apart(distance):
    other = trimesh.creation.box(extents=BOX)
    other.apply_translation([0, 0, distance])
    return trimesh.util.concatenate([trimesh.creation.box(extents=BOX), other])


def bow_tie():
    """A prism over a bow tie whose larger wing looks outwards: closed, all neighbours agree, one wing is inverted."""
    outline = [(0, 0), (60, 40), (60, 0), (-30, 40 * 1.5)]
    corners = np.array([(x, y, z) for z in (0, 30) for x, y in outline], dtype=float)
    cap = np.array([(0, 1, 2), (0, 2, 3)])
    sides = [f for i in range(4) for f in ((i, (i + 1) % 4, i + 4), ((i + 1) % 4, (i + 1) % 4 + 4, i + 4))]
    mesh = trimesh.Trimesh(corners, np.vstack([cap[:, ::-1], cap + 4, sides]), process=False)
    if mesh.volume < 0:
        mesh.invert()
    return mesh


def with_inverted_neighbour():
    """A box, and beside it a smaller one inside out: closed, its volume positive."""
    other = trimesh.creation.box(extents=(50, 50, 50))
    other.invert()
    other.apply_translation([0, 200, 0])
    return trimesh.util.concatenate([trimesh.creation.box(extents=BOX), other])


def folded():
    """Two sheets back to back, a fold of no thickness."""
    corners = np.array([(0, 0, 0), (60, 0, 0), (60, 40, 30), (0, 40, 30)], dtype=float)
    return trimesh.Trimesh(corners, [(0, 1, 2), (0, 2, 3), (2, 1, 0), (3, 2, 0)], process=False)


BAD = {
    "bow tie": (bow_tie, "cutting or overlapping itself; allowed: .* at most 15 % larger .*, not 500 %"),
    "inverted neighbour": (with_inverted_neighbour, "cutting or overlapping itself; allowed: .*, not 167 %"),
    "two pieces": (lambda: apart(300.0), "in 2 pieces that do not touch; allowed: a closed surface.*, not 117 %"),
    "folded": (folded, "without volume; allowed: a surface that encloses a solid"),
    "too small": (lambda: trimesh.creation.box(extents=(4, 30, 30)), "of 4 x 30 x 30 mm; allowed: 5 mm to below 1 m"),
    "too large": (lambda: trimesh.creation.box(extents=(40, 30, 1200)), "of 40 x 30 x 1200 mm"),
    "flat": (lambda: trimesh.creation.box(extents=(40, 30, 0)), "of 40 x 30 x 0 mm"),
    "too fine": (lambda: trimesh.creation.icosphere(subdivisions=7, radius=40), "of 327680 triangles; allowed: 4 to"),
}  # fmt: skip
"""Meshes that are no solid, and what is said of them."""


def doubled():
    box = trimesh.creation.box(extents=BOX)
    return trimesh.util.concatenate([box, box])


def two_sided():
    return trimesh.util.concatenate([trimesh.creation.box(extents=BOX), inside_out()])


def with_slivers():
    mesh = trimesh.creation.box(extents=BOX)
    faces = np.vstack([mesh.faces, [(0, 0, 1), (1, 1, 1)], mesh.faces[:1]])
    return trimesh.Trimesh(mesh.vertices, faces, process=False)


def cracked():
    """A box whose triangles do not share corners, and miss each other by up to 1 um."""
    mesh = trimesh.creation.box(extents=BOX)
    corners = mesh.triangles.reshape(-1, 3) + np.random.default_rng(0).uniform(-5e-4, 5e-4, (36, 3))
    return trimesh.Trimesh(corners, np.arange(36).reshape(-1, 3), process=False)


def pricked():
    """A finely meshed L-prism that lacks one small triangle."""
    mesh = l_prism()
    for _ in range(4):
        mesh = mesh.subdivide()
    mesh.update_faces(np.arange(len(mesh.faces)) != 700)
    return mesh


UNITED = "2 closed bodies that overlap: they are united"
"""Said where the file tells the bodies apart, as an OBJ file does."""

REPAIRED = {
    "flipped face": (flipped, BOX, "the surface is partly inside out: it is repaired"),
    "inside out": (inside_out, BOX, "the surface is inside out: it is repaired"),
    "doubled": (doubled, BOX, f"it is repaired, which changes its volume by less than 0.1 %|{UNITED}"),
    "two-sided": (two_sided, BOX, "it is repaired, which changes its volume by less than 0.1 %"),
    "cracked": (cracked, BOX, "it is repaired, which changes its volume by less than 0.1 %"),
    "slivers": (with_slivers, BOX, "it is repaired, which changes its volume by less than 0.1 %"),
    "pricked": (pricked, (60, 40, 20), "the surface is open or cut at 3 edges: it is repaired"),
    "open": (opened, BOX, "open or cut at 3 edges: its convex hull is taken, 0.0 % larger than its estimated volume"),
    "overlap": (lambda: apart(30.0), (240, 50, 120), "the surface is 2 closed bodies that overlap: they are united"),
    "touching faces": (lambda: apart(90.0), (240, 50, 180), f"open or cut at 4 edges: .*, 0.0 % larger|{UNITED}"),
}
"""Meshes with faults that are mended or replaced by their hulls, their extents [mm] and what is said of them."""


@pytest.mark.parametrize("form", ["stl", "obj"])
@pytest.mark.parametrize("name", REPAIRED)
def test_a_surface_with_faults_is_repaired_or_replaced_by_its_hull(tmp_path, name, form):
    build, extents, match = REPAIRED[name]
    build().export(tmp_path / f"object.{form}")
    shape = parse_object(f"{form}:path={tmp_path}/object.{form},unit=mm,mass_g=100")
    np.testing.assert_allclose(sorted(shape.size), sorted(np.array(extents) / 1e3), rtol=1e-3)
    assert any(re.search(match, note) for note in shape.notes), shape.notes
    assert "\n" not in shape.warning
    mass_of_box = np.diag(np.square(shape.size).sum() - np.square(shape.size)) / 12
    if name != "pricked":
        np.testing.assert_allclose(shape.inertia(), 0.1 * mass_of_box, rtol=2e-3, atol=1e-8)


def test_many_holes_of_one_triangle_each_are_filled(put):
    cup = trimesh.creation.annulus(r_min=37.0, r_max=40.0, height=90.0, sections=64)
    for _ in range(2):
        cup = cup.subdivide()
    whole, count = load_stl(put(cup), unit="mm", mass=0.1), len(cup.faces)
    cup.update_faces(~np.isin(np.arange(count), np.arange(0, count, count // 24)))
    shape = load_stl(put(cup), unit="mm", mass=0.1)
    assert "it is repaired" in shape.warning
    np.testing.assert_allclose(shape.inertia(), whole.inertia(), rtol=1e-3, atol=1e-9)


def test_a_cloud_of_triangles_is_refused_soon(put):
    """Once each piece was taken alone, which took minutes for thousands of them."""
    corners = np.random.default_rng(0).uniform(-40.0, 40.0, (2000, 1, 3))
    corners = (corners + np.random.default_rng(1).uniform(-8.0, 8.0, (2000, 3, 3))).reshape(-1, 3)
    cloud = trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=False)
    with pytest.raises(DesignError, match="in 2000 pieces; allowed: one surface, or up to 200 pieces"):
        load_stl(put(cloud), unit="mm", mass=0.1)


def mug(tilt=0.0):
    """A mug 95 mm tall whose handle makes it 108 mm long, tilted by some degrees."""
    body = trimesh.creation.cylinder(40.0, 95.0, sections=48)
    ring = trimesh.creation.annulus(18.0, 24.0, 10.0, sections=32)
    ring.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, (1.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    ring.apply_translation((44.0, 0.0, 0.0))
    whole = trimesh.boolean.union([body, ring], engine="manifold")
    whole.apply_transform(trimesh.transformations.rotation_matrix(np.radians(tilt), (1.0, 0.0, 0.0)))
    return whole


@pytest.mark.parametrize("tilt", [2.0, 8.0])
def test_a_thing_that_leans_in_its_file_is_turned_to_rest(put, tilt):
    shape = load_stl(put(mug(tilt)), unit="mm", mass=0.3)
    about = describe_object(shape)
    assert about.shape.size[2] == pytest.approx(0.095, rel=1e-3)
    assert about.pose is not None
    assert about.profile.topple_angle > np.radians(30.0)
    assert f"it rests turned by {tilt:.0f} deg" in shape.warning
    assert "turned" not in load_stl(put(mug()), unit="mm", mass=0.3).warning


def test_upright_and_lying_of_a_mug_that_is_longer_than_tall(put):
    file = put(mug())
    for pose, height in (("upright", 0.095), ("lying", 0.080)):
        shape = parse_object(f"stl:path={file},unit=mm,mass_g=300,pose={pose}")
        assert describe_object(shape).shape.size[2] == pytest.approx(height, rel=1e-3)


def test_what_rolls_in_its_file_is_stood_up_and_told(put):
    rod = trimesh.creation.cylinder(15.0, 100.0, sections=48)
    rod.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, (0.0, 1.0, 0.0)))
    shape = load_stl(put(rod), unit="mm", mass=0.1)
    assert describe_object(shape).shape.size[2] == pytest.approx(0.1)
    assert "it would not stay as it is in the file: it rests turned by 90 deg" in shape.warning


def test_a_repaired_surface_keeps_its_hollows(put):
    """A small hole is filled and the L stays an L: mass distribution and the excess of its hull."""
    pricked_l, whole = load_stl(put(pricked()), unit="mm", mass=0.1), load_stl(put(l_prism()), unit="mm", mass=0.1)
    np.testing.assert_allclose(pricked_l.inertia(), whole.inertia(), rtol=1e-3, atol=1e-9)
    assert pricked_l.solid.excess == pytest.approx(whole.solid.excess, abs=1e-3)


def test_a_cup_and_a_handle_that_reaches_into_its_wall_are_one_solid(put):
    """As many published cups: two closed surfaces. The volume is that of the union, and the hull fills the cup."""
    wall = trimesh.creation.annulus(r_min=37.0, r_max=40.0, height=90.0, sections=64)
    handle = trimesh.creation.box(extents=(26.0, 8.0, 50.0))
    handle.apply_translation((51.0, 0.0, 0.0))
    cup = trimesh.util.concatenate([wall, handle])
    shape = load_stl(put(cup), unit="mm", mass=0.3)
    assert any("2 closed bodies that overlap: they are united" in note for note in shape.notes)
    union = trimesh.boolean.union([wall, handle], engine="manifold")
    assert 0.9 * (wall.volume + handle.volume) < union.volume < wall.volume + handle.volume
    assert shape.solid.excess == pytest.approx(cup.convex_hull.volume / union.volume - 1, rel=1e-3)


def pieces(gap, shift=0.0):
    """An L of two boxes, as a convex decomposition has it: beside each other, but for a ``gap`` [mm]."""
    foot, arm = trimesh.creation.box(extents=(60, 20, 20)), trimesh.creation.box(extents=(20, 40, 20))
    arm.apply_translation([-20 + shift, 30 + gap, 0])
    return trimesh.util.concatenate([foot, arm])


@pytest.mark.parametrize(
    ("gap", "shift"),
    [(0.001, 0.0), (0.0, 0.0), *(pytest.param(*one, marks=pytest.mark.slow) for one in ((-1e-6, 0.0), (0.0, 3.0)))],
)
def test_the_pieces_of_a_convex_decomposition_are_one_solid(tmp_path, gap, shift):
    """They touch but for rounding, share corners or not; enlarged by 0.1 % they overlap, and the L stays an L."""
    pieces(gap, shift).export(tmp_path / "object.obj")
    shape = parse_object(f"obj:path={tmp_path}/object.obj,unit=mm,mass_g=100")
    assert any(
        re.search("2 closed bodies that (touch: each is enlarged by 0.1 %|overlap)", note) for note in shape.notes
    )
    np.testing.assert_allclose(sorted(shape.size), (0.020, 0.060, 0.060), rtol=3e-3)
    whole = trimesh.boolean.union(list(pieces(-0.01, shift).split()), engine="manifold")
    assert shape.solid.excess == pytest.approx(whole.convex_hull.volume / whole.volume - 1, abs=0.01)
    assert shape.solid.excess > 0.3


def test_bodies_apart_by_more_than_rounding_are_not_joined(tmp_path):
    pieces(0.5).export(tmp_path / "object.obj")
    with pytest.raises(DesignError, match="in 2 pieces that do not touch"):
        parse_object(f"obj:path={tmp_path}/object.obj,unit=mm,mass_g=100")


def cut_can(lost):
    """A can that lacks a band of its wall, a share of its height."""
    mesh = trimesh.creation.cylinder(radius=25, height=80, sections=36)
    wall = np.abs(mesh.face_normals[:, 2]) < 0.5
    around = np.degrees(np.arctan2(mesh.triangles_center[:, 1], mesh.triangles_center[:, 0])) % 360
    mesh.update_faces(~(wall & (around < 360 * lost)))
    return mesh


def test_a_can_with_a_cut_wall_is_taken_as_its_hull(put):
    shape = load_stl(put(cut_can(0.06)), unit="mm", mass=0.1)
    assert re.fullmatch(
        r"the surface is open or cut at \d+ edges: its convex hull is taken, \d.\d % larger .*", shape.notes[0]
    )
    np.testing.assert_allclose(shape.size, [0.08, 0.05, 0.05], rtol=5e-3)


def test_parts_need_a_closed_surface(put):
    with pytest.raises(DesignError, match="without a closed surface, which convex parts need"):
        load_stl(put(cut_can(0.06)), unit="mm", mass=0.1, collide="parts")


@pytest.mark.parametrize(("factor", "unit"), [(1.0, "mm"), (1e-3, "m"), (0.1, "cm"), (1 / 25.4, "cm"), (0.3, "mm")])
def test_a_unit_that_is_missing_is_guessed_from_the_size(put, factor, unit):
    """A box of 240 x 50 x 90 mm; one in inches cannot be told from one in centimetres."""
    path = put(trimesh.creation.box(extents=np.array(BOX) * factor))
    shape = parse_object(f"stl:path={path},mass_g=250")
    expected = np.array(BOX) * factor * {"mm": 1e-3, "m": 1.0, "cm": 1e-2}[unit]
    np.testing.assert_allclose(shape.size, expected, rtol=1e-5)
    assert shape.notes[0].startswith(f"the unit is guessed from the size: {unit}, ")
    assert shape.notes[0].endswith("; unit= states it")


@pytest.mark.parametrize(("mass", "unit"), [(20, "in"), (19_000, "m")])
def test_the_mass_counts_where_a_unit_is_guessed(put, mass, unit):
    """A box of 0.9 x 0.9 x 0.9 units: 0.03 kg/m3 for 20 g in metres, 1674 kg/m3 in inches."""
    shape = parse_object(f"stl:path={put(trimesh.creation.box(extents=(0.9, 0.9, 0.9)))},mass_g={mass}")
    assert shape.notes[0].startswith(f"the unit is guessed from the size: {unit}, ")


@pytest.mark.parametrize(
    ("size", "mass", "said"),
    [(500, 250, "the density is 2 kg/m3, below what things have, 10 to 20000: check the unit and mass_g"),
     (20, 200, "the density is 2.5e+04 kg/m3, above what things have, 10 to 20000: check the unit and mass_g")],
)  # fmt: skip
def test_an_absurd_density_is_told(put, size, mass, said):
    path = put(trimesh.creation.box(extents=(size, size, size)))
    assert parse_object(f"stl:path={path},unit=mm,mass_g={mass}").notes == (said,)


def test_a_size_that_fits_no_unit_is_refused(put):
    path = put(trimesh.creation.box(extents=(4000, 3000, 5000)))
    with pytest.raises(DesignError, match="of 4000 x 3000 x 5000 units; allowed: 5 mm to below 1 m each way"):
        parse_object(f"stl:path={path},mass_g=250")


CUBE = """
mtllib none.mtl
o cube
v 0 0 0
v 40 0 0 0.5 0.5 0.5
v 40 40 0 # a comment
v 0 40 0
vn 0 0 1
vt 0 0
usemtl red
f -1//1 -2//1 -3//1 -4//1
v 0 0 40
v 40 0 40
v 40 40 40
v 0 40 40
f -4 -3 -2 -1
g sides
s off
f 1/1/1 2/1/1 6/1/1 \\
5/1/1
f 2/1 3/1 7/1 6/1
f 3 4 8 7
f 4 1 5 8
l 1 2
p 1
"""


def test_an_obj_of_quads_materials_and_negative_indices_is_a_cube(tmp_path):
    file = tmp_path / "cube.obj"
    for text in (CUBE, CUBE.replace("\n", "\r\n")):
        file.write_bytes(text.encode())
        shape = parse_object(f"obj:path={file},unit=mm,mass_g=60")
        np.testing.assert_allclose(shape.size, 0.04, rtol=1e-9)
        np.testing.assert_allclose(shape.inertia(), np.eye(3) * 0.06 * 0.04**2 / 6, atol=1e-12)
        assert not shape.notes


def prism_text(outline, height, first=0):
    """OBJ of a prism whose two caps are single polygons that start at the corner ``first``."""
    n = len(outline)
    corners = [(*outline[(first + i) % n], z) for z in (0, height) for i in range(n)]
    caps = [range(n, 0, -1), range(n + 1, 2 * n + 1)]
    sides = [(i + 1, (i + 1) % n + 1, (i + 1) % n + n + 1, i + n + 1) for i in range(n)]
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    return "\n".join(lines + ["f " + " ".join(map(str, face)) for face in (*caps, *sides)]) + "\n"


L_OUTLINE = [(0, 0), (60, 0), (60, 15), (20, 15), (20, 40), (0, 40)]
NOTCHED = [(0, 0), (60, 0), (60, 60), (35, 60), (35, 50), (25, 50), (25, 60), (0, 60)]
FRAME = [(0, 0), (60, 0), (60, 60), (0, 60), (0, 0), (15, 15), (15, 45), (45, 45), (45, 15), (15, 15)]
"""A square with a square hole: its outline goes to the hole and back along the same line."""
SPLIT_SIDES = [(0, 0), (30, 0), (60, 0), (60, 60), (0, 60), (0, 30)]
"""A square with corners in the middle of sides, where triangles of a fan have no area."""


@pytest.mark.parametrize("first", range(6))
def test_a_concave_polygon_of_an_obj_is_read_from_any_corner(put, tmp_path, first):
    file = tmp_path / "l.obj"
    file.write_text(prism_text(L_OUTLINE, 20, first))
    shape, same = parse_object(f"obj:path={file},unit=mm,mass_g=100"), load_stl(put(l_prism()), unit="mm", mass=0.1)
    assert shape.notes == same.notes
    np.testing.assert_allclose(shape.size, same.size, rtol=1e-6)
    np.testing.assert_allclose(shape.center(), same.center(), atol=1e-9)
    np.testing.assert_allclose(shape.inertia(), same.inertia(), rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize(("outline", "area"), [(NOTCHED, 3500), (FRAME, 2700), (SPLIT_SIDES, 3600)])
def test_polygons_with_notches_holes_and_split_sides_are_read_as_they_are(tmp_path, outline, area):
    for first in range(len(outline)):
        content = prism_text(outline, 120, first).encode()
        points, faces = read_obj(content, "it", most=1000)
        corners = points[faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
        caps = np.abs(normals[:, 2]) > 1e-9
        assert np.abs(normals[caps, 2]).sum() == pytest.approx(2 * area, rel=1e-12)
        assert np.linalg.norm(normals, axis=1).min() > 1e-9
        assert len(faces) == 4 * len(outline) - 4


def test_a_convex_polygon_of_an_obj_is_a_fan():
    _, faces = read_obj(CUBE.encode(), "it", most=1000)
    assert faces[:2].tolist() == [[3, 2, 1], [3, 1, 0]]
    assert faces[4:6].tolist() == [[0, 1, 5], [0, 5, 4]]


@pytest.mark.parametrize(
    "corners",
    [[(0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 1, 0)], [(0, 0, 0), (3, 3, 0), (3, 0, 0), (0, 1, 0)], [(1, 2, 3)] * 5,
     [(i, 0, 0) for i in range(6)], [(math.nan, 0, 0)] + [(i * i, i, 0) for i in range(4)],
     [(1e300 * i * i, -1e300 * i, i) for i in range(4)],
     np.random.default_rng(0).normal(size=(1000, 3)).tolist()],
    ids=["crossing", "crossing unequally", "point", "line", "nan", "overflow", "random"],
)  # fmt: skip
def test_a_polygon_without_an_inside_is_read_as_so_many_triangles(corners):
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + ["f " + " ".join(str(i + 1) for i in range(len(corners)))]
    _, faces = read_obj("\n".join(lines).encode(), "it", most=1000)
    assert faces.shape == (len(corners) - 2, 3)
    assert set(faces.ravel().tolist()) == set(range(len(corners)))


@pytest.mark.parametrize(
    "before", ["\ufeff", "# C:\\\n", "mtllib C:\\\n", "usemtl a \\\nb\n", "v 0 0 \\\n0 # the first\n"]
)
def test_what_comes_before_the_first_vertex_of_an_obj_loses_none(before):
    text = prism_text(L_OUTLINE, 20)
    own = text.removeprefix("v 0 0 0\n") if before.startswith("v") else text
    for content in (before + own, (before + own).replace("\n", "\r\n")):
        for found, expected in zip(
            read_obj(content.encode(), "it", most=99), read_obj(text.encode(), "it", most=99), strict=True
        ):
            np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize(
    "line",
    [
        "f 1 2 99",
        "f 0 1 2",
        "f -9 1 2",
        "f 1 2",
        "f a b c",
        "v 1 2",
        "v x 1 2",
        "f " + "1 " * 2000,
        f"f {'9' * 5000} 1 2",
    ],
    ids=range(9),
)
def test_a_broken_line_of_an_obj_is_named(tmp_path, line):
    file = tmp_path / "cube.obj"
    text = CUBE.replace(" \\\n", " ")
    file.write_text(text + line + "\n")
    expected = len((text + line).splitlines())
    with pytest.raises(DesignError, match=f"no OBJ that can be read, at line {expected}; allowed") as caught:
        parse_object(f"obj:path={file},unit=mm,mass_g=60")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", BAD)
def test_a_mesh_that_is_no_solid_is_refused_with_the_reason(put, name):
    build, match = BAD[name]
    path = put(build())
    with pytest.raises(DesignError, match=match) as caught:
        parse_object(f"stl:path={path},unit=mm,mass_g=100")
    assert "\n" not in str(caught.value)


def test_a_wrong_unit_is_told(put):
    path = put(trimesh.creation.box(extents=BOX))
    with pytest.raises(DesignError, match=r"of 2.4e\+05 x 5e\+04 x 9e\+04 mm; allowed: .*not m but one of cm, mm, in"):
        load_stl(path, unit="m", mass=0.1)


BAD_BYTES = {
    "empty": (b"", "allowed: a file that exists.*of 1 byte to 20 MB; it is empty"),
    "text": (b"hello, this is not a mesh at all", "no STL that can be read.*; an OBJ is given by obj:path="),
    "no triangles": (b"solid nothing\nendsolid nothing\n", "no STL that can be read|of 0 triangles"),
    "cut short": (
        b"x" * 80 + (1000).to_bytes(4, "little") + b"y" * 500,
        "cut off: it states 1000 triangles and holds 10",
    ),
    "a count beyond the file": (b"x" * 80 + (2**32 - 1).to_bytes(4, "little"), "no STL that can be read"),
    "too big": (b"x" * 20_000_001, "allowed: a file that exists.*; it is larger than 20 MB"),
}


@pytest.mark.parametrize("name", BAD_BYTES)
def test_bytes_that_are_no_mesh_are_refused(tmp_path, name):
    content, match = BAD_BYTES[name]
    file = tmp_path / "object.stl"
    file.write_bytes(content)
    with pytest.raises(DesignError, match=match) as caught:
        load_stl(str(file), unit="mm", mass=0.1)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("content", "match"),
    [(bytes(range(128, 256)) * 9, "is no OBJ, or has no faces; allowed: an OBJ"),
     (b"solid can\nendsolid can\n", "is no OBJ, or has no faces"),
     (b"v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n", "is of 1 triangles; allowed: 4 to 100000; fewer enclose no solid")],
)  # fmt: skip
def test_an_obj_without_a_solid_is_refused(tmp_path, content, match):
    (tmp_path / "can.obj").write_bytes(content)
    with pytest.raises(DesignError, match=match):
        parse_object(f"obj:path={tmp_path}/can.obj,mass_g=100")


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_coordinates_that_are_not_finite_are_refused(tmp_path, value):
    mesh = trimesh.creation.box(extents=BOX)
    content = bytearray(mesh.export(file_type="stl"))
    content[84 + 12 : 84 + 16] = np.float32(value).tobytes()
    file = tmp_path / "object.stl"
    file.write_bytes(content)
    with pytest.raises(DesignError, match="not finite in some coordinates"):
        load_stl(str(file), unit="mm", mass=0.1)


@given(st.binary(max_size=400), st.booleans())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60, deadline=None)
def test_any_bytes_are_an_object_or_one_line_of_error(tmp_path, content, has_header):
    file = tmp_path / "fuzz.stl"
    file.write_bytes(bytes(80) + (len(content) // 50).to_bytes(4, "little") + content if has_header else content)
    said = ""
    for text in (f"stl:path={file},unit=mm,mass_g=100", f"mjcf:path={file}"):
        try:
            parse_object(text)
        except SpiralTrunkError as error:
            said += str(error)
    assert "\n" not in said


@pytest.mark.parametrize(
    ("text", "error", "match"),
    [
        ("obj:mass_g=100", DesignError, "without path; allowed: obj:path=FILE,mass_g="),
        ("stl:path=a.stl,mass_g=100,pose=1,pose=2", DesignError, r"each measure once: stl:.*pose=upright\|lying"),
        ("stl:path=a.stl,unit=mm", DesignError, "without mass_g"),
        ("stl:path=a.stl,unit=feet,mass_g=100", UnknownName, "unknown unit 'feet'; known: m, cm, mm, in"),
        ("stl:path=a.stl,unit=,mass_g=100", UnknownName, "unknown unit ''"),
        ("stl:path=a.stl,unit=mm,mass_g=100,axis=w", UnknownName, "unknown axis 'w'; known: longest, x, y, z"),
        ("stl:path=a.stl,unit=mm,mass_g=100,collide=no", UnknownName, "unknown way to collide 'no'"),
        ("stl:path=no such.stl,unit=mm,mass_g=100", DesignError, "'no such.stl'; allowed: .*; it does not exist"),
        ("stl:path=/,unit=mm,mass_g=100", DesignError, "allowed: a file that exists.*; it is a folder"),
        ("stl:path=/dev/zero,unit=mm,mass_g=100", DesignError, "it is a pipe, a socket or a device"),
        ("stl:path=a\0b,unit=mm,mass_g=100", DesignError, "allowed: a file that"),
        ("stl:path=~nobody-at-all/a,unit=mm,mass_g=100", DesignError, "allowed: a file that"),
        ("stl:path=a,b.stl,unit=mm,mass_g=100", DesignError, r"each measure once: stl:.*\[,axis=longest\|x\|y\|z\]"),
        ("mjcf:path=there is none.xml", DesignError, "mjcf:path is 'there is none.xml'"),
        ("mjcf:", DesignError, "without path; allowed: mjcf:path=FILE"),
        ("mjcf:path=a,unit=mm", UnknownName, "unknown measure of mjcf 'unit'; known: path, mass_g, axis, pose"),
    ],
)  # fmt: skip
def test_bad_texts_are_refused(text, error, match):
    with pytest.raises(error, match=match):
        parse_object(text)


def test_a_ball_of_many_triangles_encloses_its_middle_once():
    mesh = trimesh.creation.icosphere(subdivisions=4)
    points = np.array([(0, 0, 0), (0.9, 0, 0), (1.1, 0, 0), (5, 5, 5)], dtype=float)
    np.testing.assert_allclose(winding_numbers(points, mesh.triangles), [1, 1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(winding_numbers(points, mesh.triangles[:, ::-1]), [-1, -1, 0, 0], atol=1e-12)


def tube():
    """A pipe: bore 60 mm, outside 80 mm, 100 mm long."""
    return trimesh.creation.annulus(r_min=30, r_max=40, height=100, sections=32)


@pytest.mark.slow
def test_convex_parts_leave_a_pipe_open(put):
    pytest.importorskip("coacd")
    path = put(tube())
    hull, parts = (load_stl(path, unit="mm", mass=0.2, collide=collide) for collide in ("hull", "parts"))
    assert hull.solid.excess == pytest.approx(40**2 / (40**2 - 30**2) - 1, rel=1e-3)
    assert abs(parts.solid.excess) < 0.15
    np.testing.assert_allclose(parts.size, hull.size, rtol=1e-3)
    np.testing.assert_allclose(parts.inertia(), hull.inertia(), rtol=1e-9, atol=1e-12)
    assert [touches_a_ball_in_the_bore(shape) for shape in (hull, parts)] == [True, False]


def touches_a_ball_in_the_bore(shape):
    spec = mujoco.MjSpec()
    add_object(spec, shape)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.02, 0, 0])
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return data.ncon > 0


def test_the_same_mesh_gives_the_same_parts(put):
    pytest.importorskip("coacd")
    path = put(l_prism())
    first, second = (load_stl(path, unit="mm", mass=0.1, collide="parts").solid for _ in range(2))
    assert len(first.geoms) == len(second.geoms) >= 3
    for one, other in zip(first.geoms, second.geoms, strict=True):
        np.testing.assert_array_equal(one.vertices, other.vertices)


def test_parts_without_the_package_say_which_extra(put, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "coacd", None)
    with pytest.raises(MissingPackage, match=r"pip install 'spiraltrunk\[objects\]'"):
        load_stl(put(l_prism()), unit="mm", mass=0.1, collide="parts")


DUMBBELL = """
<mujoco>
  <worldbody>
    <geom type="plane" size="1 1 .1"/>
    <body name="dumbbell" pos="1 2 3" quat="0.5 0.5 0.5 0.5">
      <freejoint/>
      <geom type="box" size="0.02 0.03 0.01" mass="0.2"/>
      <geom type="sphere" size="0.01" pos="0.1 0 0" mass="0.1"/>
      <geom type="box" size="0.2 0.2 0.2" contype="0" conaffinity="0" mass="0"/>
      <body pos="0 0.05 0" euler="0 0 90"><geom type="capsule" size="0.01 0.03" mass="0.05"/></body>
    </body>
  </worldbody>
</mujoco>
"""


@pytest.fixture
def mjcf(tmp_path):
    def write(text):
        file = tmp_path / "object.xml"
        file.write_text(text)
        return str(file)

    return write


def test_a_body_from_mjcf_has_the_mass_and_inertia_that_mujoco_gives_it(mjcf):
    path = mjcf(DUMBBELL)
    shape = parse_object(f"mjcf:path={path},axis=y")  # Where the body's x points in the file.
    fused = mujoco.MjSpec.from_file(path)
    fused.compiler.fusestatic = True
    model = fused.compile()
    assert model.nbody == 2
    assert shape.mass == pytest.approx(0.35, rel=1e-9)
    low, high = np.array([-0.02, -0.03, -0.04]), np.array([0.11, 0.06, 0.04])
    np.testing.assert_allclose(shape.size, high - low, rtol=1e-9)
    np.testing.assert_allclose(shape.center(), model.body_ipos[1] - (low + high) / 2, atol=1e-12)
    np.testing.assert_allclose(shape.inertia(), mujoco_inertia(model.body(1)), rtol=1e-9, atol=1e-12)
    spec = mujoco.MjSpec()
    add_object(spec, shape)
    model = spec.compile()
    assert {model.body(b).name for b in model.geom_bodyid} == {"object"}
    assert [bool(kind) for kind in model.geom_contype] == [True, True, False, True]


CYLINDER = '<geom type="cylinder" size="0.03 0.1" mass="0.3"/>'


@pytest.mark.parametrize(
    "text",
    ['<body pos="1 2 3" euler="90 0 0"><freejoint/>{}</body>', '<body pos="1 2 3" quat="1 1 0 0">{}</body>',
     '<body pos="1 2 3" euler="90 0 0" mocap="true">{}</body>', '<frame euler="90 0 0"><body>{}</body></frame>',
     '<body><body pos="0 1 0" euler="90 0 0">{}</body></body>'],
)  # fmt: skip
def test_an_mjcf_body_is_oriented_as_in_its_file_however_that_is_said(mjcf, text):
    """A cylinder of which the file says that it lies: it would roll, and is stood up."""
    expected = load_mjcf(mjcf(one_body(CYLINDER.replace("/>", ' euler="90 0 0"/>'))))
    shape = load_mjcf(mjcf(f"<mujoco><worldbody>{text.format(CYLINDER)}</worldbody></mujoco>"))
    assert shape.notes == expected.notes
    assert "it would not stay as it is in the file: it rests turned by 90 deg" in shape.warning
    assert (shape.up, shape.mass) == (expected.up, expected.mass)
    np.testing.assert_allclose(shape.size, expected.size, rtol=1e-9)
    np.testing.assert_allclose(shape.center(), expected.center(), atol=1e-12)
    np.testing.assert_allclose(shape.inertia(), expected.inertia(), atol=1e-12)


def test_a_box_of_an_mjcf_lies_as_its_body_does(mjcf):
    box = '<geom type="box" size="0.1 0.05 0.02" density="500"/>'
    lying, on_its_side = (
        load_mjcf(mjcf(f'<mujoco><worldbody><body quat="{quat}">{box}</body></worldbody></mujoco>'))
        for quat in ("1 0 0 0", "1 1 0 0")
    )
    for shape, height in ((lying, 0.04), (on_its_side, 0.1)):
        assert describe_object(shape).profile.total_height == pytest.approx(height)
        assert not shape.notes


def test_a_body_from_mjcf_takes_a_mass_of_its_own(mjcf):
    path = mjcf(DUMBBELL)
    stated, other = parse_object(f"mjcf:path={path}"), parse_object(f"mjcf:path={path},mass_g=70")
    assert other.mass == pytest.approx(0.07, rel=1e-12)
    np.testing.assert_allclose(other.inertia(), 0.2 * stated.inertia(), rtol=1e-9, atol=1e-15)
    np.testing.assert_array_equal(other.center(), stated.center())
    with pytest.raises(DesignError, match="mass_g"):
        parse_object(f"mjcf:path={path},mass_g=0")


def test_a_body_with_a_mesh_from_mjcf_is_where_the_mesh_is(mjcf, put):
    put(l_prism(), "l.stl")
    path = mjcf(
        '<mujoco><asset><mesh name="l" file="l.stl" scale=".001 .001 .001" inertia="exact"/></asset><worldbody><body>'
        '<geom type="mesh" mesh="l" density="1000"/></body></worldbody></mujoco>'
    )
    shape, same = load_mjcf(path), load_stl(put(l_prism()), unit="mm", mass=0.028)
    np.testing.assert_allclose(shape.size, same.size, rtol=1e-5)
    np.testing.assert_allclose(shape.center(), same.center(), atol=1e-7)
    np.testing.assert_allclose(shape.inertia(), same.inertia(), rtol=1e-4, atol=1e-10)


def one_body(inner):
    return f"<mujoco><worldbody><body>{inner}</body></worldbody></mujoco>"


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("<mujoco><worldbody/></mujoco>", "of 0 bodies on the world; allowed: one"),
        ("<mujoco><worldbody>" + "<body><geom size='.03'/></body>" * 2 + "</worldbody></mujoco>",
         "of 2 bodies on the world"),
        (one_body("<joint/><geom size='.03'/>"), "of 1 joints that bend or slide; allowed: one rigid body"),
        (one_body("<geom size='.03'/><body><joint/><geom size='.03'/></body>"), "of 1 joints"),
        (one_body("<geom size='.001'/>"), "of 2 x 2 x 2 mm; allowed: 5 mm to below 1 m"),
        (one_body("<geom size='.03' density='1e9'/>"), r"object\.mass"),
        (one_body("<geom size='.03' contype='0' conaffinity='0'/>"), "without a geom that collides"),
        (one_body("<geom size='.03' mass='0'/>"), "of 0 g; allowed: some mass|MuJoCo"),
        (one_body("<geom type='mesh' mesh='none'/>"), "no MJCF that MuJoCo loads"),
        (one_body("<geom size='.03'/>" * 201), "of 201 geoms; allowed: at most 200"),
        ("<urdf/>", "no MJCF but XML with the root 'urdf'; allowed: <mujoco>"),
        ("not xml", "no MJCF; allowed: well-formed XML"),
        ("<mujoco><include file='none.xml'/></mujoco>", "names 'none.xml', which does not exist"),
    ],
)  # fmt: skip
def test_what_is_not_one_rigid_body_is_refused(mjcf, text, match):
    with pytest.raises(DesignError, match=match) as caught:
        load_mjcf(mjcf(text))
    assert "\n" not in str(caught.value)


def test_the_reader_is_not_trusted(put, monkeypatch):
    def fail(*_, **__):
        raise IndexError("somewhere in the reader")

    monkeypatch.setattr(trimesh, "load_mesh", fail)
    with pytest.raises(DesignError, match="no STL that can be read"):
        load_stl(put(l_prism()), unit="mm", mass=0.1)


@pytest.mark.slow
def test_a_large_mesh_is_checked_in_seconds(put):
    mesh = trimesh.creation.icosphere(subdivisions=6, radius=40)
    shape = load_stl(put(mesh), unit="mm", mass=0.1)
    assert len(mesh.faces) == 81920
    np.testing.assert_allclose(np.diag(shape.inertia()), 0.4 * 0.1 * 0.04**2, rtol=1e-3)


def wavy():
    """A ball with many dents, of which coacd makes parts for minutes."""
    mesh = trimesh.creation.icosphere(subdivisions=5, radius=40)
    x, y = mesh.vertices[:, :1] / 40, mesh.vertices[:, 1:2] / 40
    mesh.vertices = mesh.vertices * (1 + 0.25 * np.sin(9 * x) * np.sin(9 * y))
    return mesh


def test_a_mesh_that_takes_too_long_to_split_is_refused(put, monkeypatch):
    pytest.importorskip("coacd")
    monkeypatch.setattr(mesh_file, "DECOMPOSITION_MOST", 2)
    with pytest.raises(DesignError, match=r"too slow to decompose; allowed: at most 2 s|ended with code -"):
        load_stl(put(wavy()), unit="mm", mass=0.1, collide="parts")


def test_a_pipe_is_no_file(tmp_path):
    os.mkfifo(tmp_path / "object.stl")
    for text in (f"stl:path={tmp_path}/object.stl,unit=mm,mass_g=100", f"mjcf:path={tmp_path}/object.stl"):
        with pytest.raises(DesignError, match=r"of 1 byte to 20 MB; it is a pipe, a socket"):
            parse_object(text)


CUP = """<mujoco><asset><mesh name="cup" file="cup.stl" scale="{scale}"/></asset>
<worldbody><body><freejoint/><geom type="mesh" mesh="cup" density="800"{more}/></body></worldbody></mujoco>"""


def put_cup(folder, scale="0.001 0.001 0.001", more=""):
    cup = trimesh.creation.annulus(r_min=37.0, r_max=40.0, height=90.0, sections=64)
    handle = trimesh.creation.box(extents=(26.0, 8.0, 50.0))
    handle.apply_translation((51.0, 0.0, 10.0))
    trimesh.boolean.union([cup, handle], engine="manifold").export(folder / "cup.stl")
    (folder / "cup.xml").write_text(CUP.format(scale=scale, more=more))
    return str(folder / "cup.xml")


def test_a_hollow_mesh_of_an_mjcf_has_its_own_centre_and_is_told_to_be_filled(tmp_path):
    shape = load_mjcf(put_cup(tmp_path))
    alone = load_stl(str(tmp_path / "cup.stl"), unit="mm", mass=shape.mass)
    assert shape.solid.excess == pytest.approx(alone.solid.excess, rel=1e-3)
    assert "hollows are filled" in shape.warning
    assert "collide=parts" not in shape.warning
    np.testing.assert_allclose(np.sort(shape.center()), np.sort(alone.center()), atol=1e-5)
    np.testing.assert_allclose(np.sort(np.diag(shape.inertia())), np.sort(np.diag(alone.inertia())), rtol=1e-3)


def test_an_mjcf_of_hidden_geoms_alone_is_described(tmp_path):
    about = describe_object(load_mjcf(put_cup(tmp_path, more=' group="3"')))
    assert about.volume > 0
    assert len(about.triangles) > 100


def test_a_mesh_in_mm_of_an_mjcf_is_refused_with_its_size(tmp_path):
    with pytest.raises(DesignError, match=r"of 1.04e\+05 x 8e\+04 x 9e\+04 mm; allowed: 5 mm .* scale="):
        load_mjcf(put_cup(tmp_path, scale="1 1 1"))


def test_a_centre_of_mass_above_the_body_is_refused(tmp_path):
    file = tmp_path / "top.xml"
    file.write_text(
        '<mujoco><worldbody><body><freejoint/><inertial pos="0 0 0.12" mass="0.3" diaginertia="1e-3 1e-3 1e-4"/>'
        '<geom type="cylinder" size="0.03 0.09"/></body></worldbody></mujoco>'
    )
    with pytest.raises(DesignError, match="a centre of mass in its geoms"):
        load_mjcf(str(file))


def test_a_binary_stl_that_is_cut_off_says_so_and_what_follows_it_is_left_out(put):
    file = put(trimesh.creation.box(extents=BOX))
    content = Path(file).read_bytes()
    Path(file).write_bytes(content[:-70])
    with pytest.raises(DesignError, match="cut off: it states 12 triangles and holds 10"):
        load_stl(file, unit="mm", mass=0.1)
    Path(file).write_bytes(content + b"made by a scanner")
    assert sorted(load_stl(file, unit="mm", mass=0.1).size) == pytest.approx(sorted(np.array(BOX) / 1e3))


@pytest.mark.parametrize("seed", [2, 3, 7])
def test_a_thing_that_rests_on_a_rolling_pose_is_told_to_rest_in_it(seed):
    assert describe_object(parse_object(f"everyday:seed={seed},pose=0")).pose == 0


def test_what_has_only_rolled_is_not_told_to_be_turned(put):
    rod = trimesh.creation.cylinder(5.0, 300.0, sections=48)
    rod.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, (0.0, 1.0, 0.0)))
    for mesh in (trimesh.creation.icosphere(3, 30.0), rod):
        assert "turned" not in load_stl(put(mesh), unit="mm", mass=0.1).warning


def test_a_plate_that_is_tilted_is_laid_on_the_nearer_side(put):
    plate = trimesh.creation.box((120.0, 80.0, 10.0))
    plate.apply_transform(trimesh.transformations.rotation_matrix(np.radians(30.0), (1.0, 0.0, 0.0)))
    assert "it rests turned by 30 deg" in load_stl(put(plate), unit="mm", mass=0.1).warning


def test_a_pose_that_was_asked_for_is_not_told_to_be_another(put):
    file = put(mug(8.0))
    for pose in ("lying", "upright", "0"):
        assert "turned" not in parse_object(f"stl:path={file},unit=mm,mass_g=300,pose={pose}").warning


def test_a_compact_box_has_its_longest_side_up_as_its_measures_say(put):
    file = put(trimesh.creation.box((100.0, 90.0, 80.0)))
    for pose, height in (("upright", 0.1), ("lying", 0.08)):
        for kind in (f"stl:path={file},unit=mm", "box:x_mm=100,y_mm=90,z_mm=80"):
            shape = parse_object(f"{kind},mass_g=300,pose={pose}")
            assert describe_object(shape).shape.size[2] == pytest.approx(height, rel=1e-3)


TWO = """<mujoco><asset><mesh name="cup" file="cup.stl" scale="0.001 0.001 0.001"/>
<mesh name="mark" file="mark.stl" scale="0.001 0.001 0.001"/></asset><worldbody><body><freejoint/>
<geom type="mesh" mesh="cup" density="800"/><geom type="mesh" mesh="mark" mass="0" contype="0" conaffinity="0"/>
</body></worldbody></mujoco>"""


def test_a_faulty_mesh_leaves_the_others_their_true_mass(tmp_path):
    whole = load_mjcf(put_cup(tmp_path))
    mark = trimesh.creation.box((10.0, 10.0, 10.0))
    mark.faces[:3] = mark.faces[:3, ::-1]
    mark.export(tmp_path / "mark.stl")
    (tmp_path / "two.xml").write_text(TWO)
    both = load_mjcf(str(tmp_path / "two.xml"))
    assert both.mass == pytest.approx(whole.mass, rel=1e-6)
    assert both.mass == pytest.approx(800 * trimesh.load(tmp_path / "cup.stl").volume * 1e-9, rel=1e-3)


def test_of_an_open_mesh_no_hollow_is_told(tmp_path):
    box = trimesh.creation.box((60.0, 60.0, 90.0))
    box.update_faces(box.face_normals[:, 2] < 0.5)
    box.export(tmp_path / "cup.stl")
    (tmp_path / "cup.xml").write_text(CUP.format(scale="0.001 0.001 0.001", more=""))
    assert "hollows" not in load_mjcf(str(tmp_path / "cup.xml")).warning


def test_of_more_triangles_than_stated_none_is_left_out(put):
    file = put(trimesh.creation.box(extents=BOX))
    content = bytearray(Path(file).read_bytes())
    content[80:84] = (10).to_bytes(4, "little")
    Path(file).write_bytes(content)
    with pytest.raises(DesignError, match="no STL that can be read"):
        load_stl(file, unit="mm", mass=0.1)
