"""The three design principles, each against the geometry that it is about."""

import math
import re

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from scipy.integrate import quad

from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.rules import (
    GRAVITY,
    LEAST_TIP_WIDTH,
    RANGES,
    build_bare,
    compactness,
    design_from_rules,
    graspable_range,
    growth_from_overlap,
    payload,
)
from spiraltrunk.design.spiral import points, radius
from spiraltrunk.errors import DesignError

OVERLAPS = st.floats(0.5, 3.0)


@given(st.floats(0.01, 100.0))
def test_growth_is_the_inverse_of_the_overlap(m):
    assert 1 / math.expm1(math.pi * growth_from_overlap(m)) == pytest.approx(m, rel=1e-9)


@given(st.floats(0.01, 1.0))
def test_the_compact_backbone_is_midway_between_successive_turns(b):
    """Principle 1: what lies inside the backbone of one turn is as wide as what lies outside it."""
    inner = math.exp(-2 * math.pi * b)
    assert compactness(b) - inner == pytest.approx(1 - compactness(b), rel=1e-12)


@given(OVERLAPS)
def test_smallest_object_is_m_times_the_tip(m):
    """Principle 2: the trunk's smallest object is the gripper's largest, HJ = m GH."""
    design = design_from_rules(m=m)
    assert graspable_range(design).minimum == pytest.approx(m * design.tip_width, rel=1e-12)


@given(OVERLAPS)
def test_smallest_object_is_the_room_in_the_tips_inner_turn(m):
    """GH and HJ as distances of points of the contour (paper, figure 4a), with theta_min = pi/2 - 2 pi."""
    design = design_from_rules(m=m)
    theta_min = math.pi / 2 - 2 * math.pi
    end, half, full = points(design.spiral, theta_min + math.pi * np.arange(3))
    assert np.linalg.norm(full - end) == pytest.approx(design.tip_width, rel=1e-12)
    assert np.linalg.norm(half - end) == pytest.approx(graspable_range(design).minimum, rel=1e-12)


@given(OVERLAPS, st.sampled_from([4, 6, 8, 12]), st.sampled_from([1.0, 1.5, 2.0]))
def test_largest_object_takes_half_a_turn_of_the_whole_trunk(m, parts, turns):
    design = design_from_rules(m=m, delta_theta=math.pi / parts, turns=turns)
    largest = graspable_range(design).maximum
    k, half = design.k, design.k - math.exp(-2 * math.pi * design.spiral.b)

    def turn_per_angle(theta):
        r = float(radius(design.spiral, theta))
        return k * r * math.hypot(1.0, design.spiral.b) / ((largest + 2 * half * r) / 2)

    turn, _ = quad(turn_per_angle, design.theta_tip, design.theta_base, epsabs=1e-12)
    assert turn == pytest.approx(math.pi, rel=1e-9)


@given(OVERLAPS, st.floats(0.005, 0.2), st.sampled_from([3, 4, 5, 6, 9, 12]))
def test_section_one_matches_the_arm(m, arm_radius, parts):
    """Principle 3."""
    design = design_from_rules(m=m, arm_radius=arm_radius, delta_theta=math.pi / parts)
    assert design.section_radius[0] == pytest.approx(arm_radius, rel=1e-12)
    assert design.n_section == 3 * parts
    assert design.theta_base - design.theta_tip == pytest.approx(3 * math.pi, rel=1e-12)


@given(st.floats(0.2, 5.0))
def test_the_graspable_range_grows_with_the_arm(factor):
    small, large = design_from_rules(), design_from_rules(arm_radius=0.044 * factor)
    assert graspable_range(large) == pytest.approx(np.multiply(factor, graspable_range(small)), rel=1e-9)
    assert graspable_range(small).minimum < graspable_range(small).maximum


def test_m_is_the_papers_unless_given():
    assert design_from_rules().spiral.b == growth_from_overlap(1.53)
    assert design_from_rules(b=0.16).spiral.b == 0.16


def test_rules_and_preset_agree_on_the_paper():
    design = design_from_rules(b=0.16)
    assert design.spiral == PAPER.spiral
    assert design.joint.radius == pytest.approx(PAPER.joint.radius, rel=1e-14)
    assert design.joint.length == pytest.approx(PAPER.joint.length, rel=1e-14)
    assert design.gripper.mass == pytest.approx(PAPER.gripper.mass, rel=1e-3)


def test_payload_meets_the_published_number_and_falls_with_width():
    """4.89 kg at the smallest object (paper, Results)."""
    assert payload(PAPER) == pytest.approx(4.89, abs=0.005)
    assert payload(PAPER) == payload(PAPER, graspable_range(PAPER).minimum)
    widths = np.linspace(0.01, 0.3, 20)
    assert (np.diff([payload(PAPER, width) for width in widths]) < 0).all()


def test_payload_balances_tension_and_weight():
    lever = (0.1 + PAPER.base_width) / 2
    strongest = PAPER.cable.tension_max * PAPER.hole_to_joint[0]
    ratio = payload(PAPER, 0.1) * GRAVITY * lever / strongest
    assert ratio == pytest.approx(payload(PAPER, 0.2) * GRAVITY * (lever + 0.05) / strongest, rel=1e-12)


@pytest.mark.parametrize("angle_deg", [31.0, 25.0, 50.0, 89.0])
def test_an_angle_that_leaves_a_rest_is_refused_with_angles_that_do_not(angle_deg):
    with pytest.raises(DesignError, match="divides 540 deg into whole sections") as caught:
        design_from_rules(delta_theta=math.radians(angle_deg))
    offered = [float(word) for word in str(caught.value).replace("(", "").split() if word.replace(".", "").isdigit()]
    below, count = offered[-4], offered[-3]
    assert below * count == pytest.approx(540.0, rel=1e-4)
    assert caught.value.name == "delta_theta"


@pytest.mark.parametrize(
    ("name", "wish"),
    [
        ("m", {"m": 1.53, "b": 0.16}),
        ("m", {"m": 0.0}),
        ("m", {"m": math.nan}),
        ("m", {"m": "1.53"}),
        ("b", {"b": -0.16}),
        ("b", {"b": 2.0}),
        ("b", {"b": True}),
        ("arm_radius", {"arm_radius": 0.0}),
        ("arm_radius", {"arm_radius": math.inf}),
        ("delta_theta", {"delta_theta": 0.0}),
        ("delta_theta", {"delta_theta": math.pi}),
        ("turns", {"turns": 0.0}),
        ("turns", {"turns": 10**400}),
        ("turns", {"turns": 1 / 12}),
    ],
)
def test_impossible_wishes_are_refused_by_name(name, wish):
    with pytest.raises(DesignError) as caught:
        design_from_rules(**wish)
    assert caught.value.name == name


def inside(name):
    """Numbers from end to end of the range that the rules state."""
    allowed = RANGES[name]
    return np.geomspace(allowed.least, allowed.most, 40).clip(allowed.least, allowed.most).tolist()


@pytest.mark.parametrize("name", ["m", "b", "arm_radius"])
def test_every_wish_inside_its_range_gives_a_trunk_that_grasps(name):
    for value in inside(name):
        smallest, largest = graspable_range(design_from_rules(**{name: value}))
        assert 0 < smallest < largest


def test_all_turns_of_whole_sections_inside_the_range_give_a_trunk_that_grasps():
    allowed = RANGES["turns"]
    for n_section in range(round(12 * allowed.least), round(12 * allowed.most) + 1):
        smallest, largest = graspable_range(design_from_rules(turns=n_section / 12))
        assert 0 < smallest < largest


@pytest.mark.parametrize("n_section", range(7, 201))
def test_all_angles_that_divide_the_turns_give_a_trunk_that_grasps(n_section):
    design = design_from_rules(delta_theta=3 * math.pi / n_section)
    assert design.n_section == n_section
    assert 0 < graspable_range(design).minimum < graspable_range(design).maximum


def test_a_trunk_too_short_for_half_a_turn_round_its_smallest_object_wraps_nothing():
    ranges = [graspable_range(build_bare(0.16, math.pi / 6, n_section, a=0.026)) for n_section in range(2, 20)]
    assert [widths.is_empty for widths in ranges] == sorted((widths.is_empty for widths in ranges), reverse=True)
    assert ranges[0].is_empty
    assert not ranges[-1].is_empty
    for widths in ranges:
        assert widths.maximum == 0.0 if widths.is_empty else widths.maximum >= widths.minimum > 0


@pytest.mark.parametrize("name", RANGES)
def test_a_wish_just_outside_its_range_is_refused_with_the_range(name):
    allowed = RANGES[name]
    for value in (allowed.above, 0.999 * allowed.least, 1.001 * allowed.most, allowed.below):
        if math.isfinite(value):
            with pytest.raises(DesignError, match="allowed: a finite number, ") as caught:
                design_from_rules(**{name: value})
            assert caught.value.name == name


@example(turns=1.9999999999999991, angle_deg=81.0)
@given(turns=st.floats(0.75, 5.0), angle_deg=st.floats(10.0, 89.9))
def test_an_angle_that_is_offered_works(turns, angle_deg):
    try:
        design_from_rules(b=0.05, turns=turns, delta_theta=math.radians(angle_deg))
    except DesignError as error:
        offered = re.findall(r"([0-9.]+) deg \((\d+) sections\)", str(error.allowed))
        assert offered
        for angle, count in offered:
            design = design_from_rules(b=0.05, turns=turns, delta_theta=math.radians(float(angle)))
            assert design.n_section == int(count)


@given(
    b=st.floats(0.03, 0.6), n_section=st.integers(2, 200), turns=st.floats(0.75, 5.0), arm_radius=st.floats(0.001, 0.3)
)
def test_wishes_inside_their_ranges_give_a_trunk_unless_tip_or_sections_are_too_small(b, n_section, turns, arm_radius):
    delta_theta = 2 * math.pi * turns / n_section
    assume(delta_theta < math.pi / 2)
    refused = ""
    try:
        design = design_from_rules(b=b, turns=turns, delta_theta=delta_theta, arm_radius=arm_radius)
        assert design.tip_width >= LEAST_TIP_WIDTH
    except DesignError as error:
        refused = error.name
    assert refused in ("", "width of the tip", "length of section 1")


def test_wishes_that_leave_no_tip_are_refused_with_the_reason():
    with pytest.raises(DesignError, match=r"width of the tip is 8.13e-07 mm; allowed: at least 0.1 mm: fewer turns"):
        design_from_rules(b=0.6, turns=5)
    with pytest.raises(DesignError, match=r"width of the tip"):
        design_from_rules(b=0.6, arm_radius=0.005)


@pytest.mark.parametrize("width", [0.0, -1.0, math.nan, math.inf, "wide"])
def test_payload_refuses_impossible_widths(width):
    with pytest.raises(DesignError, match="width"):
        payload(PAPER, width)


@pytest.mark.parametrize("given", ["paper", None])
def test_what_is_no_design_has_neither_range_nor_payload(given):
    for figure in (graspable_range, payload):
        with pytest.raises(DesignError, match=r"^design is .*; allowed: TrunkDesign$"):
            figure(given)
