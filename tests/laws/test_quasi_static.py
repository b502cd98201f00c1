"""Laws of quasi-static loading: what of the path matters, equilibrium at its end; with and without friction."""

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.design.presets import PAPER
from spiraltrunk.model import statics
from spiraltrunk.model.kinematics.cables import gap_vectors
from spiraltrunk.model.kinematics.shape import Status
from spiraltrunk.model.statics.equilibrium import Loads, QuasiStatic, StaticsOptions

FREE = -PAPER.cable_stroke
AGAINST = {"pull": np.array([0.03, 0.05, 0.02]), "theta_0": 0.4, "roll": 0.3, "loads": Loads(mass=0.1)}
"""Every cable pulled against the others, so that many shapes balance."""
BENT = {"pull": np.array([0.05, FREE, FREE]), "theta_0": 0.8}
TWO = {"pull": np.array([0.04, 0.02, FREE]), "theta_0": 0.8}
MU = 0.15


def load(factor=1.0, damping=3.0, **changed):
    """Fast winders and much damping, so that the way matters; a factor changes the time's unit alone."""
    slow = QuasiStatic(damping_time=damping * factor, pull_speed=0.02 / factor, tension_speed=4.0 / factor)
    options = StaticsOptions(cable_stiffness=2e4, quasi_static=slow)
    shape = statics.solve(PAPER, **AGAINST | {"options": options} | changed)
    assert (shape.status != Status.NOT_CONVERGED).all()
    return shape


def step(**given):
    """In one step, with friction in small increments."""
    options = StaticsOptions(cable_stiffness=2e4, increment=2.5e-4)
    return statics.solve(PAPER, **AGAINST | given, options=options)


def farthest(first, second):
    return np.linalg.norm(first.points - second.points, axis=-1).max()


@pytest.mark.parametrize(("friction", "near"), [(0.0, 1e-8), (MU, 1e-6)])
def test_where_one_shape_balances_quasi_static_loading_finds_it(friction, near):
    led, other = load(**BENT, friction=friction), step(**BENT, friction=friction)
    assert led.status == other.status == Status.CONVERGED
    np.testing.assert_allclose(led.points, other.points, rtol=0, atol=near)


def test_with_friction_two_cables_come_the_nearer_to_small_increments_the_slower_they_are_pulled():
    increments = step(**TWO, friction=MU)
    far = [farthest(load(**TWO, friction=MU, damping=damping), increments) for damping in (0.3, 0.03, 0.003)]
    assert far[0] > 3 * far[1] > 9 * far[2]
    assert far[2] < 5e-4


@pytest.mark.parametrize("friction", [0.0, MU])
def test_only_speed_times_damping_time_counts(friction):
    shape = load(friction=friction)
    np.testing.assert_allclose(load(10.0, friction=friction).points, shape.points, rtol=0, atol=1e-8)


def test_where_it_ends_the_energy_is_a_minimum():
    """A Newton iteration may end on a saddle, quasi-static loading does not: the shape yields to every small force."""
    shape = load()
    assert shape.forces.residual <= 1e-9
    assert np.linalg.eigvalsh(shape.forces.tip_compliance).min() >= -1e-12


@pytest.mark.parametrize("friction", [0.0, MU])
def test_the_way_tells_which_of_several_shapes_it_is(friction):
    """Cable by cable the trunk ends elsewhere than with all pulled together, and both balance."""
    together, first = load(friction=friction), load(friction=friction, pull=AGAINST["pull"] * [1, 0, 0])
    after = load(friction=friction, start=first)
    assert farthest(after, together) > 1e-3
    still = step(friction=friction, start=after)
    np.testing.assert_allclose(still.points, after.points, rtol=0, atol=1e-8 if friction == 0 else 2e-6)


@pytest.mark.parametrize("damping", [3.0, 0.03])
@pytest.mark.parametrize("given", [BENT, TWO, AGAINST])
def test_no_hole_holds_more_than_the_capstan_can(given, damping):
    shape = load(**given, friction=MU, damping=damping)
    taut = shape.forces.cable_tension > 0
    tension = np.concatenate([shape.forces.cable_tension[None], shape.forces.gap_tension])[:, taut]
    gap = gap_vectors(PAPER, shape.joint_rotation)[:, taut]
    heading = gap / np.linalg.norm(gap, axis=-1, keepdims=True)
    before = np.arccos(np.clip(heading[..., 0], -1, 1))
    beyond = np.arccos(np.clip((heading * shape.joint_rotation[:, None, :, 0]).sum(axis=-1), -1, 1))
    turn = before + np.concatenate([np.zeros((1, taut.sum())), beyond[:-1]])
    wide = shape.gap[:, taut] > 1e-4  # Narrower ones lose their direction.
    wide[1:] &= wide[:-1]
    used = (np.abs(np.log(tension[1:] / tension[:-1])) / (MU * turn))[wide]
    assert used.size >= 9
    assert used.max() == pytest.approx(1.0, abs=1e-4)  # Some slid last, and
    assert (used.min() < 0.5) == (taut.sum() > 1)  # where cables pull against each other others stick.


def test_a_cable_let_out_again_leaves_what_friction_holds():
    bent, free = load(**BENT, friction=MU), load(**BENT | {"pull": BENT["pull"] * [0.5, 1, 1]}, friction=MU)
    back = load(**BENT | {"pull": BENT["pull"] * [0.5, 1, 1]}, friction=MU, start=bent)
    assert farthest(back, free) > 1e-3
    assert back.forces.cable_tension[0] < free.forces.cable_tension[0]


def test_a_quasi_static_batch_with_friction_is_its_rows_to_the_bit():
    pull = np.array([[0.05, FREE, FREE], [0.03, 0.05, 0.02]])
    both = load(pull=pull, friction=MU)
    for b in range(2):
        np.testing.assert_array_equal(load(pull=pull[b], friction=MU).points, both.points[b])


def test_what_rests_goes_on_resting():
    shape = load(**BENT, friction=MU)
    np.testing.assert_array_equal(load(**BENT, friction=MU, start=shape).points, shape.points)


def test_a_load_that_is_added_alone_bends_the_resting_trunk():
    shape, heavy = load(**BENT, friction=MU), {"friction": MU, "loads": Loads(mass=0.2)}
    loaded = load(**BENT, **heavy, start=shape)
    assert farthest(loaded, shape) > 1e-3
    assert farthest(loaded, step(**BENT, **heavy, start=shape)) < 2e-4


@pytest.mark.parametrize("friction", [0.0, 0.01])
def test_a_straight_trunk_that_is_pressed_from_all_sides_buckles(friction):
    """Exactly balanced, it would stay straight."""
    options = StaticsOptions(quasi_static=QuasiStatic())
    shape = statics.solve(presets.get("spirob-15"), tension=(10.0, 10.0), friction=friction, options=options)
    assert shape.status == Status.CONVERGED
    assert shape.joint_angle.max() > 0.3


@pytest.mark.parametrize("friction", [0.0, MU])
def test_who_gives_up_on_the_way_says_so(friction):
    options = StaticsOptions(quasi_static=QuasiStatic(), steps_most=100)
    shape = statics.solve(PAPER, **BENT, friction=friction, options=options)
    assert shape.status == Status.NOT_CONVERGED
    assert np.isfinite(shape.points).all()
