"""lerobot itself reads what is written, in an environment of its own: it cannot be installed beside spiraltrunk."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

from spiraltrunk.workflows.demos.dataset.layout import Episodes, Layout
from spiraltrunk.workflows.demos.dataset.lerobot.write import write_lerobot
from spiraltrunk.workflows.demos.dataset.task_text import describe_episode
from spiraltrunk.workflows.demos.recording.pictures import decode

PYTHON = "SPIRALTRUNK_LEROBOT_PYTHON"
"""Variable with the path of a Python that has lerobot."""


@pytest.mark.slow
@pytest.mark.skipif(PYTHON not in os.environ, reason=f"{PYTHON} names no Python with lerobot")
def test_lerobot_reads_the_episodes(stored: Episodes, layout: Layout, tmp_path: Path) -> None:
    write_lerobot(stored, layout, tmp_path / "set")
    program = Path(__file__).parent / "read_with_lerobot.py"
    clean = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | {"HF_HOME": str(tmp_path / "hf")}
    command = [os.environ[PYTHON], str(program), str(tmp_path / "set")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=280, env=clean, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    found = json.loads(done.stdout.splitlines()[-1])
    episodes = list(stored)
    assert (found["frames"], found["episodes"]) == (17, 3)
    assert found["kinds"] == {
        "observation.images.front": "VISUAL", "observation.images.top": "VISUAL", "observation.state": "STATE",
        "observation.environment_state": "ENV", "action": "ACTION",
    }  # fmt: skip
    state, action = len(layout.agent_names), len(layout.action_names)
    assert found["batch"]["observation.state"] == [4, 2, state]
    assert found["batch"]["action"] == [4, 2, action]
    assert found["batch"]["observation.images.top"] == [4, 3, 32, 32]
    frames = [episode.frames for episode in episodes]
    np.testing.assert_allclose(found["state"], np.concatenate([each.agent[:-1] for each in frames]), atol=1e-6)
    np.testing.assert_allclose(found["action"], np.concatenate([each.action for each in frames]), atol=1e-6)
    np.testing.assert_allclose(found["mean"], np.concatenate([each.action for each in frames]).mean(0), atol=1e-6)
    assert found["task"] == [describe_episode(episode) for episode in episodes for _ in range(len(episode.frames))]
    last = np.cumsum([len(each) for each in frames]) - 1
    assert [i for i, success in enumerate(found["success"]) if success] == [last[0], last[2]]
    for camera in layout.cameras:
        given = np.concatenate([list(decode(each.videos[camera]))[:-1] for each in episodes])
        told = found["colour"][f"observation.images.{camera}"]
        np.testing.assert_allclose(told, given.mean(axis=(1, 2)) / 255, atol=0.03)
