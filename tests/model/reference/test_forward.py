"""The forward model's inputs, batches and branches, and Algorithms 1 and 2 written out a second time."""

import gc
import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.rules import design_from_rules
from spiraltrunk.errors import ModelError
from spiraltrunk.model import reference
from spiraltrunk.model.kinematics.cables import hole_positions
from spiraltrunk.model.kinematics.shape import Status
from spiraltrunk.model.reference import constants, forward, gravity_rest
from spiraltrunk.model.reference.algorithm_1 import arcsine
from spiraltrunk.model.reference.constants import gravity_moment_term, prepare, read_table, rest_stiffness

HANGING = math.pi / 2
FIELDS = ("points", "joint_rotation", "joint_angle", "gap", "cable_change", "is_shut", "status")
VENTRAL_STROKE = float(PAPER.hole_to_joint.sum()) - PAPER.cable_stroke
"""Full ventral curl of a trunk with a limit of 30 deg: 2 R (sin 30 deg - sin 15 deg)."""


def bends(shape):
    return np.arctan2(shape.joint_rotation[..., 1, 0], shape.joint_rotation[..., 0, 0])


# The two algorithms, in plain words.


def plain_pull(level, portion, room):
    """Length that each gap takes, from the tip to the base; a full gap's excess goes to those nearer to the base.

    What the base cannot take goes to all that have room, by their portions.
    """
    left, taken = level, np.zeros(len(portion))
    for i in range(len(portion) - 1, -1, -1):
        taken[i] = min(level * portion[i], room[i])
        if level * portion[i] > room[i] and i > 0:
            level += (level * portion[i] - room[i]) / portion[:i].sum()
    for _ in range(len(portion)):
        has_room = taken < room
        more = np.where(has_room, (left - taken.sum()) * portion / max(portion[has_room].sum(), 1e-9), 0)
        taken = np.minimum(taken + more, room)
    return taken


def turned(axis, angle):
    axis = axis / np.linalg.norm(axis)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def search(function, low, high):
    """Where a growing function passes 0."""
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if function(middle) < 0 else (low, middle)
    return (low + high) / 2


def plain_twist(design, first, second, theta_0, as_authors):
    """Rotations of Algorithm 2, by bisection."""
    start = reference.bend_dorsal(design, first, theta_0, as_authors=as_authors)
    n_open = int(reference.first_shut(start)) - 1
    beyond, before = hole_positions(design)
    portion = read_table(prepare(design, as_authors).constants).portion[::-1][:n_open]

    def rotation(i, turn):
        return turned(before[i, 0], turn) @ start.joint_rotation[i]

    def gap(i, turn):
        return np.linalg.norm(rotation(i, turn) @ beyond[i, 1] - before[i, 1])

    def opening(i, turn):
        return math.acos(min(rotation(i, turn)[0, 0], 1))

    limit = [search(lambda a, i=i: design.joint_limit - opening(i, a), -math.pi / 4, 0) for i in range(n_open)]
    room = np.array([gap(i, 0) - gap(i, limit[i]) for i in range(n_open)])
    if as_authors:
        taken, level, share = np.zeros(n_open), second, portion / portion.sum() if n_open else portion
        for i in range(n_open - 1, -1, -1):
            taken[i] = min(level * share[i], room[i])
            if level * share[i] > room[i]:
                level, share = level - room[i], share / share[: i + 1].sum()
    else:
        taken = plain_pull(second, portion / portion.sum() if n_open else portion, room)
    turns = [search(lambda a, i=i: gap(i, a) - (gap(i, 0) - taken[i]), limit[i], 0) for i in range(n_open)]
    joints = [rotation(i, turns[i] if i < n_open and taken[i] > 0 else 0.0) for i in range(design.n_joint)]
    return np.array(joints), taken < room


@pytest.mark.parametrize(
    ("as_authors", "inclinations"),
    [
        pytest.param(True, (70,), id="authors at 70"),
        pytest.param(True, (120,), id="authors at 120", marks=pytest.mark.slow),
        pytest.param(False, (70, 120), id="exact", marks=pytest.mark.slow),
    ],
)
def test_twist_is_algorithm_2_written_out(as_authors, inclinations):
    """Also where several joints are full, one after the other, and where cable 1 has shut none."""
    n_full = set()
    for first in (0.0, 0.01, 0.03, 0.06, 0.1):
        for second in (0.005, 0.03, 0.06, 0.09, 0.12):
            for theta_0 in map(math.radians, inclinations):
                shape = reference.twist(PAPER, first, second, theta_0, as_authors=as_authors)
                joints, has_room = plain_twist(PAPER, first, second, theta_0, as_authors)
                np.testing.assert_allclose(shape.joint_rotation, joints, rtol=0, atol=2e-7)
                n_full.add(int((~has_room).sum()))
    assert n_full >= {0, 1}
    assert max(n_full) >= 5


@pytest.mark.parametrize("theta_deg", [-30, 0, 45, 90, 135])
@pytest.mark.parametrize("part", [0.05, 0.3, 0.7, 0.95])
def test_bending_is_algorithm_1_written_out(part, theta_deg):
    theta_0 = math.radians(theta_deg)
    rest = reference.rest(PAPER, theta_0, as_authors=False).gap[:, 0]
    chord = 2 * PAPER.hole_to_joint
    turn = np.radians(30) * PAPER.k_p ** (2.5 * np.arange(16, -1, -1))
    portion = chord * (np.sin(np.radians(15) + turn / 2) - np.sin(np.radians(15)))
    portion /= portion.sum()
    dorsal = reference.bend_dorsal(PAPER, part * PAPER.cable_stroke, theta_0, as_authors=False)
    gap = rest - plain_pull(part * PAPER.cable_stroke, portion, rest)
    np.testing.assert_allclose(dorsal.gap[:, 0], gap, rtol=0, atol=1e-13)
    np.testing.assert_allclose(bends(dorsal), np.radians(30) - 2 * np.arcsin(gap / chord), rtol=0, atol=1e-12)
    ventral = reference.bend_ventral(PAPER, part * VENTRAL_STROKE, theta_0, as_authors=False)
    gap = rest + plain_pull(part * VENTRAL_STROKE, portion, chord / 2 - rest)
    np.testing.assert_allclose(ventral.gap[:, 0], gap, rtol=0, atol=1e-13)


def test_authors_overflow_is_measured_from_the_straight_gap():
    """At theta_0 = 0 the base sags and its dorsal gaps start wide, so the authors' code loses cable or makes some."""
    theirs = reference.bend_ventral(PAPER, 0.08, 0.0)
    start = reference.rest(PAPER, 0.0)
    given_out = theirs.gap[:, 0].sum() - start.gap[:, 0].sum()
    assert abs(given_out - 0.08) > 1e-3
    ours = reference.bend_ventral(PAPER, 0.08, 0.0, as_authors=False)
    start = reference.rest(PAPER, 0.0, as_authors=False)
    assert ours.gap[:, 0].sum() - start.gap[:, 0].sum() == pytest.approx(0.08, abs=1e-12)


def soft_base():
    """A trunk of next to no weight that curls from the base."""
    soft = tuple(0.01 * 1.5**i for i in range(PAPER.n_joint))
    mass = replace(PAPER.mass, density=0.1, sections=None)
    return replace(PAPER, joint=replace(PAPER.joint, stiffness=soft), mass=mass)


def test_cable_that_the_base_cannot_take_goes_to_open_joints():
    """A trunk with a soft base curls there first; the rest of the pull still has to go somewhere."""
    design = soft_base()
    for part in (0.5, 0.9, 0.999):
        pull = part * design.cable_stroke
        shape = reference.bend_dorsal(design, pull, HANGING, as_authors=False)
        assert shape.is_shut[0]
        assert not shape.is_shut.all()
        assert shape.cable_change[0] == pytest.approx(pull, abs=1e-9)
        assert shape.status == Status.CONVERGED


# Gravity's branches.


def heavy(factor):
    masses = tuple(factor * mass for mass in PAPER.section_mass)
    return replace(PAPER, mass=replace(PAPER.mass, sections=masses))


def test_a_heavy_trunk_is_held_at_its_stops():
    shape = reference.rest(heavy(8.0), 0.0)
    assert shape.status == Status.CONVERGED
    assert shape.is_shut[0]
    assert not shape.is_shut.all()
    assert bends(shape)[0] == pytest.approx(-PAPER.joint_limit, rel=1e-12)
    shut = reference.bend_dorsal(heavy(8.0), 0.0, math.pi)
    assert reference.first_shut(shut) == 1
    assert reference.first_shut(reference.bend_dorsal(heavy(8.0), 0.0, 0.0)) == PAPER.n_joint + 1


def test_an_upright_trunk_falls_and_a_stiff_one_stands():
    fallen = reference.rest(PAPER, -HANGING)
    assert fallen.status == Status.CONVERGED
    assert fallen.joint_angle.sum() > 1
    standing = reference.rest(heavy(0.1), -HANGING)
    np.testing.assert_allclose(standing.joint_angle, 0, atol=1e-12)


def straight_stiffness(design):
    """Second derivatives of the energy of the trunk that stands straight, shape (n_joint, n_joint) [N m/rad]."""
    before = np.tril(np.ones((design.n_joint, design.n_joint)))
    return np.diag(rest_stiffness(design)) - before.T @ np.diag(gravity_moment_term(design)) @ before


@pytest.mark.parametrize("lean", [0.0, 1e-9, 1e-6, 1e-3])
@pytest.mark.parametrize("excess", [-1e-3, -1e-6, 1e-6, 1e-4, 1e-3, 1e-2])
def test_a_trunk_that_hardly_stands_or_hardly_falls_comes_to_rest(excess, lean):
    """Near the mass under which it buckles, where an equilibrium is nearly indifferent."""
    critical = search(lambda factor: -np.linalg.eigvalsh(straight_stiffness(heavy(factor)))[0], 0.1, 2.0)
    design = heavy(critical * (1 + excess))
    shape = reference.rest(design, lean - HANGING, as_authors=False)
    assert shape.status == Status.CONVERGED
    sag = -bends(shape)
    weight, stiffness = gravity_moment_term(design), rest_stiffness(design)
    before = np.tril(np.ones((design.n_joint, design.n_joint)))
    axis = lean - HANGING + before @ sag
    moment = stiffness * sag - before.T @ (weight * np.cos(axis))
    curvature = np.diag(stiffness) + before.T @ np.diag(weight * np.sin(axis)) @ before
    assert np.linalg.eigvalsh(curvature)[0] > 0
    np.testing.assert_allclose(np.linalg.solve(curvature, moment), 0, atol=2e-11)
    assert np.abs(sag).max() > 1e-5 or excess < 0


@pytest.mark.parametrize("turns", [1, -2, 50])
def test_whole_turns_change_nothing(turns):
    one, other = (reference.twist(PAPER, 0.05, 0.02, 0.4 + 2 * math.pi * n) for n in (0, turns))
    np.testing.assert_allclose(other.points, one.points, rtol=0, atol=1e-11)


def test_cos_and_sin_of_bends_are_cos_and_sin():
    """Within the last bit of 1 and of the sine, wide bends included."""
    angle = np.concatenate([np.linspace(-1.5, 1.5, 30001), np.logspace(-300, -1, 500)])
    cos, sin = np.empty_like(angle), np.empty_like(angle)
    gravity_rest.cos_sin(angle, 1.5, cos, sin)
    np.testing.assert_allclose(cos, np.cos(angle), rtol=0, atol=2.3e-16)
    np.testing.assert_allclose(sin, np.sin(angle), rtol=4.5e-16, atol=0)


def test_arcsine_is_the_arcsine():
    """To the last bit or the one next to it."""
    x = np.concatenate([np.linspace(0, 1, 20001), 0.5 + np.linspace(-1e-12, 1e-12, 201), np.logspace(-300, 0, 500)])
    ours = np.array([arcsine(value) for value in x])
    np.testing.assert_allclose(ours, np.arcsin(x), rtol=4.5e-16, atol=0)


# Shapes and batches.


def test_shapes_of_the_answers():
    shape = reference.twist(PAPER, np.full((2, 1, 3), 0.05), 0.02, np.full((4, 1), HANGING))
    expected = [(18, 3), (17, 3, 3), (17,), (17, 3), (3,), (17,), ()]
    assert [getattr(shape, name).shape for name in FIELDS] == [(2, 4, 3, *rest) for rest in expected]
    single = reference.twist(PAPER, 0.05, 0.02, HANGING)
    assert [getattr(single, name).shape for name in FIELDS] == expected
    assert single.is_shut.dtype == bool
    assert reference.rest(PAPER, np.zeros((0, 2))).points.shape == (0, 2, 18, 3)
    assert reference.rest(PAPER, np.float64(1)).points.shape == (18, 3)
    assert reference.rest(PAPER, np.array(1)).points.shape == (18, 3)


@pytest.mark.parametrize("law", [reference.rest, reference.bend_dorsal, reference.bend_ventral, reference.twist])
def test_large_batches_are_single_shapes_to_the_bit(law):
    """Large enough to be solved on all cores."""
    n = 2 * forward._CHUNK + 77
    rng = np.random.default_rng(5)
    n_pull = {reference.rest: 0, reference.twist: 2}.get(law, 1)
    given = [rng.uniform(0, 0.12, n) for _ in range(n_pull)] + [np.repeat(rng.uniform(-2, 2, n // 5 + 1), 5)[:n]]
    batch = law(PAPER, *given)
    for i in (0, 1, 255, 256, 257, n // 2, n - 1):
        single = law(PAPER, *(float(column[i]) for column in given))
        for name in FIELDS:
            np.testing.assert_array_equal(getattr(batch, name)[i], getattr(single, name))


@pytest.mark.parametrize("as_authors", [True, False])
def test_points_alone_are_those_of_the_shape_to_the_bit(as_authors):
    """Runs of every length at one theta_0, on one core and on all, full curl and straight among them."""
    rng = np.random.default_rng(6)
    theta_0 = np.repeat(rng.uniform(-2, 2, 90), np.arange(90))
    pull = rng.uniform(0, 1.01 * PAPER.cable_stroke, theta_0.size)
    pull[::7], pull[3::11] = 0.0, 1.01 * PAPER.cable_stroke
    for n in (len(pull), 200, 1):
        lean = reference.bend_dorsal_points(PAPER, pull[:n], theta_0[:n], as_authors=as_authors)
        full = reference.bend_dorsal(PAPER, pull[:n], theta_0[:n], as_authors=as_authors)
        np.testing.assert_array_equal(lean.points, full.points)
        np.testing.assert_array_equal(np.abs(lean.bend), full.joint_angle)
    assert reference.bend_dorsal_points(PAPER, 0.1, np.zeros((2, 1))).points.shape == (2, 1, 18, 3)
    assert reference.bend_dorsal_points(PAPER, 0.1, 0.0).bend.shape == (17,)


def test_points_go_into_the_memory_of_an_earlier_answer():
    pull = np.linspace(0, 0.1, 90).reshape(3, 30)
    first = reference.bend_dorsal_points(PAPER, pull[::-1], 0.4)
    where = first.points.ctypes.data, first.bend.ctypes.data
    again = reference.bend_dorsal_points(PAPER, pull, 0.4, out=first)
    assert again is first
    assert (again.points.ctypes.data, again.bend.ctypes.data) == where
    fresh = reference.bend_dorsal_points(PAPER, pull, 0.4)
    np.testing.assert_array_equal(again.points, fresh.points)
    np.testing.assert_array_equal(again.bend, fresh.bend)


def test_memory_of_another_answer_is_refused():
    first = reference.bend_dorsal_points(PAPER, np.zeros(4), 0.4)
    with pytest.raises(ModelError, match=r"out\.points has shape \(4, 18, 3\); allowed here: \(5, 18, 3\)"):
        reference.bend_dorsal_points(PAPER, np.zeros(5), 0.4, out=first)
    copied = reference.PlaneShape(points=first.points.copy(), bend=first.bend)
    with pytest.raises(ModelError, match="out has another memory layout"):
        reference.bend_dorsal_points(PAPER, np.zeros(4), 0.4, out=copied)
    first.bend.flags.writeable = False
    with pytest.raises(ModelError, match="out has another memory layout"):
        reference.bend_dorsal_points(PAPER, np.zeros(4), 0.4, out=first)


def test_points_alone_share_what_the_base_cannot_take():
    soft = soft_base()
    pull = np.linspace(0, 1, 77) * soft.cable_stroke
    lean = reference.bend_dorsal_points(soft, pull, HANGING, as_authors=False)
    full = reference.bend_dorsal(soft, pull, HANGING, as_authors=False)
    np.testing.assert_array_equal(lean.points, full.points)


def test_two_cables_bend_but_do_not_twist():
    design = presets.get("spirob-15")
    shape = reference.bend_dorsal(design, 0.5 * design.cable_stroke, HANGING)
    assert shape.gap.shape == (design.n_joint, 2)
    assert reference.bend_ventral(design, 0.01, HANGING).cable_change[1] > 0
    with pytest.raises(ModelError, match=r"cable\.angles are 0, 180 deg; allowed for twist: 0, 120 and 240 deg"):
        reference.twist(design, 0.01, 0.01, HANGING)


def test_numbers_of_a_design_are_kept_while_it_lives():
    design = design_from_rules(b=0.2)
    assert prepare(design) is prepare(design)
    assert prepare(design) is not prepare(design, False)
    key = (id(design), True)
    assert key in constants._PREPARED
    del design
    gc.collect()
    assert key not in constants._PREPARED


# What is refused.


def with_angles(*degrees):
    return replace(PAPER, cable=replace(PAPER.cable, angles=tuple(math.radians(angle) for angle in degrees)))


@pytest.mark.parametrize("law", [reference.rest, reference.bend_dorsal, reference.bend_ventral, reference.twist])
def test_cable_1_is_dorsal(law):
    given = {reference.rest: (0.0,), reference.twist: (0.0, 0.0, 0.0)}.get(law, (0.0, 0.0))
    with pytest.raises(ModelError, match=r"cable\.angles are 10, 130, 250 deg; allowed: cable 1 dorsal, at 0 deg"):
        law(with_angles(10, 130, 250), *given)


@pytest.mark.parametrize("angles", [(0, 120, 230), (0, 45, -45), (0, 150)])
def test_ventral_cables_mirror_each_other(angles):
    design = with_angles(*angles)
    reference.bend_dorsal(design, 0.01, HANGING)
    with pytest.raises(ModelError, match="allowed for ventral pulls: cables that mirror each other"):
        reference.bend_ventral(design, 0.01, HANGING)


@pytest.mark.parametrize("angles", [(0, 110, 250), (0, 240, 120), (0, 90, 180, 270)])
def test_twist_takes_the_papers_three_cables(angles):
    with pytest.raises(ModelError, match="allowed for twist: 0, 120 and 240 deg"):
        reference.twist(with_angles(*angles), 0.01, 0.01, HANGING)


DORSAL_RANGE = r"allowed: a finite number, at least 0, at most 0\.131157 m$"
VENTRAL_RANGE = r"allowed: a finite number, at least 0, at most 0\.122219 m$"


@pytest.mark.parametrize(
    ("law", "given", "message"),
    [
        (reference.rest, (math.nan,), r"^theta_0 is nan rad; allowed: a finite number, at least -1e\+06, at most"),
        (
            reference.rest,
            ([0.0, math.inf],),
            r"^theta_0 is inf rad; allowed: a finite number, at least -1e\+06, at most",
        ),
        (reference.bend_dorsal, (-1e-3, 0.0), "^pull is -0.001 m; " + DORSAL_RANGE),
        (reference.bend_dorsal, (math.nan, 0.0), "^pull is nan m; " + DORSAL_RANGE),
        (reference.bend_dorsal, (0.132, 0.0), "^pull is 0.132 m; " + DORSAL_RANGE),
        (reference.bend_dorsal, ([0.0, 0.132], 0.0), "^pull is 0.132 m; " + DORSAL_RANGE),
        (reference.bend_dorsal, (130, 90), "^pull is 130 m; " + DORSAL_RANGE),
        (reference.bend_ventral, (0.1225, 0.0), "^lengthening is 0.1225 m; " + VENTRAL_RANGE),
        (reference.bend_ventral, (-1e-9, 0.0), "^lengthening is -1e-09 m; " + VENTRAL_RANGE),
        (reference.twist, (0.14, 0.0, 0.0), "^pull_1 is 0.14 m; " + DORSAL_RANGE),
        (reference.twist, (0.1, -0.1, 0.0), "^pull_2 is -0.1 m; " + DORSAL_RANGE),
        (reference.twist, (0.1, [0.1, 0.14], 0.0), "^pull_2 is 0.14 m; " + DORSAL_RANGE),
        (
            reference.twist,
            (0.1, 0.1, -math.inf),
            r"^theta_0 is -inf rad; allowed: a finite number, at least -1e\+06, at most",
        ),
        (reference.bend_dorsal, ("0.1", 0.0), r"^pull is '0.1'; allowed: numbers$"),
        (reference.bend_dorsal, (None, 0.0), r"^pull is None; allowed: numbers$"),
        (reference.bend_dorsal, (0.1j, 0.0), r"^pull is 0.1j; allowed: numbers$"),
        (reference.bend_dorsal, ([[0.1], [0.1, 0.2]], 0.0), r"^pull is \[\[0.1\], \[0.1, 0.2\]\]; allowed: numbers$"),
        (
            reference.bend_dorsal,
            ([0.1] * 3, [0.0] * 2),
            r"^batches are pull \(3,\), theta_0 \(2,\); allowed: batches that broadcast$",
        ),
    ],
)
def test_what_cannot_be_done_is_refused_in_one_line(law, given, message):
    with pytest.raises(ModelError, match=message) as caught:
        law(PAPER, *given)
    assert "\n" not in str(caught.value)


def test_the_allowed_ends_are_allowed():
    for law, most in ((reference.bend_dorsal, PAPER.cable_stroke), (reference.bend_ventral, VENTRAL_STROKE)):
        assert law(PAPER, 1.01 * most, HANGING).status == Status.ALL_SHUT
        assert law(PAPER, most, HANGING).status == Status.CONVERGED
        assert law(PAPER, 0, HANGING).status == Status.CONVERGED
    full = reference.twist(PAPER, PAPER.cable_stroke, 0.01, HANGING)
    assert full.status == Status.ALL_SHUT
    most = 1.01 * PAPER.cable_stroke
    assert reference.twist(PAPER, 0.0, most, HANGING, as_authors=False).status == Status.ALL_SHUT


def test_section_ends_of_nothing_are_nothing():
    assert reference.bend_dorsal_points(PAPER, [], 1.0).points.shape == (0, 18, 3)
