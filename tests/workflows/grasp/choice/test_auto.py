"""The strategy that chooses: the best first, after a failed try the next, and the last try is judged."""

import math
from dataclasses import replace
from itertools import groupby

import numpy as np
import pytest

from spiraltrunk.control.loop import run
from spiraltrunk.control.messages import CameraObservation, Goal, Observation, Target, Task
from spiraltrunk.control.plant import CONTROL_PERIOD, Plant
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import UnknownName
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.objects.profile import compute_profile
from spiraltrunk.strategies.moves import base_position
from spiraltrunk.workflows.grasp.artifacts import compute_result
from spiraltrunk.workflows.grasp.choice.auto import MOST_TRIES, Auto, _plan_way_back, get_strategy, list_objects
from spiraltrunk.workflows.grasp.choice.candidates import Candidate
from spiraltrunk.workflows.grasp.choice.seen_task import correct_place, task_as_seen
from spiraltrunk.workflows.grasp.trial import run_trial

DT, GROUND = 0.02, 0.60
HANGING = np.array([[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]])


def _task(width=0.03, length=0.03, kind="cylinder"):
    target = Target(
        kind=kind, width=width, length=length, mass=0.02, position=np.array([0.45, 0.10, GROUND + length / 2]),
        axis=np.array([0.0, 0.0, 1.0]),
    )  # fmt: skip
    aside = np.array([0.0, 0.2, 0.0])
    return Task(design=PAPER, target=target, goal=Goal(aside=aside, place=target.position + aside, ground=GROUND))


class Hand(Plant):
    """A robot that does at once what it is told; ``holds`` says which closing of its fingers holds the object.

    An object that is held at ``drops`` [s] falls back to where it was. After the first failed closing the object has
    the axis ``axis``. An object that is let go is dragged by ``drag`` [m].
    """

    control_period = DT

    def __init__(self, task, holds=(), drops=math.inf, axis=(0.0, 0.0, 1.0), drag=(0.0, 0.0, 0.0)):
        self.task, self.holds, self.drops, self.axis_after = task, holds, drops, np.array(axis)
        self.drag = np.array(drag)

    def reset(self):
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = HANGING, (0.31, 0.0, 1.22)
        self.place, self.axis = self.task.target.position.copy(), self.task.target.axis
        self.held, self.count, self.was_closed = None, 0, False
        return self._observe(0.0, T)

    def step(self, command):
        base, is_closed = command.T_world_base[:3, 3], command.gripper > 0.05
        if is_closed and not self.was_closed:
            if self.count < len(self.holds) and self.holds[self.count]:
                self.held = self.place - base
            self.count += 1
        if self.time > self.drops:
            self.held, self.drops = None, math.inf
        if not is_closed:
            self.place, self.held = self.place + (0.0 if self.held is None else self.drag), None
        if self.count and self.held is None and not is_closed:
            self.axis = self.axis_after
        self.was_closed = is_closed
        low = self.task.goal.ground + self.task.target.length / 2
        self.place = np.array([*self.place[:2], low]) if self.held is None else base + self.held
        return self._observe(self.time + DT, command.T_world_base)

    def _observe(self, time, T):
        self.time = time
        weight = 10.0 + (0.2 if self.held is not None and self.place[2] > GROUND + 0.05 else 0.0)
        return Observation(
            time=time, task=self.task, T_world_base=T.copy(), arm_position=np.zeros(7), arm_velocity=np.zeros(7),
            cable_pull=np.zeros(3), cable_tension=np.zeros(3), base_force=np.array([0.0, 0.0, -weight]),
            base_torque=np.zeros(3), camera=CameraObservation(time=time, position=self.place.copy(), axis=self.axis),
        )  # fmt: skip


def _ranking(*names, seen=None):
    """A ranking of these names in this order, whatever the object; it notes what it is asked."""

    def rank(observation, tried):
        if seen is not None:
            seen.append((observation.task, tried))
        return tuple(
            Candidate(strategy=name, feasible=True, score=0.5, reason="") for name in names if name not in tried
        )

    return rank


def _run(plant, *names, seen=None):
    return run(plant, Auto(PAPER, ranking=_ranking(*names, seen=seen)))


def test_the_best_is_tried_and_no_other_where_it_succeeds():
    log = _run(Hand(_task(), holds=(True,)), "tip-grip", "pinch")
    assert log.gave_up is None
    assert [each.strategy for each in log.state.attempts] == ["tip-grip"]
    assert log.milestone_span(Milestone.HELD) is not None


def test_after_a_failed_try_comes_the_next():
    # A tip grip closes twice before it gives up.
    log = _run(Hand(_task(), holds=(False, False, True)), "tip-grip", "pinch")
    assert log.gave_up is None
    first, second = log.state.attempts
    assert (first.strategy, second.strategy) == ("tip-grip", "pinch")
    assert "nothing was lifted" in first.outcome
    assert second.outcome == ""


def test_after_fingers_failed_a_wrap_comes_first():
    log = _run(Hand(_task(0.036, 0.12), holds=(False, False)), "tip-grip", "pinch", "wrap-horizontal")
    assert [each.strategy for each in log.state.attempts][:2] == ["tip-grip", "wrap-horizontal"]


def test_the_arm_is_brought_back_before_the_next_try():
    plant = Hand(_task(), holds=(False, False, True))
    log = _run(plant, "tip-grip", "pinch")
    actions = [action for action, _ in groupby(status.action for status in log.statuses)]
    end = actions.index("look again")
    assert actions[end - 3 : end + 2] == ["let go", "rise", "return", "look again", "approach"]
    again = log.state.attempts[1].began
    there = next(seen for seen in log.observations if seen.time >= again)
    assert there.T_world_base == pytest.approx(log.observations[0].T_world_base, abs=1e-6)
    steps = np.diff([command.T_world_base[:3, 3] for command in log.commands], axis=0)
    assert np.abs(steps).max() < 0.02  # No jump: below 1 m/s.


def test_the_way_back_goes_on_from_a_moving_base():
    log = _run(Hand(_task(), holds=(True,)), "tip-grip")
    state, seen = replace(log.state, velocity=np.array([0.0, 0.05, 0.2])), log.observations[-1]
    before, first = state.command.T_world_base[:3, 3], base_position(_plan_way_back(state, seen), seen.time)
    np.testing.assert_allclose((first - before) / CONTROL_PERIOD, state.velocity, atol=1e-9)


def test_a_strategy_that_ended_does_not_rise_further_on_the_way_back():
    log = _run(Hand(_task(), holds=(True,)), "tip-grip")
    actions = [move.action for move in _plan_way_back(log.state, log.observations[-1]).moves]
    assert actions == ["let go", "return", "look again"]


def test_what_is_dropped_in_the_hold_is_seen():
    log = _run(Hand(_task(), holds=(True, True), drops=9.0), "tip-grip", "pinch")
    first = log.state.attempts[0]
    assert first.outcome == "the object is seen low while it should be held"
    assert log.gave_up is None


def test_what_was_dragged_off_its_place_is_set_down_as_far_on_the_other_side():
    drag = np.array([0.05, -0.04, 0.0])
    task = _task()
    log = _run(Hand(task, holds=(True, True), drag=drag), "tip-grip", "pinch")
    first, second = log.state.attempts
    assert first.outcome == "the object is seen 6 cm from its place"
    assert first.told is first.task
    assert second.outcome == ""
    np.testing.assert_allclose(second.told.goal.place, task.goal.place - drag, atol=2e-3)
    np.testing.assert_array_equal(second.task.goal.place, task.goal.place)  # By which the verdict is.
    assert log.gave_up is None
    np.testing.assert_allclose(log.observations[-1].camera.position, task.goal.place, atol=2e-3)


def test_the_third_try_corrects_the_error_of_the_second():
    first = Hand(_task()).reset()
    goal = first.task.goal
    told = replace(first.task, goal=replace(goal, place=goal.place + np.array([0.03, 0.0, 0.0])))
    camera = CameraObservation(time=0.0, position=goal.place + np.array([0.01, -0.02, 0.0]), axis=_UP)
    again = correct_place(replace(first, camera=camera), told)
    assert again.goal.place == pytest.approx(goal.place + np.array([0.02, 0.02, 0.0]))


def test_the_place_is_not_corrected_by_where_an_object_has_toppled():
    first = Hand(_task()).reset()
    camera = CameraObservation(time=0.0, position=first.task.goal.place + 0.1, axis=np.array([1.0, 0.0, 0.0]))
    assert correct_place(replace(first, camera=camera), first.task) is None


def test_after_fingers_let_go_beside_the_place_a_wrap_is_told_the_place_itself():
    log = _run(Hand(_task(0.036, 0.12), holds=(True,), drag=(0.06, 0.0, 0.0)), "tip-grip", "wrap-horizontal")
    first, second = log.state.attempts
    assert "from its place" in first.outcome
    assert second.told is second.task


def test_a_toppled_object_is_ranked_as_it_lies():
    seen, task = [], _task(width=0.036, length=0.05)
    task = replace(task, target=replace(task.target, profile=compute_profile(parse_object("cylinder-32"))))
    plant = Hand(task, holds=(False, False, True), axis=(0.6, 0.8, 0.0))
    _run(plant, "tip-grip", "pinch", seen=seen)
    (before, none), (after, tried) = seen
    assert (none, tried) == ((), ("tip-grip",))
    assert before.target.axis == pytest.approx([0, 0, 1])
    assert after.target.axis == pytest.approx([0.6, 0.8, 0.0])
    assert before.target.profile is not None
    assert after.target.profile is None  # It is of the object as it stood.
    assert after.target.position[2] == pytest.approx(GROUND + 0.018)
    assert after.goal.place == pytest.approx(before.goal.place - [0, 0, 0.007])


def test_it_ends_after_the_last_candidate_with_its_reason():
    log = _run(Hand(_task()), "tip-grip", "pinch")
    assert log.gave_up is not None
    assert log.gave_up.startswith("pinch: nothing was lifted")
    assert [each.strategy for each in log.state.attempts] == ["tip-grip", "pinch"]


def test_tries_are_limited():
    log = _run(Hand(_task()), "tip-grip", "pinch", "flip-grip", "wrap-horizontal")
    assert len(log.state.attempts) == MOST_TRIES


def test_nothing_moves_where_no_strategy_can_take_it():
    none = Candidate(strategy="pinch", feasible=False, score=0.0, reason="too wide for the fingers by 8 mm")
    log = run(Hand(_task()), Auto(PAPER, ranking=lambda observation, tried: (none,)))
    assert log.commands == ()
    assert log.gave_up == "no strategy can take it: pinch: too wide for the fingers by 8 mm"
    assert log.state.candidates == (none,)


def test_a_candidate_without_a_plan_is_passed_over():
    log = _run(Hand(_task(), holds=(True,)), "wrap-horizontal", "tip-grip")  # 30 mm is too low for the wrap.
    assert [each.strategy for each in log.state.attempts] == ["tip-grip"]


def test_an_object_that_stands_keeps_its_announced_height():
    task, camera = _task(length=0.05), CameraObservation(time=0.0, position=np.array([0.5, 0.2, 0.63]), axis=-_UP)
    seen = replace(Hand(task).reset(), camera=camera)
    target = task_as_seen(seen).target
    assert target.position == pytest.approx([0.5, 0.2, GROUND + 0.025])
    assert target.axis == pytest.approx(_UP)


_UP = np.array([0.0, 0.0, 1.0])


@pytest.mark.parametrize(("moved", "sign"), [(-0.05, 1.0), (0.0, 1.0), (0.09, 1.0), (0.11, -1.0), (0.15, -1.0)])
def test_what_has_come_near_its_place_is_not_carried_on_beyond_it(moved, sign):
    first = Hand(_task()).reset()
    position = first.task.target.position + np.array([0.0, moved, 0.0])
    camera = CameraObservation(time=0.0, position=position, axis=_UP)
    goal = task_as_seen(replace(first, camera=camera)).goal
    assert goal.aside == pytest.approx(sign * first.task.goal.aside)
    assert goal.place == pytest.approx(first.task.goal.place)


@pytest.mark.slow
def test_a_real_trial_succeeds_by_the_first_choice():
    trial = run_trial(PAPER, parse_object("cylinder:diameter_mm=66,height_mm=115,mass_g=350"), strategy="auto", seed=0)
    assert trial.verdict.success, trial.verdict.reason
    first, *later = trial.log.state.attempts
    assert first.strategy == trial.log.state.candidates[0].strategy
    assert not later


@pytest.mark.slow
def test_a_real_second_try_succeeds_where_the_first_set_the_object_down_beside_its_place():
    trial = run_trial(PAPER, parse_object("everyday:seed=13703"), strategy="auto", seed=13703)
    first, second = trial.log.state.attempts
    assert "cm from its place" in first.outcome
    assert second.strategy != first.strategy
    assert trial.verdict.success, trial.verdict.reason


@pytest.mark.slow
def test_a_real_second_try_corrects_by_how_far_the_first_dragged_the_object():
    trial = run_trial(PAPER, parse_object("everyday:seed=13808"), strategy="auto", seed=13808)
    first, *later = trial.log.state.attempts
    assert "cm from its place" in first.outcome
    assert later[0].told.goal.place != pytest.approx(later[0].task.goal.place, abs=0.03)
    assert trial.verdict.success, trial.verdict.reason
    told = compute_result(trial, "auto")["attempts"]
    assert told[0]["place_correction_m"] == [0.0, 0.0, 0.0]
    assert told[1]["place_correction_m"] == pytest.approx(later[0].told.goal.place - later[0].task.goal.place)


def test_names_and_stages_are_checked():
    shape = parse_object("cube-28")
    assert get_strategy("auto", PAPER, shape).support == "ground"
    assert get_strategy("auto", PAPER, shape, "hung").support == "hung"
    assert get_strategy("pinch", PAPER, shape).name == "pinch"
    with pytest.raises(UnknownName, match=r"'atuo'; known: wrap-vertical, .*, sweep, auto"):
        get_strategy("atuo", PAPER, shape)
    with pytest.raises(UnknownName, match="unknown stage"):
        get_strategy("auto", PAPER, shape, "air")
    for name in list_objects("auto"):
        parse_object(name)
