"""``spiraltrunk optimize``: its table, its JSON, and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from spiraltrunk import cli
from spiraltrunk.workflows.optimize import objective, optimize, search_space
from spiraltrunk.workflows.survey.summary import count_rate

pytest.importorskip("optuna", reason="the search needs the extra optimize")

FEW = ("--trials", "2", "--objects", "5", "--unseen", "5", "--workers", "2")


@pytest.fixture(autouse=True)
def fake_trials(monkeypatch: pytest.MonkeyPatch) -> None:
    class FakeTrials:
        def __init__(self, **options: Any) -> None:
            assert options == {"workers": 2, "engine": None}

        def run(self, plan: Any, folder: Path) -> dict[str, Any]:
            rows = [{"success": i % 2 == 0} for i in range(plan.trials)]
            return {"strategies": {name: {**count_rate(rows), "causes": {"slipped": 2}} for name in plan.objects}}

        def compare(self, a: Path, b: Path) -> dict[str, Any]:
            return {"overall": {"difference": 0.1, "low": -0.1, "high": 0.3, "p": 0.5, "only_a": 1, "only_b": 2}}

    monkeypatch.setattr(optimize, "LocalTrials", FakeTrials)
    monkeypatch.setattr(objective, "find_faults", lambda design: ())


def test_the_table_names_the_best_and_the_paper(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["optimize", "--out", str(tmp_path), *FEW]) == 0
    printed = capsys.readouterr()
    assert "3 of 5" in printed.out
    assert "preset paper" in printed.out
    assert "Difference +10 % of the objects (-10 to +30 %, paired)" in printed.out
    assert all(each.name in printed.out for each in search_space.SPACE)
    assert f"6 files in {tmp_path}" in printed.out
    assert "candidate 1" in printed.err
    assert "| 0 | 1.53 | 12 | 1 | 0.6 | 1 |" in (tmp_path / "table.md").read_text()


def test_json_alone_on_standard_output(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["optimize", "--out", str(tmp_path), *FEW, "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result == json.loads((tmp_path / "optimize.json").read_text())
    assert [each["number"] for each in result["candidates"]] == [0, 1]
    assert result["unseen"]["paper"]["trials"] == 5


@pytest.mark.parametrize(
    ("argv", "line"),
    [
        (("--trials", "0"), "--trials is 0; allowed: a whole number from 1 to 10000"),
        (("--objects", "x"), "argument --objects: 'x' given; allowed: a whole number"),
        (("--strategy", "kick"), "--strategy is 'kick'; allowed: auto or a strategy that grasps: wrap-vertical, "),
        (("--strategy", "wave"), "unknown strategy 'wave'; known: auto"),
        (("--kind", "cloud"), "unknown class of everyday shapes 'cloud'"),
        (("--friction", "nan"), "argument --friction: 'nan' given"),
        (("--friction", "3"), "--friction is 3.0; allowed: a finite number, at least 0, below 2"),
        (("--address", "10.0.0.1"), "--address: '10.0.0.1' given; allowed: with --engine ray"),
        (("--workers", "0"), "--workers is 0"),
    ],
)
def test_bad_input_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], argv: tuple[str, ...], line: str, monkeypatch
) -> None:
    monkeypatch.undo()
    assert cli.main(["optimize", "--out", str(tmp_path / "new"), *argv]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.splitlines()[-1].startswith(f"spiraltrunk: error: {line}")
    assert not (tmp_path / "new").exists()


def test_a_folder_with_anothers_file_is_refused_before_the_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "best.toml").write_text("mine")
    assert cli.main(["optimize", "--out", str(tmp_path), *FEW]) == 2
    assert "no run of 'optimize' wrote it" in capsys.readouterr().err
    assert (tmp_path / "best.toml").read_text() == "mine"
