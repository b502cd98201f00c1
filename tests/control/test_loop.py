"""The loop: what is logged, when it ends, what it says."""

import numpy as np
import pytest

from spiraltrunk.control.loop import LONGEST, run
from spiraltrunk.control.messages import Command
from spiraltrunk.control.plant import Plant
from spiraltrunk.control.strategy import Milestone, Status, Strategy
from spiraltrunk.errors import RunError
from spiraltrunk.workflows.grasp.artifacts import compute_phase_spans


class Seen:
    """As much of an observation as the loop reads."""

    def __init__(self, time):
        self.time = time


class Clock(Plant):
    """Nothing but time."""

    def __init__(self, period=0.5):
        self.period, self.time = period, 0.0

    @property
    def control_period(self):
        return self.period

    def reset(self):
        self.time = 0.0
        return Seen(0.0)

    def step(self, command):
        self.time += self.period
        return Seen(self.time)


class Count(Strategy):
    """Counts to a number; the first half is a reach."""

    name, number = "count", 9

    def __init__(self, most, gave_up=None):
        self.most, self.gave_up = most, gave_up

    def init(self, observation):
        return 0

    def step(self, state, observation):
        return state + 1, Command(T_world_base=np.eye(4), cable_tension=np.zeros(3))

    def status(self, state):
        is_done = state > self.most
        phase, milestone = ("reach", None) if state <= self.most // 2 else ("transport", Milestone.LIFTED)
        gave_up = self.gave_up if is_done else None
        return Status(phase=phase, action="lift", milestone=milestone, is_done=is_done, gave_up=gave_up)


def test_everything_is_logged_in_step():
    log = run(Clock(), Count(6))
    assert [seen.time for seen in log.observations] == [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]
    assert len(log.commands) == len(log.statuses) == 6
    assert log.gave_up is None


def test_spans_are_the_times_after_the_first_and_last_command():
    log = run(Clock(), Count(6))
    assert log.span("reach") == (0.5, 1.5)
    assert log.span("transport", "lift") == (2.0, 3.0)
    assert log.span("transport", "hold") is None
    assert log.span("release") is None
    assert log.milestone_span(Milestone.LIFTED) == (2.0, 3.0)
    assert log.milestone_span(Milestone.HELD) is None


def test_why_it_gave_up_is_kept():
    log = run(Clock(), Count(4, gave_up="enough"))
    assert log.gave_up == "enough"
    assert len(log.statuses) == 4


@pytest.mark.parametrize("gave_up", [None, "at once"])
def test_a_strategy_may_end_before_it_does_anything(gave_up):
    log = run(Clock(), Count(0, gave_up=gave_up))
    assert log.commands == log.statuses == ()
    assert len(log.observations) == 1
    assert log.gave_up == gave_up
    assert compute_phase_spans(log) == ()


def test_a_run_without_end_is_stopped():
    with pytest.raises(RunError, match=f"count did not end in {LONGEST:g} s"):
        run(Clock(period=10.0), Count(10**9))


def test_the_watcher_sees_every_step_and_may_stop_the_run():
    seen = []
    run(Clock(), Count(3), watch=lambda observation, status: seen.append((observation.time, status.phase)))
    assert seen == [(0.5, "reach"), (1.0, "transport"), (1.5, "transport")]

    def stop(observation, status):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(Clock(), Count(3), watch=stop)


class Broken(Count):
    """Returns what it may not."""

    def __init__(self, **returned):
        super().__init__(3)
        self.returned = returned

    def step(self, state, observation):
        return self.returned.get("step", super().step(state, observation))

    def status(self, state):
        return self.returned.get("status", super().status(state))


class Stuck(Clock):
    """A plant whose time does as it likes, or that sees nothing."""

    def __init__(self, *seen):
        super().__init__()
        self.seen = iter(seen)

    def step(self, command):
        return next(self.seen)


@pytest.mark.parametrize(
    ("plant", "strategy", "words"),
    [
        (Clock(), Broken(step=None), "strategy.step returned None; allowed: a pair"),
        (Clock(), Broken(step=(1, 2, 3)), r"strategy.step returned \(1, 2, 3\); allowed: a pair"),
        (Clock(), Broken(status=None), "strategy.status returned None; allowed: a Status"),
        (
            Clock(),
            Broken(status=Status(phase="transport", action="lift", milestone="lifted")),
            "status.milestone is 'lifted'; allowed: a Milestone, or None",
        ),
        (Stuck(None), Count(3), "plant.step returned None; allowed: an Observation"),
        (Stuck(Seen(0.5), Seen(0.5)), Count(3), "time went from 0.5 to 0.5 s; allowed: forward"),
        (Stuck(Seen(0.5), Seen(0.1)), Count(3), "time went from 0.5 to 0.1 s; allowed: forward"),
        (Stuck(Seen(float("nan"))), Count(3), "time went from 0.0 to nan s; allowed: forward"),
    ],
)
def test_what_plant_and_strategy_may_not_return_ends_the_run_in_one_line(plant, strategy, words):
    with pytest.raises(RunError, match=words):
        run(plant, strategy)


def test_a_watcher_is_a_function():
    with pytest.raises(RunError, match="watch is 3; allowed: a function"):
        run(Clock(), Count(3), watch=3)
