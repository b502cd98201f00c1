"""The script that attacks the reader of MJCF runs, and a reader that breaks is noticed."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "attack_mjcf.py"


@pytest.fixture
def attack(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    spec = importlib.util.spec_from_file_location("attack_mjcf", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "SLOWEST", 120.0)
    return module


@pytest.mark.slow
def test_mutated_models_are_compiled_or_refused(tmp_path):
    """A process of its own, as a hook on opened files stays for the life of one."""
    command = [sys.executable, str(SCRIPT), "--count", "20", "--seed", "3"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["tries"] == sum(found["outcomes"].values()) == 20
    assert found["outcomes"]["compiled"] >= 1
    assert found["outcomes"]["refused by the reader"] >= 5
    assert list(tmp_path.iterdir()) == []


def test_every_attack_leaves_a_file(attack, tmp_path):
    canary = attack.lay_out(tmp_path / "model")
    draw, seen = attack.random.Random(1), set()
    for _ in range(60):
        seen.update(attack.write_try(tmp_path / "model", canary, draw))
        assert (tmp_path / "model" / "model.xml").stat().st_size > 0
    assert seen == set(attack.ATTACKS)


def test_the_models_that_are_mutated_compile(attack, tmp_path, monkeypatch):
    canary = attack.lay_out(tmp_path / "model")
    monkeypatch.setattr(attack, "TREE", dict.fromkeys(attack.TREE, lambda root, draw: None))
    monkeypatch.setattr(attack, "ATTACKS", tuple(attack.TREE))
    draw = attack.random.Random(0)
    for _ in range(4):
        attack.write_try(tmp_path / "model", canary, draw)
        assert attack.outcome(tmp_path / "model") == "compiled"


@pytest.mark.parametrize(
    ("read", "error"),
    [
        (lambda content, path, what: (path.parent.parent / "canary.xml").read_text(), "opened"),
        (lambda content, path, what: {}["a"], "a"),
        (lambda content, path, what: subprocess.Popen(["sleep", "60"]), "1 processes left"),
    ],
)  # fmt: skip
def test_a_reader_that_breaks_a_promise_is_noticed(attack, monkeypatch, tmp_path, read, error):
    started = []
    monkeypatch.setattr(attack, "load_mjcf_spec", lambda *what: started.append(read(*what)))
    monkeypatch.setattr(attack, "compile_spec", lambda spec: None)
    try:
        with pytest.raises((AssertionError, KeyError), match=error):
            attack.run(1, 60.0, 0)
    finally:
        for process in started:
            if isinstance(process, subprocess.Popen):
                process.kill()
                process.wait()
    assert (tmp_path / "attack_mjcf_failure.xml").exists()
