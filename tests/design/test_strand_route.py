"""The gripper's cables run along the axis in hollow joints, and as two balanced legs beside the solid ones."""

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.design.strand_route import HOLE_PITCH, find_strand_route

LARGE = presets.get("paper-large-grip")


def test_thick_joints_are_hollow_and_thin_ones_solid():
    route = find_strand_route(LARGE)
    assert 0 < route.first_solid < LARGE.n_joint


def test_the_holes_of_the_groups_keep_their_distance():
    route = find_strand_route(LARGE)
    close, open_ = route.aside * route.leg_directions()
    assert np.linalg.norm(close - open_) == pytest.approx(HOLE_PITCH)
    assert np.linalg.norm(close) == pytest.approx(route.aside)
    assert abs(close[1]) > abs(close[0])
