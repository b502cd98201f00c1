"""A real trial, recorded: the survey's own, with the environments' pictures."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import numpy as np
import pytest

from spiraltrunk.control.encoding import ControlMode, decode_action, encode_agent
from spiraltrunk.control.messages import Command
from spiraltrunk.workflows.demos.options import RecordingOptions
from spiraltrunk.workflows.demos.recording.episode import restore_commands, restore_observations
from spiraltrunk.workflows.demos.recording.episode_file import load_episode
from spiraltrunk.workflows.demos.recording.pictures import decode
from spiraltrunk.workflows.demos.run_demos import DemosPlan, run_demos
from spiraltrunk.workflows.survey.plan import SurveyPlan
from spiraltrunk.workflows.survey.run_entry import compute_row


@pytest.mark.slow
@pytest.mark.gl
def test_a_recorded_trial_is_the_surveys(tmp_path: Path) -> None:
    survey = SurveyPlan(objects={"kick": ("ball-80",)}, trials=1, seed=0)
    recording = RecordingOptions(cameras=("front", "close"), size=64, fps=10)
    result = run_demos(DemosPlan(survey=survey, recording=recording, format="robomimic"), folder=tmp_path)
    assert (result["demonstrations"], result["complete"]) == (1, True)
    (row,) = json.loads((tmp_path / "trials" / "survey.json").read_text())["rows"]
    alone = compute_row(survey.entries()[0])
    changing = {"wall_s", "real_time_factor", "planning_wall_s"}
    assert {key: row[key] for key in row if key not in changing} == {
        key: alone[key] for key in alone if key not in changing
    }
    episode = load_episode(tmp_path / "episodes" / "kick-000000.npz")
    assert episode.time[-1] == pytest.approx(row["simulated_s"])
    assert np.array_equal(episode.time, episode.state[:, 0])
    assert episode.scene.startswith("<mujoco")
    assert "/" not in "".join(part.partition('"')[0] for part in episode.scene.split('file="')[1:])
    assert {"turn", "kick", "watch"} <= set(episode.action)
    seen, commands = restore_observations(episode), restore_commands(episode)
    np.testing.assert_array_equal(encode_agent(seen[0]), episode.frames.agent[0])
    before = Command(T_world_base=seen[0].T_world_base, cable_tension=np.zeros(3))
    for step, action in zip(episode.steps[1:], episode.frames.action, strict=True):
        before = decode_action(ControlMode.DELTA_POSE_TENSION_PULL, action, before, seen[0].task, period=0.1)
        np.testing.assert_allclose(before.T_world_base, commands[step - 1].T_world_base, atol=1e-5)
    assert float(episode.frames.clipped) == 0
    for camera in recording.cameras:
        pictures = list(decode(episode.videos[camera]))
        assert len(pictures) == len(episode.frames) + 1
        assert np.abs(pictures[0].astype(int) - pictures[-1]).max() > 40
    with h5py.File(tmp_path / "demos.hdf5") as file:
        demo = file["data/demo_0"]
        assert demo["rewards"][-1] == 1
        assert demo["obs/close_image"].shape == (len(episode.frames), 64, 64, 3)
        assert json.loads(demo.attrs["provenance"])["world"]["friction"] == pytest.approx(row["friction"])
