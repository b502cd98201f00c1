"""The trunk of the tab, and what is said of it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.model.statics.pull_sequences import wind_cables
from spiraltrunk.studio.shape import texts
from spiraltrunk.studio.shape.compile_models import compile_models
from spiraltrunk.studio.shape.state import TrunkState


@pytest.fixture
def state():
    state = TrunkState(presets.PAPER)
    state.solve()
    state.compare()
    return state


def test_a_solution_is_the_equilibrium_of_the_pulls(state):
    state.pull = np.array([0.08, -0.12, -0.12])
    state.turn(1.0, 0.3)
    state.restart()
    state.solve()
    assert np.array_equal(state.shape.points, wind_cables(presets.PAPER, state.pull, 1.0, 0.3).points)


def test_the_tip_follows_to_where_another_pull_brings_it(state):
    target = wind_cables(presets.PAPER, [0.06, 0.02, -0.12]).points[-1]
    left = state.reach(target, is_final=True)
    assert left < 5e-5
    again = wind_cables(presets.PAPER, state.pull, start=state.shape)
    assert again.points == pytest.approx(state.shape.points, abs=1e-6)


def test_out_of_reach_is_told_in_millimetres(state):
    target = np.array([2.0, 0.0, 0.0])
    left = state.reach(target, is_final=True)
    assert left == pytest.approx(np.linalg.norm(state.tip - target))
    state.compare()
    text = texts.format_state(state, (left, True))
    assert f"Out of reach: the tip stays {1e3 * left:.1f} mm away" in text


def test_friction_leaves_a_distance_that_is_told():
    rough = replace(presets.PAPER, cable=replace(presets.PAPER.cable, friction=0.1))
    state = TrunkState(rough)
    target = wind_cables(presets.PAPER, [0.06, 0.02, -0.12]).points[-1]
    left = state.reach(target, is_final=False)
    assert left > 1e-3
    assert left == pytest.approx(np.linalg.norm(state.shape.points[-1] - target))


def test_the_words_name_status_shut_joints_tensions_and_the_paper(state):
    state.pull = np.array([0.09, -0.12, -0.12])
    state.solve()
    state.compare()
    text = texts.format_state(state, None)
    assert "<b>Converged</b>" in text
    assert "7 to 17 of 17" in text
    assert "2: slack, 3: slack" in text
    assert "cable 1 in by 90.0 mm" in text


def test_runs_of_joints_are_joined():
    assert texts.format_runs(np.array([True, False, True, True])) == "1, 3 to 4 of 4"
    assert texts.format_runs(np.zeros(17, bool)) == "none of 17"


def test_compilation_calls_every_model_and_says_which():
    told = []
    compile_models(told.append, presets.PAPER)
    assert [one.partition(" (")[0] for one in told] == ["static equilibrium", "the paper's model", "inverse model"]


def test_the_straight_trunk_stands_in_before_there_is_a_model():
    state = TrunkState(presets.PAPER)
    state.turn(math.pi / 6, 0.0)
    assert state.tip == pytest.approx(presets.PAPER.length * np.array([math.sqrt(0.75), -0.5, 0.0]))
