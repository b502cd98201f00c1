"""validation/robustness.md and README.md tell what stands in robustness.json."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from spiraltrunk import strategies
from spiraltrunk.design import presets
from spiraltrunk.workflows.survey.plan import derive_seed

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "validation" / "robustness.md").read_text()
README = (DOCS.parent / "README.md").read_text()


def load(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, DOCS / "studies" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def pages() -> Any:
    before = list(sys.path)
    yield load("make_robustness")
    sys.path[:] = before


def test_the_pages_tell_the_rows(pages: ModuleType) -> None:
    rows, rates = pages.load_figures()
    assert pages.fill_page(PAGE, rows) == PAGE
    assert pages.fill_readme(README, rows, rates) == README
    wrong = json.loads(json.dumps(rows))
    for row in wrong:
        row["success"], row["cause"] = not row["success"], "missed"
    assert pages.fill_page(PAGE, wrong) != PAGE
    assert pages.fill_readme(README, wrong, rates) != README


def test_the_rows_are_trials_of_the_study(pages: ModuleType) -> None:
    study = load("study_robustness")
    rows, _ = pages.load_figures()
    for row in rows:
        objects = strategies.get(row["strategy"]).objects
        assert row["condition"] in study.CONDITIONS
        seed = study.find_seed(row["condition"], row["strategy"])
        assert row["seed"] == derive_seed(seed, row["strategy"], row["index"])
        assert row["object"] == objects[row["index"] % len(objects)]
    keys = [(row["condition"], row["strategy"], row["index"]) for row in rows]
    assert len(set(keys)) == len(keys)


def test_recounted_trials_take_the_place_of_the_same_condition_and_strategy(
    pages: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    rows, _ = pages.load_figures()
    monkeypatch.setattr(pages, "RESULT", tmp_path / "robustness.json")
    pages.RESULT.write_text(pages.format_rows(rows))
    own = [row for row in rows if (row["condition"], row["strategy"]) == ("m 1.7", "kick")]
    trials = tmp_path / "trials.jsonl"
    turned = [row | {"success": not row["success"]} for row in own]
    trials.write_text("".join(json.dumps(row) + "\n" for row in turned) + '{"cut')
    assert pages.replace_strategies(tmp_path) is None
    after, _ = pages.load_figures()
    assert [row for row in after if row not in rows] == turned
    assert len(after) == len(rows)
    trials.write_text("".join(json.dumps(row) + "\n" for row in turned[1:]))
    assert pages.replace_strategies(tmp_path) == f"{tmp_path} has fewer trials than there are of kick, m 1.7"
    assert pages.replace_strategies(tmp_path / "none") == f"{tmp_path / 'none'} has no trials"
    assert pages.load_figures()[0] == after


def test_each_condition_changes_one_thing() -> None:
    study = load("study_robustness")
    paper, conditions = presets.PAPER, study.CONDITIONS
    assert conditions["friction 0.15"].cable.friction == 0.15
    assert all(conditions[name].cable.friction == 0 for name in conditions if name != "friction 0.15")
    assert conditions["m 1.45"].length < paper.length < conditions["m 1.7"].length
    radii = {name: design.section_radius[0] for name, design in conditions.items()}
    assert radii["arm radius 36 mm"] == pytest.approx(0.036)
    assert radii["arm radius 55 mm"] == pytest.approx(0.055)
    assert radii["m 1.7"] == pytest.approx(paper.section_radius[0], rel=0.01)
    assert conditions["sections of 20 deg"].n_section == 27


def test_jobs_go_through_all_conditions_before_the_next_trial() -> None:
    study = load("study_robustness")
    jobs = list(study.list_jobs(["m 1.7", "paper"], ["kick", "pinch"], 2, 5))
    told = [(condition, entry.strategy, entry.index) for condition, entry in jobs]
    first = [("m 1.7", "kick", 0), ("paper", "kick", 0), ("m 1.7", "pinch", 0), ("paper", "pinch", 0)]
    assert told == first + [(condition, name, 1) for condition, name, _ in first]


def test_a_row_that_was_cut_off_is_run_again(tmp_path: Path) -> None:
    path = tmp_path / "trials.jsonl"
    path.write_text(json.dumps({"seed": 1}) + "\n" + '{"seed": 2')
    assert load("study_robustness").load_rows(path) == [{"seed": 1}]
