"""The framed camera shows trunk and object large and whole, by what the renderer sees of them."""

import mujoco
import numpy as np
import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import MissingPackage
from spiraltrunk.sim.framing import choose_size, compute_fill, find_geoms, frame_view
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.render import View, render_frames
from spiraltrunk.sim.robot.trunk import hinge_names
from spiraltrunk.sim.scene.build import build_model
from spiraltrunk.sim.scene.options import SceneOptions

SIDE = View(fovy=20.0, width=320, height=240)


@pytest.fixture(scope="module")
def model():
    return build_model(PAPER, SceneOptions(shape=parse_object("cylinder-90"), support="ground", orientation="upright"))


def _pose(model, bend):
    """Arm at rest, all joints of the trunk bent alike [rad]."""
    qpos = mujoco.MjData(model).qpos.copy()
    for i in range(PAPER.n_joint):
        qpos[model.joint(hinge_names(i)[0]).qposadr[0]] = bend
    return qpos


def _boxes(model, qpos, view):
    """Pixels (left, top, right, bottom) that show trunk or object, from the renderer's segmentation; None unseen."""
    try:
        model.vis.global_.fovy = view.fovy
        renderer = mujoco.Renderer(model, height=view.height, width=view.width)
    except Exception as error:
        pytest.skip(f"no OpenGL: {error}")
    data, camera = mujoco.MjData(model), mujoco.MjvCamera()
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    camera.lookat[:] = view.lookat
    camera.distance, camera.azimuth, camera.elevation = view.distance, view.azimuth, view.elevation
    renderer.enable_segmentation_rendering()
    renderer.update_scene(data, camera)
    seen = renderer.render()
    renderer.close()
    is_geom = seen[..., 1] == int(mujoco.mjtObj.mjOBJ_GEOM)
    rows, columns = np.nonzero(is_geom & np.isin(seen[..., 0], find_geoms(model)))
    return columns.min(), rows.min(), columns.max(), rows.max()


@pytest.mark.gl
@pytest.mark.parametrize("bend", [0.0, 0.25, 0.45])
def test_trunk_and_object_are_large_and_never_cut(model, bend):
    """Their box covers a third of the picture or more, and stays off its edges."""
    qpos = _pose(model, bend)
    view = frame_view(model, [qpos], choose_size(model, [[qpos]], SIDE))
    left, top, right, bottom = _boxes(model, qpos, view)
    covered = (right - left + 1) * (bottom - top + 1) / (view.width * view.height)
    assert covered >= 1 / 3
    assert covered <= compute_fill(model, qpos, view) <= covered + 0.1  # Its boxes enclose the shapes.
    assert min(left, top) > 0
    assert right < view.width - 1
    assert bottom < view.height - 1


@pytest.mark.gl
def test_a_view_of_several_moments_cuts_none(model):
    poses = [_pose(model, bend) for bend in (0.0, 0.45)]
    view = frame_view(model, poses, SIDE)
    for qpos in poses:
        left, top, right, bottom = _boxes(model, qpos, view)
        assert min(left, top) > 0
        assert right < view.width - 1
        assert bottom < view.height - 1


@pytest.mark.gl
def test_each_picture_has_its_own_view_and_the_model_keeps_its_field(model):
    qpos, fovy = _pose(model, 0.3), float(model.vis.global_.fovy)
    views = [frame_view(model, [qpos], SIDE), View(fovy=60.0, width=320, height=240)]
    try:
        near, far = render_frames(model, [qpos, qpos], views)
    except MissingPackage as error:
        pytest.skip(str(error))
    assert near.shape == far.shape == (240, 320, 3)
    assert (near != far).any()
    assert model.vis.global_.fovy == fovy


def test_pictures_and_views_must_be_as_many(model):
    with pytest.raises(ValueError, match="shorter"):
        list(render_frames(model, [_pose(model, 0.0)] * 2, [SIDE]))
