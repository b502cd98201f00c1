"""Slopes of states with friction: against differences, and by the law that stiffness over mass is all that counts."""

import math

import numpy as np
import pytest

from spiraltrunk.calibration.parameters import apply_parameters, name_parameters
from spiraltrunk.calibration.predict_states import State, is_one_increment, predict_statics
from spiraltrunk.calibration.sensitivities import by_parameters
from spiraltrunk.design.presets import PAPER
from spiraltrunk.model.statics.pull_sequences import carry_gripper

TRUNK = carry_gripper(PAPER)
NAMES = name_parameters(PAPER)
NAN = math.nan


TWIST = tuple(
    State(theta_0=math.pi / 2, pull=(0.06, second, NAN), before=i - 1, kind="twist", chain=0)
    for i, second in enumerate((-0.028, -0.023, -0.018, -0.013, -0.008))
)
"""Cable 1 pulled in and held, then cable 2 step by step."""


def _states():
    """Rest at a tilt, and four steps of a dorsal bend of a hanging trunk."""
    rest = State(theta_0=0.3, pull=(NAN, NAN, NAN), before=-1, kind="rest", chain=0)
    bend = [
        State(
            theta_0=math.pi / 2,
            pull=(0.02 * (i + 1), NAN, NAN),
            before=-1 if i == 0 else i,
            kind="bend-dorsal",
            chain=1,
        )
        for i in range(4)
    ]
    return (rest, *bend)


def _values(seed=3):
    draw = np.random.default_rng(seed)
    return np.array([*(0.1 * draw.standard_normal(17)), 0.05, 0.01, 0.2, 0.003, 0.003, 0.003, 0.005, 2e-5])


def _predict(values, states=None):
    design, winders = apply_parameters(TRUNK, values)
    return design, predict_statics(design, states or _states(), winders)


def _differentiate(values, states):
    design, found = _predict(values, states)
    each = []
    for shape, state, length in zip(found.shapes, states, found.length, strict=True):
        before = None if state.before < 0 else each[state.before]
        each.append(
            by_parameters(
                design, shape, theta_0=state.theta_0, length=length, compliance=values[-1], before=before,
                is_direct=before is not None and is_one_increment(state, states),
            )
        )  # fmt: skip
    return np.array([one.points for one in each])


@pytest.fixture(scope="module")
def slopes():
    return _differentiate(_values(), _states())


@pytest.fixture(scope="module")
def twisted():
    return _differentiate(_values(), TWIST)


@pytest.mark.parametrize(
    "name", ["stiffness_01", "stiffness_09", "stiffness_17", "center", "friction", "slack_1", "hole", "give"]
)
def test_slopes_are_those_of_differences(slopes, name):
    _check_slopes(name, slopes, _states())


@pytest.mark.parametrize("name", ["stiffness_09", "friction", "slack_1", "slack_2", "hole", "give"])
def test_slopes_of_a_twist_know_what_sticking_holes_remember(twisted, name):
    """Cable 1 is held and most of its holes stick: as constants, their forces made half of the slope by friction."""
    _check_slopes(name, twisted, TWIST)


def _check_slopes(name, slopes, states):
    k, step = NAMES.index(name), {"slack_1": 1e-6, "slack_2": 1e-6, "give": 1e-7}.get(name, 1e-4)
    ends = []
    for side in (step, -step):
        values = _values()
        values[k] += side
        ends.append(_predict(values, states)[1].points)
    expected = (ends[0] - ends[1]) / (2 * step)
    size = max(float(np.abs(expected).max()), 1e-9)
    np.testing.assert_allclose(slopes[:, k] / size, expected / size, rtol=0, atol=2e-3)


def test_mass_moves_the_trunk_as_all_stiffnesses_do_the_other_way(slopes):
    """What gives under a force gives as much less under one that is scaled up with all others."""
    together = slopes[:, :17].sum(axis=1) + slopes[:, NAMES.index("mass")]
    together -= _values()[NAMES.index("give")] * slopes[:, NAMES.index("give")]
    # The friction's elastic foot, 20 um at 1 N, does not scale with them.
    assert np.abs(together).max() < 1e-3 * np.abs(slopes[:, NAMES.index("mass")]).max()


def test_a_cable_that_is_never_pulled_moves_nothing(slopes):
    assert (slopes[:, NAMES.index("slack_2")] == 0).all()


def test_at_rest_neither_friction_nor_holes_count(slopes):
    for name in ("friction", "hole", "slack_1"):
        assert (slopes[0, NAMES.index(name)] == 0).all()


def test_without_friction_the_slope_by_friction_is_that_of_a_little():
    values, k, step = _values(), NAMES.index("friction"), 1e-4
    values[k] = 0.0
    design, found = _predict(values)
    slopes = by_parameters(
        design, found.shapes[2], theta_0=math.pi / 2, length=found.length[2], compliance=values[-1]
    ).points
    values[k] = step
    expected = (_predict(values)[1].points[2] - found.points[2]) / step
    np.testing.assert_allclose(slopes[k], expected, rtol=0, atol=0.02 * np.abs(expected).max())
