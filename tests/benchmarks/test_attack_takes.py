"""The script that gives hostile recordings to the command line runs, and what breaks is noticed."""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import random
import subprocess
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
    [("validate", "csv", 40), pytest.param(("calibrate", "bench", 20), marks=pytest.mark.slow),
     pytest.param(("validate", "c3d", 8), marks=pytest.mark.slow),
     pytest.param(("validate", "protocol", 60), marks=pytest.mark.slow),
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
    server = attack.Server(argparse.Namespace(seed=0, verb="validate", kind="csv", fresh=False), tmp_path)
    server.command = [sys.executable, "-c", code]
    limit = 60.0 if "died" in fault else 0.2
    assert fault in server.ask(0, limit)["faults"][0]
    assert server.process is None


def test_a_try_does_not_depend_on_the_hashes_of_names(attack, seeds, tmp_path) -> None:
    """Else ``--only N`` does not repeat it; the order of a set differs from process to process."""
    program = (
        "import sys; from pathlib import Path; sys.path.insert(0, sys.argv[1]); import attack_takes as a, hashlib\n"
        "seeds, folder, out = Path(sys.argv[2]), Path(sys.argv[3]), hashlib.sha256()\n"
        "for number in range(40):\n"
        "    a.draw_try(number, a.Attack(0, 'validate', 'c3d'), seeds, folder)\n"
        "    [out.update(path.read_bytes()) for path in sorted(folder.iterdir())]\n"
        "print(out.hexdigest())"
    )
    found = set()
    for one in "123":
        (tmp_path / one).mkdir()
        command = [sys.executable, "-c", program, str(SCRIPT.parent), str(seeds / "seeds"), str(tmp_path / one)]
        environment = os.environ | {"PYTHONHASHSEED": one}
        found.add(subprocess.run(command, env=environment, capture_output=True, check=True).stdout)
    assert len(found) == 1


TASKS = """
import os, time

def run_double(sent):
    print("not the result")
    return 2 * sent

def run_large(sent):
    return bytes(3_000_000)

def run_raise(sent):
    raise ValueError("broken")

def run_take(sent):
    return bytes(1 << 31)

def run_die(sent):
    os.kill(os.getpid(), 11)

def run_sleep(sent):
    time.sleep(600)

def run_count(sent):
    while True:
        pass
"""


def test_each_file_has_a_forked_process_of_its_own(attack, tmp_path) -> None:
    """How it ends is told of its file alone: the next one is read as if nothing had been."""
    pytest.importorskip("ezc3d", reason="ezc3d is not installed")
    (tmp_path / "tasks.py").write_text(TASKS)
    reader = attack.ForkedReader()

    def run(task: str, seconds: int = 60) -> bytes:
        return reader.run(tmp_path / "tasks.py", task, b"ab", seconds=seconds, memory=1 << 30)

    for task, code in (("raise", "1"), ("die", "-11"), ("take", "1"), ("none", "1")):
        with pytest.raises(ChildProcessError, match=f"^{code}$"):
            run(task)
        assert run("double") == b"abab"
    for task in ("sleep", "count"):
        with pytest.raises((TimeoutError, ChildProcessError)):
            run(task, seconds=1)
        assert run("double") == b"abab"
    assert run("large") == bytes(3_000_000)
    assert Path(f"/proc/{reader.process.pid}/task/{reader.process.pid}/children").read_text() == ""
    reader.process.kill()
