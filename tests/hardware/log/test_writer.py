"""A log is written whole, replaces nothing, and never holds up the control loop."""

from __future__ import annotations

import errno
import json
import logging
import os
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader

from spiraltrunk.errors import DriveError, OutputError
from spiraltrunk.hardware.arm.arm_port import ArmState
from spiraltrunk.hardware.log import LogWriter, load_log, part, writer
from spiraltrunk.hardware.log.channels import CHANNELS, ArmLog, FaultLog, MotorLog, StateLog, WarningLog
from spiraltrunk.hardware.log.recording import log_arm, log_fault, log_motors, log_state, log_warning
from spiraltrunk.hardware.motors.motor_port import MotorState
from spiraltrunk.hardware.safety.fault import Fault, FaultKind

PATIENCE = 60.0

Write = Callable[..., Path]
Build = Callable[..., Any]


def wait_for(holds: Callable[[], bool]) -> None:
    end = time.monotonic() + PATIENCE
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.01)


def fake_disc(monkeypatch: pytest.MonkeyPatch, write: Callable[[int, bytes], int]) -> None:
    """Let the log's thread write with another function."""
    monkeypatch.setattr(part, "os", SimpleNamespace(write=write, fsync=os.fsync, close=os.close))


def test_numbers_come_back_exactly(tmp_path: Path, build_metadata: Build) -> None:
    state = MotorState(time=99.9, angle=np.pi, speed=-1e-300, torque=0.1 + 0.2, temperature=41.0, voltage=None)
    fault = Fault(kind=FaultKind.STALL, time=101.0, cable=2, text="4 N; allowed: 3 N")
    joints = np.array([1 / 3, np.nan])
    with LogWriter(tmp_path / "a.mcap", 100.0, build_metadata()) as log:
        log_motors(
            log, 100.5, (state, None), sent=[0.25, 0], pull=[1e-3, -0.0], tension=[np.inf, 2.0], felt=[None, 2.0],
            target=(3, 4),
        )  # fmt: skip
        log_arm(
            log, ArmState(time=100.6, position=joints, velocity=joints, acceleration=joints, torque=joints, error="é")
        )
        log_state(log, 100.7, "armed")
        log_fault(log, fault, "torque off")
        log_warning(log, 102.0, "1 % of the frames are lost")
    read = load_log(tmp_path / "a.mcap")
    motors, arm, faults = read[MotorLog], read[ArmLog], read[FaultLog]
    assert read.is_complete
    assert motors.time.tolist() == [100.5]
    np.testing.assert_array_equal(motors.angle, [[np.pi, np.nan]])
    np.testing.assert_array_equal(motors.speed, [[-1e-300, np.nan]])
    np.testing.assert_array_equal(motors.torque, [[0.1 + 0.2, np.nan]])
    np.testing.assert_array_equal(motors.torque_sent, [[0.25, 0.0]])
    np.testing.assert_array_equal(motors.voltage, [[np.nan, np.nan]])
    np.testing.assert_array_equal(motors.tension, [[np.nan, 2.0]])
    np.testing.assert_array_equal(motors.felt, [[np.nan, 2.0]])
    np.testing.assert_array_equal(motors.target, [[3.0, 4.0]])
    np.testing.assert_array_equal(arm.position, [joints])
    assert arm.error == ("é",)
    assert (read[StateLog].mode, read[StateLog].cause) == (("armed",), (None,))
    assert (faults.kind, faults.cable.tolist(), faults.reaction) == (("stall",), [2.0], ("torque off",))
    assert faults.time.tolist() == [101.0]
    assert read[WarningLog].text == ("1 % of the frames are lost",)


def test_metadata_come_back(write: Write, build_metadata: Build) -> None:
    changes = {"seed": 3, "versions": {"numpy": "2"}, "provenance": "drive run", "wall_start": 10**18, "bus": "can0"}
    read = load_log(write(1, **changes)).metadata
    assert read == build_metadata(**changes, clock_origin=100.0)


def test_other_readers_find_index_schema_and_wall_clock(write: Write) -> None:
    with write(5, wall_start=10**18).open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        messages = list(reader.iter_messages())
    assert summary.statistics.message_count == 5
    assert summary.chunk_indexes
    for k, (schema, channel, message) in enumerate(messages):
        assert (channel.topic, channel.message_encoding, schema.encoding) == ("/motors", "json", "jsonschema")
        assert message.log_time == 10**18 + 2_000_000 * k
        said, values = json.loads(schema.data), json.loads(message.data)
        assert said["type"] == "object"
        assert said["properties"].keys() == values.keys()
    assert "[N m]" in said["description"]


@pytest.mark.parametrize("topic", CHANNELS)
def test_every_channel_can_be_read_empty(write: Write, topic: str) -> None:
    messages = load_log(write(0)).channels[topic]
    assert type(messages) is CHANNELS[topic]
    assert len(messages.time) == 0


def test_an_existing_file_is_never_replaced(tmp_path: Path, write: Write) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(b"mine")
    with pytest.raises(OutputError, match=r"exists; allowed: a new file"):
        write()
    assert [one.name for one in tmp_path.iterdir()] == ["a.mcap"]
    assert path.read_bytes() == b"mine"


def test_a_folder_that_is_missing_is_one_line(write: Write) -> None:
    with pytest.raises(OutputError, match=r"cannot be made: No such file"):
        write(name="none/a.mcap")


def test_without_hard_links_nothing_is_replaced_either(
    tmp_path: Path, write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    def link(*_: object) -> None:
        raise PermissionError(errno.EPERM, "no links")

    monkeypatch.setattr(os, "link", link)
    assert load_log(write(3)).is_complete
    with pytest.raises(OutputError, match="exists"):
        write(3)
    assert [one.name for one in tmp_path.iterdir()] == ["a.mcap"]


def test_messages_are_on_the_disc_while_the_log_is_open(tmp_path: Path, build_metadata: Build) -> None:
    path = tmp_path / "a.mcap"
    with LogWriter(path, 0.0, build_metadata()) as log:
        log.write("/warning", 1.0, {"text": "seen"})
        wait_for(lambda: load_log(path)[WarningLog].text == ("seen",))
        assert not load_log(path).is_complete
    assert load_log(path).is_complete


def test_a_full_disc_is_warned_of_once_and_made_up_for(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    build_metadata: Build,
    motor_values: Build,
) -> None:
    refusals = []

    def write(descriptor: int, data: bytes) -> int:
        if len(refusals) < 4:
            refusals.append(len(data))
            if len(refusals) % 2:  # Part of a chunk fits, then nothing.
                return os.write(descriptor, data[: len(data) // 3])
            raise OSError(errno.ENOSPC, "No space left on device")
        return os.write(descriptor, data)

    fake_disc(monkeypatch, write)
    with caplog.at_level(logging.WARNING), LogWriter(tmp_path / "a.mcap", 0.0, build_metadata()) as log:
        for k in range(50):
            log.write("/motors", 0.002 * k, motor_values(k))
        wait_for(lambda: len(refusals) == 4)
    assert log.n_lost == 0
    assert [record.message for record in caplog.records] == [
        "the log is not written as it should be (No space left on device); control goes on"
    ]
    read = load_log(tmp_path / "a.mcap")
    assert read.is_complete
    assert read[MotorLog].angle[:, 0].tolist() == list(range(50))


def test_a_disc_that_stays_full_leaves_a_log_that_opens(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    build_metadata: Build,
    motor_values: Build,
) -> None:
    def write(_: int, __: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    fake_disc(monkeypatch, write)
    with caplog.at_level(logging.WARNING), LogWriter(tmp_path / "a.mcap", 0.0, build_metadata()) as log:
        for k in range(50):
            log.write("/motors", 0.002 * k, motor_values(k))
    assert log.n_lost == 50
    assert len(caplog.records) == 1
    read = load_log(tmp_path / "a.mcap")
    assert (read.is_complete, read.damage, read[MotorLog].time.size) == (False, None, 0)


def test_a_disc_that_hangs_holds_nothing_up_and_loss_is_counted(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    build_metadata: Build,
    motor_values: Build,
) -> None:
    hangs, goes_on = threading.Event(), threading.Event()

    def write(descriptor: int, data: bytes) -> int:
        hangs.set()
        assert goes_on.wait(PATIENCE)
        return os.write(descriptor, data)

    fake_disc(monkeypatch, write)
    monkeypatch.setattr(writer, "MOST_QUEUED", 10)
    with caplog.at_level(logging.WARNING), LogWriter(tmp_path / "a.mcap", 0.0, build_metadata()) as log:
        log.write("/motors", 0.0, motor_values(0))
        assert hangs.wait(PATIENCE)
        for k in range(1, 31):  # Returns, though the disc hangs.
            log.write("/motors", 0.002 * k, motor_values(k))
        assert log.n_lost == 20
        goes_on.set()
    assert len(caplog.records) == 1
    read = load_log(tmp_path / "a.mcap")
    assert read[MotorLog].angle[:, 0].tolist() == list(range(11))
    assert read[WarningLog].text == ("20 messages of the log are lost so far",)


def test_a_log_that_waits_loses_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, build_metadata: Build, motor_values: Build
) -> None:
    monkeypatch.setattr(writer, "MOST_QUEUED", 10)
    with LogWriter(tmp_path / "a.mcap", 0.0, build_metadata(), waits=True) as log:
        for k in range(200):
            log.write("/motors", 0.002 * k, motor_values(k))
    assert load_log(tmp_path / "a.mcap")[MotorLog].angle[:, 0].tolist() == list(range(200))


@pytest.mark.parametrize(
    "message",
    [(np.nan, {"text": "a"}), (1e30, {"text": "a"}), (1.0, {"text": object()}), (1.0, {}), (1.0, {"text": "", "b": 1})],
)
def test_what_cannot_be_written_is_counted(
    tmp_path: Path,
    message: tuple[float, dict[str, object]],
    caplog: pytest.LogCaptureFixture,
    build_metadata: Build,
    motor_values: Build,
) -> None:
    with caplog.at_level(logging.WARNING), LogWriter(tmp_path / "a.mcap", 0.0, build_metadata()) as log:
        log.write("/warning", *message)
        log.write("/motors", 1.0, motor_values(1))
    assert log.n_lost == 1
    assert len(caplog.records) == 1
    assert load_log(tmp_path / "a.mcap")[MotorLog].time.tolist() == [1.0]


def test_unknown_channels_and_closed_logs_are_refused(
    tmp_path: Path, build_metadata: Build, motor_values: Build
) -> None:
    with LogWriter(tmp_path / "a.mcap", 0.0, build_metadata()) as log, pytest.raises(DriveError, match="/motors"):
        log.write("/none", 0.0, {})
    log.close()
    with pytest.raises(DriveError, match="a log that is open"):
        log.write("/motors", 0.0, motor_values(0))


@pytest.mark.parametrize("origin", [np.nan, np.inf, "a", [1.0]])
def test_an_origin_of_the_clock_that_is_none_is_one_line(tmp_path: Path, build_metadata: Build, origin: object) -> None:
    with pytest.raises(DriveError, match="clock_origin of the log"):
        LogWriter(tmp_path / "a.mcap", origin, build_metadata())
    assert list(tmp_path.iterdir()) == []
