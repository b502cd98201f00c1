"""Laws of the equilibrium, on drawn pulls, tensions, tilts and loads."""

import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.model import statics
from spiraltrunk.model.kinematics.cables import gap_vectors, lengths_from_rotations
from spiraltrunk.model.kinematics.frames import bend_rotation
from spiraltrunk.model.kinematics.shape import Status
from spiraltrunk.model.statics import equilibrium
from spiraltrunk.model.statics.equilibrium import Loads, StaticsOptions
from spiraltrunk.model.statics.kernels.laws.cable_gaps import NARROW

FREE = -PAPER.cable_stroke
STRICT = StaticsOptions(tolerance=1e-12)
GRAVITY = 9.81


def draw(count, seed=0, most=0.1):
    """Pulls on one or two cables, tilts, rolls and masses; pointing up, a heavy trunk would have two equilibria."""
    rng = np.random.default_rng(seed)
    pull = rng.uniform(0.0, most, (count, 3))
    pull[np.arange(count), rng.integers(0, 3, count)] = FREE
    pull[rng.random(count) < 0.3, 1] = FREE
    return {
        "pull": pull, "theta_0": rng.uniform(0.0, 1.5, count), "roll": rng.uniform(-3, 3, count),
        "loads": Loads(mass=rng.choice([0.0, 0.05, 0.3], count), section=11),
    }  # fmt: skip


@pytest.fixture(scope="module")
def drawn():
    given = draw(60)
    return given, statics.solve(PAPER, **given)


def row(given, b):
    loads = Loads(mass=given["loads"].mass[b], section=given["loads"].section)
    return {"pull": given["pull"][b], "theta_0": given["theta_0"][b], "roll": given["roll"][b], "loads": loads}


# What every solution keeps.


def test_cables_only_pull_and_no_more_than_the_winders_can(drawn):
    _, shape = drawn
    tension = shape.forces.cable_tension
    assert (shape.status != Status.NOT_CONVERGED).all()
    assert (tension >= 0).all()
    assert (tension <= PAPER.cable.tension_max).all()
    assert (shape.forces.gap_tension == tension[:, None, :]).all()


def test_a_cable_is_as_long_as_its_winder_says_or_slack_or_stalled(drawn):
    given, shape = drawn
    short, tension = shape.cable_change - given["pull"], shape.forces.cable_tension
    held = (tension > 0) & (tension < PAPER.cable.tension_max)
    assert held.sum() > 40
    assert np.abs(short[held]).max() <= 1e-9
    assert (short[tension == 0] >= -1e-9).all()
    assert (short[tension == PAPER.cable.tension_max] <= 1e-9).all()


def test_joints_stay_in_their_cones_and_press_on_the_rim_alone(drawn):
    _, shape = drawn
    reaction, angle = shape.forces.limit_reaction, shape.joint_angle
    assert (angle <= PAPER.joint_limit * (1 + 1e-14)).all()
    assert (reaction >= 0).all()
    assert (reaction > 0).sum() > 50
    assert (angle[reaction > 0] >= PAPER.joint_limit * (1 - 1e-12)).all()
    np.testing.assert_array_equal(shape.is_shut[reaction > 0], True)


def test_its_cables_are_those_of_its_shape(drawn):
    _, shape = drawn
    cables = lengths_from_rotations(PAPER, shape.joint_rotation)
    np.testing.assert_allclose(shape.cable_change, cables.change, rtol=0, atol=17e-6)  # A micrometre a gap at most.
    np.testing.assert_allclose(shape.joint_angle, np.arccos(shape.joint_rotation[..., 0, 0]), rtol=0, atol=1e-7)
    np.testing.assert_allclose(shape.joint_rotation, bend_rotation(shape.history.bend[..., :2]), rtol=0, atol=1e-12)


def lagrangian(given, b, tension, bend):
    """Energy of the bends plus tension times length, none of it by the kernels, shape of the batch [J]."""
    mass, at = given["loads"].mass[b], given["loads"].section
    theta, roll = given["theta_0"][b], given["roll"][b]
    down = np.array([[math.cos(theta), math.sin(theta), 0], [-math.sin(theta), math.cos(theta), 0], [0, 0, 1]])
    turn = np.array([[1, 0, 0], [0, math.cos(roll), -math.sin(roll)], [0, math.sin(roll), math.cos(roll)]])
    cables = lengths_from_rotations(PAPER, bend_rotation(bend))
    height = (cables.points @ (down @ turn).T)[..., 1]
    starts = np.concatenate([np.zeros((*height.shape[:-1], 1)), height[..., :-1]], axis=-1)
    part = PAPER.section_center / PAPER.section_length
    center = starts + part * (height - starts)
    elastic = 0.5 * (PAPER.joint_stiffness * (bend**2).sum(axis=-1)).sum(axis=-1)
    soft = np.sqrt(cables.gap**2 + statics.SHUT**2).sum(axis=-2)
    weight = GRAVITY * (center @ PAPER.section_mass + mass * height[..., at])
    return elastic + weight + soft @ tension


def test_the_energy_is_least_among_what_cables_and_joints_allow(drawn):
    """Small steps along the held cables' lengths, put back into the cones, never lower energy plus tension x length."""
    given, shape = drawn
    rng = np.random.default_rng(2)
    for b in range(0, 60, 4):
        bend, tension = shape.history.bend[b, :, :2], shape.forces.cable_tension[b]
        step = rng.normal(size=(200, *bend.shape)) * rng.choice([1e-4, 3e-4], (200, 1, 1))
        step -= across_cables(bend, tension, step)
        moved = bend + step
        moved *= np.minimum(1.0, PAPER.joint_limit / np.linalg.norm(moved, axis=-1, keepdims=True))
        rise = lagrangian(given, b, tension, moved) - lagrangian(given, b, tension, bend)
        assert rise.min() > -1e-12, (b, rise.min())
        assert rise.max() > 1e-10


def across_cables(bend, tension, step):
    """The part of steps that changes the lengths of the cables under tension."""
    small, flat = 1e-6, bend.ravel()
    shifts = (np.concatenate([np.eye(flat.size), -np.eye(flat.size)]) * small + flat).reshape(-1, *bend.shape)
    gap = np.sqrt(lengths_from_rotations(PAPER, bend_rotation(shifts)).gap ** 2 + statics.SHUT**2).sum(axis=-2)
    slope = ((gap[: flat.size] - gap[flat.size :]) / (2 * small))[:, tension > 0]
    if slope.shape[1] == 0:
        return np.zeros_like(step)
    basis = np.linalg.qr(slope)[0]
    return ((step.reshape(len(step), -1) @ basis) @ basis.T).reshape(step.shape)


def test_a_batch_is_its_rows_to_the_bit_and_again_the_same(drawn):
    given, shape = drawn
    for b in (0, 7, 31, 59):
        alone = statics.solve(PAPER, **row(given, b))
        np.testing.assert_array_equal(alone.points, shape.points[b])
        np.testing.assert_array_equal(alone.forces.cable_tension, shape.forces.cable_tension[b])
        np.testing.assert_array_equal(alone.forces.tip_compliance, shape.forces.tip_compliance[b])
        assert alone.status == shape.status[b]
    np.testing.assert_array_equal(statics.solve(PAPER, **given).points, shape.points)


# Symmetries.


def test_mirrored_pulls_give_the_mirrored_trunk(drawn):
    given, shape = drawn
    mirrored = given | {"pull": given["pull"][:, [0, 2, 1]], "roll": -given["roll"]}
    other = statics.solve(PAPER, **mirrored)
    np.testing.assert_allclose(other.points * [1, 1, -1], shape.points, rtol=0, atol=1e-6)
    np.testing.assert_allclose(other.forces.cable_tension[:, [0, 2, 1]], shape.forces.cable_tension, atol=1e-4)


def test_a_roll_by_120_deg_passes_each_cables_pull_to_the_next(drawn):
    given, shape = drawn
    turned = given | {"pull": np.roll(given["pull"], 1, axis=1), "roll": given["roll"] - 2 * math.pi / 3}
    other = statics.solve(PAPER, **turned)
    np.testing.assert_allclose(other.points, shape.points, rtol=0, atol=1e-6)


def test_hanging_the_roll_turns_the_shape_about_the_vertical():
    pull, turn = (0.06, 0.02, FREE), 0.8
    still, turned = statics.solve(PAPER, pull=pull), statics.solve(PAPER, pull=pull, roll=turn)
    c, s = math.cos(turn), math.sin(turn)
    about_y = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    np.testing.assert_allclose(turned.points, still.points @ about_y.T, rtol=0, atol=1e-7)


# Compliance, tension, torsion.


def test_the_tips_compliance_is_that_of_small_forces():
    for drive in ({"tension": (3.0, 1.0, 0)}, {"pull": (0.05, 0.03, FREE)}, {"pull": (0.09, FREE, FREE)}):
        given = drive | {"theta_0": 0.6, "roll": 0.4, "options": STRICT}
        shape = statics.solve(PAPER, **given)
        compliance, size = shape.forces.tip_compliance, 1e-4
        for axis in range(3):
            ends = [
                statics.solve(PAPER, **given, start=shape, loads=Loads(force=side * size * np.eye(3)[axis])).points[-1]
                for side in (1, -1)
            ]
            expected = (ends[0] - ends[1]) / (2 * size)
            np.testing.assert_allclose(compliance[:, axis], expected, rtol=0, atol=2e-5 * np.abs(compliance).max())


def test_the_tips_compliance_is_symmetric_and_never_negative(drawn):
    _, shape = drawn
    compliance = shape.forces.tip_compliance
    size = np.abs(compliance).max(axis=(1, 2), keepdims=True)
    np.testing.assert_allclose(compliance / size, np.swapaxes(compliance, 1, 2) / size, rtol=0, atol=1e-7)
    assert (np.linalg.eigvalsh(compliance) >= -1e-7 * size[:, 0]).all()


@pytest.mark.parametrize("cable", [0, 1, 2])
def test_more_tension_is_more_curl(cable):
    tension = np.zeros((25, 3))
    tension[:, cable] = np.linspace(0.0, 30.0, 25)
    angle = statics.solve(PAPER, tension=tension).joint_angle.sum(axis=-1)
    assert (np.diff(angle) > 0).all()


def test_with_torsion_a_planar_shape_stays_and_a_spatial_one_twists():
    twisting = StaticsOptions(has_torsion=True)
    plane, space = {"pull": (0.06, FREE, FREE)}, {"pull": (0.06, 0.02, FREE), "theta_0": 0.3, "roll": 1.0}
    locked, free = (statics.solve(PAPER, **plane, options=options) for options in (None, twisting))
    np.testing.assert_allclose(free.points, locked.points, rtol=0, atol=1e-7)
    free = statics.solve(PAPER, **space, options=twisting)
    assert 1e-3 < np.abs(free.history.bend[:, 2]).max() < 0.3
    assert statics.solve(PAPER, **space).history.bend[:, 2] == pytest.approx(0.0, abs=0)


def test_torsion_goes_to_the_torsion_free_shape_as_the_joints_stiffen(monkeypatch):
    space = {"pull": (0.06, 0.02, FREE), "theta_0": 0.3, "roll": 1.0}
    locked, away = statics.solve(PAPER, **space), []
    for k, factor in enumerate((1e3, 1e4, 1e5)):
        monkeypatch.setattr(equilibrium, "POISSON", (1 + 0.48) / factor - 1)
        named = replace(PAPER, name=f"stiff in torsion {k}")
        stiff = statics.solve(named, **space, options=StaticsOptions(has_torsion=True))
        away.append(np.linalg.norm(stiff.points - locked.points, axis=-1).max())
    ratio = np.array(away[:-1]) / away[1:]
    np.testing.assert_allclose(ratio, 10.0, rtol=0.1)
    assert away[-1] < 1e-5


# Friction and its history.

SLIDING = {"pull": (0.02, FREE, FREE), "theta_0": math.pi / 2}


@pytest.mark.parametrize("mu", [0.1, 0.3])
def test_while_a_cable_slides_its_tension_falls_by_the_turns_it_makes(mu):
    """Capstan: T_k = T_0 exp(-mu x sum of the turns up to gap k)."""
    shape = statics.solve(PAPER, **SLIDING, friction=mu)
    assert shape.status == Status.CONVERGED
    expected = shape.forces.cable_tension[0] * np.exp(-mu * np.cumsum(dorsal_turns(shape.joint_rotation)))
    np.testing.assert_allclose(shape.forces.gap_tension[:, 0], expected, rtol=1e-6)
    assert shape.gap.min() > 5 * NARROW  # None is about to shut and lose its direction.
    assert shape.forces.gap_tension[-1, 0] < 0.75 * shape.forces.cable_tension[0]


def dorsal_turns(rotation):
    """Turn of cable 1 before each gap, from the directions of the gaps and of the sections' axes [rad]."""
    gap = gap_vectors(PAPER, rotation)[:, 0]
    gap /= np.linalg.norm(gap, axis=-1, keepdims=True)
    before, beyond = np.arccos(gap[:, 0]), np.arccos((gap * rotation[:, :, 0]).sum(axis=-1))
    return before + np.concatenate([[0.0], beyond[:-1]])


def sequence(mu, *pulls):
    shape = None
    for pull in pulls:
        shape = statics.solve(PAPER, pull=pull, friction=mu, start=shape)
        assert shape.status == Status.CONVERGED
    return shape


def test_the_order_of_pulling_matters_with_friction_and_not_without():
    last = (0.04, 0.02, FREE)
    for mu, low, high in ((0.0, 0.0, 1e-7), (0.15, 3e-3, 0.1)):
        first, other = sequence(mu, (0.04, FREE, FREE), last), sequence(mu, (FREE, 0.02, FREE), last)
        assert low <= np.linalg.norm(first.points - other.points, axis=-1).max() <= high


def test_a_path_in_two_is_the_path_in_one():
    one = sequence(0.15, (0.04, FREE, FREE))
    two = sequence(0.15, (0.02, FREE, FREE), (0.04, FREE, FREE))
    np.testing.assert_allclose(two.points, one.points, rtol=0, atol=2e-4)


def test_going_back_along_the_path_leaves_what_friction_holds():
    bent, free = sequence(0.15, (0.04, FREE, FREE)), sequence(0.15, (0.02, FREE, FREE))
    back = statics.solve(PAPER, pull=(0.02, FREE, FREE), friction=0.15, start=bent)
    assert np.linalg.norm(back.points[-1] - free.points[-1]) > 1e-3
    assert back.forces.cable_tension[0] < free.forces.cable_tension[0]


def test_smaller_increments_change_nothing_that_matters():
    given = {"pull": (0.05, 0.02, FREE), "theta_0": 1.0, "friction": 0.15}
    coarse = statics.solve(PAPER, **given)
    fine = statics.solve(PAPER, **given, options=StaticsOptions(increment=1e-3))
    assert np.linalg.norm(coarse.points - fine.points, axis=-1).max() < 2e-4


def test_tensions_laid_on_at_once_or_bit_by_bit_bend_the_trunk_alike():
    given = {"tension": (0.0, 4.16, 4.16), "friction": 0.2}
    shapes = [
        statics.solve(PAPER, **given, options=StaticsOptions(tension_increment=step)) for step in (5.0, 2.0, 0.5, 0.1)
    ]
    for shape in shapes[:-1]:
        np.testing.assert_allclose(shape.points, shapes[-1].points, rtol=0, atol=2e-6)
    tension = np.r_[4.16, shapes[0].forces.gap_tension[:, 1]]
    assert (np.diff(tension) < 0).all()  # Every hole holds back the cable that was pulled.


@pytest.mark.parametrize("stiffness", [600.0, 5e4, math.inf])
def test_what_rests_with_friction_goes_on_resting(stiffness):
    rng, options = np.random.default_rng(7), StaticsOptions(cable_stiffness=stiffness)
    for _ in range(8):
        by_tension = rng.random(3) < 0.4
        given = {
            "pull": rng.uniform(0.0, 0.05, 3), "tension": np.where(by_tension, rng.uniform(0, 10, 3), 60.0),
            "by_tension": by_tension, "theta_0": rng.uniform(-1.5, 1.5), "friction": rng.choice([0.1, 0.2, 0.4]),
        }  # fmt: skip
        shape = statics.solve(PAPER, **given, options=options)
        again = statics.solve(PAPER, **given, options=options, start=shape)
        np.testing.assert_allclose(again.points, shape.points, rtol=0, atol=2e-6)
        tension = shape.forces.cable_tension
        np.testing.assert_allclose(again.forces.cable_tension, tension, rtol=1e-4, atol=1e-4)


def test_friction_begins_where_a_shape_without_it_ended():
    free = statics.solve(PAPER, tension=(0.0, 2.0, 2.0), friction=0.0)
    held = statics.solve(PAPER, tension=(0.0, 2.0, 2.0), friction=0.3, start=free)
    np.testing.assert_allclose(held.points, free.points, rtol=0, atol=1e-4)
    beyond = np.cumsum(free.gap[::-1], axis=0)[::-1]
    np.testing.assert_allclose(free.history.anchor, beyond, rtol=0, atol=1e-12)


def test_opposed_cables_of_held_length_take_up_a_small_push():
    options = StaticsOptions(cable_stiffness=5e4)
    held = statics.solve(PAPER, tension=(10.0, 10.0, 10.0), friction=0.2, options=options)
    wound = held.cable_change + held.forces.cable_tension / options.cable_stiffness
    for stiff in (options, StaticsOptions()):
        length = wound if stiff is options else held.cable_change
        pushed = statics.solve(
            PAPER, pull=length, friction=0.2, start=held, options=stiff, loads=Loads(force=(0.02, 0.0, 0.0))
        )
        assert np.abs(pushed.forces.cable_tension - 10.0).max() < 0.6
        assert np.linalg.norm(pushed.points[-1] - held.points[-1]) < 1e-4
