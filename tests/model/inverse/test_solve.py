"""From targets to cables: forward of inverse is identity, and what is out of reach is said to be so, by how much."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.errors import DesignError, ModelError
from spiraltrunk.model import inverse, statics
from spiraltrunk.model.inverse.multistart import InverseOptions
from spiraltrunk.model.inverse.start_table import LoadCase, compute_start_table
from spiraltrunk.model.kinematics.shape import Shape, Status
from spiraltrunk.model.statics.loads import Loads
from spiraltrunk.strategies.wrap.hung_model import predict_wrap

STANDS = [{}, {"theta_0": 0.3, "roll": 0.5, "loads": Loads(mass=0.05)}]


def draw(name: str, count: int, seed: int, case: dict) -> Shape:
    """Equilibria at tensions even in their logarithm, a fifth of the cables slack."""
    design, rng = presets.get(name), np.random.default_rng(seed)
    size = (count, design.n_cable)
    tension = 10 ** rng.uniform(-1, np.log10(design.cable.tension_max), size)
    return statics.solve(design, tension=np.where(rng.random(size) < 0.2, 0.0, tension), **case)


def check_identity(name: str, count: int, seed: int, case: dict, least: float) -> None:
    """A pliant shape's tip moves by tens of metres per N m of what the solver leaves: that is 1e-10 N m here."""
    design, wanted = presets.get(name), draw(name, count, seed, case).points[:, -1]
    sharp = statics.StaticsOptions(tolerance=1e-10)
    reach = inverse.solve(design, wanted, options=InverseOptions(statics=sharp), **case)
    again = statics.solve(design, tension=reach.tension, options=sharp, **case)
    left = np.linalg.norm(again.points[:, -1] - wanted, axis=-1)
    np.testing.assert_allclose(reach.distance, left, atol=1e-8)
    np.testing.assert_allclose(reach.points, again.points, rtol=0, atol=1e-8)
    assert (left < 1e-4).mean() >= least
    assert (reach.tension >= 0).all()
    assert (reach.tension <= design.cable.tension_max).all()
    assert (reach.pull <= 1.0001 * design.cable_stroke).all()
    np.testing.assert_array_equal(reach.status == Status.OUT_OF_REACH, left > 5e-5)


@pytest.mark.parametrize("case", STANDS)
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name == "spirob-1m" else name for name in presets.NAMES]
)
def test_forward_of_inverse_is_identity(name: str, case: dict) -> None:
    check_identity(name, 20, 3, case, least=1.0)


@pytest.mark.parametrize("case", STANDS)
def test_answers_are_those_of_the_straight_trunk(case: dict) -> None:
    """To what the solver leaves, with cables drawn against each other up to their largest tension, upright too."""
    case = case | {"theta_0": np.repeat([-1.5, -0.5, 0.5, 1.5], 15)}
    wanted = draw("paper", 60, 8, case).points[:, -1]
    reach = inverse.solve(presets.PAPER, wanted, **case)
    again = statics.solve(presets.PAPER, tension=reach.tension, **case)
    np.testing.assert_allclose(reach.points, again.points, rtol=0, atol=1e-7)


@pytest.mark.parametrize("angles", [(0.0, 90.0, 180.0), (0.0, 90.0, 180.0, 270.0)])
def test_a_slack_cable_does_not_do_where_others_are_opposed(angles: tuple[float, ...]) -> None:
    """Each answer is then looked at from the straight trunk, as others may pull against each other."""
    cable = replace(presets.PAPER.cable, angles=tuple(np.radians(angles).tolist()))
    opposed = replace(presets.PAPER, cable=cable)
    case = LoadCase(np.pi / 2, 0.0, 0.0, -1, None, -1)
    starts = [compute_start_table(design, case, 4, statics.StaticsOptions()) for design in (presets.PAPER, opposed)]
    assert starts[0].slack > 0
    assert starts[1].slack < 0


@pytest.mark.slow
@pytest.mark.parametrize("case", STANDS)
@pytest.mark.parametrize("name", presets.NAMES)
def test_all_but_one_in_a_hundred_reachable_targets_are_reached(name: str, case: dict) -> None:
    check_identity(name, 500, 11, case, least=0.99)


def test_the_pulls_hold_the_same_shape() -> None:
    wanted = draw("paper", 20, 4, {}).points[:, -1]
    reach = inverse.solve(presets.PAPER, wanted)
    again = statics.solve(presets.PAPER, pull=reach.pull, start=reach.shape)
    np.testing.assert_allclose(again.points, reach.points, atol=1e-6)


def test_least_tension_holds_the_straight_trunk() -> None:
    """Cables that work against each other keep a hanging trunk straight at any tension."""
    rest = statics.solve(presets.PAPER, tension=[9.0, 9.0, 9.0]).points[-1]
    reach = inverse.solve(presets.PAPER, rest)
    assert reach.status == Status.CONVERGED
    assert reach.tension.max() < 0.05


@pytest.mark.parametrize(
    "way", [(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 1.0, 0.0), (0.3, -0.2, -0.9), (0.0, 0.0, 1.0)]
)
def test_a_far_target_is_out_of_reach_by_no_less_than_the_trunk_is_short(way: tuple[float, float, float]) -> None:
    design = presets.PAPER
    target = 3.0 * np.array(way) / np.linalg.norm(way)
    reach = inverse.solve(design, target)
    assert reach.status == Status.OUT_OF_REACH
    assert "out of reach" in reach.advice
    assert reach.distance >= 3.0 - design.length
    assert reach.distance == pytest.approx(np.linalg.norm(reach.points[-1] - target), abs=1e-12)
    drawn = np.linalg.norm(draw("paper", 300, 8, {}).points[:, -1] - target, axis=-1)
    assert reach.distance <= drawn.min() + 1e-6


def test_below_the_hanging_tip_the_nearest_is_the_hanging_trunk() -> None:
    reach = inverse.solve(presets.PAPER, [0.0, -0.6, 0.0])
    assert reach.distance == pytest.approx(0.6 - presets.PAPER.length, abs=1e-5)


def test_a_pose_of_the_trunk_is_found_and_another_met_half_way() -> None:
    shape = draw("paper", 12, 6, {})
    heading = shape.points[:, -1] - shape.points[:, -2]
    reach = inverse.solve(presets.PAPER, shape.points[:, -1], direction=3 * heading)
    assert (reach.status == Status.CONVERGED).mean() > 0.9
    assert reach.turn is not None
    good = reach.status == Status.CONVERGED
    assert reach.turn[good].max() < 1e-3
    tip = shape.points[0, -1]
    heavy = inverse.solve(presets.PAPER, tip, direction=(0.0, 1.0, 0.3), direction_weight=1.0)
    light = inverse.solve(presets.PAPER, tip, direction=(0.0, 1.0, 0.3), direction_weight=1e-3)
    assert heavy.turn < light.turn
    assert heavy.distance > light.distance


def test_a_shape_of_the_trunk_is_followed() -> None:
    wanted = draw("paper", 12, 7, {}).points
    reach = inverse.follow(presets.PAPER, wanted)
    assert reach.distance.max() < 1e-4
    off = inverse.follow(presets.PAPER, wanted[0] + np.array([0.0, 0.0, 0.01]))
    assert off.status == Status.OUT_OF_REACH
    assert 0.001 < off.distance <= 0.01 + 1e-9


def test_answers_are_the_same_twice_and_alone_or_in_a_batch() -> None:
    wanted = draw("paper", 12, 9, {}).points[:, -1]
    first, second = inverse.solve(presets.PAPER, wanted), inverse.solve(presets.PAPER, wanted)
    np.testing.assert_array_equal(first.tension, second.tension)
    alone = inverse.solve(presets.PAPER, wanted[5])
    np.testing.assert_array_equal(first.tension[5], alone.tension)
    assert alone.points.shape == (presets.PAPER.n_section, 3)
    assert alone.distance.shape == ()


def test_batches_of_stands_broadcast_against_targets() -> None:
    turn = np.array([0.2, 1.2])
    reach = inverse.solve(presets.PAPER, np.full((3, 1, 3), 0.1), theta_0=turn, loads=Loads(mass=0.01))
    assert reach.tension.shape == (3, 2, 3)
    alone = inverse.solve(presets.PAPER, np.full(3, 0.1), theta_0=1.2, loads=Loads(mass=0.01))
    np.testing.assert_allclose(reach.points[0, 1], alone.points, atol=1e-9)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: inverse.solve(presets.PAPER, [0.0, 1.0]), "tip has shape"),
        (lambda: inverse.solve(presets.PAPER, [np.nan, 0, 0]), "tip is nan m"),
        (lambda: inverse.solve(presets.PAPER, [1e9, 0, 0]), "tip is 1e.09 m"),
        (lambda: inverse.solve(presets.PAPER, [0.1, 0, 0], direction=[0, 0, 0]), "direction has length 0"),
        (lambda: inverse.solve(presets.PAPER, [1, 0, 0], direction=[1, 0, 0], direction_weight=-1), "direction_weight"),
        (lambda: inverse.solve(presets.PAPER, np.ones((2, 3)), theta_0=np.ones(3)), "broadcast"),
        (lambda: inverse.follow(presets.PAPER, np.ones((4, 3))), "points has shape"),
        (lambda: inverse.follow(presets.PAPER, np.ones((18, 3)), weight=np.zeros(18)), "weight"),
        (lambda: inverse.curl(presets.PAPER, [0.1, -0.3, 0], 0.0), "diameter"),
        (lambda: inverse.curl(presets.PAPER, [0.1, -0.3, 0], 0.1, touching=19), "touching"),
    ],
)  # fmt: skip
def test_bad_input_is_one_clear_error(call, words: str) -> None:
    with pytest.raises((DesignError, ModelError), match=words):
        call()


def test_a_tolerance_says_what_is_reached() -> None:
    target = [0.0, -0.51, 0.0]
    assert inverse.solve(presets.PAPER, target).status == Status.OUT_OF_REACH
    near = inverse.solve(presets.PAPER, target, options=InverseOptions(tolerance=0.01))
    assert near.status == Status.CONVERGED


@pytest.mark.parametrize("width", [0.033, 0.05, 0.072, 0.1, 0.15])
def test_a_curl_touches_the_circle_and_goes_no_deeper_than_a_millimetre(width: float) -> None:
    """The circle is where a planned wrap has it; the free curl touches it, if not all round."""
    down, ahead = predict_wrap(presets.PAPER, width, 0.0, 10.0).center
    reach = inverse.curl(presets.PAPER, (-ahead, -down, 0.0), width)
    assert reach.status == Status.CONVERGED
    assert reach.gap is not None
    assert -1e-3 <= reach.gap.min() <= 1e-3
    assert reach.distance == pytest.approx(abs(reach.gap.min()))
    assert np.abs(reach.points[:, 2]).max() < 0.02


def test_gaps_are_the_distances_of_the_outer_surface_from_the_circle() -> None:
    """Against points sampled in the half of the section that faces the circle."""
    design, center, width = presets.PAPER, np.array([-0.06, -0.33, 0.0]), 0.05
    reach = inverse.curl(design, center, width)
    start = np.vstack([np.zeros(3), reach.points[:-1]])
    axis = (reach.points - start) / design.section_length[:, None]
    across = (center - start) - ((center - start) * axis).sum(axis=-1, keepdims=True) * axis
    across /= np.linalg.norm(across, axis=-1, keepdims=True)
    along = np.linspace(design.solid.rim_start, design.solid.rim_end, 1001)
    for n, gap in enumerate(reach.gap):
        line = start[n] + design.scale[n] * along[:, None] * axis[n]
        layers = [line + part * design.section_radius[n] * across[n] for part in np.linspace(0, 1, 201)]
        nearest = min(np.linalg.norm(layer - center, axis=-1).min() for layer in layers) - width / 2
        assert gap == pytest.approx(nearest, abs=2e-5)


def test_a_circle_far_away_is_out_of_reach_by_no_less_than_the_trunk_is_short() -> None:
    design = presets.PAPER
    reach = inverse.curl(design, [1.0, 0.0, 0.0], 0.1)
    assert reach.status == Status.OUT_OF_REACH
    assert reach.distance >= 1.0 - 0.05 - design.length - design.section_radius[0]


@pytest.mark.parametrize("theta_0", [1e6, -1e6])
def test_the_largest_turn_that_is_allowed_is_taken(theta_0):
    assert inverse.solve(presets.PAPER, [0.1, -0.4, 0.1], theta_0=theta_0).advice


def test_each_circle_of_a_batch_is_curled_round_as_it_is_alone():
    widths = np.array([0.04, 0.12])
    batch = inverse.curl(presets.PAPER, [-0.06, -0.3, 0.0], widths)
    for i, width in enumerate(widths):
        alone = inverse.curl(presets.PAPER, [-0.06, -0.3, 0.0], width)
        np.testing.assert_array_equal(batch.tension[i], alone.tension)
