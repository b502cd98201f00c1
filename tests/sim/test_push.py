"""Whole kicks and sweeps: balls, boxes and cylinders go where they shall, unaided."""

import numpy as np
import pytest

from spiraltrunk import strategies
from spiraltrunk.design.presets import PAPER
from spiraltrunk.sim import parse_object
from spiraltrunk.workflows.grasp.trial import run_trial
from spiraltrunk.workflows.grasp.world import draw_scene


@pytest.mark.slow
@pytest.mark.parametrize("name", ["box-100", "ball-100", "cylinder-120"])
def test_a_kick_sends_an_object_the_goals_way(name):
    trial = run_trial(PAPER, parse_object(name), strategy="kick", seed=7)
    assert trial.verdict.reason == "success"
    moved = trial.plant.trace[-1].object_position - trial.plant.trace[0].object_position
    assert moved[1] > 0.15
    assert abs(moved[0]) < moved[1] * np.tan(np.radians(30.0))
    assert trial.plant.model.neq == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cylinder-60", "ball-30", "cube-28"])
def test_a_sweep_brings_an_object_to_where_it_is_then_grasped(name):
    trial = run_trial(PAPER, parse_object(name), strategy="sweep", seed=1)
    assert trial.verdict.reason == "success"
    assert trial.plant.model.neq == 0


@pytest.mark.parametrize("name", ["kick", "sweep"])
def test_a_pushed_object_waits_where_its_strategy_says_and_its_goal_lies_as_far_as_it_says(name):
    strategy = strategies.get(name)
    options = draw_scene(parse_object(strategy.objects[0]), 3, strategy=strategy)
    assert options.position[:2] == strategy.position
    assert options.push == strategy.push


def test_a_sweep_ends_where_the_wrap_that_follows_has_its_objects():
    sweep, wrap = strategies.get("sweep"), strategies.get("wrap-horizontal")
    np.testing.assert_allclose(np.add(sweep.position, sweep.push), wrap.position)
