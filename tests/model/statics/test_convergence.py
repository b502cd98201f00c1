"""Drawn equilibria end: a slice of benchmarks/statics_convergence.py, and that script itself."""

import copy
import importlib.util
import json
import math
import operator
from pathlib import Path

import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import ModelError
from spiraltrunk.model import statics
from spiraltrunk.model.statics import equilibrium


@pytest.fixture(scope="module")
def script():
    path = Path(__file__).parents[3] / "benchmarks" / "statics_convergence.py"
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_three_hundred_drawn_cases_converge(script):
    chunk = script.run_chunk((0.0, 0, 300))
    assert chunk["failed"] == []
    assert chunk["not_finite"] == 0
    assert chunk["status"]["NOT_CONVERGED"] == 0
    assert sum(chunk["status"].values()) == 300


def test_what_ended_is_kept_and_the_next_run_goes_on(script, tmp_path, monkeypatch, capsys):
    asked = ["--friction", "--workers", "1", "--out", str(tmp_path), "--trials"]
    assert script.main([*asked, "150"]) == 0
    kept = json.loads((tmp_path / "statics_convergence.json").read_text())
    assert [(chunk["first"], chunk["last"]) for chunk in kept["chunks"]] == [(0, 100), (100, 150)]
    solved, run = [], script.run_chunk
    monkeypatch.setattr(script, "run_chunk", lambda chunk: solved.append(chunk) or run(chunk))
    assert script.main([*asked, "200"]) == 0
    assert solved == [(0.0, 100, 200)]
    assert "100.000 % of 200 converged" in capsys.readouterr().out


def test_a_case_that_does_not_converge_is_told_and_fails(script, monkeypatch, capsys):
    seen = {"status": "NOT_CONVERGED", "is_finite": True, "residual": 1e-3, "excess": 0.0, "bend": 0.1}
    monkeypatch.setattr(script, "judge", lambda *_: seen)
    assert script.main(["--trials", "2", "--friction", "--workers", "1"]) == 1
    assert "not converged: trials [0, 1]" in capsys.readouterr().out


@pytest.mark.parametrize(("friction", "trial"), [pytest.param(0.1, 17, marks=pytest.mark.slow), (0.2, 240)])
def test_friction_that_does_not_settle_in_increments_is_loaded_slowly(script, monkeypatch, friction, trial):
    """A trunk that leaps on the way."""
    case = script.draw_case(friction, trial)
    assert script.is_good(script.judge(case, script.solve_case(case)))
    monkeypatch.setattr(equilibrium, "_fall_back", lambda *_: None)
    assert script.judge(case, script.solve_case(case))["status"] == "NOT_CONVERGED"


@pytest.mark.parametrize("part", ["gap", "history.bend", "history.anchor", "forces.cable_tension"])
def test_a_start_that_is_not_finite_is_refused(part):
    start = copy.deepcopy(statics.solve(PAPER, theta_0=0.5))
    operator.attrgetter(part)(start)[...] = math.nan
    with pytest.raises(ModelError, match=rf"^start\.{part} is nan; allowed: "):
        statics.solve(PAPER, pull=[0.01, 0, 0], by_tension=[False, True, True], start=start)
