"""Policies as strategies: stages, memory, smoothed set points, and their place in a survey's table."""

from __future__ import annotations

import importlib
import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from spiraltrunk.control.command_check import read_command
from spiraltrunk.control.encoding import encode_command
from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.design import presets
from spiraltrunk.errors import ModelError, SurveyError
from spiraltrunk.strategies.policy.description import PolicyDescription
from spiraltrunk.strategies.policy.memory import MODE, TIMES, begin_memory, build_inputs, enter_stage, observe
from spiraltrunk.strategies.policy.network import Network
from spiraltrunk.strategies.policy.policy_strategy import PolicyStrategy
from spiraltrunk.strategies.policy.smoothing import Filtered, follow
from spiraltrunk.workflows.survey.plan import SurveyPlan
from spiraltrunk.workflows.survey.run_survey import run_survey


def later(observation: Observation, time: float) -> Observation:
    return replace(observation, time=time)


Build = Callable[[int, np.ndarray], Network]


def wait_then_keep(description: PolicyDescription, build: Build) -> Network:
    """A stage network that leaves the first stage after 0.5 s, and the second after 2 s."""
    n, place = len(description.inputs), description.inputs.index
    weight = np.zeros((3, n))
    weight[0, place("stage_is_up")], weight[1, place("stage_is_keep")] = 1.0, 1.0
    weight[1, place("stage_time_to_0.5_s")] = 2.001
    weight[2, place("stage_time_to_2_s")] = 1.05
    weight[2, place("stage_is_up")] = -5.0
    return replace(build(n, np.zeros(3)), weights=(weight,))


@pytest.fixture
def waiting(description: PolicyDescription, observation: Observation, build_constant: Build) -> PolicyStrategy:
    still = Command(T_world_base=observation.T_world_base, cable_tension=np.full(3, 20.0))
    goal = encode_command(MODE, still, still, observation.task).action.astype(float)
    networks = {
        "stage": wait_then_keep(description, build_constant),
        "action": build_constant(len(description.inputs), goal),
    }
    return PolicyStrategy("policy:waiting", description, networks)


def test_stages_by_time_since_they_began(waiting: PolicyStrategy, observation: Observation) -> None:
    state = waiting.init(observation)
    told = []
    for i in range(300):
        state, command = waiting.step(state, later(observation, 0.02 * i))
        read_command(command, 3, presets.PAPER.cable.tension_max)
        status = waiting.status(state)
        told.append((status.milestone, status.is_done))
        if status.is_done:
            break
    milestones = [milestone for milestone, _ in told]
    assert milestones[0] is Milestone.LIFTED
    assert milestones[24] is Milestone.LIFTED
    assert milestones[25] is Milestone.HELD  # At 0.5 s, a multiple of the period.
    assert milestones.count(Milestone.HELD) == 100
    assert told[-1] == (Milestone.RELEASED, True)


def test_stages_keep_their_times_and_order(
    description: PolicyDescription, observation: Observation, build_constant: Build
) -> None:
    up, keep, end = description.stages
    stages = (replace(up, least=0.3, after=("keep",)), replace(keep, least=0.2, most=0.5), end)
    stage = build_constant(len(description.inputs), np.array([1.0, 2.0, 3.0]))  # Always for the end.
    action = build_constant(len(description.inputs), np.zeros(len(description.outputs)))
    networks = {"stage": stage, "action": action}
    hasty = PolicyStrategy("policy:hasty", replace(description, stages=stages), networks)
    assert list_stages(hasty, observation) == ["up"] * 15 + ["keep"] * 10
    stage = build_constant(len(description.inputs), np.array([1.0, 2.0, -3.0]))  # Never for the end.
    slow = (stages[0], replace(stages[1], after=("end",)), end)
    lazy = PolicyStrategy("policy:lazy", replace(description, stages=slow), networks | {"stage": stage})
    assert list_stages(lazy, observation) == ["up"] * 15 + ["keep"] * 30


def test_stages_are_entered_as_often_as_allowed(
    description: PolicyDescription, observation: Observation, build_constant: Build
) -> None:
    up, keep, end = description.stages
    stages = (replace(up, least=0.1, visits=2), replace(keep, least=0.1), end)
    n = len(description.inputs)
    weight = np.zeros((3, n))
    weight[0, description.inputs.index("stage_is_keep")] = 9.0  # There and back again.
    stage = replace(build_constant(n, np.array([0.0, 5.0, 1.0])), weights=(weight,))
    action = build_constant(n, np.zeros(len(description.outputs)))
    networks = {"stage": stage, "action": action}
    turning = PolicyStrategy("policy:turning", replace(description, stages=stages), networks)
    assert list_stages(turning, observation)[:20] == ["up"] * 5 + ["keep"] * 5 + ["up"] * 5 + ["keep"] * 5


def list_stages(strategy: PolicyStrategy, observation: Observation) -> list[str]:
    state, told = strategy.init(observation), []
    for i in range(200):
        state, _ = strategy.step(state, later(observation, 0.02 * i))
        if strategy.status(state).is_done:
            break
        told.append(strategy.status(state).action)
    return told


def test_set_points_are_reached_smoothly(waiting: PolicyStrategy, observation: Observation) -> None:
    state, tension = waiting.init(observation), []
    for i in range(60):
        state, command = waiting.step(state, later(observation, 0.02 * i))
        tension.append(float(command.cable_tension[0]))
    assert tension[0] == pytest.approx(0.0, abs=1e-6)
    assert np.all(np.diff(tension) >= -1e-9)
    assert tension[-1] == pytest.approx(20.0, abs=0.05)


def test_it_gives_up_in_time(description: PolicyDescription, observation: Observation, build_constant: Build) -> None:
    action = build_constant(len(description.inputs), np.zeros(len(description.outputs)))
    stage = build_constant(len(description.inputs), np.array([1.0, 0.0, 0.0]))
    short = PolicyStrategy("policy:short", replace(description, longest=1.0), {"stage": stage, "action": action})
    state = short.init(observation)
    for i in range(60):
        state, _ = short.step(state, later(observation, 0.02 * i))
        if short.status(state).is_done:
            break
    assert short.status(state).gave_up == "not done after 1 s"
    assert 1.0 < 0.02 * i <= 1.12


def test_equal_inputs_equal_outputs(waiting: PolicyStrategy, observation: Observation) -> None:
    state = waiting.init(observation)
    for i in range(10):
        state, _ = waiting.step(state, later(observation, 0.02 * i))
    first, second = (waiting.step(state, later(observation, 0.2))[1] for _ in range(2))
    assert np.array_equal(first.T_world_base, second.T_world_base)


def test_other_observation_names(description: PolicyDescription, observation: Observation) -> None:
    names = ("arm_posture_1", *description.inputs[1:])
    other = PolicyStrategy("policy:other", replace(description, inputs=names), {})
    with pytest.raises(ModelError, match=r"other inputs.*arm_posture_1.*arm_position_1"):
        other.init(observation)


def test_other_trunk(description: PolicyDescription, observation: Observation) -> None:
    with pytest.raises(ModelError, match="3 cables; allowed: 2"):
        PolicyStrategy("policy:two", replace(description, n_cable=2), {}).init(observation)


def test_an_arm_of_other_joints(waiting: PolicyStrategy, observation: Observation) -> None:
    short = replace(observation, arm_position=np.zeros(6), arm_velocity=np.zeros(6))
    with pytest.raises(ModelError, match=r"other inputs .* arm of 6 joints: 'arm_position_7', not 'arm_velocity_1'"):
        waiting.init(short)


def test_memory(observation: Observation) -> None:
    heavy = replace(observation, base_force=np.array([0.0, 0.0, -5.0]))
    memory = begin_memory(observation, np.zeros(10))
    for i in range(1, 100):
        memory = observe(memory, later(heavy, 0.02 * i))
    assert memory.load[0] == pytest.approx(5.0, abs=1e-3)
    assert memory.latched[0] == pytest.approx(2.0)
    entered = enter_stage(memory, 1, later(heavy, 2.0), np.ones(10), latches=True)
    assert entered.latched[0] == pytest.approx(5.0, abs=1e-3)
    assert enter_stage(memory, 1, later(heavy, 2.0), np.ones(10), latches=False).latched[0] == pytest.approx(2.0)
    inputs = build_inputs(entered, later(heavy, 3.5), None, 3)
    n_known = len(inputs) - (3 + len(TIMES) + 10 + 3 + 2 + 5)
    assert inputs[n_known : n_known + 8].tolist() == [0.0, 1.0, 0.0, 0.5, 1.0, 1.5, 1.5, 1.5]


def test_filter_is_exact_for_any_step() -> None:
    start, goal = Filtered(value=np.array([1.0]), rate=np.array([-2.0])), np.array([3.0])
    whole = follow(start, goal, 0.1, 0.3)
    parts = start
    for _ in range(30):
        parts = follow(parts, goal, 0.1, 0.01)
    assert (parts.value[0], parts.rate[0]) == (pytest.approx(whole.value[0]), pytest.approx(whole.rate[0]))
    slope = -2.0 + (1.0 - 3.0) / 0.1
    assert whole.value[0] == pytest.approx(3.0 + (-2.0 + slope * 0.3) * math.exp(-3.0))


def test_policy_in_a_survey(policy_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(Path(__file__).parents[2] / "workflows" / "survey" / "fakes")
    run_inline = importlib.import_module("survey_fakes").run_inline
    name = f"policy:{policy_file}"
    plan = SurveyPlan(objects={"wrap-vertical": ("cylinder-60",), name: ("cylinder-60", "box-60")}, trials=4)
    result = run_survey(plan, folder=tmp_path / "out", work=pretend, engine=run_inline)
    assert {key: own["successes"] for key, own in result["strategies"].items()} == {"wrap-vertical": 4, name: 2}
    assert list(result["settings"]["policies"]) == [name]
    assert run_survey(plan, folder=tmp_path / "out", work=pretend, engine=run_inline) == result
    text = policy_file.with_suffix(".json")
    text.write_text(json.dumps(json.loads(text.read_text()) | {"longest": 50.0}))
    with pytest.raises(SurveyError, match="policies"):
        run_survey(plan, folder=tmp_path / "out", work=pretend, engine=run_inline)


def pretend(entry: object) -> dict[str, object]:
    from spiraltrunk.workflows.survey.row import build_empty_row

    is_success = entry.strategy == "wrap-vertical" or entry.index % 2 == 0
    row = build_empty_row(entry, "success" if is_success else "lifted 3 cm")
    return row | {"success": is_success, "cause": None if is_success else "missed"}


def test_surveys_without_policies_keep_their_settings() -> None:
    assert "policies" not in SurveyPlan(objects={"kick": ("box-60",)}, trials=1).settings()
