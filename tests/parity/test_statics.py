"""The equilibrium against MuJoCo at rest: a slice of benchmarks/statics_parity.py."""

import importlib.util
from pathlib import Path

import pytest


@pytest.fixture(scope="module")
def parity():
    path = Path(__file__).parents[2] / "benchmarks" / "statics_parity.py"
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("trial", [0, *(pytest.param(trial, marks=pytest.mark.slow) for trial in (2, 4, 9))])
def test_mujoco_rests_where_the_model_puts_the_trunk(parity, trial):
    row = parity.compare("free", trial)
    assert row["simulated"] in {"CONVERGED", "STALLED", "ALL_SHUT"}
    assert row["past_limit_deg"] < 2e-3
    assert row["unbalance_nm"] < 1e-4
    assert row["same_limit_m"] < 5e-5
    assert row["distance_m"] < 5e-5


@pytest.mark.slow
@pytest.mark.parametrize("trial", [12, 110])
def test_with_all_cables_pulled_the_model_creeps_where_mujoco_goes(parity, trial):
    row = parity.compare("free", trial)
    assert row["used"] == [True, True, True]
    assert row["unbalance_nm"] < 1e-4
    assert row["distance_m"] < 5e-5 < parity.BAR["free"] < row["other_way_m"]


@pytest.mark.slow
@pytest.mark.parametrize("trial", [3, 4])
def test_with_friction_too(parity, trial):
    row = parity.compare("friction", trial)
    assert row["simulated"] == row["solved"] == "CONVERGED"
    assert row["distance_m"] < parity.BAR["friction"]


@pytest.mark.slow
@pytest.mark.parametrize("trial", [5, 36])
def test_with_friction_and_all_cables_pulled_it_creeps_there_and_in_increments_goes_elsewhere(parity, trial):
    row = parity.compare("friction", trial)
    assert row["used"] == [True, True, True]
    assert row["simulated"] == row["solved"] == "STALLED"
    assert row["distance_m"] < parity.BAR["friction"] < row["other_way_m"]
