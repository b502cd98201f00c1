"""A log tells the run that the control loop returned, and draws its figures."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from spiraltrunk.control import (
    CameraObservation,
    Command,
    Goal,
    Milestone,
    Observation,
    Plant,
    RunLog,
    Status,
    Strategy,
    Target,
    Task,
    run,
)
from spiraltrunk.design import presets
from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.clock import Clock
from spiraltrunk.hardware.log import LoggedPlant, LogWriter, build_run_log, describe_task, load_log
from spiraltrunk.report import Series
from spiraltrunk.report.trial.figures import build_run_figure
from spiraltrunk.workflows.grasp.artifacts import compute_phase_spans

Build = Callable[..., Any]

TASK = Task(
    design=presets.PAPER,
    target=Target(kind="cylinder", width=0.06, length=0.1, mass=0.2, position=np.ones(3) / 3, axis=np.eye(3)[2]),
    goal=Goal(aside=np.zeros(3), place=np.array([0.1, 0.2, 0.3]), ground=None),
)


class Ticks(Clock):
    """A clock that counts its calls from 1000."""

    def __init__(self) -> None:
        self.count = itertools.count(1)

    def now(self) -> float:
        return 1000.0 + next(self.count) / 1000

    def sleep_until(self, moment: float) -> None:
        raise NotImplementedError


class Random(Plant):
    """A plant that measures random numbers; the camera sees every third time."""

    control_period = 0.02

    def reset(self) -> Observation:
        self.rng, self.n, self.camera = np.random.default_rng(1), 0, None
        return self.observe()

    def step(self, command: Command) -> Observation:
        self.n += 1
        if self.n % 3 == 0:
            position, axis = self.rng.normal(size=(2, 3))
            self.camera = CameraObservation(time=0.02 * self.n - 0.005, position=position, axis=axis)
        return self.observe()

    def observe(self) -> Observation:
        arrays = {
            "T_world_base": (4, 4), "arm_position": 7, "arm_velocity": 7, "cable_pull": 3, "cable_tension": 3,
            "base_force": 3, "base_torque": 3,
        }  # fmt: skip
        seen = {name: self.rng.normal(size=shape) for name, shape in arrays.items()}
        return Observation(time=0.02 * self.n, task=TASK, camera=self.camera, **seen)


class Steps(Strategy[int]):
    """Counts to 40 through the phases; its limits come and go."""

    name = "steps"
    number = 1

    def __init__(self, gives_up: str | None = None) -> None:
        self.gives_up = gives_up

    def init(self, observation: Observation) -> int:
        return -1

    def step(self, state: int, observation: Observation) -> tuple[int, Command]:
        state += 1
        pull = [None, np.array([0.1, np.inf, -0.2]), np.full(3, 1 / 3)][state % 3]
        frame = observation.T_world_base + state
        return state, Command(T_world_base=frame, cable_tension=np.arange(3) / 7, cable_pull=pull, gripper=state / 100)

    def status(self, state: int) -> Status:
        phase = ("reach", "prehension", "transport", "release")[min(state // 10, 3)]
        milestone = Milestone.LIFTED if phase == "transport" else None
        is_done = state == 40
        gave_up = self.gives_up if is_done else None
        return Status(phase=phase, action=f"step {state}", milestone=milestone, is_done=is_done, gave_up=gave_up)


def assert_equal(one: object, other: object) -> None:
    """Every number exactly."""
    if is_dataclass(one):
        assert type(one) is type(other)
        for field in fields(one):
            if field.name == "profile":  # Of the object, and not logged.
                continue
            assert_equal(getattr(one, field.name), getattr(other, field.name))
    elif isinstance(one, tuple):
        assert isinstance(other, tuple)
        assert len(one) == len(other)
        for pair in zip(one, other, strict=True):
            assert_equal(*pair)
    else:
        np.testing.assert_array_equal(one, other)


@pytest.fixture
def record(tmp_path: Path, build_metadata: Build) -> Callable[..., tuple[Path, RunLog]]:
    """Runs a strategy on a logged plant; path and what the loop returned."""

    def record(gives_up: str | None = None, *, n: int = 1, task: object = None) -> tuple[Path, RunLog]:
        metadata = build_metadata(task=describe_task(TASK) if task is None else task)
        with LogWriter(tmp_path / "run.mcap", 1000.0, metadata) as log:
            for _ in range(n):
                plant = LoggedPlant(Random(), log, Ticks())
                done = run(plant, Steps(gives_up), watch=plant.watch)
                plant.end(done)
        return tmp_path / "run.mcap", done

    return record


@pytest.mark.parametrize("gives_up", [None, "the object slipped"])
def test_the_run_comes_back_exactly(record: Build, gives_up: str | None) -> None:
    path, done = record(gives_up)
    told = build_run_log(load_log(path))
    assert len(told.commands) == 40
    assert told.gave_up == gives_up
    assert_equal(told, replace(done, state=None))  # The state of the strategy is its own, and not logged.


def test_the_logged_run_is_the_unlogged_one(record: Build) -> None:
    _, done = record()
    assert_equal(replace(done, planning=0.0), replace(run(Random(), Steps()), planning=0.0))


def build_series(log: RunLog) -> Series:
    """What the figures of a trial draw, from what a robot measures; the rest is zero."""
    seen = log.observations
    n = len(seen)
    columns = {name: np.array([getattr(s, name) for s in seen]) for name in ("time", "cable_pull", "cable_tension")}
    height = np.array([np.nan if s.camera is None else s.camera.position[2] for s in seen])
    design = seen[0].task.design
    return Series(
        **columns, phase_spans=compute_phase_spans(log), joint_bend=np.zeros((n, design.section_length.size - 1)),
        joint_limit=design.joint_limit, section_length=design.section_length, object_height=height,
        lift=log.milestone_span(Milestone.LIFTED) and (0.0, 0.2), grip_force=np.zeros(n), string_tension=np.zeros(n),
        title="replay",
    )  # fmt: skip


@pytest.mark.parametrize("name", ["cables.png", "object.png", "overview.png"])
def test_figures_of_a_replay_are_those_of_the_run(record: Build, name: str) -> None:
    path, done = record()
    told = build_run_log(load_log(path))
    figures = [build_run_figure(build_series(one), name) for one in (told, done)]
    for replayed, direct in zip(*(figure.axes for figure in figures), strict=True):
        lines = [(line.get_label(), line.get_xydata()) for line in replayed.lines]
        assert_equal(tuple(lines), tuple((line.get_label(), line.get_xydata()) for line in direct.lines))
        assert [text.get_text() for text in replayed.texts] == [text.get_text() for text in direct.texts]
    drawn = figures[0].axes[0].lines
    assert {"reach", "prehension", "transport", "release"} <= {text.get_text() for text in figures[0].axes[0].texts}
    if name == "cables.png":
        for cable, line in enumerate(drawn[:3]):
            np.testing.assert_array_equal(line.get_ydata(), [1e3 * s.cable_pull[cable] for s in done.observations])


def test_a_run_that_was_cut_off_ends_with_a_whole_step(tmp_path: Path, build_metadata: Build) -> None:
    class Crash(Exception):
        pass

    seen = []

    def watch(observation: Observation, status: Status) -> None:
        seen.append(status)
        if len(seen) == 7:
            raise Crash
        plant.watch(observation, status)

    with LogWriter(tmp_path / "a.mcap", 1000.0, build_metadata(task=describe_task(TASK))) as log:
        plant = LoggedPlant(Random(), log, Ticks())
        with pytest.raises(Crash):
            run(plant, Steps(), watch=watch)
    told, whole = build_run_log(load_log(tmp_path / "a.mcap")), run(Random(), Steps())
    assert_equal(told.observations, whole.observations[:7])
    assert_equal(told.commands, whole.commands[:6])
    assert_equal(told.statuses, whole.statuses[:6])
    assert (told.gave_up, told.planning) == (None, 0.0)


def test_steps_whose_messages_were_lost_are_left_out(record: Build) -> None:
    path, done = record()
    log = load_log(path)
    command = log.channels["/command"]
    kept = np.delete(np.arange(40), [5])
    lists = {field.name: getattr(command, field.name)[kept] for field in fields(command)}
    told = build_run_log(replace(log, channels=log.channels | {"/command": replace(command, **lists)}))
    assert_equal(told.statuses, done.statuses[:5] + done.statuses[6:])
    assert_equal(told.observations, done.observations[:6] + done.observations[7:])


def test_two_runs_and_none_are_refused(record: Build, write: Build) -> None:
    with pytest.raises(DriveError, match="more than one run"):
        build_run_log(load_log(record(n=2)[0]))
    with pytest.raises(DriveError, match="no run"):
        build_run_log(load_log(write(3)))


@pytest.mark.parametrize(
    ("part", "key", "value"),
    [
        ("target", "position", [1, 2]), ("target", "mass", "a"), ("goal", "hold", None),
        ("goal", "place", [1, 2, None]), ("goal", "new", 1),
    ],
)  # fmt: skip
def test_a_task_that_is_none_is_one_line(record: Build, part: str, key: str, value: object) -> None:
    task = describe_task(TASK)
    task[part][key] = value
    path, _ = record(task=task)
    with pytest.raises(DriveError, match=rf"{part}.* of the log"):
        build_run_log(load_log(path))


def test_a_design_that_is_none_is_one_line(tmp_path: Path, record: Build) -> None:
    log = load_log(record()[0])
    for design in ("a = ", "\ud800", "[spiral]\na_mm = -1"):
        with pytest.raises(DriveError, match="design of the log"):
            build_run_log(replace(log, metadata=replace(log.metadata, design=design)))
