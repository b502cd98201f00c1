"""Inverse with friction: the answer's loading path, replayed by the statics, ends at the target."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.errors import DesignError, ModelError
from spiraltrunk.model import inverse, statics
from spiraltrunk.model.inverse.path_search import Found, bounded_step
from spiraltrunk.model.inverse.solve import InverseSolution
from spiraltrunk.model.inverse.staged_loading import assign_turns
from spiraltrunk.model.kinematics.shape import Shape, Status
from spiraltrunk.model.statics.loads import Loads

PAPER = presets.PAPER
MOST = PAPER.cable.tension_max

PLANAR = replace(PAPER, cable=replace(PAPER.cable, angles=(0.0, np.pi)))
"""Two cables have fewer orders: fewer starts to compute."""


def pull_two(first: int, pulls: tuple[float, float], held: float, friction: float, **case) -> Shape:
    """The cable after ``first`` held by ``held`` N, then ``first`` pulled in, then the last cable, by the statics."""
    other, second = (first + 1) % 3, (first + 2) % 3
    tension, pull = np.zeros(3), np.zeros(3)
    tension[other] = held
    shape, is_held = statics.solve(PAPER, tension=tension, friction=friction, **case), np.full(3, True)
    for cable, more in zip((first, second), pulls, strict=True):
        pull[cable], tension[cable], is_held[cable] = shape.cable_change[cable] + more, MOST, False
        shape = statics.solve(
            PAPER, pull=pull, tension=tension, by_tension=is_held, friction=friction, start=shape, **case
        )
    return shape


def draw(count: int, friction: float, seed: int) -> np.ndarray:
    """Tips that loadings in a drawn order reach, shape (count, 3) [m]."""
    rng, tips = np.random.default_rng(seed), []
    while len(tips) < count:
        held = float(rng.choice([0.0, 10 ** rng.uniform(-1, 1)]))
        pulls = (float(rng.uniform(0, 0.12)), float(rng.uniform(0, 0.06)))
        shape = pull_two(int(rng.integers(3)), pulls, held, friction)
        if shape.status == Status.CONVERGED:
            tips.append(shape.points[-1])
    return np.array(tips)


def replay(solution: InverseSolution, row: int, friction: float) -> Shape:
    """The path of one row by `statics.solve` alone."""
    path = solution.path
    assert path is not None
    shape, is_relaxed = None, np.full(3, True)
    for cable in path.order[row][path.order[row] >= 0]:
        is_relaxed[cable] = False
        shape = statics.solve(
            PAPER, pull=solution.pull[row], tension=np.where(is_relaxed, 0.0, path.tension[row]),
            by_tension=path.by_tension[row] | is_relaxed, friction=friction, start=shape,
        )  # fmt: skip
    assert shape is not None
    return shape


@pytest.mark.slow
def test_paths_replayed_by_the_statics_end_at_the_targets() -> None:
    tips = draw(10, 0.2, 3)
    solution = inverse.solve(PAPER, tips, friction=0.2)
    assert solution.path is not None
    again = np.array([replay(solution, row, 0.2).points[-1] for row in range(len(tips))])
    left = np.linalg.norm(again - tips, axis=-1)
    np.testing.assert_allclose(solution.distance, left, rtol=0, atol=1e-9)
    assert (left <= 5e-5).all()
    along = statics.load_along(PAPER, solution.path, friction=0.2)
    np.testing.assert_array_equal(along.points, solution.points)
    np.testing.assert_array_equal(solution.status == Status.OUT_OF_REACH, left > 5e-5)


@pytest.mark.slow
def test_the_order_matters_and_friction_cannot_be_left_out() -> None:
    """The frictionless answer misses by centimetres, and so does the path in reverse order."""
    tip = pull_two(0, (0.06, 0.06), 0.0, 0.2).points[-1]
    solution, plain = inverse.solve(PAPER, tip, friction=0.2), inverse.solve(PAPER, tip)
    assert solution.distance < 5e-5
    path = solution.path
    assert path is not None
    backwards = replace(path, order=np.array([*path.order[path.order >= 0][::-1], *path.order[path.order < 0]]))
    assert np.linalg.norm(statics.load_along(PAPER, backwards, friction=0.2).points[-1] - tip) > 2e-2
    assert np.linalg.norm(statics.solve(PAPER, tension=plain.tension, friction=0.2).points[-1] - tip) > 2e-2


def test_a_path_that_the_replay_does_not_confirm_is_refined(monkeypatch) -> None:
    """The search's loading ends millimetres away when replayed; the tension next to 0 that is no part of it goes."""
    path = statics.LoadingPath(
        order=np.array([2, -1, -1]), pull=np.array([0.0, 0.0, 0.08]), tension=np.array([0.0, 0.0, MOST]),
        by_tension=np.array([True, True, False]),
    )  # fmt: skip
    tip = statics.load_along(PAPER, path, friction=0.4).points[-1]
    found = Found(np.array([5e-4, 0.0805, 0.0]), (0, 2, 1), np.array([0.0, 0.0, 0.0805]), 1e-6)
    monkeypatch.setattr("spiraltrunk.model.inverse.friction.search_path", lambda *_: found)
    monkeypatch.setattr("spiraltrunk.model.inverse.friction.get_friction_starts", lambda *_: None)
    solution = inverse.solve(PAPER, tip, friction=0.4)
    assert solution.distance <= 5e-5
    assert solution.path is not None
    np.testing.assert_array_equal(solution.path.order, path.order)
    again = statics.load_along(PAPER, solution.path, friction=0.4)
    np.testing.assert_array_equal(again.points, solution.points)


@pytest.mark.slow
def test_base_pose_load_and_direction_are_met() -> None:
    case = {"theta_0": 1.2, "roll": 0.4, "loads": Loads(mass=0.02)}
    shape = pull_two(1, (0.04, 0.02), 1.0, 0.15, **case)
    way = shape.points[-1] - shape.points[-2]
    solution = inverse.solve(PAPER, shape.points[-1], direction=way, friction=0.15, **case)
    assert solution.status == Status.CONVERGED
    assert solution.turn is not None
    assert solution.turn < 1e-3
    assert solution.path is not None
    again = statics.load_along(PAPER, solution.path, friction=0.15, **case)
    np.testing.assert_array_equal(again.points, solution.points)


def test_a_far_target_is_out_of_reach_by_no_less_than_the_trunk_is_short() -> None:
    solution = inverse.solve(PLANAR, [[0.0, -3.0, 0.0]], friction=0.2, options=inverse.InverseOptions(tries=2))
    assert solution.status.tolist() == [Status.OUT_OF_REACH]
    assert 3.0 - PAPER.length <= solution.distance[0] < 3.0 - PAPER.length + 1e-3


def test_without_friction_nothing_changes_and_the_design_says_how_much_there_is() -> None:
    tip = [0.1, -0.4, 0.05]
    plain, zero = inverse.solve(PAPER, tip), inverse.solve(PAPER, tip, friction=0.0)
    assert zero.path is None
    np.testing.assert_array_equal(plain.tension, zero.tension)
    np.testing.assert_array_equal(plain.points, zero.points)
    rough = replace(PLANAR, cable=replace(PLANAR.cable, friction=0.2))
    by_design, asked = inverse.solve(rough, tip), inverse.solve(PLANAR, tip, friction=0.2)
    np.testing.assert_array_equal(by_design.points, asked.points)
    assert np.linalg.norm(inverse.solve(PLANAR, tip).points - asked.points) > 1e-2
    np.testing.assert_array_equal(
        inverse.solve(rough, tip, friction=0.0).points, inverse.solve(PLANAR, tip, friction=0.0).points
    )


@pytest.mark.parametrize("friction", [-0.1, np.nan, np.inf, 2.0, "0.2"])
def test_a_friction_out_of_range_is_refused(friction) -> None:
    with pytest.raises((DesignError, ModelError), match="friction"):
        inverse.solve(PAPER, [0.1, -0.4, 0.0], friction=friction)


def test_quasi_static_loading_is_refused_with_friction() -> None:
    options = inverse.InverseOptions(statics=statics.StaticsOptions(quasi_static=statics.QuasiStatic()))
    with pytest.raises(ModelError, match="quasi_static"):
        inverse.solve(PAPER, [0.1, -0.4, 0.0], friction=0.2, options=options)


@pytest.mark.parametrize(
    ("part", "words"),
    [
        ({"order": [0, 1]}, "shape"),
        ({"order": [0, 1, 3]}, "out of range"),
        ({"order": [0.0, 1.0, 2.0]}, "integers"),
        ({"by_tension": [0, 1, 1]}, "booleans"),
        ({"order": [0], "pull": [0.0], "tension": [0.0], "by_tension": [True]}, "1 cables"),
        ({"pull": [np.nan, 0.0, 0.0]}, "pull is nan"),
        ({"order": [0, 0, -1]}, "twice"),
    ],
)
def test_a_wrong_path_is_refused(part: dict, words: str) -> None:
    good = {"order": [0, -1, -1], "pull": [0.01, 0, 0], "tension": [60.0, 0, 0], "by_tension": [False, True, True]}
    with pytest.raises(ModelError, match=words):
        statics.load_along(PAPER, statics.LoadingPath(**(good | part)), friction=0.1)


def test_turns_are_assigned_to_any_number_of_cables() -> None:
    assert assign_turns(1) == [(-1, 0, -1)]
    assert assign_turns(2) == [(-1, 0, 1), (-1, 1, 0)]
    assert len(assign_turns(3)) == 6
    assert len(assign_turns(4)) == 24


def test_a_trunk_with_two_cables_meets_a_tip_of_its_plane() -> None:
    shape = statics.solve(PLANAR, pull=[0.05, 0.0], by_tension=[False, True], friction=0.2)
    solution = inverse.solve(PLANAR, shape.points[-1], friction=0.2)
    assert solution.distance < 5e-5


def test_a_bounded_step_is_the_least_squares_step_within_its_bounds() -> None:
    rng = np.random.default_rng(0)
    jacobian, residual, most = rng.normal(size=(3, 3)), rng.normal(size=3), np.array([2.0, 2.0, 0.0])
    free = bounded_step(np.ones(3), np.full(3, 9.0), jacobian, 0.1 * residual, 0.0)
    np.testing.assert_allclose(jacobian @ free, -0.1 * residual, atol=1e-9)
    step = bounded_step(np.array([0.0, 1.0, 0.0]), most, jacobian, residual, 1e-6)
    assert step[2] == 0.0
    assert step[0] >= 0.0
    assert 0.0 <= 1.0 + step[1] <= 2.0


def test_shapes_and_solutions_are_printed_in_a_line() -> None:
    shape = statics.solve(PAPER, tension=[[1.0, 0, 0], [2.0, 0, 0]])
    assert repr(shape).startswith("Shape(batch (2,), 18 sections, 3 cables, tip x ")
    assert repr(shape).endswith("CONVERGED 2)")
    solution = inverse.solve(PLANAR, [0.1, -0.4, 0.05], friction=0.2)
    assert len(repr(shape)) < 240
    assert len(repr(solution)) < 240
    assert "by" in repr(solution.path)


def test_a_whole_shape_and_a_curl_refuse_friction_and_say_how_to_neglect_it():
    rough = replace(PAPER, cable=replace(PAPER.cable, friction=0.2))
    calls = {
        "follow": lambda design, **given: inverse.follow(design, statics.solve(PAPER).points, **given),
        "curl": lambda design, **given: inverse.curl(design, [-0.06, -0.33, 0.0], 0.05, **given),
    }
    for name, call in calls.items():
        with pytest.raises(ModelError, match=rf"friction is 0\.2; allowed in {name}: 0"):
            call(rough)
        with pytest.raises(ModelError, match=r"friction is 0\.1; allowed"):
            call(PAPER, friction=0.1)
        np.testing.assert_array_equal(call(rough, friction=0.0).tension, call(PAPER).tension)
