"""Strategies that grip with the fingers: where they go, what they check, and what they do when nothing is held."""

import copy
import dataclasses
import functools
import math
from itertools import pairwise

import numpy as np
import pytest

from spiraltrunk import strategies
from spiraltrunk.control.loop import run
from spiraltrunk.control.messages import CameraObservation, Goal, Observation, Target, Task
from spiraltrunk.control.plant import Plant
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DesignError, ModelError
from spiraltrunk.strategies import resting
from spiraltrunk.strategies.fingertip import plan
from spiraltrunk.strategies.fingertip.cycle import FIRMER, TIGHTEN
from spiraltrunk.strategies.fingertip.moves import EASE, put
from spiraltrunk.strategies.fingertip.plan import closing, opening, tip_height, turned_across
from spiraltrunk.strategies.moves import PHASES

DT, GROUND = 0.02, 0.60
NAMES = ("pinch", "tip-grip", "flip-grip")


def _task(width=0.03, length=0.03, kind="sphere", axis=(0.0, 0.0, 1.0), design=PAPER):
    target = Target(kind=kind, width=width, length=length, mass=0.02,
                    position=np.array([0.45, 0.10, GROUND + width / 2]), axis=np.array(axis))  # fmt: skip
    place = target.position + np.array([0.0, 0.2, 0.0])
    goal = Goal(lift=0.2, aside=np.array([0.0, 0.2, 0.0]), place=place, ground=GROUND)
    return Task(design=design, target=target, goal=goal)


class Hand(Plant):
    """A robot that does at once what it is told; what its fingers close round near the ground hangs below its base.

    ``grips`` says which grip of the trial holds, ``slips`` when the object sinks [s] and by how much [m].
    """

    def __init__(self, task, offset=(0.0, 0.0, 0.0), grips=(True,), slips=(1e9, 0.0), has_camera=True):
        self.task, self.offset, self.grips, self.slips = task, np.array(offset), grips, slips
        self.has_camera = has_camera

    @property
    def control_period(self):
        return DT

    def reset(self):
        T = np.eye(4)
        T[:3, :3] = [[0, 0, -1], [0, -1, 0], [-1, 0, 0]]  # Hanging, ventral towards +y.
        T[:3, 3] = [0.31, 0.0, 1.22]
        self.place, self.held, self.count, self.was_closed = self.task.target.position + self.offset, None, 0, False
        return self._observe(0.0, T)

    def step(self, command):
        time, base = self.time + DT, command.T_world_base[:3, 3]
        is_closed = command.gripper > 0.05
        if is_closed and not self.was_closed:
            holds = self.grips[min(self.count, len(self.grips) - 1)]
            is_there = np.linalg.norm(base[:2] - self.place[:2]) < 0.004
            self.held, self.count = (self.place - base if holds and is_there else None), self.count + 1
        if not is_closed:
            self.held = None
        self.was_closed = is_closed
        if self.held is not None:
            if time - DT < self.slips[0] <= time:
                self.held = self.held - [0.0, 0.0, self.slips[1]]
            self.place = base + self.held
        else:
            self.place = np.array([*self.place[:2], self.task.target.position[2]])
        return self._observe(time, command.T_world_base)

    def _observe(self, time, T):
        self.time = time
        load = 9.81 * self.task.target.mass if self.held is not None else 0.0
        weight = 9.81 * self.task.design.total_mass + load
        look = CameraObservation(time=time - time % 0.5, position=self.place, axis=self.task.target.axis)
        if time > 0 and round(time / DT) % 25:
            look = self.look
        self.look = look
        return Observation(
            time=time, task=self.task, T_world_base=T, arm_position=np.zeros(7), arm_velocity=np.zeros(7),
            cable_pull=np.zeros(3), cable_tension=np.zeros(3), base_force=np.array([0, 0, -weight]),
            base_torque=np.zeros(3), camera=look if self.has_camera else None,
        )  # fmt: skip


@pytest.fixture(params=NAMES)
def strategy(request):
    return strategies.get(request.param)


@functools.cache
def run_plain(name):
    """The log of a strategy whose first grip holds."""
    return run(Hand(_task()), strategies.get(name))


def _frozen(value):
    """A value as something that can be compared, arrays by their bytes."""
    if dataclasses.is_dataclass(value):
        return tuple((f.name, _frozen(getattr(value, f.name))) for f in dataclasses.fields(value))
    if isinstance(value, np.ndarray):
        return value.shape, value.tobytes()
    return tuple(map(_frozen, value)) if isinstance(value, tuple) else value


@pytest.mark.slow
@pytest.mark.parametrize(
    "strategy",
    NAMES,
    indirect=True,
)
def test_the_same_state_and_observation_give_the_same_and_stay_as_they_are(strategy):
    plant = Hand(_task())
    observation = plant.reset()
    state = strategy.init(observation)
    for _ in range(700):
        before = _frozen((state, observation))
        after, command = strategy.step(state, observation)
        assert _frozen((state, observation)) == before
        assert _frozen(strategy.step(copy.deepcopy(state), observation)) == _frozen((after, command))
        state, observation = after, plant.step(command)


def test_phases_come_in_order_and_the_object_ends_at_its_place(strategy):
    plant = Hand(_task(), offset=(0.02, -0.02, 0.0))
    log = run(plant, strategy)
    assert log.gave_up is None
    phases = [status.phase for status in log.statuses]
    assert [phase for i, phase in enumerate(phases) if i == 0 or phases[i - 1] != phase] == list(PHASES)
    np.testing.assert_allclose(plant.place, plant.task.goal.place, rtol=0, atol=2e-3)


def test_milestones_come_in_order(strategy):
    log = run_plain(strategy.name)
    spans = [log.milestone_span(milestone) for milestone in Milestone if milestone is not Milestone.PUSHED]
    times = [time for span in spans for time in span]
    assert times == sorted(times)


def test_commands_are_smooth_and_end_slack(strategy):
    log = run_plain(strategy.name)
    place = np.array([command.T_world_base[:3, 3] for command in log.commands])
    speed, tension = np.diff(place, axis=0) / DT, np.array([command.cable_tension for command in log.commands])
    assert np.abs(speed).max() < 0.6
    assert np.abs(np.diff(speed, axis=0) / DT).max() < 2.5
    assert np.abs(np.diff(tension, axis=0)).max() < 1.0
    np.testing.assert_array_equal(tension[-1], 0.0)


def test_only_the_flip_pulls_cables_and_it_bounds_their_lengths():
    for name in NAMES:
        log = run_plain(name)
        pulled = [command for command in log.commands if command.cable_tension.max() > 0]
        assert bool(pulled) == (name == "flip-grip")
        for command in pulled:
            assert np.isfinite(command.cable_pull[1:]).all()


def test_an_object_beside_its_announced_place_is_gripped_where_it_is_seen(strategy):
    log = run(Hand(_task(), offset=(0.02, 0.015, 0.0)), strategy)
    i = [status.action for status in log.statuses].index("close")
    np.testing.assert_allclose(log.commands[i].T_world_base[:2, 3], [0.47, 0.115], rtol=0, atol=1e-3)


def test_a_failed_grip_is_tried_once_more_and_firmer(strategy):
    once = run_plain(strategy.name)
    log = run(Hand(_task(), grips=(False, True)), strategy)
    actions = [status.action for status in log.statuses]
    assert log.gave_up is None
    assert sum(a != "close" == b for a, b in pairwise(actions)) == 2
    first, second = (max(command.gripper for command in run.commands) for run in (once, log))
    assert second == pytest.approx(min(1.0, FIRMER * first), rel=1e-9)


def test_where_nothing_is_lifted_it_gives_up(strategy):
    log = run(Hand(_task(), grips=(False,)), strategy)
    assert "lifted" in log.gave_up
    assert log.span("release") is None
    assert sum(a.action != "close" == b.action for a, b in pairwise(log.statuses)) == 2


def test_without_a_camera_the_weight_tells():
    held, empty = (run(Hand(_task(), grips=(g,), has_camera=False), strategies.get("tip-grip")) for g in (True, False))
    assert held.gave_up is None
    assert "lifted" in empty.gave_up


def test_slip_is_answered_by_a_tighter_grip():
    slack = run_plain("tip-grip")
    start, _ = slack.span("transport", "hold")
    slipped = run(Hand(_task(), slips=(start + 1.7, 0.008)), strategies.get("tip-grip"))
    grips = [max(command.gripper for command in log.commands) for log in (slack, slipped)]
    assert grips[1] == pytest.approx(TIGHTEN * grips[0], rel=1e-9)


def test_a_trunk_without_a_gripper_is_refused(strategy):
    with pytest.raises(ModelError, match="has no gripper"):
        strategy.init(Hand(_task(design=dataclasses.replace(PAPER, gripper=None))).reset())


def test_what_is_wider_than_the_fingers_is_refused(strategy):
    with pytest.raises(ModelError, match="do not open round 120 mm"):
        strategy.init(Hand(_task(width=0.12)).reset())


@pytest.mark.parametrize("angle", np.radians([-85, -40, -10, 0, 25, 31, 60, 89]))
def test_a_pinch_sets_one_finger_square_to_the_axis_by_the_least_turn(angle):
    start = Hand(_task()).reset().T_world_base[:3, :3]
    axis = np.array([math.cos(angle), math.sin(angle), 0.0])
    turned = turned_across(start, axis, _task())
    np.testing.assert_allclose(turned[:, 0], start[:, 0], atol=1e-12)
    fingers = [turned @ [0.0, math.cos(a), math.sin(a)] for a in 2 * np.pi * np.arange(3) / 3]
    assert min(abs(finger @ axis) for finger in fingers) < 1e-9
    turn = math.acos(np.clip((np.trace(start.T @ turned) - 1) / 2, -1, 1))
    assert turn <= math.radians(30.0) + 1e-9


def test_the_grip_clears_ground_and_object_and_opens_wider_for_wider_ones():
    openings = []
    for width in (0.010, 0.020, 0.030):
        task = _task(width=width)
        height = tip_height(task) - GROUND
        assert height > max(PAPER.gripper.finger_length, 1.1 * width)
        openings.append(opening(task))
    assert 0 > openings[0] > openings[1] > openings[2] >= -1


def test_a_standing_box_whose_turn_is_not_known_takes_the_room_of_its_corners():
    box, round_ = (_task(width=0.028, kind=kind) for kind in ("box", "cylinder"))
    assert tip_height(box) > tip_height(round_)


def test_fingers_press_on_a_slope_as_hard_as_it_takes_and_at_most_as_they_can(monkeypatch):
    """On a side at an angle a, N lifts N (mu cos a - sin a), with a third of the friction to spare for."""
    monkeypatch.setattr(plan, "PRESS_LEAST", 0.0)

    def command(kind, length, mass=0.01):
        task = _task(kind=kind, length=length, width=0.012)
        return closing(dataclasses.replace(task, target=dataclasses.replace(task.target, mass=mass)))

    upright, slim, steep = command("cylinder", 0.04), command("cone", 0.04), command("cone", 0.02)
    assert upright < slim < steep == 1.0
    assert command("cone", 1e6) == pytest.approx(upright), "a cone without a slope is a cylinder"
    bare = command("cylinder", 0.04, mass=0.0)
    angle = math.atan2(0.006, 0.04)
    share = (0.8 / 3.0) / (0.8 / 3.0 * math.cos(angle) - math.sin(angle))
    assert (slim - bare) / (upright - bare) == pytest.approx(share)


def test_a_flip_that_the_cables_cannot_make_is_refused_before_anything_moves():
    weak = dataclasses.replace(PAPER, cable=dataclasses.replace(PAPER.cable, tension_max=2.0))
    start = Hand(_task(design=weak)).reset()
    strategies.get("tip-grip").init(start)
    with pytest.raises(ModelError, match=r"the tip turns by .* deg at 2 N"):
        strategies.get("flip-grip").init(start)


def test_an_object_that_is_already_down_is_lowered_in_one_period():
    """A move of no duration has no fraction."""
    hand = Hand(_task())
    seen = hand.reset()
    base = np.array([0.45, 0.10, 1.2])
    held = dataclasses.replace(strategies.get("tip-grip").init(seen).sequence.moves[-1], position=base)
    moves = put(held, seen, base, -0.5)
    assert [move.action for move in moves] == ["bring", "lower", "open", "leave", "rest"]
    assert min(move.duration for move in moves) >= DT


def _standing(length):
    task = _task(kind="cylinder", length=length)
    position = np.array([0.45, 0.10, GROUND + length / 2])
    return dataclasses.replace(task, target=dataclasses.replace(task.target, position=position))


def test_a_tall_object_is_let_go_after_the_base_has_risen_from_where_the_ground_bore_it():
    seen = Hand(_standing(0.15)).reset()
    held = dataclasses.replace(
        strategies.get("tip-grip").init(seen).sequence.moves[-1], position=np.array([0.0, 0.0, 1.3])
    )
    _, lower, ease, let_go, _, _ = put(held, seen, np.array([0.0, 0.0, 1.2]), -0.5)
    assert (lower.action, ease.action, let_go.action) == ("lower", "ease", "open")
    assert ease.gripper == lower.gripper != let_go.gripper
    np.testing.assert_allclose(ease.position - lower.position, [0, 0, EASE], atol=1e-12)
    np.testing.assert_array_equal(let_go.position, ease.position)


@pytest.mark.parametrize(("length", "rests"), [(0.15, resting.MOST_RESTS), (0.03, 1)])
def test_a_tall_object_that_rocks_is_waited_for(length, rests):
    """It rocks for ever here: in turn to either side at each look."""
    hand = Hand(_standing(length))
    strategy, seen = strategies.get("tip-grip"), hand.reset()
    state = strategy.init(seen)
    moves = put(state.sequence.moves[-1], seen, np.array([0.45, 0.1, 1.2]), -0.5)
    state = dataclasses.replace(state, sequence=dataclasses.replace(state.sequence, moves=moves, index=len(moves) - 2))
    actions = []
    for look in range(40):
        actions.append(state.sequence.move.action)
        axis = np.array([0.05 * (-1) ** look, 0.0, 1.0])
        camera = CameraObservation(time=float(look), position=np.array([0.45, 0.3, GROUND]), axis=axis)
        state = strategy.next_move(state, dataclasses.replace(seen, time=float(look), camera=camera))
        if state.is_done:
            break
    assert actions == ["leave", *["rest"] * rests]


@pytest.mark.parametrize("name", ["lift", "hold"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, "1"])
def test_a_goal_without_lift_or_hold_is_refused(name, value):
    with pytest.raises(DesignError, match=rf"goal\.{name} is "):
        Goal(**{"aside": np.zeros(3), "place": np.zeros(3), name: value})


def test_the_slope_of_a_cone_counts_where_it_stands():
    """The wall of a lying cone narrows along the ground, as its assessment has it."""
    lying = {"width": 0.03, "length": 0.06, "axis": (1.0, 0.0, 0.0)}
    assert closing(_task(kind="cone", **lying)) == closing(_task(kind="cylinder", **lying))
    assert closing(_task(kind="cone", length=0.06)) > closing(_task(kind="cylinder", length=0.06))
