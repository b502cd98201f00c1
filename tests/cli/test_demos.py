"""``spiraltrunk demos`` with fake trials: what it prints, what it refuses, and what a signal leaves behind."""

from __future__ import annotations

import importlib
import json
import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import h5py
import pytest

import spiraltrunk.workflows.demos.run_demos as engine
from spiraltrunk import cli

FAKES = Path(__file__).parents[1] / "workflows" / "demos" / "fakes"

DEMOS = """
import functools, sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
import demos_fakes
import spiraltrunk.workflows.demos.run_demos as engine
from spiraltrunk import cli
folder = Path(sys.argv[3]).resolve() / "episodes"
work = functools.partial(getattr(demos_fakes, sys.argv[2]), folder=folder)
engine.run_demos = functools.partial(engine.run_demos, work=work)
sys.exit(cli.main(["demos", *sys.argv[4:], "--out", sys.argv[3]]))
"""
"""The verb with other trials."""

ARGV = ["demos", "wrap-vertical,kick", "--trials", "4", "--workers", "1"]


@pytest.fixture
def fakes(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> ModuleType:
    monkeypatch.syspath_prepend(FAKES)
    fakes = importlib.import_module("demos_fakes")
    work = partial(fakes.work, folder=tmp_path / "out" / "episodes")
    monkeypatch.setattr(engine, "run_demos", partial(engine.run_demos, work=work))
    return fakes


@pytest.mark.usefixtures("fakes")
def test_the_answer_is_the_result(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    argv = [*ARGV, "--out", str(tmp_path / "out"), "--format", "robomimic"]
    assert cli.main([*argv, "--json"]) == 0
    printed = capsys.readouterr()
    result = json.loads(printed.out)
    assert result == json.loads((tmp_path / "out" / "result.json").read_text())
    assert result["complete"]
    assert result["format"] == "robomimic"
    assert set(result["strategies"]) == {"wrap-vertical", "kick"}
    lines = printed.err.splitlines()
    assert all(line.startswith("spiraltrunk: ") for line in lines)
    assert lines[0] == "spiraltrunk: 0/8 trials"
    assert f"spiraltrunk: data set of {result['demonstrations']} demonstrations" in lines
    assert cli.main(argv) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    assert (
        printed.out.splitlines()[-1] == f"{result['demonstrations']} demonstrations (robomimic) in {tmp_path / 'out'}"
    )


@pytest.mark.parametrize(
    ("argv", "told"),
    [
        (["juggle"], "unknown strategy 'juggle'; known: wrap-vertical"),
        (["kick,"], "a strategy's name is empty"),
        (["kick", "--trials", "0"], "--trials is 0; allowed: a whole number from 1 to 100000"),
        (["kick", "--trials", "x"], "allowed: a whole number"),
        (["kick", "--format", "zarr"], "invalid choice: 'zarr'"),
        (["kick", "--workers", "65"], "--workers is 65; allowed: a whole number from 1 to 64"),
        (["kick", "--cameras", "left"], "unknown camera 'left'; known: front, side, top, close"),
        (["kick", "--cameras", "top,top"], "each camera once"),
        (["kick", "--cameras", ""], "allowed: a text that is not empty"),
        (["kick", "--size", "95", "--cameras", "top"], "an even number"),
        (["kick", "--size", "96"], "--size is of no use without --cameras, as it is that of pictures; allowed: both"),
        (["kick,kick"], "the strategy 'kick' is named twice; allowed: each once"),
        (["kick", "--fps", "30"], "--fps is 30; allowed: 1, 2, 5, 10, 25, 50"),
        (["kick", "--mode", "torque"], "unknown control mode 'torque'; known: delta-pose-tension"),
        (["kick", "--object", "banana"], "known: solids and files (cylinder:, "),
        pytest.param(
            ["pinch", "--object", "cylinder-120"],
            "mm wide where the fingers grip; allowed: 0 to 40 mm",
            marks=pytest.mark.slow,
        ),
        (["kick", "--timestep-ms", "3"], "such as 0.5, 1 or 2"),
        (["kick", "--address", "auto"], "allowed: with --engine ray"),
        (["kick", "--shard", "5/4"], "allowed: I/N, as 2/16"),
        (["kick", "--merge", "a", "b"], "STRATEGIES are of no use with --merge"),
        (["kick", "extra"], "unrecognized"),
    ],
)
def test_bad_input_is_refused(argv: list[str], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    usual = ["--trials", "2", "--format", "robomimic", "--out", str(tmp_path / "new")]
    assert cli.main(["demos", argv[0], *usual, *argv[1:]]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    assert told in printed.err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("missing", ["--trials", "--out", "--format"])
def test_what_is_required_is_told(missing: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = {"--trials": "2", "--out": str(tmp_path / "new"), "--format": "minari"}
    argv = [word for option, value in given.items() if option != missing for word in (option, value)]
    assert cli.main(["demos", "kick", *argv]) == 2
    assert missing in capsys.readouterr().err


def test_what_does_not_go_with_merge_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    merge = ["demos", "--merge", "a", "b", "--out", str(tmp_path / "new")]
    for more, told in (
        (["--trials", "3"], "--trials is of no use with --merge"),
        (["--format", "minari"], "--format is of no use with --merge"),
        (["--all"], "--all is of no use with --merge"),
        ([], "'a' cannot be read"),
    ):
        assert cli.main([*merge, *more]) == 2
        assert told in capsys.readouterr().err
    assert not (tmp_path / "new").exists()


@pytest.mark.slow
@pytest.mark.usefixtures("fakes")
def test_shards_are_merged(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*ARGV, "--shard", "1/1", "--format", "minari", "--out", str(tmp_path / "out")]) == 0
    capsys.readouterr()
    assert cli.main(["demos", "--merge", str(tmp_path / "out"), "--out", str(tmp_path / "all"), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["settings"]["shard"] is None
    assert result["complete"]
    assert result["demonstrations"] == len(list((tmp_path / "all" / "episodes").iterdir()))


def test_a_missing_package_names_its_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    argv = ["demos", "kick", "--trials", "1", "--format", "lerobot", "--out", str(tmp_path / "new")]
    assert cli.main(argv) == 2
    printed = capsys.readouterr().err
    assert "pyarrow" in printed
    assert "spiraltrunk[demos]" in printed
    assert not (tmp_path / "new").exists()


def test_another_folder_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "demos.hdf5").write_text("mine")
    assert cli.main(["demos", "kick", "--trials", "1", "--format", "robomimic", "--out", str(tmp_path)]) == 2
    printed = capsys.readouterr().err
    assert printed.count("\n") == 1
    assert "no run of 'demos' wrote it" in printed
    assert (tmp_path / "demos.hdf5").read_text() == "mine"


def start(work: str, folder: Path, *arguments: str) -> subprocess.Popen[str]:
    """Begin the command with Ctrl-C heard, also where the tests run in the background and ignore it."""
    command = [sys.executable, "-c", DEMOS, str(FAKES), work, str(folder), *arguments]
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    pipe = subprocess.PIPE
    try:
        return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, start_new_session=True)
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.slow
def test_ctrl_c_leaves_a_data_set_and_says_how_to_go_on(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    argv = ["kick", "--trials", "9", "--workers", "1", "--format", "robomimic"]
    process = start("hang_after_third", folder, *argv)
    log, end = folder / "trials" / "trials.jsonl", time.monotonic() + 60
    while time.monotonic() < end and not (log.exists() and log.read_text().count("\n") >= 3):
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert out == ""
    assert f"spiraltrunk: 3 of 9 trials are in {folder}; the same command goes on with the rest" in err.splitlines()
    assert err.splitlines()[-1] == "spiraltrunk: interrupted"
    result: dict[str, Any] = json.loads((folder / "result.json").read_text())
    assert (result["demonstrations"], result["trials"], result["complete"]) == (3, 3, False)
    with h5py.File(folder / "demos.hdf5") as file:
        assert list(file["data"]) == ["demo_0", "demo_1", "demo_2"]
    process = start("work", folder, *argv, "--json")
    out, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    assert err.splitlines()[0] == "spiraltrunk: 3/9 trials are there already"
    assert json.loads(out)["complete"]
