"""The tip gripper: its fingers are spirals too."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.design import GripperDesign
from spiraltrunk.errors import DesignError

GRIPPERS = st.builds(
    GripperDesign,
    b=st.floats(0.01, 1.9),
    delta_theta=st.floats(0.1, 1.5),
    n_phalanx=st.integers(1, 8),
    finger_length=st.floats(1e-3, 1.0),
)


@given(GRIPPERS)
def test_phalanges_make_up_the_finger(gripper):
    assert gripper.phalanx_length.shape == (gripper.n_phalanx,)
    assert gripper.phalanx_length.sum() == pytest.approx(gripper.finger_length, rel=1e-12)


@given(GRIPPERS)
def test_every_phalanx_is_k_p_times_the_one_before(gripper):
    lengths, stiffness = gripper.phalanx_length, gripper.joint_stiffness
    assert gripper.k_p == pytest.approx(math.exp(-gripper.b * gripper.delta_theta), rel=1e-15)
    np.testing.assert_allclose(lengths[1:], gripper.k_p * lengths[:-1], rtol=1e-12)
    np.testing.assert_allclose(stiffness[1:], gripper.k_p**3 * stiffness[:-1], rtol=1e-12)
    assert stiffness[0] == gripper.stiffness


@given(GRIPPERS)
def test_fingers_never_get_thinner_than_a_quarter(gripper):
    width = gripper.phalanx_width
    assert width[0] == gripper.finger_width
    assert (width >= gripper.finger_width / 4).all()
    assert (np.diff(width) <= 0).all()


@given(GRIPPERS, st.floats(0.1, 9.0))
def test_a_scaled_gripper_is_of_the_same_material(gripper, factor):
    """Stress = tension over area, bending strain and density stay: lengths f, forces f^2, stiffness and mass f^3."""
    large = gripper.scaled(factor)
    powers = {"finger_length": 1, "finger_width": 1, "mount_radius": 1, "mass": 3, "stiffness": 3, "tension_max": 2}
    for name, power in powers.items():
        assert getattr(large, name) == pytest.approx(factor**power * getattr(gripper, name), rel=1e-12), name
    assert replace(large, **{name: getattr(gripper, name) for name in powers}) == gripper
    assert large.grasp_width == pytest.approx(factor * gripper.grasp_width, rel=1e-12)


def test_the_paper_gripper_grasps_about_40_mm():
    """Paper, Results: three fingers, golden ratio, 60 deg, objects up to about 40 mm."""
    gripper = GripperDesign()
    assert (gripper.n_finger, gripper.b) == (3, 0.618)
    assert math.degrees(gripper.delta_theta) == pytest.approx(60.0)
    assert gripper.grasp_width == pytest.approx(0.040, abs=1.5e-3)


@pytest.mark.parametrize("factor", [0.0, -1.0, math.nan, math.inf, "2"])
def test_impossible_scales_are_refused(factor):
    with pytest.raises(DesignError, match="gripper scale"):
        GripperDesign().scaled(factor)


@pytest.mark.parametrize("scale", [1.25, 1.5, 2.0])
def test_an_enlarged_gripper_is_scaled_and_its_cables_run_on_both_sides(scale):
    large = GripperDesign().enlarged(scale)
    assert large == replace(GripperDesign().scaled(scale), n_leg=2)
    assert large.tension_max == pytest.approx(8.0 * scale**2)


def test_a_scale_of_1_is_the_paper_gripper():
    assert GripperDesign().enlarged(1.0) == GripperDesign()


@pytest.mark.parametrize("scale", [0.99, 2.01, 0.0, -1.5, math.nan, math.inf, "1.5"])
def test_finger_scales_beyond_1_to_2_are_refused(scale):
    with pytest.raises(DesignError, match=r"gripper\.scale is .*; allowed: a finite number, at least 1, at most 2"):
        GripperDesign().enlarged(scale)
