"""Frames of a recording are those of the trace, thirty times a second."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from spiraltrunk.control.strategy import Status
from spiraltrunk.sim.body_meshes import BodyPoses
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.workflows.grasp.recording import RATE, Recorder, interpolate_poses, join_frames, record

PHASES = ("reach", "prehension", "transport", "release")


@pytest.fixture(scope="module")
def trial() -> Any:
    """One second of a robot that holds still and of an object that falls: 50 samples in four phases."""
    plant = SimPlant()
    plant.reset()
    plant.set_cables(np.zeros(plant.design.n_cable), 0.0)
    for _ in range(50):
        plant.advance(0.02)
        plant.record()
    statuses = tuple(Status(phase=PHASES[i * 4 // 50], action=f"action {i}") for i in range(50))
    return SimpleNamespace(
        plant=plant, log=SimpleNamespace(statuses=statuses), strategy="stand", seed=3,
        verdict=SimpleNamespace(reason="success"),
    )  # fmt: skip


def test_frames_come_thirty_times_a_second_and_lie_between_the_samples(trial: Any) -> None:
    recording = record(trial)
    frames, trace = recording.frames, trial.plant.trace
    assert len(frames) == RATE + 1
    assert frames.time == pytest.approx(np.arange(RATE + 1) / RATE)
    assert frames.pose.dtype == np.float32
    times = [sample.time for sample in trace]
    for column, name in ((frames.height, "object_position"), (frames.grip_force, "grip_force")):
        values = [np.atleast_1d(getattr(sample, name))[-1] for sample in trace]
        assert column == pytest.approx(np.interp(frames.time, times, values))
    body, poses = trial.plant.model.body("object").id, BodyPoses(trial.plant.model)
    for i in (0, 15, 30):  # Frames at samples of the trace.
        exact, string = poses.compute(trace[round(50 * i / RATE)].qpos)
        assert frames.pose[i] == pytest.approx(exact, abs=1e-6)
        assert frames.string[i] == pytest.approx(string, abs=1e-6)
    above = trial.plant.model.joint("object").qposadr[0] + 2
    exact = np.interp(frames.time, times, [sample.qpos[above] for sample in trace])
    assert frames.pose[:, body, 2] == pytest.approx(exact, abs=1e-6)
    assert exact[0] - exact[-1] > 1e-4, "it sinks into its strings"
    assert recording.title == "stand, seed 3: success"


def test_phases_follow_the_strategy(trial: Any) -> None:
    spans = record(trial).frames.spans()
    assert [name for name, _, _ in spans] == list(PHASES)
    assert spans[0][1] == 0.0
    assert spans[-1][2] == pytest.approx(1.0)
    assert all(end == begin for (_, _, end), (_, begin, _) in pairwise(spans))


def test_frames_taken_while_it_runs_are_those_taken_afterwards(trial: Any) -> None:
    machine = SimpleNamespace(model=trial.plant.model, trace=[trial.plant.trace[0]])
    recorder, parts = Recorder(machine), []  # type: ignore[arg-type]
    for sample, status in zip(trial.plant.trace[1:], trial.log.statuses, strict=True):
        machine.trace.append(sample)
        recorder.watch(None, status)
        part = recorder.take()
        parts += [] if part is None else [part]
    assert recorder.take() is None
    streamed, whole = join_frames(parts), record(trial).frames
    assert np.array_equal(streamed.pose, whole.pose)
    assert np.array_equal(streamed.tension, whole.tension)
    assert streamed.phase == whole.phase
    assert streamed.action == whole.action


def test_a_pose_between_two_is_on_the_short_way() -> None:
    half = np.sqrt(0.5)
    before = np.array([[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])
    after = np.array([[2.0, 0.0, 4.0, -half, -half, 0.0, 0.0]])  # A quarter turn about x, with the other sign.
    middle = interpolate_poses(before, after, 0.5)
    eighth = np.pi / 8
    assert middle[0] == pytest.approx([1.0, 0.0, 2.0, np.cos(eighth), np.sin(eighth), 0.0, 0.0])
