"""Shards of demonstrations, and their merge: the data set that one machine would have made."""

from __future__ import annotations

import hashlib
import json
import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from spiraltrunk.errors import SurveyError
from spiraltrunk.workflows.demos.merge_demos import merge_demos
from spiraltrunk.workflows.demos.options import RecordingOptions
from spiraltrunk.workflows.demos.run_demos import DemosPlan, run_demos
from spiraltrunk.workflows.survey import run_survey
from spiraltrunk.workflows.survey.plan import Shard, SurveyPlan

SURVEY = SurveyPlan(objects={"wrap-vertical": ("cylinder-60", "ball-80"), "kick": ("box-60",)}, trials=6, seed=7)

PLAN = DemosPlan(survey=SURVEY, recording=RecordingOptions(), format="lerobot")

COUNT = 3


def record(fakes: ModuleType, folder: Path, plan: DemosPlan) -> dict[str, Any]:
    work = partial(fakes.work, folder=folder / "episodes", recording=plan.recording)
    return run_demos(plan, folder=folder, work=work, engine=fakes.run_inline)


@pytest.fixture(scope="module")
def made(fakes: ModuleType, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Demonstrations, and the same in shards."""
    folder = tmp_path_factory.mktemp("shards")
    record(fakes, folder / "whole", PLAN)
    for number in range(1, COUNT + 1):
        shard = replace(SURVEY, shard=Shard(number=number, count=COUNT))
        assert record(fakes, folder / str(number), replace(PLAN, survey=shard))["complete"]
    return folder


@pytest.fixture
def shards(made: Path, tmp_path: Path) -> Path:
    """The same, to be spoiled."""
    return shutil.copytree(made, tmp_path / "shards")


def merge(folder: Path, *names: str) -> dict[str, Any]:
    return merge_demos([folder / name for name in names], folder / "out")


def digest(folder: Path) -> dict[str, str]:
    """Digests of the data set, by the files' names."""
    names = json.loads((folder / "result.json").read_text())["files"]
    return {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in names}


@pytest.mark.slow
def test_merged_shards_are_the_demonstrations_bit_for_bit(shards: Path) -> None:
    result = merge(shards, "3", "1", "2")
    assert result == json.loads((shards / "whole" / "result.json").read_text())
    assert result["demonstrations"] == len(list((shards / "out" / "episodes").iterdir())) > 4
    assert digest(shards / "out") == digest(shards / "whole")
    assert merge(shards, "1", "2", "3") == result  # Once more changes nothing.


@pytest.mark.slow
def test_an_interrupted_merge_goes_on(shards: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    copied = []

    def stop(step: str, count: int, total: int) -> None:
        copied.append(count)
        if count == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        merge_demos([shards / str(i) for i in (1, 2, 3)], shards / "out", progress=stop)
    assert copied == [0, 1, 2]
    merge(shards, "1", "2", "3")
    assert digest(shards / "out") == digest(shards / "whole")


def test_shards_of_another_version_are_merged(shards: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_survey, "compute_code", lambda: {"versions": {"mujoco": "0"}, "source": "another"})
    result = merge(shards, "1", "2", "3")
    assert result == json.loads((shards / "whole" / "result.json").read_text())
    assert digest(shards / "out") == digest(shards / "whole")


@pytest.mark.parametrize("name", ["1", "3"])
def test_a_missing_episode_is_refused_before_anything_is_written(shards: Path, name: str) -> None:
    episode = min((shards / name / "episodes").iterdir())
    episode.unlink()
    with pytest.raises(SurveyError, match=rf"--merge: '{episode}' is missing, though .*; allowed: complete folders"):
        merge(shards, "1", "2", "3")
    assert not (shards / "out").exists()


@pytest.mark.parametrize(
    ("names", "told"),
    [
        (("1", "2"), "of 3 shards, 3/3 missing"),
        (("1", "2", "2", "3"), "shard 2/3 is in"),
        (("1", "whole"), "holds whole demonstrations, not a shard; allowed: complete folders of demos --shard"),
        (("1", "none"), "cannot be read: "),
    ],
)
def test_what_is_not_all_shards_once_is_refused(shards: Path, names: tuple[str, ...], told: str) -> None:
    with pytest.raises(SurveyError, match=told):
        merge(shards, *names)
    assert not (shards / "out").exists()


def test_shards_of_other_demonstrations_and_half_ones_are_refused(fakes: ModuleType, shards: Path) -> None:
    other = replace(
        PLAN, survey=replace(SURVEY, shard=Shard(number=2, count=COUNT)), recording=RecordingOptions(fps=10)
    )
    record(fakes, shards / "other", other)
    with pytest.raises(SurveyError, match="they differ in recording; allowed: shards of one command"):
        merge(shards, "1", "other", "3")
    result = json.loads((shards / "2" / "result.json").read_text())
    for spoiled, told in (
        ({**result, "complete": False}, "has .* of .* trials; allowed: complete folders"),
        ({**result, "settings": 3}, "is of no demonstrations"),
        ({**result, "settings": {**result["settings"], "recording": {"fps": 1}}}, "they differ in recording"),
    ):
        (shards / "2" / "result.json").write_text(json.dumps(spoiled))
        with pytest.raises(SurveyError, match=told):
            merge(shards, "1", "2", "3")
    assert not (shards / "out").exists()
