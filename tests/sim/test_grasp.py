"""Whole grasps: the default object is lifted, carried, held and released, by friction alone and the same each time."""

from dataclasses import fields, replace

import numpy as np
import pytest

from spiraltrunk import strategies
from spiraltrunk.control.loop import run
from spiraltrunk.design import ArmDesign, load_design, write_design
from spiraltrunk.design.presets import PAPER
from spiraltrunk.sim import SimPlant, parse_object
from spiraltrunk.sim.objects.catalogue import DEFAULT_OBJECT
from spiraltrunk.sim.robot.fr3 import FR3
from spiraltrunk.strategies.wrap.hung_model import predict_wrap
from spiraltrunk.workflows.grasp.trial import run_trial
from spiraltrunk.workflows.grasp.verdict.evidence import Evidence
from spiraltrunk.workflows.grasp.verdict.grasp_verdict import evaluate_grasp
from spiraltrunk.workflows.grasp.world import EXACT, Spread, draw_scene

SHAPE = parse_object(DEFAULT_OBJECT)


@pytest.fixture(scope="module")
def trial():
    return run_trial(PAPER, SHAPE, seed=0)


@pytest.mark.slow
def test_the_default_grasp_succeeds(trial):
    assert trial.verdict.reason == "success"
    assert trial.verdict.success
    assert trial.plant.warnings == 0
    assert trial.plant.model.neq == 0


@pytest.mark.slow
def test_the_object_went_where_the_verdict_says(trial):
    """Height and place read off the trace directly."""
    heights = np.array([sample.object_position[2] for sample in trial.plant.trace])
    assert heights.max() - heights[0] > 0.14
    np.testing.assert_allclose(trial.plant.trace[-1].object_position, trial.plant.task.goal.place, atol=0.05)
    held = [s for s in trial.plant.trace if s.grip_force > 0 and s.string_tension == 0 and not s.touches_table]
    assert len(held) * trial.plant.control_period > 3.0
    assert trial.plant.trace[-1].grip_force == 0.0


def _bytes(trace):
    return [np.asarray(getattr(sample, field.name)).tobytes() for sample in trace for field in fields(sample)]


@pytest.mark.slow
def test_the_same_seed_gives_the_same_trace_to_the_bit():
    """The shortest strategy; `tests/cli/test_grasp.py` compares the figures of the default one."""
    trial, again = (run_trial(PAPER, parse_object("ball-80"), strategy="kick", seed=0) for _ in range(2))
    assert len(again.plant.trace) == len(trial.plant.trace)
    assert _bytes(again.plant.trace) == _bytes(trial.plant.trace)
    assert again.verdict == trial.verdict


@pytest.mark.slow
def test_the_fr3_of_a_design_file_grasps_within_its_own_limits(tmp_path):
    write_design(replace(PAPER, arm=ArmDesign(model="fr3")), tmp_path / "trunk.toml")
    fr3 = run_trial(load_design(tmp_path / "trunk.toml"), SHAPE, seed=0)
    assert (fr3.verdict.reason, fr3.verdict.unjudged) == ("success", ())
    assert fr3.plant.arm_limits is FR3.limits
    evidence = Evidence.from_run(fr3.plant, fr3.log)
    for quantity in ("acceleration", "torque", "velocity"):  # Each is truly judged: at a fifth of it, it is passed.
        tight = replace(FR3.limits, **{quantity: 0.18 * getattr(FR3.limits, quantity)})
        verdict = evaluate_grasp(replace(evidence, limits=tight))
        assert verdict.reason == f"the arm passed its {quantity.replace('velocity', 'speed')} limit"


@pytest.mark.slow
def test_another_seed_gives_another_world(trial):
    other = run_trial(PAPER, SHAPE, seed=1)
    assert other.options != trial.options
    assert _bytes(other.plant.trace) != _bytes(trial.plant.trace)


def test_worlds_are_drawn_within_their_bounds():
    spread, drawn = Spread(), [draw_scene(SHAPE, seed) for seed in range(200)]
    offset = np.array([scene.offset for scene in drawn])
    assert (np.abs(offset) <= spread.position).all()
    assert np.abs(offset).max() > 0.8 * spread.position
    friction = np.array([scene.shape.friction for scene in drawn])
    assert spread.friction[0] <= friction.min() < 0.55 < 1.15 < friction.max() <= spread.friction[1]
    ratios = {
        "stiffness": [scene.trunk.stiffness_factor for scene in drawn],
        "size": [scene.shape.width / SHAPE.width for scene in drawn],
        "mass": [scene.shape.mass / SHAPE.mass for scene in drawn],
    }
    for name, ratio in ratios.items():
        bound, most = getattr(spread, name), np.abs(np.array(ratio) - 1)
        assert 0.8 * bound < most.max() <= bound + 1e-12, name
    yaw = np.abs([scene.yaw_error for scene in drawn])
    assert 0.8 * spread.yaw < yaw.max() <= spread.yaw
    assert len({scene.sensors.seed for scene in drawn}) == 200
    assert drawn[3] == draw_scene(SHAPE, 3)


def test_what_the_robot_is_told_is_not_what_was_drawn():
    plant = SimPlant(PAPER, draw_scene(SHAPE, 3))
    told = plant.task.target
    assert (told.width, told.mass) == (SHAPE.width, SHAPE.mass)
    assert plant.options.shape.width != told.width


def test_an_exact_world_differs_in_place_friction_and_stiffness_alone():
    scene = draw_scene(SHAPE, 3, spread=EXACT)
    assert replace(scene.shape, friction=SHAPE.friction) == SHAPE
    assert (scene.yaw, scene.yaw_error) == (0.0, 0.0)
    assert scene.sensors.delay == scene.sensors.torque_noise == 0.0


@pytest.mark.slow
def test_nothing_slippery_is_carried():
    """Friction holds the object: almost without any, the same grasp fails; at 0.02 one may still lie balanced."""
    scene = draw_scene(SHAPE, 0)
    plant = SimPlant(PAPER, replace(scene, shape=replace(scene.shape, friction=0.002)))
    log = run(plant, strategies.get("wrap-vertical"))
    end = plant.trace[-1].object_position
    is_placed = log.gave_up is None and np.linalg.norm(end - plant.task.goal.place) < 0.05
    assert not is_placed


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "measures"), [(333, "diameter_mm=100,mass_g=469"), (344, "diameter_mm=42,mass_g=444")]
)
def test_what_tilts_in_the_loop_is_set_down_in_its_place(seed, measures):
    """Wide and heavy, or thin and heavy: it touches with one end, and is moved along before it is let go."""
    trial = run_trial(PAPER, parse_object(f"cylinder:height_mm=240,{measures}"), seed=seed)
    assert trial.verdict.reason == "success"


@pytest.mark.slow
def test_a_kilogram_and_a_half_is_lifted_carried_and_set_down():
    """Near the most that 60 N on the base's joints bear."""
    shape = parse_object("cylinder:diameter_mm=60,height_mm=240,mass_g=1500")
    assert run_trial(PAPER, shape, seed=0, spread=EXACT).verdict.reason == "success"


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_what_is_heavy_is_carried_so_gently_that_it_does_not_bob(seed):
    shape = parse_object("cylinder:diameter_mm=60,height_mm=240,mass_g=1200")
    trial = run_trial(PAPER, shape, seed=seed, spread=EXACT)
    assert trial.verdict.reason == "success"
    hold = trial.log.span("transport", "hold")
    heights = [sample.object_position[2] for sample in trial.plant.trace if hold[0] <= sample.time <= hold[1]]
    assert np.ptp(heights) < 0.015


class Reached(Exception):
    """The action that was waited for has come."""


@pytest.mark.parametrize(
    "name", ["cylinder-33", *(pytest.param(name, marks=pytest.mark.slow) for name in ("cylinder-60", "cylinder-90"))]
)
def test_the_object_settles_where_the_plan_expects_it(name):
    """Relative to the base: within 30 mm ahead and 60 mm below."""
    shape = parse_object(name)
    plant = SimPlant(PAPER, replace(draw_scene(shape, 0), offset=(0.0, 0.0, 0.0), shape=shape))
    seen = []

    def watch(observation, status):
        seen.append(observation)
        if status.action == "hold":
            raise Reached

    with pytest.raises(Reached):
        run(plant, strategies.get("wrap-vertical"), watch=watch)
    last = seen[-1]
    tension = float(last.cable_tension[1:].mean())
    center = predict_wrap(PAPER, shape.width, shape.mass, tension).center
    way = last.T_world_base[:3, :3].T @ (plant.trace[-1].object_position - last.T_world_base[:3, 3])
    assert way[0] == pytest.approx(center[0], abs=0.060)
    assert -way[1] == pytest.approx(center[1], abs=0.030)
