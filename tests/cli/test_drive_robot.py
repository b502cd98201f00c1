"""Robots, buses, poses and ports on the command line: what cannot be is one line and exit code 2."""

from __future__ import annotations

import errno
import json
import math
import os
from argparse import Namespace
from contextlib import nullcontext
from pathlib import Path

import pytest

from spiraltrunk import cli
from spiraltrunk.cli.verbs.drive.figures import format_figure
from spiraltrunk.cli.verbs.drive.move_check import MoveSettings, read_move, warn_short_steps
from spiraltrunk.design import presets
from spiraltrunk.hardware.setup.robot_file import EXAMPLE
from spiraltrunk.hardware.twin.load_cells import LoadCellTwin


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    path = tmp_path / "robot.toml"
    path.write_text(EXAMPLE.replace("panda:192.168.1.2", "none"))
    return path


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--bus", "can0", "status"], "--bus is 'can0'; allowed: virtual; robot"),
        (["--bus", "socketcan:", "status"], "allowed"),
        (["--bus", "board:/dev/absent", "status"], "cannot be opened"),
        (["--bus", "robot", "status"], "--bus robot given without --robot; allowed: --robot FILE"),
        (["--bus", "virtual:x", "--real-time", "status"], "--real-time given with --bus 'virtual:x'; allowed: with"),
        (["--bus", "virtual:x", "selftest"], "allowed: virtual, the twin"),
        (["--bus", "virtual:x", "run", "wrap-vertical"], "the robot has no arm"),
        (["--robot", "absent.toml", "status"], "robot is 'absent.toml'; allowed: a robot file in TOML; No such file"),
        (["pose", "curled"], "known: none yet, `drive pose NAME --save MM MM MM`, with the length"),
        (["pose", "curled", "--poses", "/dev/zero"], "no regular file; allowed: a file of poses"),
        (["pose", "curled", "--poses", "."], "this is a folder; allowed: a file of poses"),
        (["pose", "curled", "--save", "1", "0", "0", "--poses", "/dev/null"], "this is no regular file"),
        (["jog", "1", "5", "--save", "x" * 100], "name of a pose is"),
        (["jog", "1", "5", "--save", "curled", "--poses", "/dev/zero"], "no regular file"),
        (["pose", "curled", "--save", "10"], "1 length given; allowed: 3"),
        (["pose", "curled", "--save", "1e9", "0", "0"], "cable 1: 1e+09 mm; allowed: -133 to 143 mm"),
        (["pose", "curled", "--save", "nan", "0", "0"], "allowed: a finite number"),
        (["jog", "1", "5", "--gamepad"], "a cable and a length and --gamepad given; allowed: a cable"),
        (["jog", "1", "--gamepad"], "a cable and --gamepad given; allowed:"),
        (["jog", "--gamepad", "--hold-s", "2"], "--hold-s and --gamepad given; allowed: --hold-s with a cable and a"),
        (["jog", "1"], "a cable given without a length; allowed:"),
        (["jog"], "neither a cable nor --gamepad given; allowed: a cable and a length to wind in, or --gamepad alone"),
        (["selftest", "--only", "foo"], "unknown fault 'foo'; known: frame_loss_1_percent, "),
        (["jog", "4", "5"], "cable is 4; allowed: 1 to 3"),
        (["cells"], "no load cells given; allowed: --robot FILE with a table [load_cells]"),
    ],
)
def test_bad_input_is_one_line(arguments, says, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["drive", *arguments]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert says in printed.err
    assert len(printed.err.splitlines()) == 1
    assert "Errno" not in printed.err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("given", "wrong"),
    [("ids = [1, 2, 3]", "ids = [1, 1, 3]"), ("ids = [1, 2, 3]", "ids = [1, 2]"), ("30.0", "nan"), ("30.0", "61.0"),
     ("schema = 1", "schema = 2"), ("directions = [1, 1, -1]", "directions = [1, 1, 7]"),
     ("ids = [1, 2, 3]", "ids = [1, [2], 3]"), ("ids = [1, 2, 3]", f"ids = {'[' * 2000}{']' * 2000}"),
     ("30.0", "1" + "0" * 5000), ("30.0", "-1e300"), ("speed_max", "tension_floor_n = 1e-300\nspeed_max")],
)  # fmt: skip
def test_a_wrong_robot_file_is_one_line_even_on_the_twin(given, wrong, robot, capsys):
    robot.write_text(EXAMPLE.replace(given, wrong, 1))
    assert cli.main(["drive", "--robot", str(robot), "status"]) == 2
    told = capsys.readouterr().err
    assert len(told.splitlines()) == 1
    assert "robot.toml" in told
    assert not any(word in told for word in ("recursion", "set_int_max", "array of 3"))


def test_the_load_cells_of_the_file_are_on_the_twin_and_in_the_status(robot, capsys):
    assert cli.main(["drive", "--robot", str(robot), "status"]) == 0
    table = capsys.readouterr().out.splitlines()
    assert "load cell [N]" in table[2]
    assert all(abs(float(line.split()[-1])) < 1.0 for line in table[4:7])
    for three, one in (
        ("cables = [1, 2, 3]", "cables = [3]"),
        ("[0.4, -0.1, 0.0]", "[0.4]"),
        ("[1.0, 1.0, -1.0]", "[-1.0]"),
    ):
        robot.write_text(robot.read_text().replace(three, one))
    assert cli.main(["drive", "--robot", str(robot), "status", "--json"]) == 0
    cables = json.loads(capsys.readouterr().out)["cables"]
    assert [cable["load_cell_n"] is None for cable in cables] == [True, True, False]
    assert [cable["load_cell_age_ms"] is None for cable in cables] == [True, True, False]
    assert cables[2]["load_cell_age_ms"] < 10.0


@pytest.mark.parametrize("strategy", ["pinch", "tip-grip", "flip-grip", "sweep"])
def test_a_strategy_that_needs_the_gripper_is_refused_before_a_port_is_opened(strategy, tmp_path, monkeypatch, capsys):
    file = tmp_path / "robot.toml"
    file.write_text(EXAMPLE[: EXAMPLE.index("[servo]")])
    monkeypatch.setattr("spiraltrunk.workflows.drive.camera.load_camera", lambda text: lambda time: None)
    command = ["drive", "--robot", str(file), "--bus", "robot", "run", strategy, "--camera", "a:b"]
    assert cli.main(command) == 2
    told = f"{strategy} needs the gripper; allowed: a table [servo] in the file of --robot"
    assert told in capsys.readouterr().err


def test_a_file_that_fits_is_taken_on_the_twin(robot, capsys):
    assert cli.main(["drive", "--robot", str(robot), "status", "--json"]) == 0
    state = json.loads(capsys.readouterr().out)
    assert set(state["lateness_ms"]) == {"p50", "p99", "p999", "n_period"}


def test_a_bus_without_motors_is_told_and_not_armed(capsys):
    assert cli.main(["drive", "--bus", "virtual:nobody", "home"]) == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert "no watchdog is present" in said
    assert "no feedback has come" in said


def test_poses_are_saved_and_reached(tmp_path, capsys):
    file = ["--poses", str(tmp_path / "poses.json")]
    assert cli.main(["drive", "pose", "curled", "--save", "15", "-5", "-5", *file]) == 0
    capsys.readouterr()
    assert cli.main(["drive", "pose", "curled", "--hold-s", "0.2", *file, "--json"]) == 0
    pulls = [cable["pull_mm"] for cable in json.loads(capsys.readouterr().out)["cables"]]
    assert pulls[0] > 8.0
    assert max(pulls[1:]) < 0.0


def test_ports_open_nothing_unless_a_bus_is_named(monkeypatch, capsys):
    from spiraltrunk.hardware.setup import ports

    for name in ("open_can_bus", "open_board", "discover"):
        monkeypatch.setattr(ports, name, lambda *_, **__: pytest.fail("a port was opened"))
    assert cli.main(["drive", "ports", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["bus"], found["ids"]) == (None, None)


@pytest.mark.parametrize(
    "arguments",
    [
        ["spirob-15", "ports"],
        ["spirob-15", "--bus", "virtual", "ports"],
        ["--seed", "1", "spirob-15", "--bus", "virtual", "ports"],
        ["spirob-15", "--real-time", "--seed", "1", "ports"],
    ],
)
def test_options_may_stand_between_the_design_and_the_action(monkeypatch, arguments):
    seen = []
    monkeypatch.setattr("spiraltrunk.cli.verbs.drive.poses._ports", lambda given: seen.append(given) or (0, ""))
    assert cli.main(["drive", *arguments]) == 0
    assert [(given.design, given.bus) for given in seen] == [("spirob-15", "virtual")]


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["jog", "1", "5", "--tension-n", "-1"], "--tension-n is -1; allowed: 0 to 60"),
        (["jog", "1", "5", "--tension-n", "1e300"], "--tension-n is 1e+300"),
        (["jog", "1", "5", "--speed-mm-s", "1e-9"], "--speed-mm-s is 1e-09; allowed: 0.1 to 300"),
        (["jog", "1", "5", "--speed-mm-s", "1e9"], "--speed-mm-s is 1e+09"),
        (["jog", "1", "5", "--hold-s", "-1"], "--hold-s is -1"),
        (["jog", "1", "1e300"], "cable 1: 1e+300 mm; allowed: -133 to 143 mm"),
        (["jog", "1", "144"], "cable 1: 144 mm; allowed: -133 to 143 mm, what its drum winds"),
        (["jog", "1", "-1.34e2"], "cable 1: -134 mm; allowed: -133 to 143 mm"),
        (["jog", "4", "5"], "cable is 4; allowed: 1 to 3"),
        (["pull", "500", "0", "0"], "cable 1: 500 mm; allowed"),
        (["pull", "1", "2"], "2 lengths given; allowed: 3"),
        (["pull", "1", "2", "3", "--speed-mm-s", "0"], "--speed-mm-s is 0"),
    ],
)
def test_bad_moves_are_refused_before_a_robot_is_there(monkeypatch, capsys, arguments, told):
    def open_nothing(*_, **__):
        raise AssertionError("a robot was opened")

    monkeypatch.setattr("spiraltrunk.cli.verbs.drive.actions.open_robot", open_nothing)
    assert cli.main(["drive", *arguments]) == 2
    line = capsys.readouterr().err
    assert told in line
    assert line.count("\n") == 1


def test_a_limit_of_the_robot_file_holds_for_moves(monkeypatch, robot, capsys):
    """30 N and 100 mm/s of the file; the design's and the drive's own are 60 N and 300 mm/s."""
    for module in ("actions", "poses"):
        monkeypatch.setattr(f"spiraltrunk.cli.verbs.drive.{module}.open_robot", lambda *_, **__: pytest.fail("opened"))
    for action in (["pull", "40", "0", "0"], ["jog", "1", "5"], ["pose", "x"], ["protocol", "paper", "bend-dorsal"]):
        for option, value, allowed in (
            ("--tension-n", "31", "--tension-n is 31; allowed: 0 to 30 N, the tension_max_n of "),
            ("--speed-mm-s", "101", "--speed-mm-s is 101; allowed: 0.1 to 100 mm/s, the speed_max_mm_s of "),
        ):
            assert cli.main(["drive", "--robot", str(robot), *action, option, value]) == 2
            line = capsys.readouterr().err
            assert allowed in line
            assert line.count("\n") == 1


def test_the_speed_of_the_gamepad_is_that_of_the_robot_file_or_of_the_option(robot, monkeypatch, capsys):
    speeds = []

    def jog(*_, speed, **__):
        speeds.append(speed)
        return "stop button"

    monkeypatch.setattr("spiraltrunk.hardware.gamepad.Gamepad", lambda number: nullcontext())
    monkeypatch.setattr("spiraltrunk.workflows.drive.gamepad_jog.jog_with_gamepad", jog)
    monkeypatch.setattr("spiraltrunk.workflows.drive.robot.Robot.prepare", lambda self: None)
    robot.write_text(robot.read_text().replace("s = 100.0", "s = 15.0"))
    for options in ([], ["--robot", str(robot)]):
        for speed in ([], ["--speed-mm-s", "8"]):
            assert cli.main(["drive", *options, "jog", "--gamepad", *speed]) == 0
    assert speeds == [0.02, 0.008, 0.015, 0.008]
    assert cli.main(["drive", "--robot", str(robot), "jog", "--gamepad", "--speed-mm-s", "16"]) == 2


def test_a_move_without_options_keeps_the_limits_of_the_robot_file(robot):
    given = Namespace(robot=None, tension_n=None, speed_mm_s=None, hold_s=1.0)
    assert read_move(given, presets.PAPER) == MoveSettings(tension=20.0, speed=0.02, hold=1.0)
    given.robot = str(robot)
    assert read_move(given, presets.PAPER) == MoveSettings(tension=20.0, speed=0.02, hold=1.0)
    robot.write_text(EXAMPLE.replace("tension_max_n = 30.0", "tension_max_n = 10.0").replace("s = 100.0", "s = 15.0"))
    assert read_move(given, presets.PAPER) == MoveSettings(tension=10.0, speed=0.015, hold=1.0)
    given.tension_n, given.speed_mm_s = 10.0, 15.0
    assert read_move(given, presets.PAPER) == MoveSettings(tension=10.0, speed=0.015, hold=1.0)


def test_a_file_of_poses_that_cannot_be_written_is_told_before_anything_moves(monkeypatch, tmp_path, capsys):
    def refuse(place):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(place))

    monkeypatch.setattr("spiraltrunk.files.atomic.acquire_lock", refuse)
    monkeypatch.setattr("spiraltrunk.cli.verbs.drive.actions.open_robot", lambda *_, **__: pytest.fail("opened"))
    for way in (["1", "5"], ["--gamepad"]):
        poses = str(tmp_path / "new" / "poses.json")
        assert cli.main(["drive", "jog", *way, "--save", "x", "--poses", poses]) == 2
        line = capsys.readouterr().err
        assert "poses.json' cannot be written: Read-only file system; allowed: a file in a folder" in line
        assert line.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


PROTOCOL = """
name = "short"
[[run]]
name = "bend"
kind = "bend-dorsal"
tilt_deg = 0
steps = 1
step_mm = 50
[[run]]
name = "rest"
kind = "rest"
tilt_deg = 0
"""


@pytest.fixture
def held(monkeypatch):
    """The twin, whose cable 1 no pull winds in by more than 44.3 mm."""
    from spiraltrunk.workflows.drive.robot import Robot

    at = [0.0, 0.0, 0.0]

    def pull_to(self, pulls, **_):
        at[:] = [min(pull, 0.0443) if pull == pull else -0.0 for pull in pulls]

    monkeypatch.setattr(Robot, "prepare", lambda self: None)
    monkeypatch.setattr(Robot, "pull_to", pull_to)
    monkeypatch.setattr(Robot, "read_pulls", lambda self: list(at))
    monkeypatch.setattr(Robot, "compute_pulls", lambda self, _: list(at))


def test_a_protocol_names_the_cable_and_the_step_that_missed_its_target_most(held, tmp_path, capsys):
    """The exit code is that of `pull`, which ends short in the same way."""
    protocol = tmp_path / "protocol.toml"
    protocol.write_text(PROTOCOL)
    code = cli.main(["drive", "protocol", str(protocol), "bend"])
    printed = capsys.readouterr()
    told = [line.partition("spiraltrunk: ")[2] for line in printed.err.splitlines() if "target" in line]
    cause = "the tension is at its limit, or friction holds it"
    assert told == [f"cable 1 ended 1 of 2 steps away from its target, most in step 2, 5.7 mm at 44.3 mm: {cause}"]
    assert printed.out.startswith("2 steps, pulls within 5.70 mm of their targets")
    assert "-0.0" not in printed.out
    assert cli.main(["drive", "pull", "50", "0", "0"]) == code == 0
    assert f"cable 1 ended at 44.3 mm, 5.7 mm from its target: {cause}" in capsys.readouterr().err


def test_slack_is_compensated_by_the_protocol_or_by_the_robot_file(held, robot, tmp_path, monkeypatch, capsys):
    protocol = tmp_path / "protocol.toml"
    protocol.write_text(PROTOCOL.replace("[[run]]", "slack_mm = [4.0, 0.0, 0.0]\n[[run]]", 1))
    command = ["drive", "--robot", str(robot), "protocol", str(protocol), "bend"]
    with monkeypatch.context() as patch:
        patch.setattr("spiraltrunk.cli.verbs.drive.actions.open_robot", lambda *_, **__: pytest.fail("opened"))
        assert cli.main(command) == 2
    told = capsys.readouterr().err
    assert "slack_mm is set in the protocol and " in told
    assert "and would be compensated twice; allowed: in one of the two" in told
    assert told.count("\n") == 1
    robot.write_text(robot.read_text().replace("slack_mm = [2.0, 1.5, 1.5]", "slack_mm = [0.0, 0.0, 0.0]"))
    assert cli.main(command) == 0
    protocol.write_text(PROTOCOL)
    robot.write_text(EXAMPLE)
    assert cli.main(command) == 0


def test_a_protocol_at_its_targets_warns_of_nothing(capsys):
    free = math.nan
    warn_short_steps([{"target_mm": [5.0, free], "pull_mm": [5.0 + away, -9.0]} for away in (0.0, 0.4, -0.4)])
    assert capsys.readouterr().err == ""
    warn_short_steps([{"target_mm": [5.0, free], "pull_mm": [5.0 + away, -9.0]} for away in (0.6, -3.0, 0.1)])
    told = capsys.readouterr().err
    assert "cable 1 ended 2 of 3 steps away from its target, most in step 2, 3.0 mm at 2.0 mm: " in told
    assert "cable 2" not in told


def test_a_run_of_a_protocol_that_does_not_exist_opens_nothing(tmp_path, monkeypatch, capsys):
    protocol = tmp_path / "protocol.toml"
    protocol.write_text(PROTOCOL)
    monkeypatch.setattr("spiraltrunk.cli.verbs.drive.actions.open_robot", lambda *_, **__: pytest.fail("opened"))
    for run, says in (("bned", "unknown run 'bned'; known: bend, rest"), ("bend", "cannot do")):
        assert cli.main(["drive", "protocol", str(protocol), run]) == 2
        assert says in capsys.readouterr().err
        protocol.write_text(PROTOCOL.replace("step_mm = 50", "step_mm = 500"))


@pytest.mark.parametrize("way", [["1", "5"], ["--gamepad"]])
def test_cables_are_let_go_before_a_pose_is_saved(way, monkeypatch, tmp_path):
    """The driver calls a command stale 40 ms after the last one, and writing a file may take longer."""
    from spiraltrunk.hardware.driver.trunk_driver import TrunkDriver
    from spiraltrunk.workflows.drive.robot import Robot

    done = []
    monkeypatch.setattr("spiraltrunk.hardware.gamepad.Gamepad", lambda number: nullcontext())
    monkeypatch.setattr("spiraltrunk.workflows.drive.gamepad_jog.jog_with_gamepad", lambda *_, **__: "stop button")
    monkeypatch.setattr("spiraltrunk.cli.verbs.drive.actions.save_pose", lambda *_: done.append("saved"))
    monkeypatch.setattr(Robot, "prepare", lambda self: None)
    monkeypatch.setattr(Robot, "pull_to", lambda self, pulls, **_: None)
    monkeypatch.setattr(Robot, "finish", lambda self: done.append("let go") or self.driver.snapshot())
    monkeypatch.setattr(TrunkDriver, "stop", lambda self: done.append("stopped"))
    assert cli.main(["drive", "jog", *way, "--save", "x", "--poses", str(tmp_path / "poses.json")]) == 0
    assert done[:2] == ["stopped" if way == ["--gamepad"] else "let go", "saved"]


def test_a_run_that_pulls_at_no_cable_ends_without_a_distance(held, tmp_path, capsys):
    protocol = tmp_path / "protocol.toml"
    protocol.write_text(PROTOCOL)
    assert cli.main(["drive", "protocol", str(protocol), "rest"]) == 0
    assert capsys.readouterr().out.startswith("1 step, all cables free")


@pytest.mark.parametrize(
    ("figure", "shown"), [(-0.0, "0.0"), (-0.04, "0.0"), (-0.06, "-0.1"), (2.5, "2.5"), (math.nan, "-")]
)
def test_a_zero_has_no_sign(figure, shown):
    assert format_figure(figure, 1) == shown


@pytest.mark.slow
def test_a_move_that_ends_short_is_told(capsys):
    assert cli.main(["drive", "jog", "1", "60", "--tension-n", "5", "--hold-s", "0.2"]) == 0
    assert "mm from its target" in capsys.readouterr().err


def test_a_negative_length_may_be_written_with_an_exponent(held, capsys):
    assert cli.main(["drive", "pull", "-1e1", "0", "0", "--hold-s", "0.1", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["bus"] == "virtual"


def test_the_seed_may_stand_behind_the_action(capsys):
    assert cli.main(["drive", "status", "--seed", "7", "--json"]) == 0
    assert '"mode": "safe"' in capsys.readouterr().out


CELLS = """
[load_cells]
port = "cells"
cables = [3, 1]
offsets_n = [0.0, -1.5]
scales = [-0.5, 1.0]
"""


@pytest.fixture
def celled(robot):
    text = robot.read_text()
    robot.write_text((text[: text.index("[load_cells]")] if "[load_cells]" in text else text) + CELLS)
    return str(robot)


def test_zeros_of_load_cells_are_what_they_read_with_slack_cables(celled, capsys):
    assert cli.main(["drive", "--robot", celled, "cells"]) == 0
    printed = capsys.readouterr().out
    assert printed.splitlines()[-4:-2] == ["[load_cells]", "cables = [3, 1]"]
    assert cli.main(["drive", "--robot", celled, "cells", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["reading_n"] == told["offsets_n"] == pytest.approx([0.0, -1.5], abs=0.02)
    assert told["scales"] == [-0.5, 1.0]


@pytest.mark.parametrize("held", [12.0, 25.0])
def test_a_known_mass_gives_the_scale_of_its_cell_whatever_the_file_says(celled, held, monkeypatch, capsys):
    """The twin's cell of cable 1 reads -1.5 N and the true tension; 2.4 kg that read 12 N more are a scale of 1.96."""
    build = LoadCellTwin.__init__

    def hang(self, settings, read_tensions, **options):
        build(self, settings, lambda: (held, 0.0, 0.0), **options)

    monkeypatch.setattr(LoadCellTwin, "__init__", hang)
    assert cli.main(["drive", "--robot", celled, "cells", "--cable", "1", "--mass-kg", "2.4", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["offsets_n"] == [0.0, -1.5]
    assert told["scales"] == [-0.5, pytest.approx(2.4 * 9.80665 / held, rel=2e-3)]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--cable", "1"], "--cable and --mass-kg belong together"),
        (["--mass-kg", "1"], "--cable and --mass-kg belong together"),
        (["--cable", "2", "--mass-kg", "1"], "--cable is 2; allowed, with a load cell: 3, 1"),
        (["--cable", "1", "--mass-kg", "0"], "mass is 0.0; allowed: "),
        (["--cable", "1", "--mass-kg", "1e3"], "mass is 1000.0; allowed: "),
        (["--cable", "1", "--mass-kg", "nan"], "allowed: a finite number"),
        (["--cable", "1", "--mass-kg", "1"], "N with 1 kg and -1.50 N without; allowed: at least 1 N apart"),
    ],
)
def test_a_calibration_that_cannot_be_is_one_line(celled, arguments, says, capsys):
    assert cli.main(["drive", "--robot", celled, "cells", *arguments]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert says in printed.err.splitlines()[-1]


def test_a_bus_without_motors_is_told(capsys):
    assert cli.main(["drive", "--bus", "virtual:nobody", "status"]) == 0
    printed = capsys.readouterr().out
    assert "no feedback of motor 1, 2, 3" in printed
    assert "nan" not in printed
    assert "(p50/p99/p99.9)" in printed
