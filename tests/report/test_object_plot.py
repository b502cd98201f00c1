"""The picture of an object: the whole silhouette, margins, a legend, and stable poses that are alike drawn once."""

from dataclasses import replace

import pytest

from spiraltrunk.report.object_plot import POSES_MOST, ObjectPicture, build_object_figure, group_poses
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.objects.description import describe_object


def build_picture(text):
    about = describe_object(parse_object(text))
    return ObjectPicture(title=text, triangles=about.triangles, profile=about.profile, center=about.center)


def test_the_side_view_has_the_whole_of_a_flat_box_to_scale():
    figure = build_object_figure(build_picture("box:x_mm=150,y_mm=220,z_mm=30,mass_g=500"))
    figure.draw_without_rendering()
    side = figure.axes[1]
    low, high = side.get_xlim()
    assert (low < -110, high > 110) == (True, True)
    assert side.get_aspect() == 1.0
    texts = [text.get_text() for text in side.get_legend().get_texts()]
    assert texts == ["height of the grip", "centre of mass"]


def test_the_widths_of_a_cylinder_have_a_margin():
    figure = build_object_figure(build_picture("cylinder-60"))
    assert figure.axes[2].get_xlim()[1] == pytest.approx(1.06 * 60)


def test_poses_that_are_alike_are_drawn_once():
    picture = build_picture("box:x_mm=150,y_mm=220,z_mm=30,mass_g=500")
    assert group_poses(picture.profile.stable_poses) == [[0, 1], [2, 3], [4, 5]]
    titles = [axes.get_title() for axes in build_object_figure(picture).axes[3:]]
    assert [title.splitlines()[0][:10] for title in titles] == ["poses 0, 1", "poses 2, 3", "poses 4, 5"]


@pytest.mark.parametrize(
    ("more", "said"),
    [pytest.param(1, "and 1 more stable pose", marks=pytest.mark.slow), (3, "and 3 more stable poses")],
)
def test_poses_that_are_not_drawn_are_counted(more, said):
    picture = build_picture("cylinder-60")
    pose = picture.profile.stable_poses[0]
    poses = tuple(replace(pose, height=pose.height * (1 + i)) for i in range(POSES_MOST + more))
    picture = replace(picture, profile=replace(picture.profile, stable_poses=poses))
    figure = build_object_figure(picture)
    assert len(figure.axes) == 3 + POSES_MOST
    assert figure.get_supxlabel() == said
