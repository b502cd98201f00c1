"""The stroke of a policy: from numbers to moves of the base, and from what is seen to what the network takes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.control.messages import CameraObservation, Observation
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.design import presets
from spiraltrunk.errors import ModelError
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.strategies.policy.description import Layers, PolicyDescription
from spiraltrunk.strategies.policy.network import Network
from spiraltrunk.strategies.policy.stroke_strategy import (
    INPUTS,
    OUTPUTS,
    RANGES,
    StrokeStrategy,
    describe_scene,
    plan_moves,
    plan_stroke,
)
from spiraltrunk.strategies.push.approach_pose import plan_pose, reach_of
from spiraltrunk.strategies.push.kick import Kick
from spiraltrunk.workflows.grasp.world import draw_scene

ABOUT = PolicyDescription(
    control_mode="stroke", inputs=INPUTS, outputs=OUTPUTS, networks={"action": Layers(sizes=(12, 6))}, n_cable=3,
    job="kick", support="ground", orientation="upright", holds="nothing", needs_camera=True, objects=Kick.objects,
    position=Kick.position, push=Kick.push,
)  # fmt: skip


@pytest.fixture(scope="module")
def ground(observation: Observation) -> Observation:
    """A box on the ground, seen 1 cm along the way and 2 cm to the left of where it was announced."""
    scene = draw_scene(parse_object("box-80"), 0, strategy=Kick())
    task = build_task(presets.PAPER, scene)
    seen = CameraObservation(
        time=0.0, position=task.target.position + np.array([-0.02, 0.01, 0.0]), axis=np.array([0.0, 0.0, 1.0])
    )
    return replace(observation, task=task, camera=seen)


def test_what_the_network_takes(ground: Observation) -> None:
    values = dict(zip(INPUTS, describe_scene(plan_pose(ground.task, 0.0), ground), strict=True))
    assert (values["is_sphere"], values["is_box"], values["is_upright"]) == (0.0, 1.0, 1.0)
    assert values["width"] == pytest.approx(0.08)
    assert (values["seen_along"], values["seen_across"]) == (pytest.approx(0.01), pytest.approx(-0.02))
    assert values["goal_distance"] == pytest.approx(0.15)
    assert values["height"] == pytest.approx(0.24, abs=1e-3)


def test_stroke_of_the_middle_goes_the_goals_way(ground: Observation) -> None:
    pose = plan_pose(ground.task, 0.0)
    stroke = plan_stroke(np.zeros(6), pose, ground)
    gap, follow = (float(np.mean(RANGES[name])) for name in ("gap", "follow"))
    travel = stroke.end - stroke.start
    assert travel @ pose.way == pytest.approx(gap + follow)
    assert travel @ pose.right == pytest.approx(0.0, abs=1e-9)
    front = pose.front_of(stroke.start)
    assert (ground.camera.position - front) @ pose.way == pytest.approx(gap + reach_of(ground.task.target))
    assert stroke.duration == pytest.approx(1.875 * (gap + follow) / np.mean(RANGES["speed"]))


def test_stroke_turns_to_the_left_of_the_way(ground: Observation) -> None:
    pose = plan_pose(ground.task, 0.0)
    stroke = plan_stroke(np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0]), pose, ground)
    travel = stroke.end - stroke.start
    assert math.atan2(-travel @ pose.right, travel @ pose.way) == pytest.approx(RANGES["angle"][1])


def test_numbers_beyond_the_range_are_clipped(ground: Observation) -> None:
    pose = plan_pose(ground.task, 0.0)
    least, far = (plan_stroke(np.full(6, value), pose, ground) for value in (-1.0, -50.0))
    assert np.array_equal(least.start, far.start)
    assert least.duration == pytest.approx(1.875 * 0.01 / 0.08)


def test_only_the_stroke_reports_a_push(ground: Observation) -> None:
    pose = plan_pose(ground.task, 0.0)
    moves = plan_moves(pose, plan_stroke(np.zeros(6), pose, ground), np.array([0.45, 0.1, 0.9]))
    assert [move.action for move in moves] == ["come beside", "come down", "strike", "rise", "watch"]
    assert [move.milestone is Milestone.PUSHED for move in moves] == [False, False, True, True, True]


def test_strategy_strikes_when_it_has_turned(
    ground: Observation, build_constant: Callable[[int, np.ndarray], Network]
) -> None:
    strategy = StrokeStrategy("policy:stroke", ABOUT, {"action": build_constant(12, np.zeros(6))})
    state, actions = strategy.init(ground), []
    for i in range(2000):
        state, _ = strategy.step(state, replace(ground, time=0.02 * i))
        if state.is_done:
            break
        actions.append(strategy.status(state).action)
    assert list(dict.fromkeys(actions)) == [
        "roll up", "turn", "come beside", "come down", "strike", "rise", "watch"
    ]  # fmt: skip
    assert state.retries == 1  # What never moved is struck once more.
    assert strategy.status(state).gave_up == "the object did not go far enough"


def test_other_names_are_refused(ground: Observation) -> None:
    with pytest.raises(ModelError, match="other inputs: 'heat', not 'is_sphere'"):
        StrokeStrategy("policy:x", replace(ABOUT, inputs=("heat", *INPUTS[1:])), {"action": None}).init(ground)
