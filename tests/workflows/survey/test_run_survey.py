"""A survey with fake trials: the same table with any workers, interrupted or not."""

from __future__ import annotations

import fcntl
import json
import shutil
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from spiraltrunk.errors import SurveyError
from spiraltrunk.workflows.survey.plan import SurveyPlan
from spiraltrunk.workflows.survey.resume_log import FILES
from spiraltrunk.workflows.survey.run_survey import run_survey


def cut_after(count: int) -> Callable[[Sequence[Any]], None]:
    def watch(rows: Sequence[Any]) -> None:
        if len(rows) >= count:
            raise KeyboardInterrupt

    return watch


def load(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "survey.json").read_text())


def timeless(value: Any) -> Any:
    """Everything but the wall time, which no seed fixes."""
    if isinstance(value, dict):
        return {key: timeless(part) for key, part in value.items() if "wall_s" not in key}
    return [timeless(part) for part in value] if isinstance(value, list) else value


@pytest.fixture(scope="module")
def original(fakes: ModuleType, plan: SurveyPlan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("survey")
    run_survey(plan, workers=1, folder=folder, work=fakes.work)
    return folder


@pytest.fixture
def whole(original: Path, tmp_path: Path) -> Path:
    """The folder of a complete survey, to be spoiled."""
    return shutil.copytree(original, tmp_path / "whole")


def test_a_survey_leaves_its_files(whole: Path) -> None:
    assert {path.name for path in whole.iterdir()} == set(FILES)
    held = load(whole)
    assert held["complete"]
    assert held["files"] == list(FILES)
    assert [(row["strategy"], row["index"]) for row in held["rows"]] == [
        (name, i) for name in ("wrap-vertical", "kick") for i in range(5)
    ]
    lines = [json.loads(line) for line in (whole / "trials.jsonl").read_text().splitlines()]
    assert sorted(map(str, lines)) == sorted(map(str, held["rows"]))
    assert 0 < sum(row["success"] for row in lines) < 10


def test_the_table_does_not_depend_on_workers(whole: Path, fakes: ModuleType, plan: SurveyPlan, tmp_path: Path) -> None:
    run_survey(plan, workers=3, folder=tmp_path / "three", work=fakes.work)
    assert (tmp_path / "three" / "table.md").read_text() == (whole / "table.md").read_text()
    assert timeless(load(tmp_path / "three")) == timeless(load(whole))


def test_without_a_folder_the_result_is_the_same(whole: Path, fakes: ModuleType, plan: SurveyPlan) -> None:
    result = run_survey(plan, workers=2, work=fakes.work)
    held = load(whole)
    assert result["files"] == []
    assert timeless(result["strategies"]) == timeless(held["strategies"])


def test_what_was_cut_off_goes_on(whole: Path, fakes: ModuleType, plan: SurveyPlan, tmp_path: Path) -> None:
    cut = tmp_path / "cut"
    with pytest.raises(KeyboardInterrupt):
        run_survey(plan, workers=2, folder=cut, work=fakes.work, watch=cut_after(4))
    held = load(cut)
    assert not held["complete"]
    assert len(held["rows"]) == sum(told["trials"] for told in held["strategies"].values()) == 4
    assert {path.name for path in cut.iterdir()} == set(held["files"]) == {"survey.json", "trials.jsonl", "table.md"}
    assert (cut / "table.md").read_text().startswith("Incomplete: 4 of 10")
    with (cut / "trials.jsonl").open("a") as file:
        file.write('{"strategy": "kick", "ind')  # A line that a crash tore.
    seen: list[int] = []
    run_survey(plan, folder=cut, work=fakes.work, watch=lambda rows: seen.append(len(rows)))
    assert seen == [4, 5, 6, 7, 8, 9, 10]
    assert timeless(load(cut)) == timeless(load(whole))
    assert (cut / "table.md").read_text() == (whole / "table.md").read_text()


def test_a_complete_survey_runs_nothing_again(whole: Path, fakes: ModuleType, plan: SurveyPlan) -> None:
    before = (whole / "trials.jsonl").read_bytes()
    assert run_survey(plan, folder=whole, work=fakes.raise_second)["complete"]
    assert (whole / "trials.jsonl").read_bytes() == before


@pytest.mark.parametrize(
    ("changes", "told"),
    [({"trials": 6}, "trials 5, not 6"), ({"seed": 8}, "seed 7, not 8"), ({"objects": {"kick": ("a",)}}, "objects")],
)
def test_another_survey_is_refused(
    whole: Path, fakes: ModuleType, plan: SurveyPlan, changes: dict[str, Any], told: str
) -> None:
    before = {path.name: path.read_bytes() for path in whole.iterdir()}
    with pytest.raises(SurveyError, match=told):
        run_survey(replace(plan, **changes), folder=whole, work=fakes.work)
    assert {path.name: path.read_bytes() for path in whole.iterdir()} == before


def test_a_survey_does_not_go_on_with_other_code(
    whole: Path, fakes: ModuleType, plan: SurveyPlan, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("spiraltrunk.workflows.survey.run_survey.compute_source", lambda: "0123456789abcdef")
    with pytest.raises(SurveyError, match=r'source "[0-9a-f]{16}", not "0123456789abcdef"'):
        run_survey(plan, folder=whole, work=fakes.work)


BROKEN = {
    "a list": ("survey.json", "[1]", "is no survey's"),
    "torn": ("survey.json", "{", "is no survey's"),
    "no JSON": ("trials.jsonl", "not a trial\n", "line 1 of"),
    "no trial": ("trials.jsonl", '{"strategy": "kick"}\n', "line 1 of"),
}


@pytest.mark.parametrize("how", BROKEN)
def test_a_broken_folder_is_refused(whole: Path, fakes: ModuleType, plan: SurveyPlan, how: str) -> None:
    name, text, told = BROKEN[how]
    (whole / name).write_text(text)
    with pytest.raises(SurveyError, match=told):
        run_survey(plan, folder=whole, work=fakes.work)
    assert (whole / name).read_text() == text


def test_trials_of_an_unknown_survey_are_refused(whole: Path, fakes: ModuleType, plan: SurveyPlan) -> None:
    (whole / "survey.json").unlink()
    with pytest.raises(SurveyError, match=r"trials\.jsonl, but no survey\.json"):
        run_survey(plan, folder=whole, work=fakes.work)


def test_a_folder_has_one_survey_at_a_time(whole: Path, fakes: ModuleType, plan: SurveyPlan) -> None:
    with (whole / "trials.jsonl").open() as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        with pytest.raises(SurveyError, match="a survey is being made"):
            run_survey(plan, folder=whole, work=fakes.work)


@pytest.mark.parametrize("work", ["raise_second", "die_second"])
def test_a_trial_that_breaks_is_a_failed_trial(fakes: ModuleType, plan: SurveyPlan, tmp_path: Path, work: str) -> None:
    kind = {"raise_second": "ValueError: no plan for seed N", "die_second": "its process died (SIGKILL)"}[work]
    result = run_survey(plan, workers=2, folder=tmp_path, work=getattr(fakes, work))
    assert result["complete"]
    for told in result["strategies"].values():
        assert (told["trials"], told["successes"], told["failures"]) == (5, 4, {kind: 1})
