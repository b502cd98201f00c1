"""A host that is stopped or killed leaves no torque on the motors: a twin at the other end of a serial line watches.

The host is a process of its own, its board a twin on a pseudo-terminal, so that this is the way of a real robot. What
is asserted is that the torque ends and stays off; the time that it took is printed: a computer under load is late.
"""

from __future__ import annotations

import itertools
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from spiraltrunk.design import presets
from spiraltrunk.design.drum import size_drum
from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.clock import SystemClock
from spiraltrunk.hardware.twin.board import BoardTwin
from spiraltrunk.hardware.twin.board_line import BoardLine
from spiraltrunk.hardware.twin.clock import RealTimeTwin
from spiraltrunk.hardware.twin.device import TwinDevice
from spiraltrunk.hardware.twin.motor import MotorParameters, MotorTwin
from spiraltrunk.hardware.twin.motors import MotorTwins
from spiraltrunk.hardware.twin.trunk.spring_trunk import SpringTrunk

OFF = 1e-3
"""Torque below which a motor is off [N m]."""

BAR = 0.100
"""Time within which the torque must end [s]."""

ATTEMPTS = 3

FAULT = 1
"""Exit code of a host that a fault ended."""

ROBOT = """
schema = 1
name = "twin on a serial line"
bus = "board:{port}"
watchdog = "board"

[motors]
family = "gm6020"
ids = [1, 2, 3]
period_ms = 5
"""


class Recorder(TwinDevice):
    """Notes when a motor had torque last."""

    def __init__(self, motors: MotorTwins) -> None:
        self.motors, self.last_torque = motors, 0.0

    def advance(self, dt: float) -> None:
        if max(abs(motor.torque) for motor in self.motors.motors) > OFF:
            self.last_torque = time.monotonic()


class Host:
    """The command line on a board whose other end is a twin in this process."""

    def __init__(self, folder: Path) -> None:
        design = presets.PAPER
        self.line = BoardLine(SystemClock())
        radius = size_drum(design).winding_radius
        motors = [MotorTwin(MotorParameters(drum_radius=radius, wound=-0.002)) for _ in range(design.n_cable)]
        self.board = BoardTwin()
        twins = MotorTwins(self.line, SpringTrunk(design), motors, board=self.board)
        self.seen = Recorder(twins)
        self.twin = RealTimeTwin(twins, self.seen)
        file = folder / "robot.toml"
        file.write_text(ROBOT.format(port=self.line.port))
        command = ["drive", "--robot", str(file), "--bus", "robot", "pull", "20", "-8", "-8", "--hold-s", "60"]
        before = signal.signal(
            signal.SIGINT, signal.default_int_handler
        )  # Heard also where tests run in the background.
        try:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "spiraltrunk", *command],
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            )
        finally:
            signal.signal(signal.SIGINT, before)

    def __enter__(self) -> Host:
        self.twin.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()
        self.twin.stop()
        self.line.close()

    def wait_for_pull(self) -> bool:
        """Whether the host came to pull."""
        assert self.process.stderr is not None
        is_armed = any(line.strip() == "spiraltrunk: armed" for line in self.process.stderr)
        time.sleep(0.7 if is_armed else 0.0)
        return is_armed and self.process.poll() is None and time.monotonic() - self.seen.last_torque < 0.05


def stop(folder: Path, end: Callable[[Host], None]) -> tuple[Host, float]:
    """The host, ended while it pulled, and the time until no motor had torque [s]."""
    for attempt in itertools.count(1):
        try:
            host = Host(folder)
        except DriveError as error:
            pytest.skip(str(error))
        with host:
            if host.wait_for_pull():
                ended = time.monotonic()
                end(host)
                host.process.wait(60)
                time.sleep(0.3)
                assert time.monotonic() - host.seen.last_torque > 0.1, "torque stays on"
                # A computer under load may be late just then, so that the host ends by a fault before it is ended.
                if host.process.returncode != FAULT or attempt == ATTEMPTS:
                    return host, max(0.0, host.seen.last_torque - ended)
        if attempt == ATTEMPTS:
            pytest.skip(f"this computer is too slow for a twin in real time: {host.process.returncode}")
    raise AssertionError


ENDS = {signal.SIGINT: (130, "interrupted"), signal.SIGTERM: (143, "terminated")}


@pytest.mark.parametrize("number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)])
def test_a_signal_stops_safely(number: signal.Signals, tmp_path: Path) -> None:
    said: list[str] = []

    def end(host: Host) -> None:
        host.process.send_signal(number)
        assert host.process.stderr is not None
        said[:] = host.process.stderr.read().splitlines()

    host, took = stop(tmp_path, end)
    print(*said, sep="\n")
    code, word = ENDS[number]
    assert host.process.returncode == code
    assert said[-1] == f"spiraltrunk: {word}"
    assert len([line for line in said if word in line]) == 1
    print(f"torque off {1e3 * took:.0f} ms after {number.name}; bar {1e3 * BAR:.0f} ms")


@pytest.mark.slow
def test_a_host_that_is_killed_is_survived(tmp_path: Path) -> None:
    host, took = stop(tmp_path, lambda host: host.process.kill())
    assert host.process.returncode == -signal.SIGKILL
    assert not host.board.is_open, "the watchdog has not tripped"
    print(f"torque off {1e3 * took:.0f} ms after SIGKILL; bar {1e3 * BAR:.0f} ms")
