"""``spiraltrunk shape``: what it answers, what it means by each pull, and what it refuses."""

from __future__ import annotations

import json
import math
import os
import re
from pathlib import Path

import numpy as np
import pytest

from spiraltrunk import cli
from spiraltrunk.cli.verbs import shape as verb
from spiraltrunk.design.presets import PAPER
from spiraltrunk.model import reference
from spiraltrunk.model.kinematics.shape import Status
from spiraltrunk.model.statics import pull_sequences

KEYS = {"points_m", "joint_angles_deg", "cable_change_m", "cable_tension_n", "status", "status_code", "model"}

AUTHORS = Path(__file__).parents[3] / "shared" / "paper" / "authors_model.json"


def read(typed: str, capsys: pytest.CaptureFixture[str], code: int = 0) -> dict:
    assert cli.main(["shape", *typed.split(), "--json"]) == code, capsys.readouterr().err
    return json.loads(capsys.readouterr().out)


def refuse(typed: str, capsys: pytest.CaptureFixture[str]) -> str:
    assert cli.main(["shape", *typed.split()]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("spiraltrunk: error: ")
    assert printed.err.count("\n") == 1
    return printed.err


@pytest.mark.parametrize(
    ("typed", "expected"),
    [
        ("", lambda: reference.rest(PAPER, math.pi / 2)),
        ("--theta0-deg -45", lambda: reference.rest(PAPER, -math.pi / 4)),
        ("--theta0-deg -4.5e1", lambda: reference.rest(PAPER, -math.pi / 4)),
        ("--dorsal-mm 60", lambda: reference.bend_dorsal(PAPER, 0.06, math.pi / 2)),
        ("--ventral-mm 100 --theta0-deg 45", lambda: reference.bend_ventral(PAPER, 0.1, math.pi / 4)),
        ("--twist-mm 60 30", lambda: reference.twist(PAPER, 0.06, 0.03, math.pi / 2)),
        ("--model statics", lambda: pull_sequences.rest(PAPER)),
        ("--tensions-n 5 0 2", lambda: pull_sequences.pull_tensions(PAPER, [5.0, 0.0, 2.0])),
    ],
)
def test_json_tells_the_model_shape(typed: str, expected: object, capsys: pytest.CaptureFixture[str]) -> None:
    told, shape = read(typed, capsys), expected()
    assert set(told) >= KEYS
    assert np.shape(told["points_m"]) == (18, 3)
    np.testing.assert_array_equal(told["points_m"], shape.points)
    np.testing.assert_allclose(np.radians(told["joint_angles_deg"]), shape.joint_angle, rtol=1e-12)
    np.testing.assert_array_equal(told["cable_change_m"], shape.cable_change)
    assert (told["status"], told["status_code"]) == ("converged", "CONVERGED")
    if shape.forces is None:
        assert (told["model"], told["cable_tension_n"]) == ("reference", None)
    else:
        np.testing.assert_array_equal(told["cable_tension_n"], shape.forces.cable_tension)


@pytest.mark.skipif(not AUTHORS.exists(), reason="the authors' outputs are not here")
def test_the_authors_outputs_come_out(capsys: pytest.CaptureFixture[str]) -> None:
    cases = json.loads(AUTHORS.read_text())["cases"]
    assert len(cases) == 25
    for case in cases:
        *lengths, theta0 = case["args"]
        told = read(f"--{case['call']}-mm {' '.join(map(str, lengths))} --theta0-deg {theta0}", capsys)
        np.testing.assert_allclose(1e3 * np.array(told["points_m"]), case["points_mm"], atol=0.04)


def test_pulls_mean_what_the_help_says(capsys: pytest.CaptureFixture[str]) -> None:
    for typed, cable, expected in (
        ("--dorsal-mm 40 --theta0-deg 45", 0, 0.040),
        ("--ventral-mm 40 --theta0-deg 45", 0, -0.040),
    ):
        rest = read("--model statics --theta0-deg 45", capsys)["cable_change_m"]
        told = read(f"--model statics {typed}", capsys)
        assert told["cable_change_m"][cable] - rest[cable] == pytest.approx(expected, abs=2e-6)
    assert told["cable_change_m"][1] == pytest.approx(told["cable_change_m"][2], abs=1e-6)
    assert told["cable_tension_n"][0] == 0.0
    told = read("--cables-mm 0 20 40", capsys)
    assert told["cable_change_m"][1:] == pytest.approx([0.02, 0.04], abs=1e-6)
    assert told["cable_tension_n"][0] == 0.0
    assert told["cable_change_m"][0] < 0


def test_friction_is_passed_on(capsys: pytest.CaptureFixture[str]) -> None:
    smooth = read("--model statics --dorsal-mm 60", capsys)
    rough = read("--model statics --dorsal-mm 60 --friction 0.1", capsys)
    assert rough["cable_tension_n"][0] > 1.1 * smooth["cable_tension_n"][0]
    assert (smooth["friction"], rough["friction"]) == (0.0, 0.1)


@pytest.mark.parametrize("model", ["reference", "statics"])
def test_cable_that_is_left_over_is_no_failure(model: str, capsys: pytest.CaptureFixture[str]) -> None:
    told = read(f"--model {model} --dorsal-mm 131", capsys)
    assert told["status_code"] in ("ALL_SHUT", "STALLED")
    assert all(told["joint_is_shut"])
    assert "pull less" in told["status"]


def test_not_converged_is_exit_1(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    shape = reference.rest(PAPER, math.pi / 2)
    object.__setattr__(shape, "status", np.array(int(Status.NOT_CONVERGED)))
    monkeypatch.setattr(verb, "solve_load", lambda *given: shape)
    told = read("", capsys, code=1)
    assert told["status_code"] == "NOT_CONVERGED"
    assert len(told["points_m"]) == 18


def test_two_cables(capsys: pytest.CaptureFixture[str]) -> None:
    told = read("spirob-15 --cables-mm 10 0", capsys)
    assert len(told["cable_tension_n"]) == 2
    assert told["design"] == "spirob-15"
    refused = "--cables-mm 1 0 0: 3 numbers given; allowed: 2, one for each cable of 'spirob-15'"
    assert refused in refuse("spirob-15 --cables-mm 1 0 0", capsys)
    assert "allowed for twist: 0, 120 and 240 deg" in refuse("spirob-15 --twist-mm 1 1", capsys)
    assert "three or more" in refuse("spirob-15 --twist-mm 1 1 --model statics", capsys)


def test_table_is_for_people(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["shape", "--model", "statics", "--dorsal-mm", "60"]) == 0
    table = capsys.readouterr().out
    assert "status       converged" in table
    assert re.search(r"cable 1 +60 mm in, 5\.\d+ N", table)
    assert re.search(r"joints shut +1\d-17 of 1-17", table)
    assert "mm" in next(line for line in table.splitlines() if "tip" in line)
    assert cli.main(["shape"]) == 0
    assert "joints shut  none" in capsys.readouterr().out
    assert cli.main(["shape", "spirob-15"]) == 0
    assert re.findall(r"cable \d +(.*)", capsys.readouterr().out) == ["0 mm in", "0 mm in"]


REFUSED = {
    "--dorsal-mm -1": "--dorsal-mm -1: pull is -1 mm; allowed: a finite number, at least 0, at most 131.1",
    "--dorsal-mm 131.2": "--dorsal-mm 131.2: pull is 131.2 mm; allowed: a finite number, at least 0, at most 131.1",
    "--ventral-mm 123": "--ventral-mm 123: lengthening is 123 mm; allowed: a finite number, at least 0, at most 122",
    "--twist-mm 60 -30": "--twist-mm 60 -30: pull_2 is -30 mm; allowed: a finite number, at least 0, at most 131.1",
    "--cables-mm 0 200 0": "--cables-mm 0 200 0: change is 200 mm; allowed: a finite number, at least 0, at most 131.1",
    "--cables-mm 1 2": "--cables-mm 1 2: 2 numbers given; allowed: 3, one for each cable of 'paper'",
    "--tensions-n 61 0 0": "--tensions-n 61 0 0: tension is 61 N; allowed: a finite number, at least 0, at most 60 N",
    "--cables-mm 1 0 spirob-15": "'spirob-15' given; allowed: a finite number, and DESIGN before the option",
    "--tensions-n 1": "--tensions-n 1: 1 number given; allowed: 3, one for each cable of 'paper'",
    "--dorsal-mm nan": "--dorsal-mm: 'nan' given; allowed: a finite number",
    "--dorsal-mm 1e400": "allowed: a finite number",
    "--dorsal-mm 1 --ventral-mm 1": "--dorsal-mm and --ventral-mm given; allowed: one of",
    "--dorsal-mm 0 --tensions-n 1 1 1": "--dorsal-mm and --tensions-n given; allowed: one of",
    "--model reference --cables-mm 1 1 1": "--cables-mm given with --model reference; allowed there: --dorsal-mm",
    "--model reference --tensions-n 1 1 1": "--tensions-n given with --model reference; allowed there: --dorsal-mm",
    "--friction 0.1": "allowed: --model statics",
    "--model statics --friction -0.1": "friction is -0.1; allowed: a finite number, at least 0, below 2",
    "--model magic": "'magic'",
    "--theta0-deg inf": "allowed: a finite number",
    "--theta0-deg 1e300": "--theta0-deg is 1e+300; allowed: a finite number, at least -360, at most 360",
    "--twist-mm 1": "--twist-mm",
    "--plot shape.gif": "--plot: 'shape.gif' given; allowed: a file that ends in .png, .svg, .pdf",
    "no-such-design": "no-such-design",
}
"""What is said of what cannot be."""


@pytest.mark.parametrize("typed", REFUSED)
def test_bad_input_is_one_line(
    typed: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert REFUSED[typed] in refuse(typed, capsys)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("model", ["reference", "statics"])
@pytest.mark.parametrize(
    "typed", ["--dorsal-mm 131.1", "--ventral-mm 122.2", "--twist-mm 131.1 131.1", "--dorsal-mm 0"]
)
def test_the_ends_of_the_ranges_work(model: str, typed: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["shape", "--model", model, "--theta0-deg", "135", *typed.split()]) == 0


@pytest.mark.parametrize("ending", ["png", "svg", pytest.param("pdf", marks=pytest.mark.slow)])
def test_plot_is_written(ending: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "new" / f"shape.{ending}"
    read(f"--dorsal-mm 60 --plot {path}", capsys)
    assert path.read_bytes().startswith({"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[ending])
    assert list(path.parent.iterdir()) == [path]


def test_plot_below_a_file_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    taken = tmp_path / "taken"
    taken.touch()
    assert f"--plot: '{taken}' is a file" in refuse(f"--plot {taken}/shape.png", capsys)


def test_a_plot_that_cannot_be_written_is_named_as_typed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse_all(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied", str(tmp_path / ".draft.png"))

    monkeypatch.setattr(os, "fsync", refuse_all)
    path = tmp_path / "shape.png"
    assert f"--plot: '{path}' cannot be written: Permission denied; allowed: " in refuse(f"--plot {path}", capsys)
    assert list(tmp_path.iterdir()) == []
