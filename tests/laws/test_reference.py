"""Laws of the paper's forward model, on drawn designs, pulls and inclinations."""

import math
from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.rules import design_from_rules
from spiraltrunk.model import reference
from spiraltrunk.model.kinematics import cables
from spiraltrunk.model.kinematics.shape import Status
from spiraltrunk.model.reference.constants import gravity_moment_term, rest_stiffness

HANGING = math.pi / 2
SHARE = st.floats(0.0, 1.0)
TILT = st.floats(-math.pi, math.pi)
EXACT = st.just(False)
WAYS = st.booleans()


@st.composite
def designs(draw):
    """Trunks of any growth, section angle, hole circle and weight: from one that hardly sags to one that hits stops."""
    parts = draw(st.sampled_from([4, 6, 9]))
    design = design_from_rules(
        b=draw(st.floats(0.08, 0.3)), delta_theta=math.pi / parts, turns=draw(st.sampled_from([1.0, 1.5, 2.0]))
    )
    cable = replace(design.cable, hole_fraction=draw(st.floats(0.3, 0.9)))
    mass = replace(design.mass, density=draw(st.sampled_from([1.0, 200.0, 5e3])))
    return replace(design, cable=cable, mass=mass)


def bends(shape):
    """Bends about z, dorsal positive."""
    return np.arctan2(shape.joint_rotation[..., 1, 0], shape.joint_rotation[..., 0, 0])


def ventral_stroke(design):
    return float(2 * design.hole_to_joint.sum() * math.sin(design.joint_limit)) - design.cable_stroke


@given(designs(), TILT)
def test_rest_balances_every_joint_or_presses_it_on_its_stop(design, theta_0):
    shape = reference.rest(design, theta_0, as_authors=False)
    assert shape.status == Status.CONVERGED
    sag = -bends(shape)
    weight, stiffness = gravity_moment_term(design), rest_stiffness(design)
    load = np.cumsum((weight * np.cos(theta_0 + np.cumsum(sag)))[::-1])[::-1]
    excess = load - stiffness * sag
    held = np.abs(sag) >= design.joint_limit * (1 - 1e-12)
    scale = stiffness + np.abs(load)
    np.testing.assert_array_less(np.abs(excess[~held]) / scale[~held], 1e-9)
    assert (excess[held] * np.sign(sag[held]) >= -1e-9 * scale[held]).all()


@given(designs(), TILT)
def test_rest_is_a_minimum_of_the_energy(design, theta_0):
    sag = -bends(reference.rest(design, theta_0, as_authors=False))
    weight, stiffness = gravity_moment_term(design), rest_stiffness(design)

    def energy(q):
        return (0.5 * stiffness * q**2 - weight * np.sin(theta_0 + np.cumsum(q, axis=-1))).sum(axis=-1)

    near = sag + np.random.default_rng(0).uniform(-1e-3, 1e-3, (50, len(sag)))
    near = np.clip(near, -design.joint_limit, design.joint_limit)
    assert (energy(near) >= energy(sag) - 1e-12 * (1 + abs(energy(sag)))).all()


@given(designs(), st.floats(-1.4, 1.5))
def test_rest_is_mirrored_by_a_mirrored_inclination(design, theta_0):
    """What sags to one side of the vertical sags as much to the other."""
    here, there = (reference.rest(design, angle) for angle in (theta_0, math.pi - theta_0))
    np.testing.assert_allclose(there.points * [-1, 1, 1], here.points, rtol=0, atol=1e-7 * design.length)


@given(designs(), SHARE, SHARE, TILT)
def test_the_plane_stays_a_plane(design, dorsal, ventral, theta_0):
    pulls = dorsal * design.cable_stroke, ventral * ventral_stroke(design)
    shapes = [reference.bend_dorsal(design, pulls[0], theta_0), reference.bend_ventral(design, pulls[1], theta_0)]
    for shape in (*shapes, reference.rest(design, theta_0)):
        assert (shape.points[:, 2] == 0).all()
        np.testing.assert_allclose(shape.gap[:, 1], shape.gap[:, 2], rtol=0, atol=1e-13)


@given(designs(), SHARE, SHARE, TILT)
def test_more_pull_curls_every_joint_more(design, one, other, theta_0):
    less, more = sorted([one, other])
    pulls = np.array([less, more])
    curl = bends(reference.bend_dorsal(design, pulls * design.cable_stroke, theta_0))
    assert (curl[1] >= curl[0] - 1e-12).all()
    curl = bends(reference.bend_ventral(design, pulls * ventral_stroke(design), theta_0, as_authors=False))
    assert (curl[1] <= curl[0] + 1e-7).all()


@given(designs(), SHARE, TILT)
def test_every_bit_of_the_dorsal_pull_is_in_the_gaps(design, share, theta_0):
    pull = share * design.cable_stroke
    start = reference.rest(design, theta_0, as_authors=False).gap[:, 0].sum()
    shape = reference.bend_dorsal(design, pull, theta_0, as_authors=False)
    taken = start - shape.gap[:, 0].sum()
    assert math.isclose(taken, min(pull, start), rel_tol=0, abs_tol=1e-8 * design.cable_stroke)
    assert (shape.status == Status.ALL_SHUT) == (pull - start > 1e-4 * design.cable_stroke)


@given(designs(), SHARE, TILT)
def test_every_bit_of_the_lengthening_is_in_the_gaps(design, share, theta_0):
    pull = share * ventral_stroke(design)
    start = reference.rest(design, theta_0, as_authors=False).gap[:, 0].sum()
    shape = reference.bend_ventral(design, pull, theta_0, as_authors=False)
    room = design.cable_stroke + ventral_stroke(design) - start
    given_out = shape.gap[:, 0].sum() - start
    assert math.isclose(given_out, min(pull, room), rel_tol=0, abs_tol=1e-8 * design.cable_stroke)
    assert (shape.status == Status.ALL_SHUT) == (pull - room > 1e-4 * design.cable_stroke)


@given(designs(), SHARE, SHARE, TILT)
def test_every_bit_of_the_second_pull_is_in_the_gaps(design, first, second, theta_0):
    first, second = first * design.cable_stroke, second * design.cable_stroke
    before = reference.bend_dorsal(design, first, theta_0, as_authors=False)
    after = reference.twist(design, first, second, theta_0, as_authors=False)
    taken = after.cable_change[1] - before.cable_change[1]
    assert taken <= second + 1e-8 * design.cable_stroke
    if after.status == Status.CONVERGED:
        assert math.isclose(taken, second, rel_tol=0, abs_tol=1.1e-4 * design.cable_stroke)


@given(designs(), SHARE, SHARE, TILT, WAYS)
def test_no_limit_is_passed(design, first, second, theta_0, as_authors):
    most = design.joint_limit * (1 + 1e-9)
    pull = first * design.cable_stroke
    for shape in (
        reference.rest(design, theta_0, as_authors=as_authors),
        reference.bend_dorsal(design, pull, theta_0, as_authors=as_authors),
        reference.bend_ventral(design, first * ventral_stroke(design), theta_0, as_authors=as_authors),
        reference.twist(design, pull, second * design.cable_stroke, theta_0, as_authors=as_authors),
    ):
        along = shape.joint_rotation[:, :, 0]
        angle = np.arctan2(np.hypot(along[:, 1], along[:, 2]), along[:, 0])
        assert angle.max() <= most
        np.testing.assert_allclose(shape.joint_angle, angle, rtol=0, atol=1e-12)


@given(designs(), SHARE, TILT, WAYS)
def test_a_twist_by_nothing_is_a_bend(design, share, theta_0, as_authors):
    pull = share * design.cable_stroke
    bend = reference.bend_dorsal(design, pull, theta_0, as_authors=as_authors)
    twist = reference.twist(design, pull, 0.0, theta_0, as_authors=as_authors)
    for name in ("points", "joint_rotation", "gap", "cable_change", "joint_angle"):
        np.testing.assert_allclose(getattr(twist, name), getattr(bend, name), rtol=0, atol=1e-14)
    assert (twist.is_shut == bend.is_shut).all()
    assert twist.status == bend.status


@given(designs(), SHARE, SHARE, TILT, WAYS)
def test_the_second_cable_leaves_the_first_and_the_rigid_joints_alone(design, first, second, theta_0, as_authors):
    pull = first * design.cable_stroke
    bend = reference.bend_dorsal(design, pull, theta_0, as_authors=as_authors)
    twist = reference.twist(design, pull, second * design.cable_stroke, theta_0, as_authors=as_authors)
    np.testing.assert_allclose(twist.gap[:, 0], bend.gap[:, 0], rtol=0, atol=1e-12)
    rigid = int(reference.first_shut(bend)) - 1
    np.testing.assert_allclose(twist.joint_rotation[rigid:], bend.joint_rotation[rigid:], rtol=0, atol=1e-14)
    assert (twist.gap[:, 1] <= bend.gap[:, 1] + 1e-12).all()


@given(designs(), SHARE)
def test_the_tip_curls_first(design, share):
    """A hanging trunk of one material: no joint bends more than the next one towards the tip."""
    for way in (True, False):
        curl = bends(reference.bend_dorsal(design, share * design.cable_stroke, HANGING, as_authors=way))
        assert (np.diff(curl) >= -1e-12).all()


@given(designs(), SHARE, SHARE, TILT)
def test_cables_are_those_of_the_exact_geometry(design, first, second, theta_0):
    shape = reference.twist(design, first * design.cable_stroke, second * design.cable_stroke, theta_0)
    exact = cables.lengths_from_rotations(design, shape.joint_rotation)
    np.testing.assert_allclose(shape.gap, exact.gap, rtol=0, atol=1e-13)
    np.testing.assert_allclose(shape.cable_change, exact.change, rtol=0, atol=1e-13)
    c, s = math.cos(theta_0), math.sin(theta_0)
    base = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    np.testing.assert_allclose(shape.points, exact.points @ base.T, rtol=0, atol=1e-13)


@given(st.floats(0.1, 6.0), SHARE, SHARE)
def test_a_hanging_trunk_scales(factor, first, second):
    """No length but the trunk's own decides its shape where gravity does not bend it."""
    small = design_from_rules(b=0.16)
    large = design_from_rules(b=0.16, arm_radius=0.044 * factor)
    pulls = np.array([first, second]) * small.cable_stroke
    one = reference.twist(small, *pulls, HANGING)
    other = reference.twist(large, *pulls * factor, HANGING)
    np.testing.assert_allclose(other.points, factor * one.points, rtol=0, atol=1e-6 * factor)


@settings(max_examples=20)
@given(st.lists(st.tuples(SHARE, SHARE, TILT), min_size=1, max_size=8), WAYS)
def test_a_batch_is_its_shapes_to_the_bit(rows, as_authors):
    first, second, theta_0 = np.array(rows).T
    first, second = first * PAPER.cable_stroke, second * PAPER.cable_stroke
    pairs = [
        (reference.rest, (theta_0,)),
        (reference.bend_dorsal, (first, theta_0)),
        (reference.bend_ventral, (first * 0.9, theta_0)),
        (reference.twist, (first, second, theta_0)),
    ]
    for law, given_ in pairs:
        batch = law(PAPER, *given_, as_authors=as_authors)
        for i, row in enumerate(zip(*given_, strict=True)):
            single = law(PAPER, *map(float, row), as_authors=as_authors)
            for name in ("points", "joint_rotation", "joint_angle", "gap", "cable_change", "is_shut", "status"):
                np.testing.assert_array_equal(getattr(batch, name)[i], getattr(single, name))
