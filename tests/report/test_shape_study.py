"""validation/forward_models.md tells the numbers of forward_models.json, and those are what the code computes."""

from __future__ import annotations

import importlib.util
import json
import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "validation" / "forward_models.md").read_text()
FIGURES = json.loads((DOCS / "studies" / "forward_models.json").read_text())


@pytest.fixture(scope="module")
def study() -> Any:
    before = list(sys.path)
    spec = importlib.util.spec_from_file_location("study_forward_models", DOCS / "studies" / "study_forward_models.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    yield module
    sys.path[:] = before


def test_the_page_tells_the_numbers(study: ModuleType) -> None:
    assert study.fill_page(PAGE, FIGURES) == PAGE
    assert len(re.findall(r"[\d.]<!-- = ", PAGE)) > 20


def test_a_number_that_is_wrong_is_noticed(study: ModuleType) -> None:
    wrong = json.loads(json.dumps(FIGURES))
    wrong["twist"]["0.1"]["turn_deg"] += 1.0
    wrong["share"]["reference"][16] += 0.01
    changed = [a != b for a, b in zip(study.fill_page(PAGE, wrong).splitlines(), PAGE.splitlines(), strict=True)]
    assert sum(changed) == 2  # One in a table, one in the text.


def test_every_table_and_picture_is_there(study: ModuleType) -> None:
    tables = study.format_tables(FIGURES)
    assert set(re.findall(r"<!-- table (\S+) -->", PAGE)) == set(tables)
    assert all(table in PAGE for table in tables.values())
    pictures = re.findall(r"\]\((\.\./images/\S+)\)", PAGE)
    assert len(pictures) == 4
    assert all((DOCS / "validation" / picture).exists() for picture in pictures)


def test_shares_and_twist_are_what_the_code_gives(study: ModuleType) -> None:
    for name, share in FIGURES["share"].items():
        assert sum(share) == pytest.approx(1.0, abs=1e-3), name
    bends = {0.1: study._bend_on(0.1, 90)}
    assert study._compare_shares(bends)["0.1"] == pytest.approx(FIGURES["share"]["0.1"], abs=2e-4)
    assert study._compare_bends(bends[0.1], 90)["mean_rms_mm"] == pytest.approx(
        FIGURES["distance"]["0.1"]["90"]["mean_rms_mm"], abs=0.11
    )
    told = study._describe(study._twist(0.1, 0.06, 0.03, "1 then 2"))
    for key in ("turn_deg", "out_of_plane_mm", "tilt_deg", "tip_z_mm", "base_bend_deg"):
        assert told[key] == pytest.approx(FIGURES["twist"]["0.1"][key], abs=0.11), key


@pytest.mark.slow
def test_all_of_it_is_what_the_code_gives(study: ModuleType) -> None:
    figures, _ = study.compute_figures()
    for key in ("share", "shut_mm", "rest_mm", "twist", "doubts", "distance"):
        for (path, new), (_, old) in zip(walk(figures[key]), walk(FIGURES[key]), strict=True):
            both = [np.nan if value is None else float(value) for value in (new, old)]
            # Near full curl an equilibrium may converge on one machine and not on another.
            assert np.isnan(both).any() or abs(both[0] - both[1]) <= max(1.01, 0.02 * abs(both[1])), (key, path)


def walk(value: Any, path: str = "") -> list[tuple[str, Any]]:
    """Every number of nested figures with its place."""
    if isinstance(value, dict):
        return [entry for key in value for entry in walk(value[key], f"{path}/{key}")]
    if isinstance(value, list):
        return [entry for i, item in enumerate(value) for entry in walk(item, f"{path}/{i}")]
    return [(path, value)]
