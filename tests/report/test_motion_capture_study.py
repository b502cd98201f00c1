"""validation/motion_capture.md tells the numbers of motion_capture.json, and those are what the study gives."""

from __future__ import annotations

import importlib.util
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from spiraltrunk.mocap.protocol.toml import load_protocol

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "validation" / "motion_capture.md").read_text()
FIGURES = json.loads((DOCS / "studies" / "motion_capture.json").read_text())
TOLD = FIGURES["mean_rmse_by_alignment_m"]


@pytest.fixture(scope="module")
def study() -> Any:
    spec = importlib.util.spec_from_file_location("study_motion_capture", DOCS / "studies" / "study_motion_capture.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_tells_the_numbers(study: Any) -> None:
    assert study.fill_page(PAGE, FIGURES) == PAGE
    wrong = json.loads(json.dumps(FIGURES))
    wrong["mean_rmse_by_alignment_m"]["statics"]["base"]["twist"] += 1.0
    assert study.fill_page(PAGE, wrong) != PAGE
    assert all((DOCS / "validation" / picture).exists() for picture in re.findall(r"\]\((\.\./images/\S+)\)", PAGE))


def test_what_the_page_claims_is_in_the_numbers() -> None:
    bend = {kind: TOLD["reference"][kind]["bend-dorsal"] for kind in ("base", "run", "shape")}
    assert 1e-3 < bend["shape"] < bend["run"] / 2 < bend["base"] / 2
    assert TOLD["reference"]["run"]["twist"] > 1e-2
    assert max(TOLD["statics"]["run"].values()) < 1e-4


@pytest.mark.slow
def test_the_study_gives_the_numbers(study: Any) -> None:
    protocol = load_protocol("paper")
    some = replace(protocol, runs=(protocol.run("rest-090"), protocol.run("twist")))
    again = study.measure(some)["mean_rmse_by_alignment_m"]
    for model, kinds in again.items():
        for kind, runs in kinds.items():
            for run, value in runs.items():
                assert value == pytest.approx(TOLD[model][kind][run], rel=0.01, abs=1e-6)
