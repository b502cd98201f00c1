"""``drive run --camera MODULE:NAME``: a function of the user; what is none is one line, before a port is opened."""

from __future__ import annotations

import pytest

from spiraltrunk import cli
from spiraltrunk.workflows.drive.camera import load_camera

MODULE = """
import numpy as np
from spiraltrunk.control import CameraObservation as Seen
UP = np.array([0.0, 0.0, 1.0])
number = 5
def nothing(time): return None
def good(time): return Seen(time=time - 0.03, position=[0.5, 0, 0], axis=UP)
def text(time): return "cup"
def without(): return None
def breaks(time): raise ValueError("no\\nimage")
def leaves(time): raise SystemExit(4)
def infinite(time): return Seen(time=time, position=np.array([np.inf, 0, 0]), axis=UP)
def long(time): return Seen(time=time, position=UP, axis=2 * UP)
def flat(time): return Seen(time=time, position=UP[:2], axis=UP)
def future(time): return Seen(time=time + 1.0, position=UP, axis=UP)
def timeless(time): return Seen(time=float("nan"), position=UP, axis=UP)
"""

ARM = """
schema = 1
name = "bench"
bus = "board:/dev/absent"
watchdog = "board"
arm = "panda:127.0.0.1"
[motors]
family = "gm6020"
ids = [1, 2, 3]
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", [*__import__("sys").path])
    (tmp_path / "drive_camera_of_a_test.py").write_text(MODULE)
    (tmp_path / "drive_camera_broken.py").write_text("raise RuntimeError('two\\nlines')")
    (tmp_path / "drive_camera_leaving.py").write_text("import sys; sys.exit(3)")
    (tmp_path / "drive_camera_syntax.py").write_text("def (")
    (tmp_path / "robot.toml").write_text(ARM)
    return tmp_path


@pytest.mark.parametrize(
    ("camera", "told"),
    [
        ("look", "camera is 'look'; allowed: MODULE:NAME"),
        (":look", "allowed: MODULE:NAME"),
        ("a:", "allowed: MODULE:NAME"),
        ("a:b.c", "allowed: MODULE:NAME"),
        ("../x:look", "allowed: MODULE:NAME"),
        ("no_such_module_here:look", "cannot be imported: ModuleNotFoundError"),
        ("drive_camera_broken:look", "cannot be imported: RuntimeError"),
        ("drive_camera_leaving:look", "cannot be imported: SystemExit(3)"),
        ("drive_camera_syntax:look", "cannot be imported: SyntaxError"),
        ("drive_camera_of_a_test:absent", "is missing in"),
        ("drive_camera_of_a_test:number", "is no function"),
        ("drive_camera_of_a_test:text", "returned 'cup'; allowed: a CameraObservation or None"),
        ("drive_camera_of_a_test:without", "raised TypeError"),
        ("drive_camera_of_a_test:breaks", "raised ValueError"),
        ("drive_camera_of_a_test:leaves", "raised SystemExit(4)"),
        ("drive_camera_of_a_test:infinite", "position is"),
        ("drive_camera_of_a_test:flat", "allowed: 3 finite numbers"),
        ("drive_camera_of_a_test:long", "axis has length 2; allowed: a unit vector"),
        ("drive_camera_of_a_test:future", "time is 1.0; allowed: up to 0.00 s"),
        ("drive_camera_of_a_test:timeless", "time is nan"),
    ],
)
def test_what_is_no_camera_is_one_line(camera, told, capsys):
    assert cli.main(["drive", "--bus", "robot", "--robot", "robot.toml", "run", "pinch", "--camera", camera]) == 2
    printed = capsys.readouterr()
    assert told in printed.err
    assert (printed.out, printed.err.count("\n")) == ("", 1)


def test_a_robot_without_a_camera_is_told_the_option(capsys):
    assert cli.main(["drive", "--bus", "robot", "--robot", "robot.toml", "run", "pinch"]) == 2
    assert "pinch needs a camera; allowed: --camera MODULE:NAME" in capsys.readouterr().err


def test_with_a_camera_the_ports_are_next(monkeypatch, capsys):
    """After the arm, which is opened first."""
    monkeypatch.setattr("spiraltrunk.workflows.drive.hardware_robot.HardwareRobot._open_arm", lambda self: None)
    camera = ["--camera", "drive_camera_of_a_test:good"]
    assert cli.main(["drive", "--bus", "robot", "--robot", "robot.toml", "run", "kick", *camera]) == 2
    assert "board '/dev/absent' cannot be opened" in capsys.readouterr().err


def test_a_camera_is_loaded_from_the_present_folder():
    seen = load_camera("drive_camera_of_a_test:good")(1.0)
    assert (seen.time, list(seen.position)) == (0.97, [0.5, 0, 0])
    assert load_camera("drive_camera_of_a_test:nothing")(1.0) is None
