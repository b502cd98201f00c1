"""The study of time steps with fake trials: its surveys take turns, go on, and are compared."""

from __future__ import annotations

import functools
import importlib
import json
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture
def study(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(ROOT / "benchmarks")
    monkeypatch.syspath_prepend(ROOT / "tests" / "workflows" / "survey" / "fakes")
    module, fakes = (importlib.import_module(name) for name in ("timestep_study", "survey_fakes"))
    monkeypatch.setattr(module, "run_survey", functools.partial(module.run_survey, work=fakes.work))
    return module


def run(study: ModuleType, monkeypatch: pytest.MonkeyPatch, *arguments: str) -> None:
    monkeypatch.setattr(sys, "argv", ["timestep_study.py", *arguments])
    study.main()


def count(out: Path) -> dict[str, int]:
    return {path.name: len((path / "trials.jsonl").read_text().splitlines()) for path in out.glob("*ms")}


@pytest.mark.slow
def test_steps_take_turns_and_are_compared(
    study: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    plan: Any = functools.partial(study.build_plan, trials=2, seed=0)
    for _ in range(2):
        done = [study.run_turn(plan(step), study.find_folder(tmp_path, step), 1, float("inf")) for step in (1.0, 2.0)]
    assert done == [True, True]
    assert count(tmp_path) == {"1ms": 18, "2ms": 18}
    run(study, monkeypatch, "--out", str(tmp_path), "--report")
    told = json.loads((tmp_path / "timestep.json").read_text())["against_1ms"]
    assert list(told) == ["2"]
    assert told["2"]["settings"] == {"timestep_s": [0.001, 0.002]}
    assert told["2"]["overall"]["pairs"] == 18
    assert "A: 1 ms, B: 2 ms" in capsys.readouterr().out


def test_the_time_is_kept(study: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run(study, monkeypatch, "--out", str(tmp_path), "--minutes", "0", "--trials", "2")
    assert count(tmp_path) == {}
