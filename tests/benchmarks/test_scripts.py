"""The benchmark scripts run, and what they say can be trusted."""

import importlib.util
import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from scipy.stats import binomtest

from spiraltrunk.errors import ModelError

FOLDER = Path(__file__).parents[2] / "benchmarks"

KEYS = {
    "seed", "diameter_m", "mass_kg", "offset_m", "friction", "stiffness_factor", "success", "reason", "place_error_m",
    "penetration_m", "bend", "real_time_factor",
}  # fmt: skip


def _load(name):
    spec = importlib.util.spec_from_file_location(name, FOLDER / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def trials():
    return _load("grasp_trials")


@pytest.fixture
def faked(trials, monkeypatch):
    """The script with outcomes instead of simulations: True, False or an error to raise, by seed."""

    def faked(*outcomes):
        def run_seed(seed):
            outcome = outcomes[seed]
            if isinstance(outcome, BaseException):
                raise outcome
            row = dict.fromkeys(KEYS, 0.0) | {"seed": seed, "success": outcome}
            return row | {"reason": "success" if outcome else "lifted 0 cm"}

        monkeypatch.setattr(trials, "run_seed", run_seed)
        return trials

    return faked


def _start(*arguments):
    command = [sys.executable, str(FOLDER / "grasp_trials.py"), *map(str, arguments)]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, start_new_session=True)


def _ends(group, patience=10.0):
    """Whether no process of the group is left soon; Python's own tracker of resources is the last to go."""
    end = time.monotonic() + patience
    while time.monotonic() < end:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False


def _table(folder):
    assert [path.name for path in folder.iterdir()] == ["grasp_trials.json"]
    return json.loads((folder / "grasp_trials.json").read_text())


@pytest.mark.slow
def test_two_true_trials_in_two_processes(tmp_path):
    script = _start("--trials", 2, "--seed-from", 3, "--workers", 2, "--out", tmp_path)
    out, err = script.communicate(timeout=280)
    table = _table(tmp_path)
    assert [row["seed"] for row in table["trials"]] == [3, 4]
    assert all(set(row) == KEYS for row in table["trials"])
    assert script.returncode == (0 if table["summary"]["successes"] == 2 else 1), err
    assert "of 2 succeeded (Wilson 95 %: " in out
    assert "1/2 seed " in err


@pytest.mark.slow
def test_ctrl_c_ends_every_process_and_leaves_the_trials_that_ended(tmp_path):
    script = _start("--trials", 40, "--workers", 2, "--out", tmp_path)
    assert script.stderr.readline().startswith("1/40 seed ")
    os.killpg(script.pid, signal.SIGINT)
    out, err = script.communicate(timeout=240)
    assert script.returncode == 130, err
    assert "Traceback" not in err
    assert "interrupted; 40 asked for" in out
    assert 1 <= _table(tmp_path)["summary"]["trials"] < 40
    assert _ends(script.pid)


def test_draws_are_within_their_ranges_and_repeat(trials):
    shapes = [trials.draw_object(seed) for seed in range(200)]
    assert shapes == [trials.draw_object(seed) for seed in range(200)]
    for values, (low, high) in (
        ([shape.width for shape in shapes], trials.DIAMETER_RANGE),
        ([shape.mass for shape in shapes], trials.MASS_RANGE),
    ):
        assert low <= min(values) < low + 0.1 * (high - low)
        assert high - 0.1 * (high - low) < max(values) <= high


@pytest.mark.parametrize(("successes", "code"), [(50, 0), (48, 0), (47, 1)])
def test_below_the_claim_it_fails(faked, capsys, successes, code):
    outcomes = [True] * successes + [False] * (50 - successes)
    assert faked(*outcomes).main(["--workers", "1"]) == code
    told = capsys.readouterr().out
    assert told.startswith(f"{successes} of 50 succeeded (Wilson 95 %: ")
    assert ("seed 49: lifted 0 cm" in told) == (successes < 50)


def test_an_interrupted_table_is_written_as_far_as_it_came(faked, tmp_path, capsys):
    script = faked(True, True, KeyboardInterrupt(), True)
    assert script.main(["--trials", "4", "--workers", "1", "--out", str(tmp_path)]) == 130
    table = _table(tmp_path)
    assert [row["seed"] for row in table["trials"]] == [0, 1]
    assert not table["summary"]["is_complete"]
    assert not table["summary"]["holds"]
    assert "2 of 2 succeeded" in capsys.readouterr().out


def test_an_error_of_the_package_is_a_failed_trial(trials, monkeypatch):
    def refuse(*_, **__):
        raise ModelError("out of reach")

    monkeypatch.setattr(trials, "run_trial", refuse)
    row = trials.run_seed(0)
    assert set(row) == KEYS
    assert not row["success"]
    assert row["reason"] == "ModelError: out of reach"


@pytest.mark.parametrize(("successes", "count"), [(0, 1), (48, 50), (50, 50), (1, 2), (470, 500)])
def test_the_interval_is_scipys(trials, successes, count):
    expected = binomtest(successes, count).proportion_ci(method="wilson")
    assert trials.wilson(successes, count) == pytest.approx((expected.low, expected.high), abs=1e-6)


@pytest.mark.slow
def test_the_parts_of_a_step_add_up_to_the_grasp(tmp_path, capsys):
    script = _load("speed")
    assert script.main(["--out", str(tmp_path)]) == 0
    figures = json.loads((tmp_path / "speed.json").read_text())
    factors, parts = figures["real_time_factor"], figures["part_of_wall_time"]
    assert min(factors["grasp"], factors["physics alone"]) > 0
    assert math.isclose(sum(parts.values()), 1.0, abs_tol=1e-9)
    assert {"tendons", "collision", "constraint solver", "Python loop"} <= set(parts)
    assert "times real time" in capsys.readouterr().out


def test_a_failed_write_leaves_the_earlier_figures(tmp_path, monkeypatch):
    script = _load("speed")
    (tmp_path / "speed.json").write_text("{}")
    write = Path.write_text

    def fill_up(path, text):
        write(path, text[:10])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(script, "measure", lambda: {"step_us": {"physics": 1.0}})
    monkeypatch.setattr(Path, "write_text", fill_up)
    with pytest.raises(OSError, match="No space left"):
        script.main(["--out", str(tmp_path)])
    assert [path.name for path in tmp_path.iterdir()] == ["speed.json"]
    assert (tmp_path / "speed.json").read_text() == "{}"


def test_a_bare_hanging_trunk_with_a_slack_cable_balances_in_one_shape():
    ways = _load("statics_ways")
    assert ways.count_two("paper", ways.KINDS["hangs or lies, a cable slack"], 300, 1) == 0


def test_cables_that_all_pull_may_leave_two_shapes():
    """Or the count above would say nothing."""
    ways = _load("statics_ways")
    assert ways.count_two("paper", ways.KINDS["hangs or lies, all cables pull"], 1000, 1) > 0
