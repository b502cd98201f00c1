"""What narrows upwards: how its slope is measured, and which slopes a loop does not hold."""

import math

import numpy as np
import pytest
import trimesh

from spiraltrunk.design.presets import PAPER
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.objects.presentation import as_measured
from spiraltrunk.strategies import get
from spiraltrunk.strategies.assessment import assess
from spiraltrunk.strategies.object_measures import narrowing
from spiraltrunk.strategies.wrap.standing_model import loop_band
from spiraltrunk.workflows.grasp.choice.ranking import announce_task

WRAP = get("wrap-oblique-low")


def task_of(text):
    return announce_task(PAPER, as_measured(parse_object(text)), WRAP)


def frustum(folder, degrees, height):
    """A frustum of 90 mm at its foot whose sides narrow by an angle, as a file's object."""
    top = 45.0 - height * math.tan(math.radians(degrees))
    mesh = trimesh.creation.revolve(np.array([[0, 0], [45, 0], [top, height], [0, height]]), sections=64)
    mesh.export(folder / "frustum.stl")
    return f"stl:path={folder / 'frustum.stl'},mass_g=250,unit=mm,axis=z"


@pytest.mark.parametrize("degrees", [-8.0, 0.0, 3.0, 10.0])
def test_a_frustum_narrows_by_the_angle_of_its_sides(tmp_path, degrees):
    target = task_of(frustum(tmp_path, degrees, 120.0)).target
    assert math.degrees(narrowing(target, *loop_band(target))) == pytest.approx(max(0.0, degrees), abs=0.2)


@pytest.mark.parametrize("name", ["cylinder-60", "box-80", "bottle-70", "ball-80"])
def test_what_is_straight_or_widens_in_a_part_does_not_narrow(name):
    target = task_of(name).target
    assert narrowing(target, *loop_band(target)) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("degrees", "height", "told"), [(12.0, 160.0, ""), (14.0, 160.0, "narrow upwards by 14"), (14.0, 110.0, "")]
)
def test_tall_objects_with_steep_sides_are_refused(tmp_path, degrees, height, told):
    given = assess(WRAP, task_of(frustum(tmp_path, degrees, height)))
    assert given.feasible is (not told), given.reason
    assert told in given.reason


def test_the_score_falls_with_the_slope_of_tall_objects(tmp_path):
    scores = [assess(WRAP, task_of(frustum(tmp_path, degrees, 160.0))).score for degrees in (4.0, 9.0, 12.0)]
    assert scores == sorted(scores, reverse=True)
    assert scores[2] < 0.85 * scores[0]


@pytest.mark.parametrize("text", ["cone-90", "cone:diameter_mm=50,height_mm=200,mass_g=150"])
def test_cones_are_refused(text):
    assert "narrows upwards to a point" in assess(WRAP, task_of(text)).reason


def test_a_cone_from_a_file_is_refused(tmp_path):
    trimesh.creation.cone(radius=45, height=120, sections=64).export(tmp_path / "cone.stl")
    given = assess(WRAP, task_of(f"stl:path={tmp_path / 'cone.stl'},mass_g=200,unit=mm,axis=z"))
    assert "narrows upwards to a point" in given.reason
