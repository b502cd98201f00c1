"""A survey with fake trials: the same table with any workers, interrupted or not."""

from __future__ import annotations

import json
import math
import random
import shutil
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from spiraltrunk.design import presets
from spiraltrunk.errors import OutputError, SurveyError
from spiraltrunk.files.output_folder import open_output
from spiraltrunk.workflows.survey.code_version import compute_code
from spiraltrunk.workflows.survey.plan import SurveyPlan, derive_seed
from spiraltrunk.workflows.survey.resume_log import FILES, Log
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


@pytest.fixture(autouse=True)
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Plots take most of the time; those of the original are drawn, and those of merged surveys in their tests."""
    monkeypatch.setattr(
        "spiraltrunk.workflows.survey.results.write_figure", lambda figure, path: path.write_bytes(b"a plot")
    )


@pytest.fixture(scope="module")
def original(fakes: ModuleType, plan: SurveyPlan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("survey")
    run_survey(plan, workers=1, folder=folder, work=fakes.work, engine=fakes.run_inline)
    return folder


@pytest.fixture
def whole(original: Path, tmp_path: Path) -> Path:
    """The folder of a complete survey, to be spoiled."""
    return shutil.copytree(original, tmp_path / "whole")


def test_a_survey_leaves_its_files(whole: Path) -> None:
    assert {path.name for path in whole.glob("[!.]*")} == set(FILES)
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
    run_survey(plan, workers=2, folder=tmp_path / "two", work=fakes.work)
    assert (tmp_path / "two" / "table.md").read_text() == (whole / "table.md").read_text()
    assert timeless(load(tmp_path / "two")) == timeless(load(whole))


def test_without_a_folder_the_result_is_the_same(whole: Path, fakes: ModuleType, plan: SurveyPlan) -> None:
    result = run_survey(plan, work=fakes.work, engine=fakes.run_inline)
    held = load(whole)
    assert result["files"] == []
    assert timeless(result["strategies"]) == timeless(held["strategies"])


def test_what_was_cut_off_goes_on(whole: Path, fakes: ModuleType, plan: SurveyPlan, tmp_path: Path) -> None:
    cut = tmp_path / "cut"
    with pytest.raises(KeyboardInterrupt):
        run_survey(plan, workers=1, folder=cut, work=fakes.work, engine=fakes.run_inline, watch=cut_after(4))
    held = load(cut)
    assert not held["complete"]
    assert len(held["rows"]) == sum(told["trials"] for told in held["strategies"].values()) == 4
    assert (
        {path.name for path in cut.glob("[!.]*")} == set(held["files"]) == {"survey.json", "trials.jsonl", "table.md"}
    )
    assert (cut / "table.md").read_text().startswith("Incomplete: 4 of 10")
    with (cut / "trials.jsonl").open("a") as file:
        file.write('{"strategy": "kick", "ind')  # A line that a crash tore.
    seen: list[int] = []
    go_on = partial(run_survey, plan, folder=cut, work=fakes.work, engine=fakes.run_inline)
    go_on(watch=lambda rows: seen.append(len(rows)))
    assert seen == [4, 5, 6, 7, 8, 9, 10]
    assert timeless(load(cut)) == timeless(load(whole))
    assert (cut / "table.md").read_text() == (whole / "table.md").read_text()


def test_a_complete_survey_runs_nothing_again(whole: Path, fakes: ModuleType, plan: SurveyPlan) -> None:
    before = (whole / "trials.jsonl").read_bytes()
    assert run_survey(plan, folder=whole, work=fakes.raise_second)["complete"]
    assert (whole / "trials.jsonl").read_bytes() == before


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"trials": 6}, "trials 5, not 6"),
        ({"seed": 8}, "seed 7, not 8"),
        ({"objects": {"kick": ("a",)}}, "a survey of the strategies wrap-vertical, kick, not kick"),
        ({"objects": {"wrap-vertical": ("cylinder-60", "ball-80"), "kick": ("a",)}}, "objects"),
        ({"timestep": 1e-3}, "timestep_s 0.002, not 0.001"),
        ({"design": presets.get("spirob-15")}, "a survey of another design"),
    ],
)
def test_another_survey_is_refused(
    whole: Path, fakes: ModuleType, plan: SurveyPlan, changes: dict[str, Any], told: str
) -> None:
    before = {path: path.read_bytes() for path in whole.rglob("*") if path.is_file()}
    with pytest.raises(SurveyError, match=told):
        run_survey(replace(plan, **changes), folder=whole, work=fakes.work)
    assert {path: path.read_bytes() for path in whole.rglob("*") if path.is_file()} == before


def test_a_survey_does_not_go_on_with_other_code(
    whole: Path, fakes: ModuleType, plan: SurveyPlan, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = compute_code() | {"source": "0123456789abcdef"}
    monkeypatch.setattr("spiraltrunk.workflows.survey.run_survey.compute_code", lambda: code)
    with pytest.raises(SurveyError, match=r'source "[0-9a-f]{16}", not "0123456789abcdef"'):
        run_survey(plan, folder=whole, work=fakes.work)


def test_machines_with_other_code_do_not_join(
    fakes: ModuleType, plan: SurveyPlan, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The processes of an engine compute what they run with; those of this machine's pool are not asked.

    In place of both the trials run in this process.
    """
    code = compute_code() | {"source": "0123456789abcdef"}
    monkeypatch.setattr("spiraltrunk.workflows.survey.run_survey.compute_code", lambda: code)
    with pytest.raises(SurveyError, match=r"'.*' has another spiraltrunk or other packages \(source differ"):
        run_survey(plan, work=fakes.work, engine=fakes.run_inline)
    monkeypatch.setattr("spiraltrunk.workflows.survey.run_survey.run_jobs", fakes.run_inline)
    assert run_survey(plan, work=fakes.work)["complete"]


DEEP = b"[" * 200_000
NOISE = random.Random(5).randbytes(4096)

ROW = {
    "strategy": "kick", "object": "box-60", "index": 0, "seed": derive_seed(7, "kick", 0), "success": True,
    "reason": "", "wall_s": None,
    "width_m": 0.1, "mass_kg": 0.1, "friction": None, "stiffness_factor": None, "simulated_s": None,
    "real_time_factor": None, "planning_wall_s": None, "lift_m": None, "hold_s": None, "place_error_m": None,
    "retries": None,
}  # fmt: skip

BROKEN = {
    "a list": ("survey.json", b"[1]", "survey.json' is not replaced: it was changed since 'survey' wrote it"),
    "torn": ("survey.json", b"{", "it was changed since"),
    "noise": ("survey.json", NOISE, "it was changed since"),
    "nested": ("survey.json", DEEP, "it was changed since"),
    "a table": ("table.md", b"mine", "table.md' is not replaced: it was changed since"),
    "a plot": ("rates.png", b"mine", "rates.png' is not replaced: it was changed since"),
    "no JSON": ("trials.jsonl", b"not a trial\n", "line 1 of"),
    "no trial": ("trials.jsonl", b'{"strategy": "kick"}\n', "line 1 of"),
    "noise in the log": ("trials.jsonl", NOISE, "line 1 of"),
    "noise without an end": ("trials.jsonl", NOISE.replace(b"\n", b""), "the last line of"),
    "nested in the log": ("trials.jsonl", DEEP + b"\n", "line 1 of"),
    "nested without an end": ("trials.jsonl", DEEP, "the last line of"),
    "notes without an end": ("trials.jsonl", b"my notes", "the last line of"),
    **{
        f"{key} {value!r:.20}": ("trials.jsonl", json.dumps(ROW | {key: value}).encode() + b"\n", "line 1 of")
        for key, value in (
            ("strategy", "juggle"), ("strategy", []), ("index", 5), ("index", -1), ("index", "0"), ("index", True),
            ("object", "banana"), ("seed", None), ("seed", 1), ("success", 1), ("reason", 7),
            ("width_m", "wide"), ("width_m", math.nan), ("mass_kg", 10**400), ("width_m", 1e308), ("lift_m", True),
            ("other", 1), ("cause", "boredom"), ("cause", []), ("held", 7), ("upright", "yes"),
            ("cause_time_s", "late"),
        )
    },
}  # fmt: skip


def read_all(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("how", BROKEN)
def test_a_broken_folder_is_refused(whole: Path, fakes: ModuleType, plan: SurveyPlan, how: str) -> None:
    name, data, told = BROKEN[how]
    (whole / name).write_bytes(data)
    before = read_all(whole)
    with pytest.raises((SurveyError, OutputError), match=told) as caught:
        run_survey(plan, folder=whole, work=fakes.work)
    assert "\n" not in str(caught.value)
    assert read_all(whole) == before


def test_the_row_that_is_spoiled_is_a_row_else(whole: Path, fakes: ModuleType, plan: SurveyPlan) -> None:
    """What the broken rows are made of is refused for nothing but what is broken."""
    (whole / "trials.jsonl").write_text(json.dumps(ROW) + "\n")
    assert run_survey(plan, folder=whole, work=fakes.work, engine=fakes.run_inline)["complete"]


def test_a_failure_of_an_earlier_version_is_of_unknown_cause(whole: Path, fakes: ModuleType, plan: SurveyPlan) -> None:
    (whole / "trials.jsonl").write_text(json.dumps(ROW | {"success": False}) + "\n")
    result = run_survey(plan, folder=whole, work=fakes.work, engine=fakes.run_inline)
    assert result["strategies"]["kick"]["causes"]["unknown"] == 1


def test_a_reason_that_is_no_utf_8_is_in_the_table(whole: Path, fakes: ModuleType, plan: SurveyPlan) -> None:
    """As that of an object's file whose name is none."""
    (whole / "trials.jsonl").write_text(json.dumps(ROW | {"success": False, "reason": "no file a\udcff"}) + "\n")
    assert run_survey(plan, folder=whole, work=fakes.work, engine=fakes.run_inline)["complete"]
    assert "no file a\\udcff" in (whole / "table.md").read_text()


def test_a_trial_that_is_there_twice_is_refused(whole: Path, fakes: ModuleType, plan: SurveyPlan) -> None:
    log = whole / "trials.jsonl"
    first, *others = log.read_text().splitlines(keepends=True)
    log.write_text("".join([first, first, *others[1:]]))
    with pytest.raises(SurveyError, match="line 2 of"):
        run_survey(plan, folder=whole, work=fakes.work)


@pytest.mark.parametrize("name", FILES)
def test_what_no_survey_wrote_is_not_replaced(name: str, tmp_path: Path, fakes: ModuleType, plan: SurveyPlan) -> None:
    (tmp_path / name).write_text("mine")
    with pytest.raises(OutputError, match="is not replaced: no run of 'survey' wrote it"):
        run_survey(plan, folder=tmp_path, work=fakes.raise_second)
    assert read_all(tmp_path) == {tmp_path / name: b"mine"}


def test_a_survey_that_was_killed_as_it_began_goes_on(tmp_path: Path, fakes: ModuleType, plan: SurveyPlan) -> None:
    """The log was there, the settings were not."""
    with open_output(tmp_path, "survey") as output:
        output.add_log("trials.jsonl").touch()
    assert run_survey(plan, folder=tmp_path, work=fakes.work, engine=fakes.run_inline)["complete"]


def test_a_full_disc_is_told_with_the_log(
    tmp_path: Path, fakes: ModuleType, plan: SurveyPlan, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A row of which only a part is written is an incomplete last line, which the next run removes."""
    add, cut = Log.add, 30

    def fill(log: Log, row: dict[str, Any]) -> None:
        if len(log.rows) == 2:
            file = log._file
            log._file = SimpleNamespace(write=lambda line: file.write(line[:cut]), name=file.name)
        add(log, row)

    with monkeypatch.context() as patch:
        patch.setattr(Log, "add", fill)
        with pytest.raises(OutputError) as caught:
            run_survey(plan, folder=tmp_path, work=fakes.work, engine=fakes.run_inline)
    assert str(caught.value).startswith(f"'{tmp_path / 'trials.jsonl'}' cannot be written: No space left on device")
    assert len((tmp_path / "trials.jsonl").read_bytes().splitlines()[-1]) == cut
    seen: list[int] = []
    run_survey(
        plan, folder=tmp_path, work=fakes.work, engine=fakes.run_inline, watch=lambda rows: seen.append(len(rows))
    )
    assert seen[0] == 2


def test_trials_of_an_unknown_survey_are_refused(whole: Path, fakes: ModuleType, plan: SurveyPlan) -> None:
    (whole / "survey.json").unlink()
    with pytest.raises(SurveyError, match=r"trials\.jsonl, but no survey\.json"):
        run_survey(plan, folder=whole, work=fakes.work)


def test_a_folder_has_one_survey_at_a_time(whole: Path, fakes: ModuleType, plan: SurveyPlan) -> None:
    with open_output(whole, "survey"), pytest.raises(OutputError, match="another process is writing to"):
        run_survey(plan, folder=whole, work=fakes.work)


@pytest.mark.parametrize("work", ["raise_second", pytest.param("die_second", marks=pytest.mark.slow)])
def test_a_trial_that_breaks_is_a_failed_trial(fakes: ModuleType, plan: SurveyPlan, tmp_path: Path, work: str) -> None:
    kind = {"raise_second": "ValueError: no plan for seed N", "die_second": "its process died (SIGKILL)"}[work]
    result = run_survey(plan, workers=1, folder=tmp_path, work=getattr(fakes, work))
    assert result["complete"]
    for told in result["strategies"].values():
        assert (told["trials"], told["successes"], told["failures"]) == (5, 4, {kind: 1})
        assert told["causes"] == {"simulation fault": 1}


@pytest.mark.parametrize("workers", [0, *(pytest.param(count, marks=pytest.mark.slow) for count in (1, 2))])
def test_a_missing_package_is_no_failure_of_a_strategy(
    workers: int, fakes: ModuleType, plan: SurveyPlan, tmp_path: Path
) -> None:
    """Without workers the trials run in this process, whose faults are told as those of others are."""
    engine = None if workers else fakes.run_inline
    with pytest.raises(ModuleNotFoundError) as caught:
        run_survey(plan, workers=max(workers, 1), folder=tmp_path / "out", work=fakes.miss_package, engine=engine)
    assert caught.value.name == "coacd"
    rows = load(tmp_path / "out")["rows"]
    assert all(row["index"] != 1 for row in rows)
    assert run_survey(plan, folder=tmp_path / "out", work=fakes.work, engine=fakes.run_inline)["complete"]
