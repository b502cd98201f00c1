"""The log of `drive run --out`: where it is while the robot runs, and what stays of it however the run ends."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import pytest

from spiraltrunk import cli
from spiraltrunk.cli.output import open_out
from spiraltrunk.cli.verbs.drive.run_log import add_log, open_run_log
from spiraltrunk.errors import RunError
from spiraltrunk.hardware.log import LogMetadata, LogWriter, load_log
from spiraltrunk.hardware.log.part import name_part
from spiraltrunk.hardware.setup.robot_file import EXAMPLE


def write_log(path: Path) -> None:
    with LogWriter(path, 0.0, LogMetadata(design="", bus="virtual", is_twin=True, seed=3), waits=True) as log:
        log.write("/warning", 0.0, {"text": "first"})


@pytest.fixture(params=["twin", "robot"])
def start(request, monkeypatch, tmp_path):
    """Runs the command, whose robot writes a log and then does what it is told to."""
    robot = tmp_path / "robot.toml"
    robot.write_text(EXAMPLE)
    where = [] if request.param == "twin" else ["--robot", str(robot), "--bus", "robot"]

    def run(out: Path, end: BaseException) -> int:
        def drive(*_: object, log: Path, **__: object) -> None:
            assert log.parent == out, "a program that is killed leaves its log under this name"
            write_log(log)
            raise end

        monkeypatch.setattr("spiraltrunk.workflows.drive.trial.run_on_twin", drive)
        monkeypatch.setattr("spiraltrunk.workflows.drive.hardware_trial.run_on_hardware", drive)
        monkeypatch.setattr(
            "spiraltrunk.workflows.drive.hardware_robot.HardwareRobot", lambda *_, **__: nullcontext(SimpleNamespace())
        )
        return cli.main(["drive", *where, "run", "wrap-vertical", "--no-video", "--out", str(out)])

    return run


@pytest.mark.parametrize(("end", "code"), [(KeyboardInterrupt(), 130), (RunError("the loop ended"), 1)])
def test_a_run_that_ends_early_leaves_its_log_and_the_folder_as_it_was(start, end, code, tmp_path, capsys):
    out = tmp_path / "out"
    with open_out(str(out), "drive") as output, output.draft() as draft:
        (draft / "result.json").write_text("{}")
    for number in (1, 2):
        assert start(out, end) == code
        told = f"the log of the run, up to where it ended, is '{out}/unfinished-{number}.mcap'"
        assert told in capsys.readouterr().err
    assert sorted(path.name for path in out.glob("[!.]*")) == ["result.json", "unfinished-1.mcap", "unfinished-2.mcap"]
    assert load_log(out / "unfinished-1.mcap").is_complete


def test_a_log_of_a_run_that_came_to_its_end_has_its_name_with_all_parts(tmp_path):
    with open_out(str(tmp_path), "drive") as output:
        with open_run_log(output) as path, output.draft() as draft:
            write_log(path)
            name_part(path, 2).write_bytes(b"second")
            add_log(path, draft)
        assert sorted(path.name for path in tmp_path.glob("[!.]*")) == ["drive-0002.mcap", "drive.mcap"]
    assert (tmp_path / "drive-0002.mcap").read_bytes() == b"second"


def test_a_log_stays_where_the_folder_refuses_the_files_of_the_run(tmp_path):
    """As when the program is stopped while files move in."""

    def end() -> None:
        with open_out(str(tmp_path), "drive") as output, open_run_log(output) as path, output.draft() as draft:
            write_log(path)
            add_log(path, draft)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        end()
    assert [path.name for path in tmp_path.glob("[!.]*")] == ["unfinished-1.mcap"]


def test_parts_of_an_unfinished_log_are_not_taken_for_those_of_a_new_one(tmp_path):
    (tmp_path / "unfinished-1-0002.mcap").write_bytes(b"")
    with open_out(str(tmp_path), "drive") as output, open_run_log(output) as path:
        assert path.name == "unfinished-2.mcap"
