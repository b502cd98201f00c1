"""validation/everyday.md tells what stands in everyday.json, and the limits that follow from the designs."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from PIL import Image

from spiraltrunk.design import presets

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "validation" / "everyday.md").read_text()
FIGURES = {
    **json.loads((DOCS / "studies" / "everyday.json").read_text()),
    "ranking": json.loads((DOCS / "studies" / "everyday_ranking.json").read_text()),
    "rates": json.loads((DOCS / "studies" / "everyday_rates.json").read_text()),
}


@pytest.fixture(scope="module")
def study() -> Any:
    before = list(sys.path)
    spec = importlib.util.spec_from_file_location("make_everyday", DOCS / "studies" / "make_everyday.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["make_everyday"] = module  # Its dataclass looks itself up there.
    spec.loader.exec_module(module)
    yield module
    del sys.modules["make_everyday"]
    sys.path[:] = before


def row(**given: Any) -> dict[str, Any]:
    attempts = [{"strategy": "tip-grip", "outcome": "x"}]
    return {"success": True, "held": True, "cause": None, "attempts": attempts} | given


def test_the_page_tells_the_rows(study: ModuleType) -> None:
    assert study.fill_page(PAGE, FIGURES) == PAGE
    wrong = json.loads(json.dumps(FIGURES))
    wrong["rows"][0]["success"] = not wrong["rows"][0]["success"]
    assert study.fill_page(PAGE, wrong) != PAGE
    wrong = json.loads(json.dumps(FIGURES))
    wrong["rates"]["classes"][0]["held"] = not wrong["rates"]["classes"][0]["held"]
    assert study.fill_page(PAGE, wrong) != PAGE


def test_scores_are_told_beside_the_first_tries_that_they_foretold(study: ModuleType) -> None:
    won = {"auto": {"success": True, "tries": ["pinch"]}, "feasible": {"pinch": 0.9}}
    second = {"auto": {"success": True, "tries": ["pinch", "tip-grip"]}, "feasible": {"pinch": 0.5, "tip-grip": 0.4}}
    refused = {"auto": None, "feasible": {}}
    told = study.format_scores({"choice": [won, won, second, refused, second]}, parts=2).splitlines()[2:]
    assert told == [
        "| 0.50 to 0.50 | 0.50 | 0 of 2 (0 to 66 %) |",
        "| 0.90 to 0.90 | 0.90 | 2 of 2 (34 to 100 %) |",
    ]


def test_rates_are_told_with_their_intervals_and_failures_by_cause(study: ModuleType) -> None:
    taken = {"part": "lying", "seed": 3, "success": True, "held": True, "upright": False, "cause": None}
    lost = taken | {"seed": 4, "success": False, "cause": "toppled"}
    refused = lost | {"seed": 5, "held": False, "cause": None}
    told = study.format_rates({"classes": [taken, lost, refused]}).splitlines()[-1]
    assert "| 3 to 5 | 2 of 3 (21 to 94 %) | 0 of 3 (0 to 56 %) | 1 of 3 (6 to 79 %) |" in told
    assert told.endswith("| 1 toppled after the hold, 1 refused |")
    auto = {"success": True, "held": True, "cause": None, "tries": ["pinch", "tip-grip"]}
    rows = [{"index": 0, "auto": auto, "forced": None}, {"index": 1, "auto": None, "forced": {"success": False}}]
    lifted, first, forced = study.format_choice({"choice": rows}).splitlines()[2:]
    assert "1 of 1" in lifted
    assert "0 of 1" in first
    assert "0 of 1" in forced


@pytest.mark.slow
def test_the_page_tells_the_limits_of_the_designs(study: ModuleType) -> None:
    rules = {design: study.compute_rules(presets.get(design)) for design in study.DESIGNS}
    assert study.fill_page(PAGE, FIGURES, rules) == PAGE


def test_every_thing_is_shown_in_a_gallery_that_a_page_can_hold() -> None:
    for name in ("everyday_paper", "everyday_paper_large_grip"):
        path = DOCS / "images" / f"{name}.png"
        assert path.stat().st_size < 700_000
        with Image.open(path) as picture:
            assert picture.width < 1500


def test_a_thing_that_failed_once_is_not_told_as_held(study: ModuleType) -> None:
    failed = row(success=False, held=False, cause="slipped")
    assert study.judge([]) is None
    assert study.judge([row(), row()]).words == "held and set down, 2 of 2"
    assert study.judge([row(), failed]).words == "1 of 2 succeeded, else slipped"
    assert study.judge([failed, row()]).kind == "failed"  # The gallery shows the first world.
    assert study.judge([row(success=False, cause="dropped")]).words == "0 of 1 succeeded, else dropped after the hold"
    assert study.judge([row(success=False, held=False, cause="refused", attempts=[])]).kind == "refused"


def test_reasons_are_told_once_for_the_strategies_that_share_them(study: ModuleType) -> None:
    wide = [{"strategy": name, "feasible": False, "reason": "too wide"} for name in study.FAMILIES["fingers"]]
    low = {"strategy": "wrap-oblique", "feasible": False, "reason": "too low"}
    able = {"strategy": "wrap-horizontal", "feasible": True, "reason": "80 mm wide"}
    assert study._format_reasons([*wide, low, able]) == "fingers: too wide<br>wrap-oblique: too low"
    assert study._format_reasons([able]) == "all can"
