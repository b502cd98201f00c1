"""What every plant promises, simulated or real: the hardware's runs on the twin, behind motors, bus and driver."""

import copyreg
from copy import deepcopy
from dataclasses import fields, replace
from functools import cache
from threading import Lock, RLock

import numpy as np
import pytest

from spiraltrunk.control.messages import Command
from spiraltrunk.control.plant import Plant
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import RunError
from spiraltrunk.hardware.twin.clock import STEP
from spiraltrunk.sim import SimPlant
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.workflows.drive.twin.twin_robot import TwinRobot


@cache
def _prepare(design):
    """A twin that is homed and armed, once."""
    robot = TwinRobot(design, SceneOptions(timestep=STEP))
    robot.prepare()
    return robot


def _copy(robot):
    """All of a twin as it is; locks, which cannot be copied, are new ones."""
    kinds = {type(make()): make for make in (Lock, RLock)}
    copyreg.dispatch_table.update({kind: lambda _, make=make: (make, ()) for kind, make in kinds.items()})
    try:
        return deepcopy(robot)
    finally:
        for kind in kinds:
            del copyreg.dispatch_table[kind]


class TwinPlant(Plant):
    """`HardwarePlant` on the twin. Nothing moves by itself on hardware: a person puts the robot back before a reset."""

    control_period = 0.02

    def __init__(self, design):
        self.design = design
        self._put_back()

    def _put_back(self):
        self.plant = _copy(_prepare(self.design)).build_plant()

    def reset(self):
        self._put_back()
        return self.plant.reset()

    def step(self, command):
        return self.plant.step(command)


PLANTS = {"simulation": lambda: SimPlant(PAPER), "twin": lambda: TwinPlant(PAPER)}
"""Name and how to make one."""


@pytest.fixture(scope="module", params=PLANTS)
def plant(request):
    return PLANTS[request.param]()


def _arrays(observation):
    values = {field.name: getattr(observation, field.name) for field in fields(observation)}
    del values["task"], values["camera"]
    return values


def _assert_same(first, second):
    for name, value in _arrays(first).items():
        np.testing.assert_array_equal(value, getattr(second, name), err_msg=name)


def _command(observation, tension=5.0):
    T = observation.T_world_base.copy()
    T[:3, 3] += [0.0, 0.01, 0.005]
    pull = np.zeros(observation.cable_tension.shape)
    pull[1:] = tension
    return Command(T_world_base=T, cable_tension=pull)


def test_it_is_a_plant(plant):
    assert isinstance(plant, Plant)
    assert 0.0 < plant.control_period <= 0.1


def test_observations_are_complete_and_finite(plant):
    first = plant.reset()
    n_cable = first.task.design.n_cable
    n_arm = len(first.arm_position)
    shapes = {"T_world_base": (4, 4), "arm_position": (n_arm,), "arm_velocity": (n_arm,), "cable_pull": (n_cable,),
              "cable_tension": (n_cable,), "base_force": (3,), "base_torque": (3,), "time": ()}  # fmt: skip
    for observation in (first, plant.step(_command(first))):
        values = _arrays(observation)
        assert {name: np.shape(value) for name, value in values.items()} == shapes
        assert all(np.isfinite(value).all() for value in values.values())
        turn = observation.T_world_base[:3, :3]
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-9)
        assert np.linalg.det(turn) == pytest.approx(1.0)
        np.testing.assert_array_equal(observation.T_world_base[3], [0, 0, 0, 1])


def test_time_starts_at_zero_and_advances_by_the_period(plant):
    observation = plant.reset()
    assert observation.time == 0.0
    for n in range(1, 6):
        observation = plant.step(_command(observation))
        assert observation.time == pytest.approx(n * plant.control_period, abs=1e-9)


def test_the_trunk_starts_straight_and_slack(plant):
    observation = plant.reset()
    np.testing.assert_allclose(observation.cable_pull, 0.0, atol=1e-4)
    is_ideal = isinstance(plant, SimPlant)
    floor, swing = (0.0, 1e-9) if is_ideal else (1.3, 1e-5)  # A cable is kept on its drum; homing moved the trunk.
    assert ((observation.cable_tension >= 0.0) & (observation.cable_tension <= floor)).all()
    np.testing.assert_allclose(observation.arm_velocity, 0.0, atol=swing)


def test_reset_forgets_everything(plant):
    first = plant.reset()
    for _ in range(10):
        plant.step(_command(first, tension=30.0))
    _assert_same(plant.reset(), first)


def test_the_same_commands_give_the_same_observations(plant):
    runs = []
    for _ in range(2):
        observation = plant.reset()
        commands = [_command(observation, tension) for tension in np.linspace(0, 20, 15)]
        runs.append([observation, *(plant.step(command) for command in commands)])
    for one, other in zip(*runs, strict=True):
        _assert_same(one, other)


def test_observations_are_not_overwritten(plant):
    first = plant.reset()
    kept = {name: np.copy(value) for name, value in _arrays(first).items()}
    for _ in range(5):
        plant.step(_command(first, tension=20.0))
    for name, value in kept.items():
        np.testing.assert_array_equal(getattr(first, name), value)


def _broken(observation):
    good = _command(observation)
    for value in (np.nan, np.inf, -np.inf):
        T, tension = good.T_world_base.copy(), good.cable_tension.copy()
        T[0, 3], tension[1] = value, value
        yield replace(good, T_world_base=T), r"command\.T_world_base"
        yield replace(good, cable_tension=tension), r"command\.cable_tension"
        yield replace(good, gripper=value), r"command\.gripper"
    yield replace(good, cable_pull=np.array([0.0, np.nan, 0.0])), r"command\.cable_pull"
    yield replace(good, cable_pull=np.array([0.0, -np.inf, 0.0])), r"command\.cable_pull"
    yield replace(good, cable_pull=np.array([0.0, -1e300, 0.0])), r"command\.cable_pull"


def _assert_refused(plant, commands):
    """Each in one line that says why, and none of them changes what the next command does."""
    observation = plant.reset()
    undisturbed = [plant.step(_command(observation)) for _ in range(2)][-1]
    first = plant.reset()
    plant.step(_command(first))
    for command, words in commands(first):
        with pytest.raises(RunError, match=words) as refusal:
            plant.step(command)
        assert "\n" not in str(refusal.value)
        assert len(str(refusal.value)) < 250
    _assert_same(plant.step(_command(first)), undisturbed)


def test_a_command_that_is_not_finite_is_refused_and_changes_nothing(plant):
    _assert_refused(plant, _broken)


def _impossible(observation):
    """What is no command, and what the refusal says of it."""
    good = _command(observation)
    T, n_cable = good.T_world_base, len(good.cable_tension)
    stretched, mirrored, sheared, far, bare = (T.copy() for _ in range(5))
    stretched[:3, :3] *= 1.001
    mirrored[:3, 0] *= -1.0
    sheared[:3, 1] += 0.01 * sheared[:3, 0]
    far[2, 3], bare[3, 3] = 1e6, 2.0
    for frame, words in (
        (T[:3], "has shape"), (None, "numbers"), (T.astype(complex), "numbers"), ([[1.0], 2.0], "numbers"),
        (stretched, "rotation"), (mirrored, "left-handed"), (sheared, "rotation"), (far, "within"), (bare, "row"),
    ):  # fmt: skip
        yield replace(good, T_world_base=frame), rf"command\.T_world_base.*{words}"
    for name in ("cable_tension", "cable_pull"):
        for value in (np.zeros(n_cable + 1), np.zeros((1, n_cable)), 5.0, "all", ["a"]):
            yield replace(good, **{name: value}), rf"command\.{name}.*allowed"
    most = observation.task.design.cable.tension_max
    for value in (1e5, -1.0, 1.01 * most, -1e-3):
        tension = good.cable_tension.copy()
        tension[1] = value
        yield replace(good, cable_tension=tension), rf"cable_tension is {value:g} N; allowed: 0 to {most:g} N"
    for value in (5.0, -1.01, 2):
        yield replace(good, gripper=value), rf"command\.gripper is {value:g}; allowed: -1 \(open\) to 1 \(closed\)"
    for value in (None, "open", [0.0, 0.0], 1j):
        yield replace(good, gripper=value), r"command\.gripper.*allowed"
    for value in (None, "go", T):
        yield value, "allowed: a Command"


def test_what_is_no_command_is_refused_in_one_line_and_changes_nothing(plant):
    _assert_refused(plant, _impossible)


def test_lists_and_whole_numbers_are_numbers(plant):
    first = plant.reset()
    usual = plant.step(replace(_command(first, tension=5.0), cable_pull=np.ones(len(first.cable_pull)), gripper=1.0))
    first = plant.reset()
    command = _command(first, tension=5.0)
    tension = [round(value) for value in command.cable_tension]
    listed = Command(
        T_world_base=command.T_world_base.tolist(), cable_tension=tension, cable_pull=[1] * len(tension), gripper=1
    )
    _assert_same(plant.step(listed), usual)


def test_a_command_at_the_ends_of_the_motors_is_carried_out(plant):
    """Also where its interpolation rounds beyond them."""
    first = plant.reset()
    most = first.task.design.cable.tension_max
    ends = replace(_command(first, tension=most), gripper=-1.0)
    usual = [plant.step(ends) for _ in range(3)][-1]
    plant.reset()
    rounded = replace(ends, cable_tension=ends.cable_tension * (1 + 1e-15) - 1e-14, gripper=-1.0 - 1e-15)
    for name, value in _arrays([plant.step(rounded) for _ in range(3)][-1]).items():
        np.testing.assert_allclose(value, getattr(usual, name), rtol=1e-9, atol=1e-9)


def test_a_step_before_the_first_reset_is_refused(plant):
    fresh = type(plant)(PAPER)
    with pytest.raises(RunError, match="reset"):
        fresh.step(_command(plant.reset()))


def test_an_endless_pull_is_no_bound(plant):
    """A winder told an infinite length pulls with its tension alone, as one that is told none."""
    first = plant.reset()
    free = [plant.step(_command(first)) for _ in range(3)][-1]
    plant.reset()
    endless = replace(_command(first), cable_pull=np.full(first.cable_pull.shape, np.inf))
    _assert_same([plant.step(endless) for _ in range(3)][-1], free)


def test_commands_are_not_modified(plant):
    observation = plant.reset()
    command = replace(_command(observation, tension=30.0), cable_pull=np.full(observation.cable_pull.shape, 5.0))
    kept = {field.name: np.copy(getattr(command, field.name)) for field in fields(command)}
    plant.step(command)
    for name, value in kept.items():
        np.testing.assert_array_equal(getattr(command, name), value)
