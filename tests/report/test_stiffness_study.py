"""validation/stiffness.md tells the numbers of stiffness.json, and those are what model and simulation give."""

from __future__ import annotations

import importlib.util
import json
import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "validation" / "stiffness.md").read_text()
FIGURES = json.loads((DOCS / "studies" / "stiffness.json").read_text())


@pytest.fixture(scope="module")
def study() -> Any:
    before = list(sys.path)
    spec = importlib.util.spec_from_file_location("study_stiffness", DOCS / "studies" / "study_stiffness.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["study_stiffness"] = module  # Its dataclass looks itself up there.
    spec.loader.exec_module(module)
    yield module
    del sys.modules["study_stiffness"]
    sys.path[:] = before


def test_the_page_tells_the_numbers(study: ModuleType) -> None:
    assert study.fill_page(PAGE, FIGURES) == PAGE
    assert len(re.findall(r"[\d.]<!-- = ", PAGE)) > 10
    wrong = json.loads(json.dumps(FIGURES))
    wrong["curled"]["0.2"]["10"]["length"]["in_plane"] += 100.0
    assert study.fill_page(PAGE, wrong) != PAGE


def test_every_table_and_picture_is_there(study: ModuleType) -> None:
    tables = study.format_tables(FIGURES)
    assert set(re.findall(r"<!-- table (\S+) -->", PAGE)) == set(tables)
    assert all(table in PAGE for table in tables.values())
    assert all((DOCS / "validation" / picture).exists() for picture in re.findall(r"\]\((\.\./images/\S+)\)", PAGE))


@pytest.mark.parametrize("posture", ["straight", "curled", "lying"])
def test_what_the_page_claims_is_in_the_numbers(posture: str) -> None:
    free, rubbed = FIGURES[posture]["0"], FIGURES[posture]["0.2"]
    assert free["5"]["tension"]["in_plane"] < 1.2 * free["0"]["tension"]["in_plane"]
    assert free["5"]["length"]["in_plane"] < 2.1 * free["0"]["length"]["in_plane"]
    for mode, least in (("tension", 1.5), ("length", 3.0)):
        assert rubbed["10"][mode]["in_plane"] > least * rubbed["1"][mode]["in_plane"]
    assert rubbed["10"]["length"]["in_plane"] > 3 * rubbed["10"]["tension"]["in_plane"]
    assert rubbed["10"]["simulated"]["length"] > 5 * rubbed["0"]["simulated"]["length"]
    assert rubbed["10"]["simulated"]["length"] > 1.3 * rubbed["10"]["simulated"]["tension"]


@pytest.mark.slow
@pytest.mark.parametrize("dorsal", [0.0, 5.0])
def test_without_friction_model_and_simulation_agree(study: ModuleType, dorsal: float) -> None:
    posture, told = study.POSTURES["curled"], FIGURES["curled"]["0"][f"{dorsal:g}"]
    wrap = study.find_wrap(posture, 0.0)
    again = study.measure_model(posture, 0.0, wrap, dorsal)
    for mode in study.MODES:
        assert again[mode]["in_plane"] == pytest.approx(told[mode]["in_plane"], rel=0.02)
        assert told["simulated"][mode] == pytest.approx(told[mode]["in_plane"], rel=0.03)
    simulated = study.measure_simulation(
        posture, 0.0, (wrap, dorsal), {mode: told[mode]["side"] for mode in study.MODES}
    )
    for mode in study.MODES:
        assert simulated[mode] == pytest.approx(told["simulated"][mode], rel=0.02)


def test_with_friction_it_is_what_the_model_gives(study: ModuleType) -> None:
    posture, told = study.POSTURES["curled"], FIGURES["curled"]["0.2"]["5"]
    wrap = study.find_wrap(posture, 0.2)
    for mode in study.MODES:
        again = study.push_model(posture, 0.2, (wrap, 5.0), mode, told[mode]["side"])
        assert again == pytest.approx(told[mode]["in_plane"], rel=0.05)
