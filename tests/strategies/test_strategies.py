"""Every strategy: pure, phases in order, smooth commands within the motors' tension, honest when it feels nothing."""

import copy
import dataclasses
from itertools import pairwise

import numpy as np
import pytest

from spiraltrunk import strategies
from spiraltrunk.control.loop import run
from spiraltrunk.control.messages import Command, Goal, Observation, Target, Task
from spiraltrunk.control.plant import Plant
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import UnknownName
from spiraltrunk.strategies.moves import PHASES
from spiraltrunk.strategies.timing import stretch
from spiraltrunk.strategies.wrap.hung import WrapVertical
from spiraltrunk.strategies.wrap.hung_model import free_curl, wrap_tension

DT = 0.02


def _task(design=PAPER, scale=1.0, mass=0.25):
    target = Target(kind="cylinder", width=0.06 * scale, length=0.24 * scale, mass=mass,
                    position=scale * np.array([0.45, 0.10, 0.85]), axis=np.array([1.0, 0.0, 0.0]))  # fmt: skip
    place = scale * np.array([0.45, 0.42, 0.93])
    goal = Goal(lift=0.2 * scale, aside=scale * np.array([0.0, 0.2, 0.0]), place=place)
    return Task(design=design, target=target, goal=goal)


class Stub(Plant):
    """A robot that does at once what it is told and whose arm feels a load over time [N], hung beside the base [m]."""

    def __init__(self, task, load=lambda time: 0.0, beside=0.0):
        self.task, self.load, self.beside = task, load, beside

    @property
    def control_period(self):
        return DT

    def reset(self):
        T = np.eye(4)
        T[:3, :3] = [[0, 0, -1], [0, -1, 0], [-1, 0, 0]]  # Hanging, ventral towards +y.
        T[:3, 3] = self.task.target.position + np.array([0.0, -0.25, 0.43])
        return self._observe(0.0, T, np.zeros(self.task.design.n_cable))

    def step(self, command: Command):
        return self._observe(self.time + DT, command.T_world_base, command.cable_tension)

    def _observe(self, time, T, tension):
        self.time = time
        n, design = len(tension), self.task.design
        load = self.load(time)
        weight = 9.81 * design.total_mass + load
        return Observation(
            time=time, task=self.task, T_world_base=T, arm_position=np.zeros(7), arm_velocity=np.zeros(7),
            cable_pull=np.zeros(n), cable_tension=tension, base_force=np.array([0, 0, -weight]),
            base_torque=np.cross(self.beside * self.task.target.axis, [0, 0, -load]),
        )  # fmt: skip


GRIPPED = 4.0
"""Time at which the curling trunk bears the object [s]."""

HUNG = [name for name in strategies.NAMES if strategies.get(name).support == "hung"]


@pytest.fixture(params=HUNG)
def strategy(request):
    return strategies.get(request.param)


def _carried(time):
    """An object of 0.25 kg on the trunk between curl and table."""
    return 0.25 * 9.81 if GRIPPED < time < 12.0 else 0.0


def test_strategies_are_got_by_name():
    for name in strategies.NAMES:
        assert strategies.get(name).name == name
        assert 1 <= strategies.get(name).number <= 9


def test_an_unknown_name_lists_the_known_ones():
    with pytest.raises(UnknownName, match=r"unknown strategy 'juggle'; known: .*wrap-vertical"):
        strategies.get("juggle")


def _frozen(value):
    """A value as something that can be compared, arrays by their bytes."""
    if dataclasses.is_dataclass(value):
        return tuple((f.name, _frozen(getattr(value, f.name))) for f in dataclasses.fields(value))
    if isinstance(value, np.ndarray):
        return value.shape, value.tobytes()
    return tuple(map(_frozen, value)) if isinstance(value, tuple) else value


def test_the_same_state_and_observation_give_the_same_and_stay_as_they_are(strategy):
    plant = Stub(_task(), _carried)
    observation = plant.reset()
    assert _frozen(strategy.init(observation)) == _frozen(strategy.init(copy.deepcopy(observation)))
    state = strategy.init(observation)
    for _ in range(500):
        before = _frozen((state, observation))
        after, command = strategy.step(state, observation)
        assert _frozen((state, observation)) == before
        assert _frozen(strategy.step(copy.deepcopy(state), observation)) == _frozen((after, command))
        state, observation = after, plant.step(command)


def test_two_runs_of_one_instance_do_not_know_of_each_other(strategy):
    first, second = (run(Stub(_task(), _carried), strategy) for _ in range(2))
    assert _frozen(first.commands) == _frozen(second.commands)


def test_phases_come_in_order(strategy):
    log = run(Stub(_task(), _carried), strategy)
    assert log.gave_up is None
    phases = [status.phase for status in log.statuses]
    order = [phase for i, phase in enumerate(phases) if i == 0 or phases[i - 1] != phase]
    assert order == list(PHASES)


def test_milestones_come_in_order(strategy):
    log = run(Stub(_task(), _carried), strategy)
    spans = [log.milestone_span(milestone) for milestone in Milestone if milestone is not Milestone.PUSHED]
    times = [time for span in spans for time in span]
    assert times == sorted(times)


def test_commands_are_smooth_and_within_the_motors_tension(strategy):
    log = run(Stub(_task(), _carried), strategy)
    place = np.array([command.T_world_base[:3, 3] for command in log.commands])
    speed, tension = np.diff(place, axis=0) / DT, np.array([command.cable_tension for command in log.commands])
    assert np.abs(speed).max() < 0.6
    assert np.abs(np.diff(speed, axis=0) / DT).max() < 2.5
    assert (tension >= 0.0).all()
    assert (tension <= PAPER.cable.tension_max).all()
    assert np.abs(np.diff(tension, axis=0)).max() < 1.0
    np.testing.assert_array_equal(tension[-1], 0.0)


def test_the_heaviest_object_takes_no_more_than_the_motors_have(strategy):
    log = run(Stub(_task(mass=10.0), lambda time: 98.1 if GRIPPED < time < 12.0 else 0.0), strategy)
    tension = np.array([command.cable_tension for command in log.commands])
    assert tension.max() <= PAPER.cable.tension_max


def test_where_no_load_is_felt_it_gives_up(strategy):
    log = run(Stub(_task()), strategy)
    assert "lifted" in log.gave_up
    assert log.statuses[-1].is_done
    assert log.span("release") is None
    assert log.observations[-1].time < 60.0  # Three tries of a wrap, all of them felt to be empty.


def test_touching_down_early_cuts_the_lowering_short():
    late = run(Stub(_task(), lambda time: 2.45 if time > GRIPPED else 0.0), WrapVertical())
    lowering = late.span("release", "lower")
    touch = lowering[0] + 0.5
    early = run(Stub(_task(), lambda time: 2.45 if GRIPPED < time < touch else 0.0), WrapVertical())
    assert touch <= early.span("release", "lower")[1] < touch + 0.5 < lowering[1]
    place = np.array([command.T_world_base[:3, 3] for command in early.commands])
    assert np.abs(np.diff(place, 2, axis=0) / DT**2).max() < 2.5


def _held(time):
    """The same for as long as no table bears it."""
    return 0.25 * 9.81 if time > GRIPPED else 0.0


class Table(Stub):
    """A stub whose load is borne by a table that it touches at a height of the base [m]."""

    def __init__(self, task, height, beside):
        super().__init__(task, _held, beside)
        self.height = height

    def step(self, command: Command):
        is_lowering = self.time > 9.0 and command.T_world_base[2, 3] < self.height
        self.load = (lambda time: 0.0) if is_lowering else _held
        return super().step(command)


def _lowered_to(beside, rise):
    """Where along the object's axis the base goes down, each time, for a table met higher than expected by ``rise``."""
    task = _task()
    lower = next(m for m in WrapVertical().init(Stub(task).reset()).sequence.moves if m.action == "lower")
    log = run(Table(task, lower.position[2] + 0.3 * PAPER.length + rise, beside), WrapVertical())
    actions = [status.action for status in log.statuses]
    turns = [i for i, (a, b) in enumerate(pairwise(actions)) if a != b and b in ("raise", "ease")]
    return actions, [float(log.commands[i].T_world_base[0, 3]) for i in turns]


@pytest.mark.parametrize("beside", [0.015, -0.015])
def test_what_touches_with_one_end_is_moved_along_towards_it_and_set_down_again(beside):
    """Higher by l sin t + r cos t - r, it moves by half of l - l cos t + r sin t, to the side where it hung.

    The touch is felt some readings late, up to 8 mm deeper.
    """
    half, radius, tilt = 0.12, 0.03, 0.5
    rise = half * np.sin(tilt) + radius * np.cos(tilt) - radius
    actions, (first, second) = _lowered_to(beside, rise)
    way = 0.5 * (half - half * np.cos(tilt) + radius * np.sin(tilt))
    assert first == pytest.approx(_task().target.position[0] - beside, abs=1e-3)
    assert second - first == pytest.approx(np.sign(beside) * way, rel=0.25)
    assert "move along" in actions


def test_what_touches_level_is_let_go_where_it_is():
    actions, places = _lowered_to(0.007, 0.0)
    assert "move along" not in actions
    assert len(places) == 1


@pytest.mark.parametrize(("width", "mass"), [(0.03, 0.1), (0.06, 0.25), (0.06, 1.0)])
def test_what_hangs_beside_its_middle_is_wrapped_once_more_where_that_is(width, mass):
    """From the least of three levers on: 0.625 of the width, 0.045 of the trunk's length, and what friction holds.

    That is 0.03 of the width for each time that the tension is the object's weight. It is moved by part of the lever.
    """
    task = dataclasses.replace(_task(), target=dataclasses.replace(_task().target, width=width, mass=mass))
    tension = wrap_tension(PAPER, width, mass, 0.8 * PAPER.joint_limit)
    least = min(0.625 * width, 0.045 * PAPER.length, 0.03 * width * tension / (mass * 9.81))
    for part, count in ((0.9, 0), (1.1, 1)):
        log = run(Stub(task, lambda time: _held(time) * mass / 0.25, part * least), WrapVertical())
        actions = [status.action for status in log.statuses]
        assert ("rise on" in actions) == (mass == 1.0)
        assert sum(a == "let go" != b for a, b in pairwise(actions)) == count
        first, last = (log.commands[i].T_world_base[0, 3] for i in (actions.index("curl"), _last(actions, "settle")))
        assert last - first == pytest.approx(count * 0.65 * part * least, abs=1e-3)
        brought = log.commands[actions.index("lower")].T_world_base[0, 3]
        assert brought + part * least == pytest.approx(task.goal.place[0], abs=1e-3)  # The object, not the base.


def _last(actions, action):
    return len(actions) - 1 - actions[::-1].index(action)


class Empty(Stub):
    """A stub whose cables take in what those of a trunk in the air do."""

    def _observe(self, time, T, tension):
        seen = super()._observe(time, T, tension)
        return dataclasses.replace(seen, cable_pull=np.full(3, free_curl(PAPER, float(tension[1]))))


@pytest.mark.slow
def test_where_nothing_is_touched_it_lets_go_at_half_the_tension_and_reaches_further_twice():
    log = run(Empty(_task()), WrapVertical())
    actions = [status.action for status in log.statuses]
    assert sum(a == "let go" != b for a, b in pairwise(actions)) == 2
    letting_go, tension = actions.index("let go"), np.array([command.cable_tension[1] for command in log.commands])
    assert "settle" not in actions[:letting_go]
    assert tension[:letting_go].max() == pytest.approx(0.5 * tension.max(), rel=0.02)
    ahead = [log.commands[i].T_world_base[1, 3] for i in (actions.index("curl") - 1, _last(actions, "touch"))]
    assert ahead[1] - ahead[0] == pytest.approx(2 * 0.08 * PAPER.length, abs=1e-4)  # Each a reading before its end.
    assert log.gave_up == "nothing was lifted: the arm feels no load"


def test_a_plan_scales_with_robot_and_object():
    """Twice as large, weightless: every way is twice as long, but the last one down slow over 4 times the height."""
    spiral = dataclasses.replace(PAPER.spiral, a=2 * PAPER.spiral.a)
    joint = dataclasses.replace(PAPER.joint, radius=2 * PAPER.joint.radius, length=2 * PAPER.joint.length)
    mass = dataclasses.replace(PAPER.mass, sections=(1e-9,) * PAPER.n_section)
    cable = dataclasses.replace(PAPER.cable, tension_max=4 * PAPER.cable.tension_max)
    small = dataclasses.replace(PAPER, mass=mass, gripper=None)
    large = dataclasses.replace(small, spiral=spiral, joint=joint, cable=cable)
    places = []
    for design, scale in ((small, 1.0), (large, 2.0)):
        plant = Stub(_task(design, scale, mass=1e-9))
        observation = plant.reset()
        T = observation.T_world_base.copy()
        T[:3, 3] = scale * np.array([0.45, -0.15, 1.28])
        state = WrapVertical().init(dataclasses.replace(observation, T_world_base=T))
        places.append(np.array([move.position for move in state.sequence.moves]))
    bring = [move.action for move in state.sequence.moves].index("bring")
    places[1][bring, 2] -= 2 * 0.045 * small.length * (stretch(large) ** 2 - stretch(small) ** 2)
    np.testing.assert_allclose(places[1], 2 * places[0], rtol=0, atol=2e-4)
