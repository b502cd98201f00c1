"""Random interruptions: a few of cheap commands here, more of all in the slow tests; and faults are noticed."""

from __future__ import annotations

import importlib.util
import random
import signal
import sys
from pathlib import Path
from types import ModuleType

import pytest

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "attack_interruptions.py"


@pytest.fixture
def attack(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    spec = importlib.util.spec_from_file_location("attack_interruptions", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)  # Its dataclasses look there for their types.
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("commands", "rounds"),
    [
        pytest.param("design;shape", 1, marks=pytest.mark.slow),
        pytest.param(
            "shape --plot;grasp --no-video;survey;export", 8, marks=[pytest.mark.slow, pytest.mark.timeout(3600)]
        ),
    ],
)
def test_commands_can_be_interrupted(
    attack: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str], commands: str, rounds: int
) -> None:
    asked = [str(tmp_path), "--commands", commands, "--rounds", str(rounds), "--attempts", "5"]
    assert attack.main(asked) == 0, capsys.readouterr().out
    assert f"{5 * rounds} interruptions" in capsys.readouterr().out


FAULTY = {
    "exit 0": ("os._exit(0)", "exit 0 instead of 143"),
    "traceback": ("raise SystemExit(143)", "Traceback"),
    "line": ("sys.exit(143)", "line: odd"),
    "process": ("sys.exit(143)", "1 processes left"),
    "hangs": ("pass", "did not end"),
}
"""What a faulty command does at a signal, and how it is told."""

COMMAND = """
import os, signal, subprocess, sys, time
def end(number, frame):
    TELL
    END
signal.signal(signal.SIGTERM, signal.SIG_IGN)
if PROCESS:
    subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"], stderr=subprocess.DEVNULL)
signal.signal(signal.SIGTERM, end)
while True:
    time.sleep(0.1)
"""
"""A signal just before a sleep is handled after it: the sleep is short."""


@pytest.mark.parametrize("fault", FAULTY)
def test_faults_are_noticed(attack: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fault: str) -> None:
    """A package of the same name is found first."""
    end, expected = FAULTY[fault]
    tell = {"traceback": "print('spiraltrunk: Traceback', file=sys.stderr)", "line": "print('odd', file=sys.stderr)"}
    code = COMMAND.replace("END", end).replace("TELL", tell.get(fault, "pass"))
    (tmp_path / "spiraltrunk").mkdir()
    (tmp_path / "spiraltrunk" / "__init__.py").touch()
    (tmp_path / "spiraltrunk" / "__main__.py").write_text(code.replace("PROCESS", str(fault == "process")))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    wait, is_first = attack.Running.wait, [True]

    def wait_for_handler(running: object, limit: float) -> int | None:
        while is_first and not running.hears():  # type: ignore[attr-defined]
            pass
        return None if is_first and is_first.pop() else wait(running, limit)

    monkeypatch.setattr(attack.Running, "wait", wait_for_handler)
    monkeypatch.setattr(attack, "SIGNALS", (signal.SIGTERM,))
    limits = attack.Limits(
        end=2.0 if fault == "hangs" else 60.0, processes=0.0 if fault in {"process", "hangs"} else 60.0
    )
    (tmp_path / "out").mkdir()
    attempt = attack.interrupt("design", random.Random(0), 1.0, tmp_path / "out", limits)
    assert attempt.ended == "interrupted"
    assert any(expected in found for found in attempt.faults), attempt.faults
