"""The trunk against its own definition: quadrilaterals cut from the two spirals, and self-similarity."""

import math
from contextlib import suppress
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.design import CableDesign, JointDesign, MassDesign, TrunkDesign
from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.rules import design_from_rules
from spiraltrunk.design.spiral import points
from spiraltrunk.errors import DesignError


@st.composite
def trunks(draw):
    """Trunks of the rules, also with a backbone that is not compact, other holes and other cables."""
    design = design_from_rules(
        b=draw(st.floats(0.05, 0.4)),
        delta_theta=math.pi / draw(st.integers(4, 12)),
        arm_radius=draw(st.floats(0.01, 0.2)),
        turns=draw(st.sampled_from([1.0, 1.5, 2.0])),
    )
    cable = CableDesign(
        angles=tuple(np.linspace(0.0, 2 * math.pi, draw(st.integers(2, 6)), endpoint=False).tolist()),
        hole_fraction=draw(st.floats(0.3, 0.9)),
    )
    return replace(design, cable=cable, k=design.k * draw(st.floats(0.9, 1.1)))


def section_corners(design, n):
    """Corners (axial, radial) of section n, cut from the spirals and laid on the straight axis; n = 0 is the base.

    Rows: outer corner of the proximal and of the distal face.
    """
    theta = design.theta_base - np.array([n, n + 1]) * design.delta_theta
    start, end = points(design.backbone, theta)
    axis = (end - start) / np.linalg.norm(end - start)
    corners = points(design.spiral, theta - 2 * math.pi) - start
    across = np.abs(corners @ [-axis[1], axis[0]])
    return np.stack([corners @ axis, across], axis=-1), np.linalg.norm(end - start)


@given(trunks(), st.data())
def test_sections_are_the_quadrilaterals_between_backbone_and_inner_contour(design, data):
    n = data.draw(st.integers(0, design.n_section - 1))
    corners, length = section_corners(design, n)
    solid, scale = design.solid, design.scale[n]
    expected = scale * np.array([[solid.rim_start, solid.radius], [solid.rim_end, solid.radius]])
    assert design.section_length[n] == pytest.approx(length, rel=1e-11)
    np.testing.assert_allclose(corners, expected, rtol=0, atol=1e-11 * length)


@given(trunks(), st.data())
def test_holes_lie_on_the_faces(design, data):
    n = data.draw(st.integers(0, design.n_section - 1))
    (proximal, distal), length = section_corners(design, n)
    part, end = design.cable.hole_fraction, np.array([length, 0.0])
    np.testing.assert_allclose(
        design.hole_position[n], [part * proximal, end + part * (distal - end)], rtol=0, atol=1e-11 * length
    )


@given(trunks())
def test_every_size_is_the_first_times_a_power_of_k_p(design):
    for sizes in (design.section_length, design.section_radius, design.hole_to_joint, design.cable_in_section):
        np.testing.assert_allclose(sizes[1:] / sizes[:-1], design.k_p, rtol=1e-12)
    np.testing.assert_allclose(design.section_mass[1:] / design.section_mass[:-1], design.k_p**3, rtol=1e-12)
    np.testing.assert_allclose(design.joint_stiffness[1:] / design.joint_stiffness[:-1], design.k_p**3, rtol=1e-12)
    np.testing.assert_allclose(design.section_inertia[1:] / design.section_inertia[:-1], design.k_p**5, rtol=1e-12)


@given(trunks())
def test_neighbouring_faces_open_by_the_joint_limit(design):
    assert design.solid.lean_proximal + design.solid.lean_distal == pytest.approx(design.joint_limit, rel=1e-12)


@given(trunks())
def test_both_holes_of_a_gap_are_equally_far_from_its_joint(design):
    axial, ring = design.hole_position[..., 0], design.hole_position[..., 1]
    before = np.hypot(design.section_length[:-1] - axial[:-1, 1], ring[:-1, 1])
    beyond = np.hypot(axial[1:, 0], ring[1:, 0])
    np.testing.assert_allclose(before, design.hole_to_joint, rtol=1e-11)
    np.testing.assert_allclose(beyond, design.hole_to_joint, rtol=1e-11)


@given(trunks())
def test_a_straight_cable_is_as_long_as_its_holes_lie_apart(design):
    axial, ring = design.hole_position[..., 0], design.hole_position[..., 1]
    start = np.concatenate([[0.0], np.cumsum(design.section_length)])[:-1, None]
    along, radial = (start + axial).ravel(), ring.ravel()
    pieces = np.hypot(np.diff(along), np.diff(radial))
    np.testing.assert_allclose(pieces[0::2], design.cable_in_section, rtol=1e-12)
    np.testing.assert_allclose(pieces[1::2], design.straight_gap, rtol=1e-10)
    assert design.cable_stroke == pytest.approx(pieces[1::2].sum(), rel=1e-12)


@given(trunks())
def test_sums_are_geometric_series(design):
    series = (1 - design.k_p**design.n_section) / (1 - design.k_p)
    assert design.length == pytest.approx(design.section_length[0] * series, rel=1e-12)
    assert design.length < design.arc_length


@given(trunks())
def test_the_cone_through_the_face_edges_has_the_taper(design):
    narrowing = design.face_half_width - design.tip_width / 2
    assert math.tan(design.taper / 2) == pytest.approx(narrowing / design.length, rel=1e-11)
    assert design.base_width == pytest.approx(2 * design.section_radius[0])


@given(trunks(), st.floats(0.1, 9.0))
def test_a_larger_spiral_is_a_larger_trunk(design, factor):
    spiral = replace(design.spiral, a=factor * design.spiral.a)
    joint = JointDesign(radius=factor * design.joint.radius, length=factor * design.joint.length)
    large = replace(design, spiral=spiral, joint=joint)
    for name, power in (("length", 1), ("tip_width", 1), ("cable_stroke", 1), ("arc_length", 1), ("taper", 0)):
        assert getattr(large, name) == pytest.approx(factor**power * getattr(design, name), rel=1e-9), name
    np.testing.assert_allclose(large.section_mass, factor**3 * design.section_mass, rtol=1e-9)
    np.testing.assert_allclose(large.joint_stiffness, factor**3 * design.joint_stiffness, rtol=1e-9)


def test_mass_follows_the_density_unless_measured():
    uniform = replace(PAPER, mass=MassDesign(density=1000.0), gripper=None)
    assert uniform.total_mass == pytest.approx(1000.0 * PAPER.solid.volume * (PAPER.scale**3).sum())
    assert uniform.section_center[0] == pytest.approx(PAPER.solid.centroid)
    assert PAPER.total_mass == pytest.approx(sum(PAPER.mass.sections) + PAPER.gripper.mass)
    assert PAPER.section_center[0] / PAPER.section_length[0] == pytest.approx(PAPER.mass.center_fraction)


def test_the_default_density_gives_the_authors_mass():
    uniform = replace(PAPER, mass=MassDesign())
    assert uniform.section_mass.sum() == pytest.approx(PAPER.section_mass.sum(), rel=1e-3)


def test_inertia_follows_from_mass_and_solid():
    axial, transverse = PAPER.section_inertia[0]
    assert axial == pytest.approx(PAPER.section_mass[0] * PAPER.solid.gyration_axial)
    assert transverse == pytest.approx(PAPER.section_mass[0] * PAPER.solid.gyration_transverse)


def test_stiffness_is_e_i_over_l_unless_measured():
    joint = PAPER.joint
    area_moment = math.pi * (2 * joint.radius) ** 4 / 64
    assert PAPER.joint_stiffness[0] == pytest.approx(joint.youngs_modulus * area_moment / joint.length, rel=1e-14)
    measured = replace(PAPER, joint=replace(joint, stiffness=tuple(range(1, 18))))
    assert measured.joint_stiffness.tolist() == list(range(1, 18))


def test_cables_go_from_dorsal_towards_z():
    np.testing.assert_allclose(
        PAPER.cable_direction, [[0, 1, 0], [0, -0.5, math.sqrt(3) / 2], [0, -0.5, -math.sqrt(3) / 2]], atol=1e-15
    )
    assert PAPER.n_cable == 3


def test_a_design_is_a_value():
    twin = design_from_rules(b=0.16, name="paper")
    assert design_from_rules(b=0.16, name="paper") == twin
    assert hash(design_from_rules(b=0.16, name="paper")) == hash(twin)
    with pytest.raises(FrozenInstanceError):
        twin.k = 0.7


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("joint.radius", {"joint": JointDesign(radius=0.027, length=1e-3)}),
        ("joint.length", {"joint": JointDesign(radius=1e-3, length=0.053)}),
        ("joint.stiffness", {"joint": JointDesign(radius=1e-3, length=1e-3, stiffness=(1.0,) * 18)}),
        ("mass.sections", {"mass": MassDesign(sections=(0.1,) * 17)}),
        ("n_section", {"n_section": 200, "delta_theta": 1.5, "spiral": replace(PAPER.spiral, b=1.9)}),
    ],
)
def test_parts_that_do_not_fit_are_refused_by_name(name, change):
    with pytest.raises(DesignError) as caught:
        replace(PAPER, **change)
    assert caught.value.name == name


@given(
    a=st.floats(1e-300, 999.0),
    b=st.floats(1e-300, 1.99),
    part=st.floats(1e-9, 1.0),
    delta_theta=st.floats(1e-300, 1.57),
    n_section=st.integers(2, 200),
)
def test_any_trunk_in_range_is_built_or_refused(a, b, part, delta_theta, n_section):
    inner = math.exp(-2 * math.pi * b)
    spiral = replace(PAPER.spiral, a=a, b=b)
    joint = JointDesign(radius=1e-5, length=1e-5)
    k = inner + part * (1 - inner)
    with suppress(DesignError):
        design = TrunkDesign(name="any", spiral=spiral, k=k, delta_theta=delta_theta, n_section=n_section, joint=joint)
        assert np.isfinite(design.section_length).all()
        assert design.solid.rim_start < design.solid.rim_end


def test_cables_are_at_least_5_deg_apart():
    for first in range(360):
        CableDesign(angles=(math.radians(first), math.radians(first + 5)))
        with pytest.raises(DesignError, match="allowed: cables at least 5 deg apart"):
            CableDesign(angles=(math.radians(first), math.radians(first + 4.999)))
