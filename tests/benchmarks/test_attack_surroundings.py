"""The script that runs the commands in bad surroundings runs, and what breaks is noticed."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "attack_surroundings.py"

FEW = "as it is;full disc;read-only folder;without rich;40 columns;all three closed;LANG=C, non-ASCII paths"


@pytest.fixture(scope="module")
def attack():
    sys.path.insert(0, str(SCRIPT.parent))  # What makes the recordings is beside it.
    spec = importlib.util.spec_from_file_location("attack_surroundings", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    sys.modules["attack_surroundings"] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def work(attack, tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[2] / "src"))
    (tmp_path / "takes").mkdir()
    return tmp_path


@pytest.mark.slow
def test_a_verb_holds_in_surroundings(attack, work, capsys) -> None:
    assert attack.main([str(work), "--commands", "design", "--surroundings", FEW]) == 0, capsys.readouterr().err
    rows = [json.loads(line) for line in (work / "runs.jsonl").read_text().splitlines()]
    assert {row["surroundings"]: row["code"] for row in rows} == {
        name: 2 if "folder" in name or "disc" in name else 0 for name in FEW.split(";")
    }
    assert attack.main([str(work), "--commands", "design", "--surroundings", FEW]) == 0
    assert len((work / "runs.jsonl").read_text().splitlines()) == len(rows)
    assert "read-only folder" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("command", "what", "code"),
    [
        pytest.param("shape --plot", "without matplotlib", 2, marks=pytest.mark.slow),
        ("bench", "reader of standard output gone", 0),
    ],
)
def test_what_is_missing_is_one_line(attack, work, command: str, what: str, code: int) -> None:
    attack.make_work(work)
    row = attack.run_command(command, what, work)
    assert (row["faults"], row["code"]) == ([], code)


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_small_verbs_hold_in_all_surroundings(attack, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[2] / "src"))
    assert attack.main([str(tmp_path), "--commands", ";".join(attack.SMALL)]) == 0, capsys.readouterr().err


@pytest.mark.parametrize(
    ("outcome", "fault"),
    [((0, "", []), "exit 0"), ((2, "spiraltrunk: error: pip install a", []), None),
     ((2, "spiraltrunk: error: a", []), "no 'pip install'"), ((2, "", []), "0 errors"), ((None, "", []), "exit"),
     ((2, "Traceback\nspiraltrunk: error: pip install", []), "line"),
     ((2, "spiraltrunk: error: pip install a", ["part"]), "files left")],
)  # fmt: skip
def test_what_must_not_be_is_noticed(attack, tmp_path, outcome, fault) -> None:
    code, said, left = outcome
    (tmp_path / "messages").write_text(said)
    (tmp_path / "printed").write_text("{}")
    around = attack.Surroundings(refused="writes", advice="pip install")
    found = list(attack.find_faults("design", around, code, tmp_path, left))
    assert any(fault in each for each in found) if fault else not found
