"""Episodes: what is stored comes back, and messages are restored exactly."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from spiraltrunk.control.encoding import encode_agent, encode_environment
from spiraltrunk.control.object_handle import Handle
from spiraltrunk.control.object_profile import ObjectProfile
from spiraltrunk.errors import OutputError
from spiraltrunk.workflows.demos.dataset.task_text import describe_episode
from spiraltrunk.workflows.demos.options import RecordingOptions
from spiraltrunk.workflows.demos.recording.episode import (
    ARRAYS,
    restore_commands,
    restore_observations,
)
from spiraltrunk.workflows.demos.recording.episode_file import load_episode, name_episode, write_episode
from spiraltrunk.workflows.demos.recording.pictures import decode, encode_lossless


def test_a_file_holds_all_of_an_episode(fakes: ModuleType, tmp_path: Path) -> None:
    recording = RecordingOptions(cameras=("front",), size=32, fps=10)
    episode = fakes.build_episode(11, recording=recording)
    write_episode(episode, tmp_path / "new" / "one.npz")
    loaded = load_episode(tmp_path / "new" / "one.npz")
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(loaded, name), getattr(episode, name), err_msg=name)
    for each in fields(loaded.frames):
        np.testing.assert_array_equal(getattr(loaded.frames, each.name), getattr(episode.frames, each.name))
    assert loaded.about == episode.about
    assert (loaded.scene, loaded.videos) == (episode.scene, episode.videos)
    assert len(loaded) == 23
    assert loaded.steps.tolist() == [0, 5, 10, 15, 20, 23]


def test_messages_are_restored_exactly(fakes: ModuleType) -> None:
    seen, commands = fakes.draw_messages(3, 23)
    episode = fakes.build_episode(3)
    restored = restore_observations(episode)
    assert len(restored) == len(seen) == 24
    assert restored[0].camera is None
    for given, found in zip(seen, restored, strict=True):
        np.testing.assert_array_equal(encode_agent(found), encode_agent(given))
        np.testing.assert_array_equal(encode_environment(found), encode_environment(given))
    profile, given = restored[0].task.target.profile, seen[0].task.target.profile
    for each in fields(ObjectProfile):
        if each.name != "stable_poses":
            np.testing.assert_array_equal(getattr(profile, each.name), getattr(given, each.name))
    assert restored[0].task.design == seen[0].task.design
    for given, found in zip(commands, restore_commands(episode), strict=True):
        assert (given.cable_pull is None) == (found.cable_pull is None)
        np.testing.assert_array_equal(found.cable_pull, given.cable_pull)
        np.testing.assert_array_equal(found.T_world_base, given.T_world_base)
        np.testing.assert_array_equal(found.cable_tension, given.cable_tension)
        assert found.gripper == given.gripper


def test_no_pixel_of_a_picture_is_lost() -> None:
    pictures = list(np.random.default_rng(0).integers(0, 256, (7, 18, 24, 3), np.uint8))
    decoded = list(decode(encode_lossless(pictures, 10)))
    assert len(decoded) == 7
    for given, found in zip(pictures, decoded, strict=True):
        np.testing.assert_array_equal(found, given)


@pytest.mark.parametrize("kept", [0, 1, 100, 5000, -1])
def test_a_torn_file_is_refused(fakes: ModuleType, tmp_path: Path, kept: int) -> None:
    write_episode(fakes.build_episode(), tmp_path / "torn.npz")
    data = (tmp_path / "torn.npz").read_bytes()
    (tmp_path / "torn.npz").write_bytes(data[:kept])
    with pytest.raises(OutputError, match=r"torn.npz' is no episode; allowed: the same command once that file is rem"):
        load_episode(tmp_path / "torn.npz")


def test_what_does_not_belong_together_is_refused(fakes: ModuleType, tmp_path: Path) -> None:
    episode = fakes.build_episode()
    short = replace(episode.frames, action=episode.frames.action[:-1])
    for bad in (replace(episode, phase=episode.phase[1:]), replace(episode, frames=short)):
        write_episode(bad, tmp_path / "bad.npz")
        with pytest.raises(OutputError, match="is no episode"):
            load_episode(tmp_path / "bad.npz")
    with pytest.raises(OutputError, match="is gone"):
        load_episode(tmp_path / "none.npz")


def test_a_pickle_is_not_loaded(tmp_path: Path) -> None:
    np.savez(tmp_path / "pickle.npz", about=np.array([{"a": 1}], dtype=object))
    with pytest.raises(OutputError, match="is no episode"):
        load_episode(tmp_path / "pickle.npz")


def test_policies_have_names_of_files_and_tasks(fakes: ModuleType, tmp_path: Path) -> None:
    strategy = "policy:out/../my [1].safetensors"
    name = name_episode(strategy, 3)
    assert Path(name).name == name
    episode = fakes.build_episode(11, strategy=strategy)
    write_episode(episode, tmp_path / name)
    assert list(tmp_path.glob(name_episode(strategy, "*"))) == [tmp_path / name]
    text = describe_episode(load_episode(tmp_path / name))
    assert text.startswith("grasp the standing cylinder")
    assert text.endswith(f"({strategy})")
    assert name_episode("wrap-vertical", 12) == "wrap-vertical-000012.npz"


def test_the_handle_of_a_mug_comes_back_from_the_file(fakes: ModuleType, tmp_path: Path) -> None:
    episode = fakes.build_episode(2, name="everyday:seed=3,kind=handled")
    write_episode(episode, tmp_path / "mug.npz")
    found = restore_observations(load_episode(tmp_path / "mug.npz"))[0].task.target.handle
    given = fakes.build_fake_task("everyday:seed=3,kind=handled").target.handle
    assert found is not None
    for each in fields(Handle):
        np.testing.assert_array_equal(getattr(found, each.name), getattr(given, each.name))
