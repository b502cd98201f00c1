"""How objects stand on the ground, and their stable poses."""

import math

import mujoco
import numpy as np
import pytest
import trimesh

from spiraltrunk import strategies
from spiraltrunk.errors import DesignError, UnknownName
from spiraltrunk.sim.objects.catalogue import CATALOGUE, add_object, parse_object
from spiraltrunk.sim.objects.presentation import LYING_COS, LYING_SHARE, as_measured, natural_orientation, present
from spiraltrunk.sim.objects.profile import compute_profile
from spiraltrunk.sim.objects.stable_poses import compute_stable_poses
from spiraltrunk.workflows.grasp.world import EXACT, SLOPE_FRICTION, WRAP_FRICTION, draw_scene

BOTH = ("upright", "lying")


def heights(shape):
    """Height in which each orientation presents the object [mm]."""
    return [1e3 * compute_profile(present(shape, way), way).total_height for way in BOTH]


def test_a_box_stands_as_its_measures_say():
    tall, flat = (
        parse_object(f"box:{sizes},mass_g=300") for sizes in ("x_mm=62,y_mm=62,z_mm=190", "x_mm=60,y_mm=240,z_mm=50")
    )
    assert present(tall, "upright").length == 0.19
    assert (natural_orientation(tall), natural_orientation(flat)) == BOTH
    assert heights(tall) == pytest.approx([190, 62])
    assert heights(flat) == pytest.approx([50, 50])
    upright = present(flat, "upright")
    assert (upright.length, upright.width) == (0.05, 0.24)


@pytest.mark.parametrize("name", CATALOGUE)
def test_nothing_changes_for_the_catalogue(name):
    shape = parse_object(name)
    assert present(shape, "upright") is present(shape, "lying") is shape


@pytest.mark.parametrize(
    ("text", "expected"),
    [("box:x_mm=100,y_mm=30,z_mm=150,pose=upright", 150), ("box:x_mm=100,y_mm=30,z_mm=150,pose=lying", 30),
     ("cylinder:diameter_mm=60,height_mm=160,pose=upright", 160), ("cone:diameter_mm=60,height_mm=90,pose=lying", 60),
     ("cylinder:diameter_mm=60,height_mm=160,pose=lying", 60), ("cylinder:diameter_mm=60,height_mm=160,pose=0", 60),
     ("cylinder:diameter_mm=60,height_mm=160,pose=1", 160), ("sphere:diameter_mm=60,pose=0", 60)],
)  # fmt: skip
def test_a_pose_that_is_asked_for_holds_for_every_strategy(text, expected):
    shape = parse_object(f"{text},mass_g=9")
    assert heights(shape) == pytest.approx([expected] * 2, rel=2e-3)
    for way in BOTH:
        once = present(shape, way)
        assert present(once, way) == once
        assert once.mass == shape.mass
        np.testing.assert_allclose(np.linalg.eigvalsh(once.inertia()), np.linalg.eigvalsh(shape.inertia()), rtol=1e-9)


@pytest.mark.parametrize(
    ("text", "size_mm"), [("seed=10306", (72, 67, 34)), ("kind=superquadric,seed=56", (94, 73, 34))]
)
def test_a_flat_solid_that_rarely_rests_on_its_edge_lies_flat(text, size_mm):
    shape = parse_object(f"everyday:{text},pose=lying")
    assert shape.up == "z"
    assert [1e3 * extent for extent in shape.size] == pytest.approx(size_mm, abs=0.6)
    assert level_share(parse_object(f"everyday:{text}")) < LYING_SHARE
    assert present(shape, "upright").up == "x"
    assert heights(shape) == pytest.approx([size_mm[2]] * 2, abs=0.6)


def test_a_prism_of_many_faces_lies_on_one_of_them(tmp_path):
    trimesh.creation.cylinder(radius=30.0, height=70.0, sections=20).export(tmp_path / "prism.stl")
    shape = parse_object(f"stl:path={tmp_path / 'prism.stl'},mass_g=100,unit=mm,pose=lying")
    assert max(pose.probability for pose in compute_stable_poses(shape) if pose.height < 0.065) < LYING_SHARE
    assert (shape.up, round(1e3 * shape.size[0])) == ("z", 70)


def level_share(shape):
    poses = compute_stable_poses(shape)
    return sum(pose.probability for pose in poses if abs(float(pose.rotation[2, 0])) < LYING_COS)


@pytest.mark.parametrize(
    ("pose", "error", "match"),
    [("standing", UnknownName, "unknown pose 'standing'; known: upright, lying, 0, 1"), ("", UnknownName, "pose"),
     ("6", DesignError, "object.pose is '6'; allowed: upright, lying or 0 to 5"), ("-1", UnknownName, "pose"),
     ("9" * 5000, DesignError, "object.pose")],
)  # fmt: skip
def test_other_poses_are_refused(pose, error, match):
    with pytest.raises(error, match=match) as caught:
        parse_object(f"box:x_mm=100,y_mm=30,z_mm=150,mass_g=9,pose={pose}")
    assert len(str(caught.value)) < 300 or pose.isdigit() is False


def test_a_scene_presents_the_object_as_its_strategy_needs_it():
    spec = "box:x_mm=20,y_mm=12,z_mm=150,mass_g=40"
    for pose, expected in (("", 0.02), (",pose=upright", 0.15)):
        scene = draw_scene(parse_object(spec + pose), 0, strategy=strategies.get("pinch"), spread=EXACT)
        assert scene.announced.size[2] == expected
    assert (
        draw_scene(parse_object(spec), 0, strategy=strategies.get("tip-grip"), spread=EXACT).announced.size[0] == 0.15
    )


@pytest.mark.parametrize(("name", "hardness"), [("cone-35", "SLOPE"), ("ring-90", "WRAP"), ("bottle-70", "WRAP")])
@pytest.mark.parametrize("pose", ["", ",pose=0", ",pose=1", ",pose=upright", ",pose=lying"])
def test_contacts_are_those_of_the_shape_in_every_pose(name, hardness, pose):
    shape = parse_object(name + pose)
    scene = draw_scene(shape, 0, strategy=strategies.get("wrap-horizontal"), spread=EXACT)
    assert scene.friction_hardness == {"SLOPE": SLOPE_FRICTION, "WRAP": WRAP_FRICTION}[hardness]
    for presented in (shape, scene.shape):
        spec = mujoco.MjSpec()
        add_object(spec, presented)
        assert set(spec.compile().geom_condim.tolist()) == {6}


def test_a_turned_cylinder_keeps_contacts_without_rolling_friction():
    spec = mujoco.MjSpec()
    add_object(spec, present(parse_object("cylinder-60,pose=0"), "upright"))
    assert set(spec.compile().geom_condim.tolist()) == {3}


def test_the_pose_of_the_measures_can_be_bound():
    assert heights(as_measured(parse_object("cylinder-60"))) == pytest.approx([240, 240])


def test_the_stable_poses_of_a_box_are_its_six_faces():
    poses = compute_stable_poses(parse_object("box:x_mm=60,y_mm=60,z_mm=60,mass_g=100"))
    assert [pose.probability for pose in poses] == pytest.approx([1 / 6] * 6, abs=1e-3)
    for pose in poses:
        assert pose.height == pytest.approx(0.06)
        assert pose.center_height == pytest.approx(0.03)
        assert pose.topple_angle == pytest.approx(math.pi / 4, abs=math.radians(0.5))
        np.testing.assert_allclose(pose.rotation @ pose.rotation.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(pose.rotation) == pytest.approx(1)
        assert np.linalg.norm(pose.rotation_wxyz) == pytest.approx(1)


def test_a_cylinder_lies_or_stands_on_either_end():
    poses = compute_stable_poses(parse_object("cylinder-60"))
    assert [round(1e3 * pose.height) for pose in poses] == [60, 240, 240]
    assert poses[0].topple_angle == 0.0
    assert sum(pose.probability for pose in poses) == pytest.approx(1, abs=1e-6)


def test_a_ball_has_one_pose_and_a_cone_two():
    (ball,) = compute_stable_poses(parse_object("ball-60"))
    assert (ball.probability, ball.topple_angle) == (pytest.approx(1, abs=1e-6), 0.0)
    lying, standing = compute_stable_poses(parse_object("cone-90"))
    assert (lying.topple_angle, round(1e3 * standing.height)) == (0.0, 160)


@pytest.mark.parametrize(
    ("build", "turn", "expected"),
    [
        (lambda: trimesh.creation.cylinder(25, 80), (0, 0, 0), 80),
        (lambda: trimesh.creation.cylinder(25, 80), (math.pi / 2, 0, 0), 80),  # Its y is up: it would roll.
        (lambda: trimesh.creation.cylinder(25, 80), (0.9, 0.3, 0), 80),  # Askew.
        (lambda: trimesh.creation.icosphere(3).apply_transform(np.diag([20, 20, 34, 1.0])), (0, 0, 0), 40),
    ],
)
def test_a_file_rests_as_it_says_or_as_it_can(tmp_path, build, turn, expected):
    mesh = build()
    mesh.apply_transform(trimesh.transformations.euler_matrix(*turn))
    mesh.export(tmp_path / "object.stl")
    shape = parse_object(f"stl:path={tmp_path}/object.stl,mass_g=200")
    assert heights(shape)[0] == pytest.approx(expected, rel=0.02)
