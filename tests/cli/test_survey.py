"""``spiraltrunk survey`` with fake trials: what it prints, what it refuses, and what a signal leaves behind."""

from __future__ import annotations

import functools
import importlib
import itertools
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Generator, Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import spiraltrunk.workflows.survey.run_survey as engine
from spiraltrunk import cli, strategies
from spiraltrunk.design import TrunkDesign, presets, write_design
from spiraltrunk.processes.pool import Outcome
from spiraltrunk.workflows.survey.plan import Entry
from spiraltrunk.workflows.survey.row import Row

FAKES = Path(__file__).parents[1] / "workflows" / "survey" / "fakes"

SURVEY = """
import functools, sys
sys.path.insert(0, sys.argv[1])
import survey_fakes
import spiraltrunk.workflows.survey.run_survey as engine
from spiraltrunk import cli
engine.run_survey = functools.partial(engine.run_survey, work=getattr(survey_fakes, sys.argv[2]))
sys.exit(cli.main(["survey", *sys.argv[3:]]))
"""
"""The verb with other trials."""


@pytest.fixture
def fakes(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(FAKES)
    fakes = importlib.import_module("survey_fakes")
    monkeypatch.setattr(engine, "run_survey", functools.partial(engine.run_survey, work=fakes.work))
    return fakes


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Plots take most of the time."""
    monkeypatch.setattr(
        "spiraltrunk.workflows.survey.results.write_figure", lambda figure, path: path.write_bytes(b"a plot")
    )


@pytest.fixture
def is_inline(fakes: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    """The fake trials run in this process, as each other one takes seconds to start."""
    monkeypatch.setattr(engine, "run_jobs", fakes.run_inline)


def start(work: str, *arguments: str) -> subprocess.Popen[str]:
    """Begin the command with Ctrl-C heard, also where the tests run in the background and ignore it."""
    pipe = subprocess.PIPE
    command = [sys.executable, "-c", SURVEY, str(FAKES), work, *arguments]
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, start_new_session=True)
    finally:
        signal.signal(signal.SIGINT, before)


def is_gone(group: int, patience: float = 10.0) -> bool:
    end = time.monotonic() + patience
    while time.monotonic() < end:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False


def load(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "survey.json").read_text())


@pytest.mark.slow
@pytest.mark.usefixtures("is_inline")
def test_json_is_the_survey_without_its_trials(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    argv = ["survey", "--strategies", "wrap-vertical", "--trials", "6", "--workers", "2", "--out", str(tmp_path)]
    assert cli.main([*argv, "--json"]) == 0
    printed = capsys.readouterr()
    result = json.loads(printed.out)
    held = load(tmp_path)
    assert len(held.pop("rows")) == 6
    assert result == held
    told = result["strategies"]["wrap-vertical"]
    assert set(told) >= {"trials", "successes", "rate", "low", "high", "failures"}
    assert told["successes"] + sum(told["failures"].values()) == told["trials"] == 6
    assert 0 <= told["low"] <= told["rate"] <= told["high"] <= 1
    assert set(result["files"]) == {path.name for path in tmp_path.glob("[!.]*")}
    lines = printed.err.splitlines()
    assert lines[0] == "spiraltrunk: 0/6 trials"
    assert len(lines) == 7
    assert lines[-1].startswith("spiraltrunk: 6/6 wrap-vertical, ")
    assert lines[-1].endswith(f"({told['successes']} of 6 succeeded)")
    assert cli.main(argv) == 0
    printed = capsys.readouterr()
    assert printed.err == "spiraltrunk: 6/6 trials are there already\n"
    assert printed.out.splitlines()[2].startswith(f"wrap-vertical  {told['successes']} of 6")
    assert printed.out.splitlines()[-1] == f"6 files in {tmp_path}"


@pytest.mark.usefixtures("is_inline")
def test_all_strategies_with_their_objects_or_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli.main(["survey", "--trials", "1", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert tuple(result["strategies"]) == strategies.NAMES
    assert result["settings"]["objects"] == {name: list(strategies.get(name).objects) for name in strategies.NAMES}
    assert list(tmp_path.iterdir()) == []
    thin = "cylinder:diameter_mm=40,height_mm=240,mass_g=100"
    assert cli.main(["survey", "--trials", "1", "--object", thin, "--strategies", "wrap-vertical", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["settings"]["objects"] == {"wrap-vertical": [thin]}


@pytest.mark.parametrize(
    ("argv", "told"),
    [
        (["--strategies", "juggle"], "unknown strategy 'juggle'; known: wrap-vertical"),
        (
            ["--strategies", "wrap-vertical,"],
            "a strategy's name is empty; allowed: names with commas between them, or all",
        ),
        (["--strategies", "kick, kick"], "the strategy 'kick' is named twice; allowed: each once"),
        (["--trials", "-4"], "--trials is -4; allowed: a whole number from 1 to 100000"),
        (["--trials", "0"], "--trials is 0; allowed: a whole number from 1 to 100000"),
        (["--trials", "100001"], "allowed: a whole number from 1 to 100000"),
        (["--trials", "1e3"], "allowed: a whole number"),
        (["--trials", "99999999999"], "'99999999999' given; allowed: a whole number of at most 10 digits"),
        (["--trails", "3"], "unrecognized arguments: --trails 3; see spiraltrunk survey --help"),
        (["--workers", "0"], "allowed: a whole number from 1 to 64"),
        (["--workers", "65"], "--workers is 65; allowed: a whole number from 1 to 64"),
        (["--seed", "-1"], "allowed: a whole number from 0"),
        (["--object", "banana"], "known: solids and files (cylinder:, "),
        (
            ["--object", "cylinder-120", "--strategies", "pinch"],
            "mm wide where the fingers grip; allowed: 0 to 40 mm, what pinch can",
        ),
        pytest.param(["--object", "cylinder-60"], "what pinch can take", marks=pytest.mark.slow),
        pytest.param(
            ["--object", "sphere:diameter_mm=80,mass_g=9000", "--strategies", "wrap-vertical"],
            "g, what the trunk 'paper' holds at that width",
            marks=pytest.mark.slow,
        ),
        (["--timestep-ms", "3"], "--timestep-ms: '3' given; allowed: 10 ms over a whole number, from 0.1 to 2.5 ms"),
        (["--timestep-ms", "0"], "allowed: 10 ms over a whole number"),
        (["--timestep-ms", "inf"], "allowed: a finite number"),
        (["--shard", "5/4"], "--shard: '5/4' given; allowed: I/N, as 2/16: part I of N, I from 1 to N"),
        (["--shard", "1"], "allowed: I/N, as 2/16"),
        (["--strategies", ","], "a strategy's name is empty; allowed: names with commas between them, or all"),
        (["--merge", "a", "--trials", "5"], "--trials is of no use with --merge, which runs nothing"),
        (["--merge", "a", "--timestep-ms", "2"], "--timestep-ms is of no use with --merge"),
        (["--compare", "a"], "expected 2 arguments"),
        (["--address", "auto"], "--address: 'auto' given; allowed: with --engine ray"),
        (["--engine", "ray", "--address", "auto", "--workers", "2"], "a cluster uses all its processors"),
        (["--engine", "dask"], "invalid choice"),
        (["--compare", "a", "b"], "--compare and --out exclude each other"),
        (["extra"], "unrecognized"),
    ],
)
def test_bad_input_is_refused(argv: list[str], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["survey", "--out", str(tmp_path / "new"), *argv]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    assert told in printed.err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("is_inline", "undrawn")
def test_another_surveys_folder_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    argv = ["survey", "--strategies", "wrap-vertical", "--workers", "1", "--out", str(tmp_path)]
    assert cli.main([*argv, "--trials", "1"]) == 0
    capsys.readouterr()
    assert cli.main([*argv, "--trials", "2"]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"spiraltrunk: error: --out: '{tmp_path}' holds a survey with trials 1, not 2; allowed: ")
    assert said.count("\n") == 1
    assert cli.main(["survey", "--strategies", "wrap-vertical,kick", "--trials", "1", "--out", str(tmp_path)]) == 2
    assert (
        "holds a survey of the strategies wrap-vertical, not wrap-vertical, kick; allowed: " in capsys.readouterr().err
    )


def test_without_ray_its_extra_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    assert cli.main(["survey", "--engine", "ray", "--out", str(tmp_path / "new")]) == 2
    printed = capsys.readouterr()
    assert printed.err == (
        "spiraltrunk: error: the package 'ray' is not installed: pip install 'spiraltrunk[cluster]'\n"
    )
    assert printed.out == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("is_inline", "undrawn")
def test_shards_are_merged_and_surveys_compared(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    argv = ["survey", "--strategies", "wrap-vertical,kick", "--trials", "5", "--workers", "1", "--json"]
    folders = [str(tmp_path / name) for name in ("1", "2", "merged", "whole")]
    for number, folder in enumerate(folders[:2], start=1):
        assert cli.main([*argv, "--shard", f"{number}/2", "--out", folder]) == 0
        shard = json.loads(capsys.readouterr().out)
        assert (shard["settings"]["shard"], shard["asked"], shard["complete"]) == (f"{number}/2", 5, True)
    assert cli.main([*argv, "--out", folders[3]]) == 0
    whole = json.loads(capsys.readouterr().out)
    assert cli.main(["survey", "--merge", *folders[:2], "--out", folders[2], "--json"]) == 0
    merged = json.loads(capsys.readouterr().out)
    assert merged["settings"] == whole["settings"]
    assert (tmp_path / "merged" / "table.md").read_bytes() == (tmp_path / "whole" / "table.md").read_bytes()
    assert cli.main(["survey", "--compare", *folders[2:]]) == 0
    assert "significant at 5 %, corrected by Holm: none" in capsys.readouterr().out
    assert cli.main(["survey", "--compare", *folders[2:], "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["overall"]["pairs"] == 10
    assert cli.main(["survey", "--merge", *folders[:2]]) == 2
    assert "--merge needs --out" in capsys.readouterr().err
    assert cli.main(["survey", "--compare", folders[2], f"{folders[2]}/."]) == 2
    assert "given twice; allowed: folders of two surveys" in capsys.readouterr().err


@pytest.mark.usefixtures("is_inline", "undrawn")
@pytest.mark.parametrize(
    ("number", "code", "last"),
    [
        (signal.SIGINT, 130, "spiraltrunk: interrupted"),
        pytest.param(signal.SIGTERM, 143, "spiraltrunk: terminated", marks=pytest.mark.slow),
    ],
)
def test_a_signal_leaves_what_has_ended(
    number: signal.Signals, code: int, last: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Ctrl-C reaches every process of the terminal, ``kill`` one."""
    out = tmp_path / "out"
    arguments = ("--strategies", "wrap-vertical", "--trials", "6", "--workers", "2", "--json", "--out", str(out))
    running = start("hang_after_third", *arguments)
    assert running.stderr is not None
    for line in running.stderr:
        if line.startswith("spiraltrunk: 3/6"):
            break
    began = time.monotonic()
    (os.killpg if number == signal.SIGINT else os.kill)(running.pid, number)
    printed, said = running.communicate(timeout=30)
    assert time.monotonic() - began < 20, "a trial of a minute was waited for"
    assert (running.returncode, printed) == (code, ""), said
    assert said.splitlines() == [
        f"spiraltrunk: 3 of 6 trials are in {out}; the same command goes on with the rest",
        last,
    ]
    assert is_gone(running.pid)
    held = load(out)
    assert not held["complete"]
    assert [row["index"] for row in held["rows"]] == [0, 1, 2]
    assert cli.main(["survey", *arguments]) == 0
    captured = capsys.readouterr()
    assert captured.err.startswith("spiraltrunk: 3/6 trials are there already\n")
    assert json.loads(captured.out)["strategies"]["wrap-vertical"]["trials"] == 6


@pytest.mark.slow
def test_without_out_an_interrupted_survey_says_that_it_is_lost(
    fakes: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def cut(
        work: Callable[[Entry], Row], entries: list[Entry], workers: int
    ) -> Generator[Outcome[Entry, Row], None, None]:
        yield from itertools.islice(fakes.run_inline(work, entries, workers), 3)
        raise KeyboardInterrupt

    monkeypatch.setattr(engine, "run_jobs", cut)
    assert cli.main(["survey", "--strategies", "wrap-vertical", "--trials", "5", "--workers", "1"]) == 130
    printed = capsys.readouterr()
    assert printed.out == ""
    said = printed.err.splitlines()
    assert said[3].startswith("spiraltrunk: 3/5 ")
    assert said[4:] == [
        "spiraltrunk: 3 of 5 trials are lost, as there is no --out",
        "spiraltrunk: interrupted",
    ]


def test_the_robot_that_was_asked_for_runs_the_trials(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Design and friction reach every trial."""
    tried: list[TrunkDesign] = []

    def run_jobs(work: Callable[[Entry], Row], entries: list[Entry], workers: int) -> Iterator[Outcome[Entry, Row]]:
        monkeypatch.setattr(
            "spiraltrunk.workflows.survey.run_entry.run_scene", lambda design, *_, **__: tried.append(design)
        )
        return (Outcome(job=entry, result=work(entry)) for entry in entries)

    monkeypatch.setattr(engine, "run_jobs", run_jobs)
    mine = replace(presets.PAPER, name="mine")
    write_design(mine, tmp_path / "mine.toml")
    survey = ["survey", "--strategies", "kick", "--trials", "1"]
    assert cli.main([*survey, "--design", str(tmp_path / "mine.toml"), "--friction", "0.15"]) == 0
    assert cli.main(survey) == 0
    assert tried == [replace(mine, cable=replace(mine.cable, friction=0.15)), presets.PAPER]
    assert cli.main([*survey, "--friction", "-0.1"]) == 2
    assert "cable.friction" in capsys.readouterr().err


def test_a_shard_needs_a_folder(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["survey", "--shard", "1/50", "--strategies", "pinch", "--trials", "1"]) == 2
    assert capsys.readouterr().err == (
        "spiraltrunk: error: --shard: given without --out; allowed: --out DIR, where the shard is kept to be merged\n"
    )


def test_trials_that_were_all_refused_are_told_as_such(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    design = write_design(replace(presets.PAPER, gripper=None), tmp_path / "trunk.toml")
    assert cli.main(["survey", "--strategies", "pinch", "--trials", "2", "--design", str(design)]) == 0
    told = "spiraltrunk: pinch: all 2 trials were refused before anything moved, see the reasons"
    assert told in capsys.readouterr().err.splitlines()
