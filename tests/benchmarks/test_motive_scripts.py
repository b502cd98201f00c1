"""The scripts on the reader of Motive CSVs run, and a reader that breaks is noticed."""

import importlib.util
import json
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "benchmarks"


def _load(name):
    spec = importlib.util.spec_from_file_location(name, FOLDER / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def fuzz():
    return _load("fuzz_motive")


def test_mutated_files_are_read_or_refused(fuzz, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(fuzz, "SLOWEST", 60.0)
    found = fuzz.run(3000, 60.0, seed=5)
    assert found["files"] == 3000
    assert 0.02 < found["takes"] / found["files"] < 0.5


def test_the_same_seed_gives_the_same_files(fuzz):
    seeds = fuzz.build_seeds()
    one, other = fuzz.random.Random(3), fuzz.random.Random(3)
    files = [fuzz.mutate(seeds, one) for _ in range(50)]
    assert files == [fuzz.mutate(seeds, other) for _ in range(50)]
    assert len(set(files)) > 45


def test_a_reader_that_breaks_is_noticed(fuzz, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    real, calls = fuzz.read_motive, []

    def broken(*arguments, **more):
        calls.append(1)
        if len(calls) > 40:
            raise IndexError("broken")
        return real(*arguments, **more)

    monkeypatch.setattr(fuzz, "read_motive", broken)
    with pytest.raises(IndexError):
        fuzz.run(1000, 60.0, seed=5)
    assert (tmp_path / "fuzz_motive_failure.csv").exists()


def test_the_rate_is_told_as_a_ratio_too(tmp_path, capsys, monkeypatch):
    speed = _load("motive_speed")
    monkeypatch.setattr("sys.argv", ["motive_speed.py", "--frames", "200", "--rounds", "1"])
    assert speed.main() == 0
    told = json.loads(capsys.readouterr().out)
    assert told["megabytes"] > 0.1
    assert told["ratio"] == pytest.approx(told["read_mb_s"] / told["csv_module_mb_s"])
