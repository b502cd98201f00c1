"""The script that counts what calibrations recover counts rightly, and plays one small part of a world."""

import importlib.util
import json
from pathlib import Path

import pytest

PATH = Path(__file__).parents[2] / "benchmarks" / "calibration_worlds.py"


@pytest.fixture(scope="module")
def worlds():
    spec = importlib.util.spec_from_file_location(PATH.stem, PATH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _row(seed, off, judged):
    figures = {"calibrated": judged, "uncalibrated": 0.02, "reference": 0.01}
    return {
        "seed": seed, "kind": "model", "wall_s": 2.0 + seed, "cpu_s": 3.0, "held_out_m": {"rest": figures},
        "judged_m": figures,
        "off": {"friction": off, "mass": 0.0}, "ratio": {"friction": 0.1, "mass": 0.98},
    }  # fmt: skip


def test_worlds_in_and_out_of_their_intervals_are_counted(worlds):
    rows = [_row(i, 3.0 if i < 2 else 0.1, 1e-3 * (1 + i)) for i in range(10)]
    result = worlds.summarise(rows)
    assert result["inside"] == {"friction": 8, "mass": 10}
    assert result["parameters_under_bar"] == ["friction"]
    assert result["told"] == ["friction"]
    assert result["worlds_under_bar"] == 1
    assert result["held_out_mean_m"] == pytest.approx(5.5e-3)
    assert result["wall_s_most"] == 11.0


@pytest.mark.parametrize("off", [0.0, 5.0])
def test_the_exit_says_whether_the_claims_hold_and_worlds_are_kept(worlds, monkeypatch, tmp_path, capsys, off):
    monkeypatch.setattr(worlds, "run_world", lambda seed, kind: _row(seed, off, 1e-3))
    monkeypatch.setattr("sys.argv", ["worlds", "--worlds", "3", "--out", str(tmp_path / "rows.jsonl")])
    assert worlds.main() == (1 if off > 2 else 0)
    assert json.loads(capsys.readouterr().out)["worlds"] == 3
    monkeypatch.setattr(worlds, "run_world", None)  # What is in the file is not played again.
    assert worlds.main() == (1 if off > 2 else 0)
    assert json.loads(capsys.readouterr().out)["worlds"] == 3
    assert len((tmp_path / "rows.jsonl").read_text().splitlines()) == 3


def test_a_world_that_was_cut_off_is_played_again(worlds, tmp_path):
    path = tmp_path / "rows.jsonl"
    path.write_text(json.dumps(_row(4, 0.0, 1e-3)) + "\n" + json.dumps(_row(9, 0.0, 1e-3)) + "\n" + '{"seed": 5, "ki')
    assert [row["seed"] for row in worlds.load_rows(path, range(3, 6), "model")] == [4]
    with pytest.raises(ValueError, match="line 1 was played by 'model'"):
        worlds.load_rows(path, range(3, 6), "simulated")
    path.write_text("{}\n{}\n")
    with pytest.raises(ValueError, match="line 1 is no world"):
        worlds.load_rows(path, range(3, 6), "model")
