"""What is no design, no object, no strategy, no world: one line that says what was given and what is allowed."""

import math

import numpy as np
import pytest

from spiraltrunk import strategies
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DesignError, RunError, UnknownName
from spiraltrunk.run import run
from spiraltrunk.sim import SceneOptions, SimPlant, arm_spec, build_model, parse_object, trunk_spec
from spiraltrunk.sim.sensors import SensorOptions
from spiraltrunk.trial import Spread, draw_scene, run_trial

OBJECT = parse_object("cylinder-60")

REFUSED = {
    "plant of a name": (lambda: SimPlant("paper"), "design is 'paper'; allowed: TrunkDesign"),
    "plant of a table": (lambda: SimPlant({}), "design is {}; allowed: TrunkDesign"),
    "plant with a number": (lambda: SimPlant(PAPER, 5), "options is 5; allowed: SceneOptions"),
    "plant of options": (lambda: SimPlant(SceneOptions()), "design is SceneOptions.*allowed: TrunkDesign"),
    "trunk of a name": (lambda: trunk_spec("paper"), "design is 'paper'; allowed: TrunkDesign"),
    "trunk with a table": (lambda: trunk_spec(PAPER, {}), "options is {}; allowed: TrunkOptions"),
    "arm of a name": (lambda: arm_spec("panda"), "arm is 'panda'; allowed: ArmDesign"),
    "model of a name": (lambda: build_model("paper"), "design is 'paper'; allowed: TrunkDesign"),
    "model with a table": (lambda: build_model(PAPER, {}), "options is {}; allowed: SceneOptions"),
    "object of a number": (lambda: parse_object(5), "object is 5; allowed: str"),
    "trial of a named object": (lambda: run_trial(PAPER, "cylinder-60"), "object is 'cylinder-60'; .*parse_object"),
    "trial of a named design": (lambda: run_trial("paper", OBJECT), "design is 'paper'; allowed: TrunkDesign"),
    "trial of no spread": (lambda: run_trial(PAPER, OBJECT, spread=0.1), "spread is 0.1; allowed: Spread"),
    "trial of no strategy": (lambda: run_trial(PAPER, OBJECT, strategy=1), "strategy is 1; .*strategies.get"),
    "scene of no strategy": (lambda: draw_scene(OBJECT, 0, strategy="pinch"), "strategy is 'pinch'; .*strategies.get"),
    "run without a plant": (lambda: run(None, strategies.get("pinch")), "plant is None; allowed: a Plant"),
    "run of a class": (lambda: run(SimPlant, strategies.get("pinch")), "plant is <class.*allowed: a Plant"),
    "run of a name": (lambda: run(SimPlant(), "pinch"), "strategy is 'pinch'; allowed: a Strategy.*strategies.get"),
    "run of a strategy's class": (lambda: run(SimPlant(), strategies.Strategy), "strategy is <class.*a Strategy"),
    "strategy of a list": (lambda: strategies.get(["pinch"]), "unknown strategy.*known: wrap-vertical"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_of_another_kind_is_refused(name):
    call, words = REFUSED[name]
    with pytest.raises((DesignError, RunError, UnknownName), match=words) as refusal:
        call()
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("seed", [-1, 1.5, "1", None, True, math.nan, [1, 2]])
def test_a_seed_is_a_whole_number(seed):
    with pytest.raises(DesignError, match=r"seed is .*; allowed: a whole number, at least 0"):
        draw_scene(OBJECT, seed)


def test_a_seed_of_numpy_is_a_seed():
    assert draw_scene(OBJECT, np.int64(7)) == draw_scene(OBJECT, 7)


@pytest.mark.parametrize(
    "changes",
    [
        {"position": (0.4, 0.1)}, {"position": "abc"}, {"position": 0.4}, {"offset": (0.0, 0.0, math.nan)},
        {"push": (0.1, 0.2, 0.3)}, {"shape": "cylinder-60"}, {"told": "cylinder-60"}, {"trunk": None}, {"sensors": 3},
        {"timestep": "1 ms"}, {"stage": ["hung"]},
    ],
)  # fmt: skip
def test_a_world_is_checked_when_it_is_made(changes):
    with pytest.raises((DesignError, UnknownName)):
        SceneOptions(**changes)


@pytest.mark.parametrize(
    "changes",
    [
        {"position": -0.01}, {"position": math.nan}, {"yaw": "10"}, {"size": 1.0}, {"mass": math.inf},
        {"stiffness": 1.5}, {"friction": 0.5}, {"friction": (0.5,)}, {"friction": (1.2, 0.5)}, {"friction": (0.0, 0.5)},
        {"friction": (0.5, math.nan)}, {"sensors": None},
    ],
)  # fmt: skip
def test_a_spread_is_checked_when_it_is_made(changes):
    with pytest.raises(DesignError, match=rf"spread\.{next(iter(changes))}"):
        Spread(**changes)


@pytest.mark.parametrize(
    "changes", [{"looks": 1}, {"seed": -1}, {"seed": 0.5}, {"delay": None}, {"pull_noise": math.nan}]
)
def test_sensors_are_checked_when_they_are_made(changes):
    with pytest.raises(DesignError, match=rf"sensors\.{next(iter(changes))}"):
        SensorOptions(**changes)
