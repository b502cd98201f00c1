"""What is no design, no object, no strategy, no world: one line that says what was given and what is allowed."""

import dataclasses
import math

import numpy as np
import pytest

from spiraltrunk import strategies
from spiraltrunk.control.loop import run
from spiraltrunk.control.messages import Command
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DesignError, RunError, UnknownName
from spiraltrunk.sim import SceneOptions, SimPlant, arm_spec, build_model, parse_object, trunk_spec
from spiraltrunk.sim.mujoco_log import quiet_mujoco
from spiraltrunk.sim.relaxation.relax import RelaxationOptions
from spiraltrunk.sim.robot.trunk import TrunkOptions
from spiraltrunk.sim.sensors import SensorOptions
from spiraltrunk.workflows.grasp.trial import run_trial
from spiraltrunk.workflows.grasp.world import Spread, draw_scene

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
    "sensors of no delay": (lambda: SensorOptions(delay=math.nan), "sensors.delay is nan"),
    "sensors of negative noise": (lambda: SensorOptions(pull_noise=-1e-3), "sensors.pull_noise is -0.001"),
    "trunk of no stiffness": (lambda: TrunkOptions(stiffness_factor=0.0), "trunk.stiffness_factor is 0"),
    "trunk of an infinite gain": (lambda: TrunkOptions(cable_gain=math.inf), "trunk.cable_gain is inf"),
    "winders that stand still": (lambda: RelaxationOptions(pull_speed=0.0), "relaxation.pull_speed is 0"),
    "tensions of no rate": (lambda: RelaxationOptions(tension_speed=math.nan), "relaxation.tension_speed is nan"),
    "rest at no speed": (lambda: RelaxationOptions(still=0.0), "relaxation.still is 0"),
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
        {"support": "wall"}, {"orientation": "upright"}, {"push": (0.1, 0.0)},
        {"timestep": 3e-3}, {"timestep": 5e-3}, {"timestep": 5e-5}, {"timestep": math.nan}, {"timestep": "1e-3"},
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


def _with(part, **changes):
    return dataclasses.replace(PAPER, **{part: dataclasses.replace(getattr(PAPER, part), **changes)})


@pytest.mark.parametrize(
    ("design", "options"),
    [
        (_with("gripper", mass=1e-12), SceneOptions()),
        (PAPER, SceneOptions(position=(0.45, 0.1, -1.0))),
    ],
)  # fmt: skip
def test_a_world_that_mujoco_cannot_build_is_refused_in_one_line(design, options):
    with pytest.raises(DesignError, match=r"world is one that MuJoCo refuses; allowed: .*it says: Error") as refusal:
        build_model(design, options)
    assert "\n" not in str(refusal.value)


def test_a_simulation_that_diverges_says_so_and_starts_anew(tmp_path, monkeypatch):
    """MuJoCo resets itself then, in the middle of a step: time would begin again as if nothing had been."""
    monkeypatch.chdir(tmp_path)
    plant = SimPlant(PAPER, SceneOptions(support="ground", position=(0.3, 0.0, 0.6), ground=1.2))
    first = plant.reset()

    def hold(seen):
        for _ in range(40):
            before, seen = seen.time, plant.step(Command(T_world_base=seen.T_world_base, cable_tension=np.zeros(3)))
            assert seen.time > before

    with quiet_mujoco(), pytest.raises(RunError, match=r"the simulation diverged after 0\.\d\d s"):
        hold(first)
    assert list(tmp_path.iterdir()) == []
    assert plant.reset().time == first.time == 0.0
    assert plant.warnings == 0


def test_a_task_cannot_be_changed_by_who_is_given_it():
    goal, target = SimPlant().task.goal, SimPlant().task.target
    for array in (goal.place, goal.aside, target.position, target.axis):
        with pytest.raises(ValueError, match="read-only"):
            array[:] = 0.0


def test_a_late_command_is_the_one_that_was_given():
    """What its arrays are made to hold while it is under way changes nothing."""
    plants = [SimPlant(PAPER, SceneOptions(sensors=SensorOptions(delay=0.06))) for _ in range(2)]
    frame = plants[0].reset().T_world_base
    plants[1].reset()
    tension, reused = np.array([0.0, 3.0, 3.0]), np.array([0.0, 3.0, 3.0])
    for _ in range(8):
        seen = plants[0].step(Command(T_world_base=frame, cable_tension=tension))
        reused[:] = tension
        again = plants[1].step(Command(T_world_base=frame.copy(), cable_tension=reused))
        reused[:] = np.nan
        np.testing.assert_array_equal(again.cable_tension, seen.cable_tension)
    assert seen.cable_tension[1] > 1.0


OWN = {
    "job": ({"job": "dance"}, r"strategy\.job is 'dance'; allowed: grasp, kick, sweep"),
    "name": ({"name": 3}, r"strategy\.name is 3; allowed: a printable text"),
}


@pytest.mark.parametrize(("changes", "words"), OWN.values(), ids=OWN)
def test_a_strategy_of_ones_own_is_read_before_its_trial(changes, words):
    own = type("Own", (type(strategies.get("pinch")),), changes)()
    with pytest.raises(DesignError, match=words):
        run_trial(PAPER, OBJECT, strategy=own)
