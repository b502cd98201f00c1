"""``drive replay``: figures with units, logs that are cut off or damaged, and the live table."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from rich.console import Console

from spiraltrunk import cli
from spiraltrunk.cli.verbs.drive.live import draw_table, show_robot
from spiraltrunk.design import presets
from spiraltrunk.files.output_folder import open_output
from spiraltrunk.hardware.log import LogMetadata, LogWriter
from spiraltrunk.workflows.drive.twin.twin_robot import TwinRobot

N = 40
SPEED = np.array([0.01, -0.05, 0.02])


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> bytes:
    """A log of cables that move at constant speeds, one message every 20 ms, with a fault at 0.4 s."""
    path = tmp_path_factory.mktemp("log") / "drive.mcap"
    with LogWriter(path, 0.0, LogMetadata(design="", bus="virtual", is_twin=True, seed=3), waits=True) as log:
        for i in range(N):
            time = 0.02 * i
            zeros = ("feedback_time", "angle", "speed", "torque", "torque_sent", "voltage", "felt", "target")
            same = dict.fromkeys(zeros, [0.0] * 3)
            log.write(
                "/motors", time,
                same | {"temperature": [25.0, 25.0 + i, 30.0], "pull": SPEED * time, "tension": [2.0 * i, 1.0, 3.0]},
            )  # fmt: skip
        fault = {"kind": "bus off", "cable": 1, "text": "no frame", "reaction": "torque off"}
        log.write("/fault", 0.4, fault)
        log.write("/state", 0.4, {"mode": "fault", "cause": "bus off"})
    return path.read_bytes()


@pytest.fixture
def replay(tmp_path: Path, capsys):
    """Replays bytes; exit code, standard output and standard error."""

    def replay(data: bytes, *options: str) -> tuple[int, str, str]:
        path = tmp_path / "drive.mcap"
        path.write_bytes(data)
        code = cli.main(["drive", "replay", str(path), *options])
        printed = capsys.readouterr()
        return code, printed.out, printed.err

    return replay


def test_the_figures_have_units_and_the_files_are_named(whole, replay, tmp_path):
    code, out, err = replay(whole, "--out", str(tmp_path / "plots"))
    assert (code, err) == (0, "")
    lines = [" ".join(line.split()) for line in out.splitlines()]
    assert "duration 0.78 s, 0 observations" in lines
    assert "largest tension cable 1: 78.0 N, cable 2: 1.0 N, cable 3: 3.0 N" in lines
    assert "largest speed cable 1: 10 mm/s, cable 2: 50 mm/s, cable 3: 20 mm/s" in lines
    assert "hottest motor 64 degC, of cable 2" in lines
    assert "fault 0.40 s: bus off of cable 2, no frame" in lines
    assert f"file {tmp_path / 'plots' / 'drive.png'}" in lines
    assert (tmp_path / "plots" / "drive.png").stat().st_size > 1000
    told = json.loads(replay(whole, "--json")[1])
    assert told["speed_most_mm_s"] == pytest.approx(1e3 * abs(SPEED))
    assert (told["hottest"], told["files"]) == ({"cable": 2, "temperature_degc": 64.0}, [])


@pytest.mark.slow
def test_a_plot_beside_its_log_leaves_the_run_s_files(whole, tmp_path, capsys):
    run = tmp_path / "run"
    with open_output(run, "drive", ["drive.mcap", "result.json"]) as output, output.draft() as draft:
        (draft / "drive.mcap").write_bytes(whole)
        (draft / "result.json").write_text("{}")
    for _ in range(2):
        assert cli.main(["drive", "replay", str(run / "drive.mcap"), "--out", str(run)]) == 0
        assert capsys.readouterr().err == ""
        assert sorted(path.name for path in run.iterdir()) == [".spiraltrunk", "drive.mcap", "drive.png", "result.json"]
    assert (run / "drive.mcap").read_bytes() == whole


def test_a_log_that_is_cut_off_is_replayed_as_far_as_it_goes(whole, replay):
    code, out, err = replay(whole[:-20])
    assert code == 0
    assert "is cut off" in err
    assert "cut off" in out


def test_a_damaged_log_is_told_and_refused(whole, replay):
    damaged = bytearray(whole)
    damaged[-600:-500] = bytes(100)
    code, out, err = replay(bytes(damaged))
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert f"is damaged after {0.02 * (N - 1):.2f} s" in err
    assert f"{N} messages on the motors were read" in err
    code, out, err = replay(bytes(damaged), "--intact")
    assert code == 0
    assert "damaged" in err
    assert "hottest motor" in out


def test_a_damaged_head_is_no_missing_log(whole, replay):
    damaged = bytearray(whole)
    damaged[12:60] = bytes(48)
    code, out, err = replay(bytes(damaged))
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "is damaged in its head" in err
    assert "does not begin as a log" in replay(b"text" * 50)[2]


@pytest.mark.parametrize("width", [40, 80])
def test_the_live_table_fits_the_terminal(width):
    with TwinRobot(presets.PAPER) as robot:
        robot.listen()
        seen = robot.driver.snapshot()
    cables = [
        replace(cable, pull=-0.1239, tension=58.1, tension_target=60.0, temperature=101.0, feedback_age=1.234)
        for cable in seen.cables
    ]
    text = io.StringIO()
    console = Console(file=text, width=width)
    console.print(draw_table(replace(seen, is_homed=True, time=12345.6, cables=tuple(cables)), width))
    lines = text.getvalue().splitlines()
    assert lines[0] == "safe, 12345.6 s"
    assert "mm" in lines[1]
    assert "N" in lines[1]
    for number, line in enumerate(lines[2:5], start=1):
        assert line.split() == [str(number), "-123.9", "58.1", "60.0", "101", "1234"]
    felt = [replace(cable, felt=5.0, cell_age=0.002) for cable in seen.cables[:2]]
    told = io.StringIO()
    wide = Console(file=told, width=width)
    wide.print(draw_table(replace(seen, cables=(*felt, seen.cables[2])), width))
    assert told.getvalue().splitlines()[5] == "load cells: 1 (2 ms), 2 (2 ms)"
    assert lines[5].startswith("late" if width == 40 else "loop late")
    assert "…" not in text.getvalue()


def test_the_live_table_counts_from_the_start_of_the_command(monkeypatch):
    """The clock of a robot, and of a twin in real time, is the computer's, which counts from its start."""
    monkeypatch.setenv("TERM", "xterm")
    with TwinRobot(presets.PAPER) as twin:
        twin.listen()
        seen = replace(twin.driver.snapshot(), time=3493.6)
    screen = io.StringIO()
    screen.isatty = lambda: True
    robot = SimpleNamespace(clock=SimpleNamespace(now=lambda: 3491.5), watch=None)
    with show_robot(robot, screen):
        robot.watch(SimpleNamespace(snapshot=lambda: seen))
    assert "safe, 2.1 s" in screen.getvalue()
    assert "3493" not in screen.getvalue()
