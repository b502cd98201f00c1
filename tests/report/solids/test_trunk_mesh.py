"""Surfaces of a trunk."""

import numpy as np
import pytest
import trimesh

from spiraltrunk.design import presets
from spiraltrunk.design.spiral import points
from spiraltrunk.report.shape.construction import build_construction, curled_pose
from spiraltrunk.report.solids.trunk_mesh import build_rods, build_trunk_surfaces, curl_frames

DESIGNS = [presets.get(name) for name in presets.NAMES]


def close(surface):
    return trimesh.Trimesh(surface.vertices, surface.faces, process=True)


@pytest.mark.parametrize("design", DESIGNS, ids=presets.NAMES)
@pytest.mark.parametrize("share", [0.0, 0.6])
def test_sections_have_the_volume_of_the_design(design, share):
    surfaces = build_trunk_surfaces(design, curl_frames(design, share))
    volume = sum(close(each).volume for each in surfaces.sections)
    assert volume == pytest.approx((design.solid.volume * design.scale**3).sum(), rel=0.02)
    assert all(close(each).is_volume for each in surfaces.sections)


def test_straight_trunk_is_as_long_and_wide_as_the_design():
    design = presets.PAPER
    surfaces = build_trunk_surfaces(design, curl_frames(design, 0.0))
    vertices = np.concatenate([each.vertices for each in surfaces.sections])
    assert vertices[:, 0].min() == pytest.approx(0.0, abs=1e-12)
    assert vertices[:, 0].max() == pytest.approx(design.length)
    assert np.linalg.norm(vertices[:, 1:], axis=1).max() == pytest.approx(design.solid.radius)
    assert surfaces.mount.vertices[:, 0].min() == pytest.approx(-design.housing.length - design.housing.neck_length)
    assert surfaces.gripper.vertices[:, 0].max() == pytest.approx(design.length + design.gripper.finger_length)
    gaps = np.linalg.norm(surfaces.cables[:, 2::2] - surfaces.cables[:, 1:-1:2], axis=-1)
    assert gaps == pytest.approx(np.tile(design.straight_gap, (3, 1)))


@pytest.mark.parametrize("design", DESIGNS, ids=presets.NAMES)
def test_curled_trunk_lies_on_the_construction(design):
    placed = curled_pose(design) @ curl_frames(design)
    joints = points(design.backbone, design.theta_base - design.delta_theta * np.arange(design.n_section))
    assert placed[:, :2, 3] == pytest.approx(joints, abs=1e-12)
    assert placed[:, 2, 3] == pytest.approx(0.0, abs=1e-12)
    assert np.linalg.det(curled_pose(design)[:3, :3]) == pytest.approx(1.0)


def test_construction_shows_the_sections_and_the_smallest_object():
    design = presets.PAPER
    lines = build_construction(design)
    faces = np.linalg.norm(lines.sections[:, 0] - lines.sections[:, 3], axis=1)
    assert faces == pytest.approx(design.face_half_width * design.scale)
    lengths = np.linalg.norm(lines.sections[:, 1] - lines.sections[:, 0], axis=1)
    assert lengths == pytest.approx(design.section_length)
    across = np.ptp(lines.smallest, axis=0)
    assert across == pytest.approx(0.0330, rel=0.02)
    slope = lines.tangent[1] - lines.tangent[0]
    ray = lines.rays[0, 1] - lines.rays[0, 0]
    cosine = slope @ ray / np.linalg.norm(slope) / np.linalg.norm(ray)
    assert np.arccos(cosine) == pytest.approx(np.arctan(1 / design.spiral.b), abs=1e-5)


def test_rods_of_several_lines_are_those_of_each_and_leave_out_pieces_without_a_length():
    points = np.random.default_rng(3).normal(size=(5, 2, 3))
    lines, radii = [points[:3], points[3:]], [0.1, 0.2]
    lines[0][1, 1] = lines[0][1, 0]
    rods = build_rods(lines, radii)
    assert [len(rod.vertices) for rod in rods] == [2 * 8, 2 * 8]
    assert [len(rod.faces) for rod in rods] == [2 * 8, 2 * 8]
    for rod, line, radius in zip(rods, lines, radii, strict=True):
        (alone,) = build_rods([line], [radius])
        assert np.array_equal(rod.vertices, alone.vertices)
        assert np.array_equal(rod.faces, alone.faces)
        kept = line[np.any(line[:, 0] != line[:, 1], axis=1)]
        away = rod.vertices.reshape(-1, 2, 4, 3) - kept[:, :, None]
        assert np.linalg.norm(away, axis=-1) == pytest.approx(radius)
