"""What is told of an object: its volume whatever its pose and however its geoms are shown."""

import math

import pytest

from spiraltrunk.sim.objects.catalogue import load_mjcf, parse_object
from spiraltrunk.sim.objects.description import compute_volume, describe_object

RING = 2 * math.pi**2 * 0.0375 * 0.0075**2
CONE = math.pi * 0.045**2 * 0.16 / 3
CYLINDER = math.pi * 0.03**2 * 0.2


@pytest.mark.parametrize(("name", "volume"), [("ring-90", RING), ("cone-90", CONE)])
@pytest.mark.parametrize("pose", ["", ",pose=0", ",pose=1", ",pose=lying"])
def test_the_volume_is_that_of_the_solid_in_every_pose(name, volume, pose):
    assert compute_volume(parse_object(name + pose)) == pytest.approx(volume, rel=1e-12)


@pytest.mark.parametrize("name", ["cone-90", "cone-35", "bottle-70", "cylinder-60", "ball-60"])
def test_what_rolls_in_the_pose_that_was_asked_for_is_told_to(name):
    about = describe_object(parse_object(f"{name},pose=0"))
    assert about.pose is not None
    taken = about.profile.stable_poses[about.pose]
    assert taken.topple_angle == about.profile.topple_angle == about.profile.support_radius == 0.0
    assert taken.center_height == pytest.approx(about.profile.center_height, rel=1e-3)


@pytest.mark.parametrize(("name", "topple_deg"), [("cone-90", 48), ("cone-35", 57), ("bottle-70", 22)])
def test_what_stands_in_the_pose_that_was_asked_for_does_not_roll(name, topple_deg):
    about = describe_object(parse_object(f"{name},pose=1"))
    assert about.pose == 1
    assert math.degrees(about.profile.topple_angle) == pytest.approx(topple_deg, abs=1)


@pytest.mark.parametrize(
    ("collides", "is_drawn"), [("0", "1"), ("2", "2"), ("3", "2"), ("4", "2"), ("3", "4"), ("5", "0")]
)
def test_a_copy_that_is_only_drawn_or_only_collides_has_no_volume_of_its_own(tmp_path, collides, is_drawn):
    geom = '<geom type="cylinder" size="0.03 0.1"'
    file = tmp_path / "object.xml"
    file.write_text(
        f'<mujoco><worldbody><body>{geom} mass="0.3" group="{collides}"/>'
        f'{geom} mass="0" contype="0" conaffinity="0" group="{is_drawn}"/></body></worldbody></mujoco>'
    )
    about = describe_object(load_mjcf(str(file)))
    # Where nothing is drawn, what collides counts.
    assert about.volume == pytest.approx(CYLINDER, rel=1e-9)
