"""The script that gives hostile recordings to the command line runs, and what breaks is noticed."""

from __future__ import annotations

import argparse
import importlib.util
import json
import random
import sys
from pathlib import Path

import pytest

from spiraltrunk import cli

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "attack_takes.py"

NOTHING = dict.fromkeys(("one", "two", "three"), lambda data, draw: data)


def load(path: Path = SCRIPT):
    sys.path.insert(0, str(path.parent))  # It imports the changes beside it.
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def attack():
    return load()


@pytest.fixture(scope="module")
def seeds(attack, tmp_path_factory):
    pytest.importorskip("ezc3d", reason="ezc3d is not installed")
    work = tmp_path_factory.mktemp("work")
    attack.make_seeds(work / "seeds")
    return work


def attack_with(attack, work: Path, capsys, *more: str) -> dict:
    assert attack.main(["--work", str(work), *more]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(
    "what",
    [("validate", "csv", 120), ("validate", "c3d", 20), ("validate", "protocol", 60), ("calibrate", "bench", 60),
     pytest.param(("validate", "csv", 2000), marks=pytest.mark.slow),
     pytest.param(("validate", "c3d", 400), marks=pytest.mark.slow),
     pytest.param(("calibrate", "csv", 100), marks=pytest.mark.slow)],
)  # fmt: skip
def test_hostile_files_end_as_they_must(attack, seeds, capsys, what: tuple[str, str, int]) -> None:
    verb, kind, count = what
    found = attack_with(attack, seeds, capsys, "--verb", verb, "--kind", kind, "--count", str(count), "--seed", "3")
    assert found["tries"] == sum(found["exit"].values()) == count
    assert found["faults"] == 0
    assert found["exit"]["0"] >= 1
    assert found["exit"]["2"] >= count // 4
    assert set(found["attacks"]) <= set(attack.ATTACKS[kind])


def test_files_that_are_not_changed_are_accepted(attack, seeds, capsys, monkeypatch, tmp_path) -> None:
    """Else every try would be refused, and nothing be tried."""
    monkeypatch.setattr(attack, "ATTACKS", dict.fromkeys(attack.ATTACKS, NOTHING))
    for verb, kind in (("validate", "csv"), ("validate", "c3d"), ("calibrate", "bench")):
        monkeypatch.setattr(attack, "OPTIONS", {verb: ([],)})
        argv, used = attack.draw_try(0, attack.Attack(0, verb, kind), seeds / "seeds", tmp_path)
        assert cli.main(argv) == 0
        assert set(used) <= set(NOTHING)


@pytest.mark.parametrize("kind", ["csv", "c3d", "bench", "protocol"])
def test_every_attack_changes_the_file(attack, seeds, kind: str) -> None:
    name = {"csv": "bend_1.csv", "c3d": "bend_1.c3d", "bench": "bench.csv", "protocol": "protocol.toml"}[kind]
    data, draw = (seeds / "seeds" / name).read_bytes(), random.Random(1)
    for attack_name, change in attack.ATTACKS[kind].items():
        assert any(change(data, draw) != data for _ in range(8)), attack_name


@pytest.mark.parametrize(
    ("outcome", "fault"),
    [((0, "{}", ""), None), ((2, "", "spiraltrunk: error: a"), None), ((3, "", ""), "exit 3"),
     ((0, "{", ""), "no strict JSON"), ((0, '{"a": NaN}', ""), "NaN in JSON"),
     ((2, "", "spiraltrunk: error: a\nspiraltrunk: error: b"), "2 errors"), ((2, "", ""), "0 errors"),
     ((0, "{}", "x.py:3: RuntimeWarning: overflow"), "line on standard error"),
     ((2, "{}", "spiraltrunk: error: a"), "standard output"), ((0, "{}", "spiraltrunk: " + 2000 * "a"), "too long")],
)  # fmt: skip
def test_what_must_not_be_is_noticed(attack, tmp_path, outcome, fault) -> None:
    found = list(attack.find_faults(*outcome, tmp_path, set()))
    assert (fault in found[0]) if fault else not found


def test_a_file_that_is_left_is_noticed(attack, tmp_path) -> None:
    (tmp_path / "core").write_text("a")
    assert "files left" in next(iter(attack.find_faults(0, "{}", "", tmp_path, set())))
    assert not list(attack.find_faults(0, "{}", "", tmp_path, {"core"}))


@pytest.mark.parametrize(
    ("code", "fault"),
    [("import os; input(); os.kill(os.getpid(), 9)", "died: exit -9"), ("import time; time.sleep(600)", "not ended")],
)
def test_a_process_that_dies_or_is_late_is_noticed(attack, tmp_path, code: str, fault: str) -> None:
    server = attack.Server(argparse.Namespace(seed=0, verb="validate", kind="csv"), tmp_path)
    server.command = [sys.executable, "-c", code]
    limit = 60.0 if "died" in fault else 0.2
    assert fault in server.ask(0, limit)["faults"][0]
    assert server.process is None
