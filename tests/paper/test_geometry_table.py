"""The robot's numbers as its authors print or compute them, to the last digit that they give.

"paper" is Huang et al., "Grasping by Spiraling", npj Robotics 2025; "authors' code" is their MATLAB forward kinematics.
"""

import math

import numpy as np
import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.rules import design_from_rules, graspable_range, payload
from spiraltrunk.model.kinematics import cables

SOLID = PAPER.solid
MM = 1e3

AUTHORS = {
    "b": (PAPER.spiral.b, 0.16, 0),
    "k": (PAPER.k, 0.68297, 5e-6),
    "k_p": (PAPER.k_p, 0.919637, 5e-7),
    "section angle, deg": (math.degrees(PAPER.delta_theta), 30, 1e-12),
    "sections": (PAPER.n_section, 18, 0),
    "joints": (PAPER.n_joint, 17, 0),
    "cables": (PAPER.n_cable, 3, 0),
    "backbone from, deg": (math.degrees(PAPER.theta_base), 630, 1e-12),
    "backbone to, deg": (math.degrees(PAPER.theta_tip), 90, 1e-12),
    "a, mm": (PAPER.spiral.a * MM, 26.1313, 5e-5),
    "R_soft": (SOLID.radius / PAPER.spiral.a, 1.68380, 5e-6),
    "section 1, mm": (SOLID.length * MM, 52.1271, 5e-5),
    "sum of the sections, mm": (PAPER.length * MM, 505.06, 5e-3),
    "arc length, mm": (PAPER.arc_length * MM, 510.88, 5e-3),
    "radius of section 1, mm": (SOLID.radius * MM, 44, 1e-12),
    "tip width, mm": (PAPER.tip_width * MM, 21.3, 5e-2),
    "face angle, deg": (90 - math.degrees(SOLID.lean_proximal), 66.12, 5e-3),
    "lean of the proximal face, deg": (math.degrees(SOLID.lean_proximal), 23.88, 5e-3),
    "lean of the distal face, deg": (math.degrees(SOLID.lean_distal), 6.12, 5e-3),
    "gap between faces, deg": (math.degrees(SOLID.lean_proximal + SOLID.lean_distal), 30.00, 1e-12),
    "joint limit, deg": (math.degrees(PAPER.joint_limit), 30, 1e-12),
    # The authors round the face angle to 66.12 deg (66.1201 deg here), which moves the corners by up to 1.3e-4 mm.
    "proximal corner, mm": (SOLID.rim_start * MM, 19.4797, 2e-4),
    "distal corner, mm": (SOLID.rim_end * MM, 47.4093, 2e-4),
    "hole fraction": (PAPER.cable.hole_fraction, 0.6, 0),
    "proximal hole along, mm": (PAPER.hole_position[0, 0, 0] * MM, 11.688, 5e-4),
    "proximal hole out, mm": (PAPER.hole_position[0, 0, 1] * MM, 26.4, 1e-12),
    "distal hole along, mm": (PAPER.hole_position[0, 1, 0] * MM, 49.296, 5e-4),
    "distal hole out, mm": (PAPER.hole_position[0, 1, 1] * MM, 26.4, 1e-12),
    "cable in section 1, mm": (PAPER.cable_in_section[0] * MM, 37.6085, 1e-4),
    "hole to joint 1, mm": (PAPER.hole_to_joint[0] * MM, 26.55, 5e-3),
    "hole to joint 0, mm": (PAPER.hole_to_joint[0] / PAPER.k_p * MM, 28.87, 5e-3),
    "gap cable of joint 1, mm": (PAPER.straight_gap[0] * MM, 13.74, 5e-3),
    "joint radius, mm": (PAPER.joint.radius * MM, 3.825, 1e-12),
    "joint length, mm": (PAPER.joint.length * MM, 2.10, 1e-12),
    "stiffness of joint 1, N m/rad": (PAPER.joint_stiffness[0], 1.353, 5e-4),
    "centre of mass fraction": (PAPER.section_center[0] / SOLID.length, 0.55797, 5e-6),
    "gripper mass, g": (PAPER.gripper.mass * MM, 3.2, 1e-12),
}
"""Quantity: ours, the authors' code, half the last digit that is known of it."""

PAPERS = {
    "k_p": (PAPER.k_p, 0.9196, 5e-5),
    "Young's modulus, MPa": (PAPER.joint.youngs_modulus / 1e6, 16.9, 1e-12),
    "gripper fingers": (PAPER.gripper.n_finger, 3, 0),
    "gripper b": (PAPER.gripper.b, 0.618, 0),
    "gripper angle, deg": (math.degrees(PAPER.gripper.delta_theta), 60, 1e-12),
    "gripper grasps about, mm": (PAPER.gripper.grasp_width * MM, 40, 1.5),
    # The paper prints 33 mm, its HJ rounded; from the authors' numbers it is 32.62 mm.
    "smallest object, mm": (graspable_range(PAPER).minimum * MM, 33, 0.5),
    "smallest object by its formula, mm": (graspable_range(PAPER).minimum * MM, 32.62, 5e-3),
    # The paper prints 267 mm; half a turn along the arc of the authors' backbone gives 267.9 mm.
    "largest object, mm": (graspable_range(PAPER).maximum * MM, 267, 1.0),
    "largest object along the arc, mm": (graspable_range(PAPER).maximum * MM, 267.9, 5e-2),
    "payload, kg": (payload(PAPER), 4.89, 5e-3),
    # The paper pulls 26 steps of 5 mm for a full curl; the 17 gaps add up to 129.858 mm.
    "full curl, mm": (PAPER.cable_stroke * MM, 130, 0.5),
    "sum of the gap cables, mm": (PAPER.cable_stroke * MM, 129.858, 5e-4),
}
"""Quantity: ours, the paper or what its formula gives, half the last digit."""

MASSES_G = [26, 21.3, 20.4, 14.2, 11.3, 9.7, 7.7, 9.7, 8.5, 7, 5.6, 4.7, 3.5, 3, 2.3, 2, 1.4]
"""Authors' code, sections 2 to 18."""


@pytest.mark.parametrize("quantity", AUTHORS)
def test_authors_code(quantity):
    ours, theirs, tolerance = AUTHORS[quantity]
    assert ours == pytest.approx(theirs, rel=0, abs=tolerance)


@pytest.mark.parametrize("quantity", PAPERS)
def test_paper(quantity):
    ours, theirs, tolerance = PAPERS[quantity]
    assert ours == pytest.approx(theirs, rel=0, abs=tolerance)


def test_m_of_the_paper_gives_its_spiral():
    """Paper, Methods: m = 1.53; digits from its equations, the authors then round b to 0.16."""
    design = design_from_rules(m=1.53)
    assert design.spiral.b == pytest.approx(0.160094, abs=5e-7)
    assert design.k == pytest.approx(0.682857, abs=5e-7)
    assert design.k_p == pytest.approx(0.919592, abs=5e-7)


def test_series_along_the_trunk_go_with_k_p():
    """Authors' code: each length is its first times k_p^(n-1), stiffness goes with k_p^3."""
    powers = 0.919637411925784 ** np.arange(18)
    np.testing.assert_allclose(PAPER.section_length * MM, 52.1271 * powers, atol=5e-5)
    np.testing.assert_allclose(PAPER.section_radius * MM, 44 * powers, rtol=1e-12)
    np.testing.assert_allclose(PAPER.cable_in_section * MM, 37.6085 * powers, atol=1e-4)
    np.testing.assert_allclose(PAPER.straight_gap * MM, 13.74 * powers[:17], atol=5e-3)
    np.testing.assert_allclose(PAPER.hole_to_joint * MM, 28.87 * powers[1:], atol=5e-3)
    np.testing.assert_allclose(PAPER.joint_stiffness, 1.353 * powers[:17] ** 3, atol=5e-4)


def test_masses_of_the_sections():
    np.testing.assert_allclose(PAPER.section_mass[1:] * MM, MASSES_G, rtol=1e-14)
    assert PAPER.section_mass[0] * MM == pytest.approx(MASSES_G[0] / PAPER.k_p**3, abs=0.5)
    assert PAPER.mass.center_fraction == 26.749 / 47.94


def test_cable_1_is_dorsal_and_the_others_120_deg_on():
    np.testing.assert_allclose(np.degrees(PAPER.cable.angles), [0, 120, 240], rtol=1e-14)
    np.testing.assert_allclose(PAPER.cable_direction[0], [0, 1, 0], atol=1e-15)


def test_a_full_curl_takes_the_26_steps_of_the_paper():
    bend = np.tile([0.0, math.radians(30.0)], (17, 1))
    assert cables.lengths(PAPER, bend).change[0] * MM == pytest.approx(26 * 5, abs=0.5)


def test_the_smallest_object_is_m_times_the_tip():
    """Paper, Methods, HJ = m GH, with GH and HJ at theta_min = pi/2 - 2 pi and a, b of the authors' code."""
    a, b, theta_min = 26.1313, 0.16, math.pi / 2 - 2 * math.pi
    tip = a * math.exp(b * theta_min) * (math.exp(2 * math.pi * b) - 1)
    smallest = a * math.exp(b * theta_min) * (1 + math.exp(math.pi * b))
    assert PAPER.tip_width * MM == pytest.approx(tip, rel=2e-6)
    assert graspable_range(PAPER).minimum * MM == pytest.approx(smallest, rel=2e-6)
    assert smallest / tip == pytest.approx(1.53, abs=2e-3)
