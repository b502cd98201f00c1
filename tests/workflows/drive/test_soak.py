"""Operation for hours on the twin: no false alarm, and every fault with its time; the tests print their figures."""

from __future__ import annotations

import itertools
import math
import random
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.control.messages import Command
from spiraltrunk.design.presets import PAPER
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.strategies import NAMES
from spiraltrunk.workflows.drive import soak
from spiraltrunk.workflows.drive.robot import RENEWAL
from spiraltrunk.workflows.drive.soak import FAULTS, SoakResult, record_commands, run_soak
from spiraltrunk.workflows.drive.soak_log import check_log
from spiraltrunk.workflows.drive.twin.twin_robot import TwinOptions, TwinRobot


def swing(duration: float) -> tuple[Command, ...]:
    """Tensions of 2 to 22 N, a third of 4 s apart, and all cables let go at the end."""
    commands = []
    for i in range(round(duration / RENEWAL)):
        phase = math.tau * (i * RENEWAL / 4.0 - np.arange(3) / 3)
        commands.append(Command(T_world_base=np.eye(4), cable_tension=12.0 + 10.0 * np.sin(phase)))
    return (*commands, *[Command(T_world_base=np.eye(4), cable_tension=np.zeros(3))] * 50)


def show(result: SoakResult) -> None:
    print(
        f"{result.simulated:.0f} s, {result.n_strategy} strategies, {result.n_command} commands, {result.n_lost} lost, "
        f"drift {1e3 * result.drift:.4f} mm, faults {[(one.name, one.kind) for one in result.faults]}"
    )


@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_a_minute_of_nominal_operation_raises_nothing():
    result = run_soak(PAPER, {"swing": swing(9.0)}, duration=60.0, fault_period=math.inf)
    show(result)
    assert result.simulated >= 60.0
    assert (result.faults, result.n_lost) == ((), 0)
    assert result.n_strategy == math.ceil(58.0 / 10.0)
    assert result.drift < 1e-3


@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_every_fault_is_noted_with_its_time_and_reaction():
    result = run_soak(PAPER, {"swing": swing(9.0)}, duration=90.0, seed=3, fault_period=5.0)
    show(result)
    assert len(result.faults) > 5
    assert result.n_lost == 0
    for one in result.faults:
        assert one.name in FAULTS
        assert (one.noticed is None) == (one.kind is None) == (one.reaction is None)
        if one.noticed is not None:
            assert one.injected < one.noticed < one.injected + 4.0
            assert one.reaction < 0.1
    assert all(early.injected < late.injected for early, late in itertools.pairwise(result.faults))


@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_faults_of_load_cells_are_noted_too(monkeypatch):
    """Each stops the robot, and after it is mended the robot goes on."""
    monkeypatch.setattr(soak, "FAULTS", ())
    result = run_soak(PAPER, {"swing": swing(9.0)}, duration=150.0, seed=4, fault_period=2.0, has_cells=True)
    show(result)
    assert {one.name for one in result.faults} == set(soak.CELL_FAULTS)
    assert result.n_lost == 0
    for one in result.faults:
        assert one.name.startswith("cell_")
        assert one.noticed is not None
        assert one.reaction < 0.1


@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_a_hot_motor_cools_before_the_next_homing(monkeypatch):
    monkeypatch.setattr(soak, "FAULTS", ("over_temperature",))
    result = run_soak(PAPER, {"swing": swing(9.0)}, duration=20.0, seed=1, fault_period=1.0)
    show(result)
    assert result.faults[0].kind == "over-temperature"
    assert result.simulated > 100.0


def test_a_soak_ends_when_it_is_enough():
    calls = []
    result = run_soak(
        PAPER, {"swing": swing(1.0)}, duration=1e9, fault_period=math.inf,
        progress=lambda name, done, total: calls.append((name, total)), is_enough=lambda: len(calls) == 2,
    )  # fmt: skip
    assert result.n_strategy == 2
    assert calls == [("swing", 1_000_000_000)] * 2


def step_at_random(seed: int, duration: float) -> TwinRobot:
    """New targets of 0 to 40 N, and pulls in half of them, every 0.3 to 2 s, without any ramp."""
    chance, robot = random.Random(seed), TwinRobot(PAPER, options=TwinOptions(seed=seed))
    robot.prepare()
    end, due = robot.clock.now() + duration, 0.0
    while robot.clock.now() < end and robot.driver.mode is Mode.ARMED:
        if robot.clock.now() >= due:
            due = robot.clock.now() + chance.uniform(0.3, 2.0)
            tensions = [chance.choice([0.0, 0.0, chance.uniform(0.0, 40.0)]) for _ in range(3)]
            pulls = None if chance.random() < 0.5 else [chance.uniform(-0.08, 0.1) for _ in range(3)]
        robot.driver.set_targets(tensions, pulls, valid_for=RENEWAL)
        robot.run(RENEWAL)
    return robot


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "duration"),
    [(0, 15.0), (1, 15.0), (13, 12.0), (94, 8.0)],
)
def test_steps_of_the_tension_and_slack_cables_are_no_fault(seed, duration):
    """In the last two, cables that had been slack become taut at once, which looked like a slip."""
    robot = step_at_random(seed, duration)
    assert robot.driver.faults == ()


@pytest.mark.slow
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("seed", [*range(2, 22), 90, 94, 97])
def test_many_steps_of_the_tension_are_no_fault(seed):
    robot = step_at_random(seed, 25.0)
    assert robot.driver.faults == ()


@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_an_hour_of_the_strategies_raises_nothing():
    result = run_soak(PAPER, record_commands(PAPER, NAMES), duration=3600.0, seed=0, fault_period=math.inf)
    show(result)
    assert (result.faults, result.n_lost) == ((), 0)
    assert result.drift < 1e-3


@pytest.mark.slow
def test_a_stall_knows_how_far_its_drum_turns_without_it(monkeypatch):
    """The swing turns the drum, the rest before it does not; the first strategy is compared with nothing."""
    monkeypatch.setattr(soak, "FAULTS", ("stall",))
    rest = [Command(T_world_base=np.eye(4), cable_tension=np.full(3, 4.0))] * 300
    one = soak._Soak(PAPER, 0, math.inf)
    one.home()
    commands = (*rest, *swing(6.0)[:300])
    assert one.play("both", commands)
    turned = []
    for index in (50, 320):
        one._next = 0.0
        one._inject("both", index)
        turned.append(one._turned)
        one._clear()
    assert turned[0] < 1e-3 < turned[1]
    one._next = 0.0
    one._inject("other", 50)
    assert one._turned is None


@pytest.mark.slow
def test_the_log_tells_every_fault_with_its_time_and_reaction(tmp_path):
    """What is missing or different is told: a fault that never was, another time, another kind."""
    path = tmp_path / "soak.mcap"
    result = run_soak(PAPER, {"swing": swing(2.0)}, duration=25.0, seed=3, fault_period=0.5, log=path)
    show(result)
    check = check_log(path, result.faults)
    assert check.problems == ()
    assert check.n_noticed == sum(one.noticed is not None for one in result.faults) > 0
    assert check.n_injected == len(result.faults)
    (first, *_) = [one for one in result.faults if one.noticed is not None]
    for wrong, told in (
        (replace(first, noticed=first.noticed + 0.001), "not in the log with its reaction"),
        (replace(first, kind="watchdog"), "not in the log with its reaction"),
        (replace(first, injected=first.injected - 1.0), "not in the log"),
        (replace(first, name="never"), "not in the log"),
    ):
        (problem,) = check_log(path, [wrong]).problems
        assert problem.endswith(told)
