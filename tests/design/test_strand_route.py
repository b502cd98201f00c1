"""The gripper's cables run along the axis in hollow joints, and as two balanced legs beside the solid ones."""

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.design.strand_route import find_strand_route

LARGE = presets.get("paper-large-grip")


def test_thick_joints_are_hollow_and_thin_ones_solid():
    route = find_strand_route(LARGE)
    assert 0 < route.first_solid < LARGE.n_joint


def test_the_groups_run_at_right_angles_to_each_other():
    close, open_ = find_strand_route(LARGE).leg_directions()
    assert close @ open_ == pytest.approx(0.0, abs=1e-15)
    assert np.linalg.norm(close) == np.linalg.norm(open_) == pytest.approx(1.0)
