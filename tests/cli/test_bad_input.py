"""Whatever is wrong with a command, it says so in one line, exits 2, and writes nothing."""

from __future__ import annotations

from pathlib import Path

import pytest

from spiraltrunk import cli

OPTIONS = ("--m", "--b", "--delta-theta-deg", "--arm-radius-mm", "--turns")
NUMBERS = ("nan", "inf", "-inf", "-1", "0", "1e400", "1e30", "text", "", "1,5", "1_0", "0x10", "\u0663", "1e-300")

BAD = [
    [],
    ["--frobnicate"],
    ["dance"],
    ["design", "extra"],
    ["design", "--preset"],
    ["design", "--preset", "elephant"],
    ["design", "--preset", "paper", "--m", "1.5"],
    ["design", "--m", "1.5", "--b", "0.16"],
    ["design", "--delta-theta-deg", "31"],
    ["design", "--turns", "0.01"],
    ["design", "--turn", "1.5"],
    ["grasp", "juggle"],
    ["grasp", ""],
    ["grasp", "wrap-vertical", "pinch"],
    ["grasp", "--design", "no-such-design"],
    ["grasp", "--design", "."],
    ["grasp", "--design", "/dev/zero"],
    ["grasp", "--seed", "-1"],
    ["grasp", "--seed", "4294967296"],
    ["grasp", "--seed", "1.5"],
    ["grasp", "--seed", "nan"],
    ["grasp", "--seed", "9" * 5000],
    ["grasp", "--seed", "\u0663"],
    ["grasp", "--seed", ""],
    ["grasp", "--object", ""],
    ["grasp", "--object", "banana"],
    ["grasp", "--object", "x" * 100_000],
    ["grasp", "--object", "two\nlines\x1b[31m"],
    ["grasp", "--object", "\udcff"],
    ["grasp", "--object", ":"],
    ["grasp", "--object", "cube:x_mm=10"],
    ["grasp", "--object", "cylinder:"],
    ["grasp", "--object", "cylinder:diameter_mm=60"],
    ["grasp", "--object", "cylinder:diameter_mm=60,diameter_mm=60,height_mm=200,mass_g=10"],
    ["grasp", "--object", "cylinder:diameter_mm=nan,height_mm=200,mass_g=10"],
    ["grasp", "--object", "cylinder:diameter_mm=60,height_mm=inf,mass_g=10"],
    ["grasp", "--object", "cylinder:diameter_mm=60,height_mm=200,mass_g=-1"],
    ["grasp", "--object", "cylinder:diameter_mm=60,height_mm=200,mass_g=1e400"],
    ["grasp", "--object", "cylinder:diameter_mm=0,height_mm=200,mass_g=10"],
    ["grasp", "--object", "sphere:diameter_mm=1e-300,mass_g=10"],
    ["grasp", "--object", "sphere:diameter_mm=80,mass_g=200,colour=red"],
    ["grasp", "--object", "box:x_mm=1,y_mm=1,z_mm=1,mass_g=1e9"],
    ["bench", "more"],
    *(["design", option, number] for option in OPTIONS for number in NUMBERS),
]


def assert_refused(argv: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    code = cli.main(argv)
    printed = capsys.readouterr()
    assert code == 2
    assert printed.out == ""
    assert printed.err.startswith("spiraltrunk: error: ")
    assert printed.err.count("\n") == 1
    assert printed.err.endswith("\n")
    assert len(printed.err) < 900
    assert printed.err[:-1].isprintable()
    return printed.err


@pytest.mark.parametrize("argv", BAD, ids=lambda argv: ascii(" ".join(argv))[1:60] or "nothing")
def test_bad_input_is_refused(
    argv: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    takes_out = argv[:1] in (["design"], ["grasp"], ["bench"])
    assert_refused([*argv, "--json", "--out", "made/here"] if takes_out else argv, capsys)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("verb", ["grasp", "bench"])
def test_out_that_is_a_file_is_refused_before_the_work(
    verb: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    taken = tmp_path / "taken"
    taken.write_text("mine")
    assert_refused([verb, "--out", str(taken)], capsys)
    assert_refused([verb, "--out", str(taken / "below")], capsys)
    assert taken.read_text() == "mine"
    assert list(tmp_path.iterdir()) == [taken]


@pytest.mark.parametrize("name", ["", "x" * 300, "/proc/spiraltrunk", "/dev/null/x"])
def test_out_that_cannot_be_made_is_refused(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert_refused(["grasp", "--out", name], capsys)
    assert_refused(["design", "--out", name], capsys)


def test_design_out_that_is_a_folder_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert_refused(["design", "--out", str(tmp_path)], capsys)
    assert list(tmp_path.iterdir()) == []


def test_broken_design_file_names_its_key(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "trunk.toml"
    assert cli.main(["design", "--out", str(path)]) == 0
    path.write_text(path.read_text().replace("\nb = ", "\nb = -"))
    capsys.readouterr()
    assert "b is -" in assert_refused(["grasp", "--design", str(path)], capsys)


def test_unknown_graphics_is_refused(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("MUJOCO_GL", "crayons")
    assert "MUJOCO_GL is 'crayons'" in assert_refused(["grasp"], capsys)


def test_messages_say_what_is_allowed(capsys: pytest.CaptureFixture[str]) -> None:
    assert "--turns is 20.0; allowed: a finite number, above 0, below 10" in assert_refused(
        ["design", "--turns", "20"], capsys
    )
    assert "whole number from 0 to 4294967295" in assert_refused(["grasp", "--seed", "-3"], capsys)
    assert "wrap-vertical" in assert_refused(["grasp", "juggle"], capsys)
    assert "cylinder-60" in assert_refused(["grasp", "--object", "banana"], capsys)
