"""Two surveys of the same worlds, compared."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from spiraltrunk.errors import SurveyError
from spiraltrunk.workflows.survey.compare.compare_surveys import compare_surveys
from spiraltrunk.workflows.survey.compare.comparison_text import format_comparison
from spiraltrunk.workflows.survey.plan import SurveyPlan
from spiraltrunk.workflows.survey.run_survey import run_survey

TRIALS = 20


@pytest.fixture(scope="module")
def made(fakes: ModuleType, plan: SurveyPlan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("compared")
    for name, step in (("a", 1e-3), ("b", 2e-3)):
        run_survey(
            replace(plan, trials=TRIALS, timestep=step), folder=folder / name, work=fakes.work, engine=fakes.run_inline
        )
    return folder


@pytest.fixture
def folder(made: Path, tmp_path: Path) -> Path:
    return shutil.copytree(made, tmp_path / "compared")


def change(folder: Path, edit: Callable[[dict[str, Any]], dict[str, Any] | None]) -> None:
    """Rewrite the trials of a survey; None leaves one out."""
    path = folder / "trials.jsonl"
    rows = [edit(json.loads(line)) for line in path.read_text().splitlines()]
    path.write_text("".join(json.dumps(row) + "\n" for row in rows if row is not None))


def test_equal_surveys_do_not_differ(folder: Path) -> None:
    result = compare_surveys(folder / "a", folder / "b")
    assert result["settings"] == {"timestep_s": [0.001, 0.002]}
    assert result["unpaired"] == {"a": 0, "b": 0}
    for told in (*result["strategies"].values(), result["overall"]):
        assert (told["only_a"], told["only_b"], told["difference"], told["p"]) == (0, 0, 0.0, 1.0)
        assert told["low"] < 0 < told["high"]
        assert not told["significant"]
    assert result["overall"]["pairs"] == 2 * TRIALS
    json.dumps(result, allow_nan=False)


def test_a_strategy_that_got_worse_is_told(folder: Path) -> None:
    def fail(row: dict[str, Any]) -> dict[str, Any]:
        return row | {"success": False, "reason": "fell"} if row["strategy"] == "kick" else row

    change(folder / "b", fail)
    result = compare_surveys(folder / "a", folder / "b")
    kick, wrap = result["strategies"]["kick"], result["strategies"]["wrap-vertical"]
    lost = kick["a"]["successes"]
    assert lost > 6
    assert (kick["only_a"], kick["only_b"], kick["b"]["successes"]) == (lost, 0, 0)
    assert kick["p"] == pytest.approx(2 / 2**lost)
    assert kick["p_holm"] == pytest.approx(4 / 2**lost)
    assert kick["significant"]
    assert kick["high"] < 0
    assert (wrap["p"], wrap["significant"]) == (1.0, False)
    assert result["overall"]["p"] == pytest.approx(2 / 2**lost)
    text = format_comparison(result)
    assert "significant at 5 %, corrected by Holm: kick" in text
    assert "timestep_s: 0.001 in A, 0.002 in B" in text


def test_what_has_no_twin_is_told(folder: Path) -> None:
    """Left out of one survey, or of another object."""

    def leave_out(row: dict[str, Any]) -> dict[str, Any] | None:
        return None if row["strategy"] == "kick" and row["index"] < 5 else row

    change(folder / "b", leave_out)
    result = compare_surveys(folder / "a", folder / "b")
    assert result["unpaired"] == {"a": 5, "b": 0}
    assert result["strategies"]["kick"]["pairs"] == TRIALS - 5
    assert "not paired, and not counted: 5 trials of A, 0 of B" in format_comparison(result)


def test_surveys_of_other_worlds_have_no_pairs(folder: Path, fakes: ModuleType, plan: SurveyPlan) -> None:
    run_survey(
        replace(plan, objects={"pinch": ("ball-30",)}, seed=9),
        folder=folder / "other",
        work=fakes.work,
        engine=fakes.run_inline,
    )
    result = compare_surveys(folder / "a", folder / "other")
    assert list(result["strategies"]) == ["wrap-vertical", "kick", "pinch"]
    assert result["overall"]["pairs"] == 0
    assert result["overall"]["difference"] is None
    assert result["strategies"]["pinch"]["p_holm"] is None
    assert result["unpaired"] == {"a": 2 * TRIALS, "b": 5}
    assert "corrected by Holm: none" in format_comparison(result)


def test_figures_and_speed_are_compared_over_pairs(folder: Path) -> None:
    def add(lift: float, speed: float) -> Callable[[dict[str, Any]], dict[str, Any]]:
        return lambda row: row | {"lift_m": lift + 1e-3 * row["index"], "real_time_factor": speed}

    change(folder / "a", add(0.20, 4.0))
    change(folder / "b", add(0.21, 7.0))
    told = compare_surveys(folder / "a", folder / "b")["overall"]
    assert told["speed_ratio"] == pytest.approx(1.75)
    lift = told["figures"]["lift_m"]
    assert [lift[key] for key in ("difference", "low", "high")] == pytest.approx([0.01] * 3)
    assert told["figures"]["hold_s"]["difference"] is None


def test_designs_that_differ_are_told_by_their_lines(folder: Path, fakes: ModuleType, plan: SurveyPlan) -> None:
    cable = replace(plan.design.cable, friction=0.15)
    rubs = replace(plan, design=replace(plan.design, cable=cable), timestep=1e-3)
    run_survey(rubs, folder=folder / "rubs", work=fakes.work, engine=fakes.run_inline)
    settings = compare_surveys(folder / "a", folder / "rubs")["settings"]
    assert set(settings) == {"trials", "design"}
    assert ["friction" in lines for lines in settings["design"]] == [True, True]
    assert "0.15" in settings["design"][1]


def test_a_survey_of_an_earlier_version_is_compared(folder: Path) -> None:
    path = folder / "a" / "survey.json"
    held = json.loads(path.read_text())
    for key in ("timestep_s", "shard"):
        del held["settings"][key]
    path.write_text(json.dumps(held))
    result = compare_surveys(folder / "a", folder / "b")
    assert result["settings"] == {"timestep_s": [0.001, 0.002]}


def test_what_is_no_survey_is_refused(folder: Path) -> None:
    with pytest.raises(SurveyError, match=r"--compare: '.*' cannot be read: .*; allowed: the folder of a survey"):
        compare_surveys(folder / "a", folder)
