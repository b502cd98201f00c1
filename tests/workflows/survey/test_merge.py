"""Shards of a survey, and their merge: the table that one machine would have made."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.errors import DesignError, SurveyError
from spiraltrunk.workflows.survey.merge import WALL_COLUMNS, merge_surveys
from spiraltrunk.workflows.survey.plan import Shard, SurveyPlan, parse_shard
from spiraltrunk.workflows.survey.resume_log import FILES
from spiraltrunk.workflows.survey.row import fill_row
from spiraltrunk.workflows.survey.run_survey import run_survey

COUNT = 3


@pytest.fixture(scope="module")
def made(fakes: ModuleType, plan: SurveyPlan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A survey, and the same in shards."""
    folder = tmp_path_factory.mktemp("shards")
    run = partial(run_survey, work=fakes.work, engine=fakes.run_inline)
    run(plan, folder=folder / "whole")
    for number in range(1, COUNT + 1):
        run(replace(plan, shard=Shard(number=number, count=COUNT)), folder=folder / str(number))
    return folder


@pytest.fixture
def shards(made: Path, tmp_path: Path) -> Path:
    """The same, to be spoiled."""
    return shutil.copytree(made, tmp_path / "shards")


def merge(folder: Path, *names: str) -> dict[str, Any]:
    return merge_surveys([folder / name for name in names], folder / "out")


def read_rows(folder: Path) -> list[dict[str, Any]]:
    rows = json.loads((folder / "survey.json").read_text())["rows"]
    return [{key: value for key, value in row.items() if key not in WALL_COLUMNS} for row in rows]


def timeless(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: timeless(part) for key, part in value.items() if "wall_s" not in key}
    return [timeless(part) for part in value] if isinstance(value, list) else value


@given(st.integers(1, 9), st.integers(1, 40), st.integers(1, 50))
def test_shards_are_all_trials_once_and_equal_in_number(strategies: int, trials: int, count: int) -> None:
    plan = SurveyPlan(objects={f"s{k}": ("ball-80",) for k in range(strategies)}, trials=trials)
    parts = [replace(plan, shard=Shard(number=i + 1, count=count)).entries() for i in range(count)]
    assert Counter(entry for part in parts for entry in part) == Counter(plan.entries())
    sizes = [len(part) for part in parts]
    assert max(sizes) - min(sizes) <= 1


@pytest.mark.parametrize(("strategies", "count"), [(9, 3), (9, 9), (9, 18), (2, 2), (2, 4), (4, 8)])
def test_no_shard_gets_few_strategies_alone(strategies: int, count: int) -> None:
    plan = SurveyPlan(objects={f"s{k}": ("ball-80",) for k in range(strategies)}, trials=20 * count)
    for number in range(1, count + 1):
        counts = replace(plan, shard=Shard(number=number, count=count)).count_trials().values()
        assert min(counts) >= 8, "of 20 on average"


@pytest.mark.parametrize("text", ["", "1", "0/4", "5/4", "1/0", "-1/4", "1/4/2", "1/10001", "a/b", " 1/4", "1/4\n"])
def test_what_is_no_shard_is_refused(text: str) -> None:
    with pytest.raises(DesignError, match="allowed: I/N, as 2/16"):
        parse_shard(text)


def test_merged_shards_are_the_survey(shards: Path) -> None:
    merge(shards, "2", "3", "1")
    out, whole = shards / "out", shards / "whole"
    assert (out / "table.md").read_bytes() == (whole / "table.md").read_bytes()
    for name in ("rates.png", "heatmap.png", "causes.png"):
        assert (out / name).read_bytes() == (whole / name).read_bytes()
    assert read_rows(out) == read_rows(whole)
    held, other = (timeless(json.loads((folder / "survey.json").read_text())) for folder in (out, whole))
    assert held == other
    assert {path.name for path in out.glob("[!.]*")} == set(FILES)


@pytest.mark.slow
def test_a_merged_survey_goes_on_as_the_whole_one(shards: Path, fakes: ModuleType, plan: SurveyPlan) -> None:
    merge(shards, "1", "2", "3")
    assert run_survey(plan, folder=shards / "out", work=fakes.raise_second)["complete"]
    assert read_rows(shards / "out") == read_rows(shards / "whole")
    assert merge(shards, "1", "2", "3")["complete"], "merged again"


def test_a_merge_that_was_killed_in_the_last_line_goes_on(shards: Path) -> None:
    merge(shards, "1", "2", "3")
    log = shards / "out" / "trials.jsonl"
    whole = log.read_bytes()
    assert whole == merge_lines(shards / "whole", shards)
    log.write_bytes(whole[:-20])
    assert merge(shards, "1", "2", "3")["complete"]
    assert log.read_bytes() == whole


def merge_lines(survey: Path, shards: Path) -> bytes:
    """Lines of the shards' logs in the order of the survey's rows."""
    lines = [line for number in "123" for line in (shards / number / "trials.jsonl").read_bytes().splitlines(True)]
    named = {(row["strategy"], row["index"]): line for line in lines for row in [json.loads(line)]}
    return b"".join(named[row["strategy"], row["index"]] for row in read_rows(survey))


def test_a_row_of_an_earlier_version_keeps_its_order_and_ends_with_what_it_lacks() -> None:
    row = {"strategy": "kick", "success": False, "upright": True, "wall_s": 1.0}
    filled = {**row, "cause": "unknown", "cause_time_s": None, "held": None}
    assert list(fill_row(row).items()) == list(filled.items())


def test_a_shard_does_not_go_on_as_another(shards: Path, fakes: ModuleType, plan: SurveyPlan) -> None:
    other = replace(plan, shard=Shard(number=2, count=COUNT))
    with pytest.raises(SurveyError, match='a survey with shard "1/3", not "2/3"'):
        run_survey(other, folder=shards / "1", work=fakes.work)


def test_a_row_of_another_shard_is_refused(shards: Path) -> None:
    with (shards / "1" / "trials.jsonl").open("a") as log:
        log.write((shards / "2" / "trials.jsonl").read_text())
    with pytest.raises(SurveyError, match=r"--merge: line \d+ of .* is no trial"):
        merge(shards, "1", "2", "3")


@pytest.mark.slow
def test_overlap_lack_and_strangers_are_told(shards: Path, fakes: ModuleType, plan: SurveyPlan) -> None:
    run_survey(replace(plan, shard=Shard(number=1, count=2)), folder=shards / "half", work=fakes.work)
    run_survey(replace(plan, seed=8, shard=Shard(number=2, count=COUNT)), folder=shards / "seed", work=fakes.work)
    (shards / "empty").mkdir()
    refusals = {
        ("1", "1", "2", "3"): r"shard 1/3 is in '.*' and '.*'; allowed: each shard once",
        ("1", "3"): "of 3 shards, 2/3 missing; allowed: all of them",
        ("1", "seed", "3"): "are of different surveys: they differ in seed; allowed: shards of one survey",
        ("1", "half"): "holds shard 1/2, others one of 3",
        ("whole",): "holds a whole survey, not a shard",
        ("1", "nowhere"): r"'.*nowhere' cannot be read: No such file or directory",
        ("1", "empty"): r"'.*empty/survey.json' cannot be read: No such file or directory",
    }
    for names, told in refusals.items():
        with pytest.raises(SurveyError, match=told):
            merge(shards, *names)
        assert not (shards / "out").exists()


def test_shards_with_another_content_of_a_file_are_told(fakes: ModuleType, plan: SurveyPlan, tmp_path: Path) -> None:
    vase = tmp_path / "vase.stl"
    own = replace(plan, objects={"kick": (f"stl:path={vase},mass_g=9",)}, trials=2)
    for number in (1, 2):
        vase.write_text(f"vase {number}")
        shard = replace(own, shard=Shard(number=number, count=2))
        run_survey(shard, folder=tmp_path / str(number), work=fakes.work, engine=fakes.run_inline)
    with pytest.raises(SurveyError, match="they differ in files; allowed: shards of one survey"):
        merge(tmp_path, "1", "2")
    with pytest.raises(SurveyError, match=r"holds a survey with another content of \[\".*vase.stl\"\]; allowed"):
        run_survey(replace(own, shard=Shard(number=1, count=2)), folder=tmp_path / "1", work=fakes.work)


def test_a_shard_half_done_is_told(shards: Path) -> None:
    log = shards / "2" / "trials.jsonl"
    lines = log.read_text().splitlines(keepends=True)
    log.write_text("".join(lines[:-1]) + lines[-1][:20])
    with pytest.raises(SurveyError, match=f"shard 2/3 in '.*' has {len(lines) - 1} of {len(lines)} trials; allowed"):
        merge(shards, "1", "2", "3")


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"settings": 1}', '{"settings": {"trials": 5, "seed": 7, "objects": {}, "design": 1}}']
)
def test_a_folder_of_no_survey_is_refused(shards: Path, text: str) -> None:
    (shards / "2" / "survey.json").write_text(text)
    with pytest.raises(SurveyError, match=r"--merge: .*survey.json' is no survey's; allowed"):
        merge(shards, "1", "2", "3")


def test_the_output_of_another_survey_is_refused(shards: Path) -> None:
    with pytest.raises(SurveyError, match='a survey with shard "1/3", not null'):
        merge_surveys([shards / name for name in "123"], shards / "1")
