"""Demonstrations with fake trials: the same data set with any workers, interrupted, killed or not."""

from __future__ import annotations

import hashlib
import json
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import h5py
import pytest

from spiraltrunk.design import presets
from spiraltrunk.errors import OutputError, SurveyError, UnknownName
from spiraltrunk.files.output_folder import open_output
from spiraltrunk.workflows.demos.options import RecordingOptions
from spiraltrunk.workflows.demos.recording.episode_file import load_episode
from spiraltrunk.workflows.demos.run_demos import DemosPlan, run_demos
from spiraltrunk.workflows.survey.plan import SurveyPlan, derive_seed

SURVEY = SurveyPlan(objects={"wrap-vertical": ("cylinder-60", "ball-80"), "kick": ("box-60",)}, trials=6, seed=7)

PLAN = DemosPlan(survey=SURVEY, recording=RecordingOptions(), format="robomimic")

SUCCESSES = {
    (name, index) for name in SURVEY.objects for index in range(6) if derive_seed(SURVEY.seed, name, index) % 3
}
"""Trials that succeed in the fakes."""

PROGRAM = """
import functools, sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
import demos_fakes
from spiraltrunk.workflows.demos.options import RecordingOptions
from spiraltrunk.workflows.demos.run_demos import DemosPlan, run_demos
from spiraltrunk.workflows.survey.plan import SurveyPlan
survey = SurveyPlan(objects={"wrap-vertical": ("cylinder-60", "ball-80"), "kick": ("box-60",)}, trials=6, seed=7)
plan = DemosPlan(survey=survey, recording=RecordingOptions(), format=sys.argv[3])
work = functools.partial(demos_fakes.work_slowly, folder=Path(sys.argv[2]).resolve() / "episodes")
run_demos(plan, folder=sys.argv[2], workers=2, work=work)
"""


def run(fakes: ModuleType, folder: Path, plan: DemosPlan = PLAN, **options: Any) -> dict[str, Any]:
    work = partial(fakes.work, folder=folder / "episodes", recording=plan.recording)
    return run_demos(plan, folder=folder, **{"work": work, "engine": fakes.run_inline, **options})


def cut_after(count: int) -> Callable[[Sequence[Any]], None]:
    def watch(rows: Sequence[Any]) -> None:
        if len(rows) >= count:
            raise KeyboardInterrupt

    return watch


def digest(folder: Path) -> dict[str, str]:
    """Content of the data set and the result, by name."""
    names = json.loads((folder / "result.json").read_text())["files"]
    return {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in names}


def read_seeds(folder: Path) -> list[int]:
    with h5py.File(folder / "demos.hdf5") as file:
        return [int(file[f"data/demo_{number}"].attrs["seed"]) for number in range(len(file["data"]))]


@pytest.fixture(scope="module")
def original(fakes: ModuleType, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("demos")
    result = run(fakes, folder)
    assert result["complete"]
    return folder


@pytest.fixture
def whole(original: Path, tmp_path: Path) -> Path:
    """The folder of complete demonstrations, to be spoiled."""
    return shutil.copytree(original, tmp_path / "whole")


def test_successes_are_the_data_set(original: Path) -> None:
    result = json.loads((original / "result.json").read_text())
    told = [(each["strategy"], each["index"]) for each in result["episodes"]]
    assert told == sorted(SUCCESSES, key=lambda pair: (list(SURVEY.objects).index(pair[0]), pair[1]))
    assert 0 < len(told) < 12
    assert result["demonstrations"] == len(told)
    assert read_seeds(original) == [each["seed"] for each in result["episodes"]]
    assert read_seeds(original) == [derive_seed(7, name, index) for name, index in told]
    assert result["files"] == ["demos.hdf5", "result.json", "settings.json", "trunk.toml"]
    assert {path.name for path in original.glob("[!.]*")} == {*result["files"], "episodes", "trials"}
    assert len(list((original / "episodes").iterdir())) == len(told)
    rows = json.loads((original / "trials" / "survey.json").read_text())["rows"]
    assert [row["success"] for row in rows] == [
        (name, index) in SUCCESSES for name in SURVEY.objects for index in range(6)
    ]


@pytest.mark.parametrize(
    "name", ["minari", *(pytest.param(name, marks=pytest.mark.slow) for name in ("lerobot", "robomimic"))]
)
def test_workers_and_interruptions_change_nothing(fakes: ModuleType, tmp_path: Path, name: str) -> None:
    plan = replace(PLAN, format=name)
    run(fakes, tmp_path / "one", plan)
    run(fakes, tmp_path / "three", plan, workers=3, engine=None if name == "robomimic" else fakes.run_inline)
    with pytest.raises(KeyboardInterrupt):
        run(fakes, tmp_path / "cut", plan, watch=cut_after(5))
    partly = json.loads((tmp_path / "cut" / "result.json").read_text())
    assert not partly["complete"]
    assert 0 < partly["demonstrations"] == len(partly["episodes"]) <= partly["trials"] == 5
    seen: list[int] = []
    run(fakes, tmp_path / "cut", plan, watch=lambda rows: seen.append(len(rows)))
    assert seen == list(range(5, 13))
    assert digest(tmp_path / "one") == digest(tmp_path / "three") == digest(tmp_path / "cut")


def test_failures_are_recorded_where_they_are_asked_for(fakes: ModuleType, tmp_path: Path) -> None:
    plan = replace(PLAN, recording=RecordingOptions(keeps_failures=True))
    result = run(fakes, tmp_path, plan)
    assert result["demonstrations"] == 12
    with h5py.File(tmp_path / "demos.hdf5") as file:
        told = [bool(file[f"data/demo_{number}"].attrs["success"]) for number in range(12)]
        rewards = [float(file[f"data/demo_{number}/rewards"][-1]) for number in range(12)]
    assert told == [each["success"] for each in result["episodes"]]
    assert rewards == [float(success) for success in told]
    assert sum(told) == len(SUCCESSES)


def test_without_a_success_there_is_no_data_set(fakes: ModuleType, tmp_path: Path) -> None:
    result = run(fakes, tmp_path, work=partial(fakes.fail, folder=tmp_path / "episodes"))
    assert (result["demonstrations"], result["complete"]) == (0, True)
    assert result["files"] == ["result.json", "settings.json", "trunk.toml"]
    assert not (tmp_path / "demos.hdf5").exists()


def test_complete_demonstrations_run_nothing_again(fakes: ModuleType, whole: Path) -> None:
    before = {path: path.stat().st_mtime_ns for path in whole.rglob("[!.]*") if path.is_file()}
    shutil.rmtree(whole / "episodes")  # The data set does without.
    assert run(fakes, whole, work=partial(fakes.fail, folder=whole)) == json.loads((whole / "result.json").read_text())
    assert all(path.stat().st_mtime_ns == time for path, time in before.items() if path.exists())


def test_removed_episodes_are_recorded_again(fakes: ModuleType, whole: Path, original: Path) -> None:
    (whole / "demos.hdf5").unlink()
    removed = sorted((whole / "episodes").iterdir())[1:3]
    content = [path.read_bytes() for path in removed]
    for path in removed:
        path.unlink()
    run(fakes, whole)
    assert [path.read_bytes() for path in removed] == content
    assert digest(whole) == digest(original)


def test_a_damaged_episode_is_told(fakes: ModuleType, whole: Path) -> None:
    (whole / "demos.hdf5").unlink()
    damaged = sorted((whole / "episodes").iterdir())[0]
    damaged.write_bytes(damaged.read_bytes()[:500])
    with pytest.raises(OutputError, match=r"kick-00000.\.npz' is no episode; allowed: the same command once that fil"):
        run(fakes, whole)


def test_the_data_set_grows_with_the_episodes(fakes: ModuleType, tmp_path: Path) -> None:
    """After any trial, half of the episodes or more are in a data set."""
    counts: list[tuple[int, int]] = []

    def watch(rows: Sequence[Any]) -> None:
        there = (tmp_path / "demos.hdf5").exists()
        counts.append((len(read_seeds(tmp_path)) if there else 0, sum(row["success"] for row in rows[:-1])))

    run(fakes, tmp_path, watch=watch)
    assert all(2 * written >= ended for written, ended in counts)
    assert len({written for written, _ in counts}) > 2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "delay"),
    [
        ("lerobot", 0.4),
        ("robomimic", 0.0),
        ("minari", 0.9),
    ],
)
def test_a_kill_at_any_moment_loses_no_ended_trial(fakes: ModuleType, tmp_path: Path, name: str, delay: float) -> None:
    folder = tmp_path / "killed"
    process = subprocess.Popen([sys.executable, "-c", PROGRAM, str(Path(fakes.__file__).parent), str(folder), name])
    try:
        end = time.monotonic() + 60
        while not list(folder.glob("episodes/*.npz")) and time.monotonic() < end:
            time.sleep(0.02)
        time.sleep(delay)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    ended = [
        json.loads(line) for line in (folder / "trials" / "trials.jsonl").read_text().splitlines() if line[-1] == "}"
    ]
    there = {path.name for path in folder.glob("episodes/*.npz")}
    assert {f"{row['strategy']}-{row['index']:06d}.npz" for row in ended if row["success"]} <= there
    for path in folder.glob("episodes/*.npz"):
        load_episode(path)
    plan = replace(PLAN, format=name)
    result = run(fakes, folder, plan)
    assert result["complete"]
    assert {(each["strategy"], each["index"]) for each in result["episodes"]} == SUCCESSES
    run(fakes, tmp_path / "straight", plan)
    assert digest(folder) == digest(tmp_path / "straight")


@pytest.mark.parametrize("trials", [pytest.param(1, marks=pytest.mark.slow), 5])
def test_a_kill_while_the_data_set_moves_in_is_gone_on_from(
    fakes: ModuleType, tmp_path: Path, original: Path, trials: int
) -> None:
    """At that moment there is no result."""
    with pytest.raises(KeyboardInterrupt):
        run(fakes, tmp_path, watch=cut_after(trials))
    (tmp_path / "result.json").unlink()
    with pytest.raises(SurveyError, match="holds demonstrations with seed 7, not 8"):
        run(fakes, tmp_path, replace(PLAN, survey=replace(SURVEY, seed=8)))
    seen: list[int] = []
    run(fakes, tmp_path, watch=lambda rows: seen.append(len(rows)))
    assert seen == list(range(trials, 13))
    assert digest(tmp_path) == digest(original)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"survey": replace(SURVEY, trials=7)}, "demonstrations with trials 6, not 7"),
        ({"survey": replace(SURVEY, seed=8)}, "demonstrations with seed 7, not 8"),
        ({"survey": replace(SURVEY, design=presets.get("spirob-15"))}, "demonstrations with another design"),
        ({"recording": RecordingOptions(fps=10)}, "demonstrations with fps 50, not 10"),
        ({"format": "minari"}, 'demonstrations with format "robomimic", not "minari"'),
    ],
)
def test_other_demonstrations_are_refused(
    fakes: ModuleType, whole: Path, original: Path, changes: dict[str, Any], told: str
) -> None:
    with pytest.raises(SurveyError) as caught:
        run(fakes, whole, replace(PLAN, **changes))
    assert told in str(caught.value)
    assert "allowed: the folder of demonstrations with the same settings, or a new one" in str(caught.value)
    assert digest(whole) == digest(original)


@pytest.mark.parametrize(
    "name",
    ["episodes/kick-000000.npz", "episodes", "trials/trials.jsonl", "demos.hdf5", "result.json", "settings.json"],
)
def test_a_folder_with_other_things_is_refused(fakes: ModuleType, tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    path.write_text("mine")
    with pytest.raises((SurveyError, OutputError), match="allowed"):
        run(fakes, tmp_path)
    assert path.read_text() == "mine"
    assert [each for each in tmp_path.rglob("*") if each.is_file()] == [path]


def test_a_survey_is_no_folder_of_demonstrations(fakes: ModuleType, whole: Path) -> None:
    from spiraltrunk.workflows.survey.run_survey import run_survey

    with pytest.raises(OutputError, match="'demos' wrote it, and this is 'survey'"):
        run_survey(SURVEY, folder=whole / "trials")


def test_episodes_that_another_machine_wrote_elsewhere_are_told(fakes: ModuleType, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="allowed: a folder that all machines see at the same path"):
        run(fakes, tmp_path / "here", work=partial(fakes.work, folder=tmp_path / "elsewhere"))


def test_one_process_at_a_time(fakes: ModuleType, whole: Path) -> None:
    with open_output(whole, "demos"), pytest.raises(OutputError, match="another process is writing to"):
        run(fakes, whole)


def test_an_unknown_format_is_refused() -> None:
    with pytest.raises(UnknownName, match="known: lerobot, robomimic, minari"):
        replace(PLAN, format="hdf5")


def test_a_missing_package_is_told_before_anything_is_written(
    fakes: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(ModuleNotFoundError):
        run(fakes, tmp_path / "new")
    assert not (tmp_path / "new").exists()
