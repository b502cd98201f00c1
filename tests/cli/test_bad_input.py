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
    ["design", "--arm-radius-mm", "301", "--b", "0.03"],
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
    for folder in (f"{tmp_path}", f"{tmp_path}/new/"):
        said = assert_refused(["design", "--out", folder], capsys)
        assert said == f"spiraltrunk: error: --out: '{folder}' is a folder; allowed: a file, existing or new\n"
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


TOLD = {
    "--m 1e308": "--m is 1e308; allowed: a finite number, at least 0.2, at most 10",
    "--m 999999": "--m is 999999; allowed: a finite number, at least 0.2, at most 10",
    "--m 1e-5": "--m is 1e-5; allowed: a finite number, at least 0.2, at most 10",
    "--b 2e-6": "--b is 2e-6; allowed: a finite number, at least 0.03, at most 0.6",
    "--b 1.99": "--b is 1.99; allowed: a finite number, at least 0.03, at most 0.6",
    "--turns 1e-9": "--turns is 1e-9; allowed: a finite number, at least 0.75, at most 5",
    "--turns 1.51": "--turns is 1.51; allowed: whole sections of 30 deg, such as 1.5 (18 sections) or 1.58333333 "
    "(19 sections)",
    "--arm-radius-mm 0.002": "--arm-radius-mm is 0.002; allowed: a finite number, at least 1, at most 300",
    "--delta-theta-deg 2.5": "--delta-theta-deg is 2.5; allowed: a finite number, at least 2.7, below 90",
    "--delta-theta-deg 31": "--delta-theta-deg is 31 deg; allowed: an angle that divides 540 deg into whole sections, "
    "such as 31.7647059 deg (17 sections), 30 deg (18 sections)",
    "--m 1 --b 0.1": "--m and --b given; allowed: one of them, as m = 1 / (exp(pi b) - 1)",
    "--b 0.6 --turns 5": "--b 0.6 --turns 5: width of the tip is 8.13e-07 mm; allowed: at least 0.1 mm: fewer turns or "
    "sections, a smaller b (larger m) or a wider base",
}
"""What is said of options that no trunk can be made of."""


@pytest.mark.parametrize("typed", TOLD)
def test_a_refused_wish_is_told_as_it_was_typed(typed: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert assert_refused(["design", *typed.split()], capsys) == f"spiraltrunk: error: {TOLD[typed]}\n"


@pytest.mark.parametrize(
    ("option", "ends"),
    [
        ("--m", ("0.2", "10")),
        ("--b", ("0.03", "0.6")),
        ("--turns", ("0.75", "5")),
        ("--arm-radius-mm", ("1", "300")),
        ("--delta-theta-deg", ("2.7", "77.1428571", "31.7647059")),
    ],
)
def test_the_ends_of_the_ranges_that_are_told_work(
    option: str, ends: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    for end in ends:
        assert cli.main(["design", option, end]) == 0, capsys.readouterr().err


HELD = {
    "cylinder:diameter_mm=300,height_mm=100,mass_g=10": "is 300 mm wide; allowed: 32.7 to 267.9 mm, what wrap",
    "sphere:diameter_mm=20,mass_g=10": "is 20 mm wide; allowed: 32.7 to 267.9 mm, what wrap-vertical can take",
    "sphere:diameter_mm=80,mass_g=9000": "g, what the trunk 'paper' holds at that width",
    "sphere:diameter_mm=1,mass_g=1": "object.diameter_mm is 1; allowed: a finite number, at least 5, below 1000",
    "sphere:diameter_mm=80,mass_g=1e6": "object.mass_g is 1e6; allowed: a finite number, at least 1, below 20000",
    "sphere:diameter_mm=80": "object is without mass_g; allowed: sphere:diameter_mm=,mass_g=",
}
"""What is said of objects that the paper's trunk on its arm cannot hold."""


@pytest.mark.parametrize("name", HELD)
def test_an_object_that_cannot_be_held_is_refused_before_the_trial(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = assert_refused(["grasp", "--object", name, "--out", str(tmp_path / "new")], capsys)
    assert HELD[name] in said
    assert "reach" not in said
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("width", "depth", "is_told"), [(30, 60, True), (50, 90, False)])
def test_a_refusal_tells_that_a_strategy_lays_down_what_it_takes_standing(
    width: int, depth: int, is_told: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    said = assert_refused(["grasp", "pinch", "--object", f"box:x_mm={width},y_mm={depth},z_mm=95,mass_g=150"], capsys)
    assert ("pinch lays it down, pose=upright keeps it standing" in said) == is_told


def test_the_default_object_is_checked_as_well(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "small.toml"
    assert cli.main(["design", "--arm-radius-mm", "8", "--out", str(path)]) == 0
    capsys.readouterr()
    said = assert_refused(["grasp", "--design", str(path)], capsys)
    assert "--object: 'cylinder-60' is 60 mm wide; allowed: 6 to 48.6 mm" in said


def test_out_that_is_a_file_is_told_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    taken = tmp_path / "taken"
    taken.touch()
    for argv in (
        ["grasp", "--out", str(taken)],
        ["bench", "--out", str(taken / "x")],
        ["design", "--out", f"{taken}/x"],
    ):
        said = assert_refused(argv, capsys)
        assert said == f"spiraltrunk: error: --out: '{taken}' is a file; allowed: a folder, existing or new\n"


def test_design_and_grasp_make_missing_folders(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["design", "--out", str(tmp_path / "deep" / "down" / "trunk.toml")]) == 0
    assert (tmp_path / "deep" / "down" / "trunk.toml").exists()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name = 'x'\n[spiral]\nb = 0.16\na_mm = -1\n",
         "spiral.a_mm is -1.0; allowed: a finite number, above 0, below 1e+06\n"),
        ("name = 'x'\n[spiral]\nb = 0.16\na_mm = 26\ndelta_theta_deg = 91\n",
         "spiral.delta_theta_deg is 91.0; allowed: a finite number, above 0, below 90\n"),
        ("[spiral]\nb = 0.16\na_mm = 26\n", "name is missing; allowed: the key name, a text\n"),
        ("x = [", "a file of valid TOML; Invalid value (at end of document)\n"),
    ],
)  # fmt: skip
def test_a_refused_file_is_told_as_it_was_typed(
    text: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "trunk.toml"
    path.write_text(text)
    assert assert_refused(["grasp", "--design", str(path)], capsys).endswith(message)


def test_messages_say_what_is_allowed(capsys: pytest.CaptureFixture[str]) -> None:
    assert "--turns is 20; allowed: a finite number, at least 0.75, at most 5\n" in assert_refused(
        ["design", "--turns", "20"], capsys
    )
    assert "whole number from 0 to 4294967295" in assert_refused(["grasp", "--seed", "-3"], capsys)
    assert "wrap-vertical" in assert_refused(["grasp", "juggle"], capsys)
    assert "cylinder-60" in assert_refused(["grasp", "--object", "cylinder"], capsys)


def test_a_bottle_is_measured_where_the_strategy_takes_it() -> None:
    """A neck of 28 mm is within the fingers' 40 mm, a body of 65 mm is not."""
    from spiraltrunk import strategies
    from spiraltrunk.cli.object_check import check_object
    from spiraltrunk.cli.output import UsageError
    from spiraltrunk.design.presets import PAPER
    from spiraltrunk.sim.objects.catalogue import parse_object

    bottle = "bottle:diameter_mm=65,height_mm=210,neck_mm=28,mass_g=200"
    check_object(strategies.get("tip-grip"), PAPER, parse_object(bottle), bottle)
    wide = bottle.replace("neck_mm=28", "neck_mm=44")
    with pytest.raises(
        UsageError, match=r"is 4[0-9.]+ mm wide where the fingers grip; allowed: 0 to 40 mm, what tip-grip"
    ):
        check_object(strategies.get("tip-grip"), PAPER, parse_object(wide), wide)


@pytest.mark.parametrize("most", [1, pytest.param(99, marks=pytest.mark.slow)])
def test_what_the_model_holds_impossible_is_told_before_it_is_tried(
    most: int, capsys: pytest.CaptureFixture[str]
) -> None:
    """The usual objects of a strategy are not: the first of each, or all."""
    from spiraltrunk import strategies
    from spiraltrunk.cli.object_check import warn_infeasible
    from spiraltrunk.design.presets import PAPER
    from spiraltrunk.sim.objects.catalogue import parse_object

    squat = parse_object("cylinder:diameter_mm=110,height_mm=118,mass_g=200")
    warn_infeasible(strategies.get("wrap-oblique"), PAPER, squat)
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("spiraltrunk: wrap-oblique is expected to fail: too short for its width: 118 mm tall;")
    assert line.endswith("; it is tried all the same")
    for name in strategies.NAMES:
        for usual in strategies.get(name).objects[:most]:
            warn_infeasible(strategies.get(name), PAPER, parse_object(usual))
    assert capsys.readouterr().err == ""


def test_what_has_no_plan_is_refused_without_a_promise_to_try_it(capsys: pytest.CaptureFixture[str]) -> None:
    flat = "box:x_mm=150,y_mm=220,z_mm=30,mass_g=500"
    told = assert_refused(["grasp", "wrap-oblique", "--object", flat, "--no-video"], capsys)
    assert "error: wrap-oblique: the object is 30 mm tall; allowed: 71 mm or more, to clear the ground" in told
    assert "tried all the same" not in told


@pytest.mark.parametrize(
    ("line", "strategy", "told"),
    [
        ("angles_deg = [90.0, 270.0]", "wrap-vertical", "wrap-vertical: no cable pulls ventral; allowed: a design"),
        ("angles_deg = [0.0, 5.0]", "wrap-horizontal", "wrap-horizontal: no cable pulls ventral; allowed: a design"),
        ("a_mm = 261.3", "auto", "auto: trunk and fingers are 5.09 m long; allowed: up to 1.20 m, to hang above"),
        ("a_mm = 9000.0", "auto", "length of the trunk is 174 m; allowed: at most 10 m in simulation"),
        ("n_section = 200", "auto", "length of the trunk is 2.72e+06 m; allowed: at most 10 m in simulation"),
    ],
)  # fmt: skip
def test_a_trunk_that_cannot_grasp_is_refused_in_one_line(
    line: str, strategy: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from spiraltrunk.design import format_design
    from spiraltrunk.design.presets import PAPER

    key = line.partition("=")[0]
    lines = [each for each in format_design(PAPER).splitlines() if not each.startswith("sections_g")]
    path = tmp_path / "trunk.toml"
    path.write_text("\n".join(line if each.startswith(key) else each for each in lines) + "\n")
    assert cli.main(["grasp", strategy, "--object", "cylinder-60", "--design", str(path)]) == 2
    *warned, said = capsys.readouterr().err.splitlines()
    assert said.startswith("spiraltrunk: error: ")
    assert told in said
    assert all("rated for 3: its torques are checked" in each for each in warned)


def test_a_trunk_without_fingers_is_told_as_such(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from dataclasses import replace

    from spiraltrunk.design import write_design
    from spiraltrunk.design.presets import PAPER

    path = write_design(replace(PAPER, gripper=None), tmp_path / "trunk.toml")
    told = assert_refused(["grasp", "pinch", "--object", "rod-10", "--design", str(path)], capsys)
    assert (
        "'rod-10' cannot be taken by pinch: the trunk 'paper' has no gripper; allowed: a design with a gripper" in told
    )
