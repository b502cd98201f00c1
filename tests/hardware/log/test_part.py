"""A long log is several files: the index of each stays short, and together they read as one."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader

from spiraltrunk.errors import DriveError, OutputError
from spiraltrunk.hardware.log import LogWriter, load_log, part, writer
from spiraltrunk.hardware.log.channels import MotorLog, WarningLog
from spiraltrunk.hardware.log.part import LogPart, name_part

Build = Callable[..., Any]
MOST = 5
N_PART = 4


@pytest.fixture
def write_parts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, build_metadata: Build, motor_values: Build
) -> Callable[..., tuple[Path, list[int]]]:
    """Writes messages until `N_PART` parts were begun: the file, and the entries of the index before each commit."""
    monkeypatch.setattr(part, "MOST_CHUNKS", MOST)
    monkeypatch.setattr(writer, "CHUNK_PERIOD", 0.005)
    entries: list[int] = []
    commit = LogPart.commit

    def count(self: LogPart) -> None:
        entries.append(len(self._writer._Writer__chunk_indices))
        commit(self)

    monkeypatch.setattr(LogPart, "commit", count)

    def write(name: str = "a.mcap", **changes: object) -> tuple[Path, list[int]]:
        path, k = tmp_path / name, 0
        with LogWriter(path, 100.0, build_metadata(**changes)) as log:
            while not name_part(path, N_PART).exists():
                log.write("/motors", 100.0 + 0.002 * k, motor_values(k))
                k += 1
                time.sleep(0.002)
        assert log.n_lost == 0
        return path, entries

    return write


def test_parts_are_named_after_the_first() -> None:
    path = Path("out", "drive.mcap")
    assert [name_part(path, k) for k in (1, 2, 30)] == [
        path, Path("out", "drive-0002.mcap"), Path("out", "drive-0030.mcap"),
    ]  # fmt: skip


def test_the_index_in_memory_stays_short_however_long_the_log(write_parts: Build) -> None:
    _, entries = write_parts()
    assert len(entries) > N_PART * MOST / 2
    assert max(entries) <= MOST + 1


def test_parts_read_as_one_log(write_parts: Build) -> None:
    path, _ = write_parts()
    log = load_log(path)
    ticks = log[MotorLog].angle[:, 0]
    assert (log.is_complete, log.damage) == (True, None)
    assert ticks.tolist() == list(range(len(ticks)))
    assert log[MotorLog].time[-1] == pytest.approx(100.0 + 0.002 * (len(ticks) - 1))
    alone = load_log(name_part(path, 2))[MotorLog].angle[:, 0].tolist()
    assert alone == list(range(int(alone[0]), int(alone[-1]) + 1))
    assert 0 < alone[0] < alone[-1] < ticks[-1]


def test_every_part_is_a_whole_file_for_other_readers(write_parts: Build) -> None:
    path, _ = write_parts()
    for number in range(1, N_PART + 1):
        with name_part(path, number).open("rb") as file:
            summary = make_reader(file, validate_crcs=True).get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert len(summary.chunk_indexes) == summary.statistics.chunk_count


def test_a_part_without_end_and_one_that_is_missing_are_told(write_parts: Build, tmp_path: Path) -> None:
    path, _ = write_parts()
    second = name_part(path, 2)
    data = second.read_bytes()
    second.write_bytes(data[: len(data) * 3 // 4])
    log = load_log(path)
    assert (log.is_complete, log.damage) == (False, "part 2 has no end")
    name_part(path, 4).unlink()
    name_part(path, 3).unlink()
    assert (load_log(path).is_complete, load_log(path).damage) == (False, None), "as after a kill"


def test_a_log_without_its_last_part_is_told(write_parts: Build) -> None:
    path, _ = write_parts()
    name_part(path, N_PART).unlink()
    log = load_log(path)
    assert (log.is_complete, log.damage) == (False, "the log ends without its last part")
    ticks = log[MotorLog].angle[:, 0]
    assert ticks.tolist() == list(range(len(ticks))), "what is there is read"
    for number in (2, 3):
        name_part(path, number).unlink()
    assert load_log(path).damage == "the log ends without its last part"


def test_a_log_that_does_not_say_whether_it_ends_is_read(write_parts: Build, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(part, "format_end", lambda is_last: {})
    path, _ = write_parts()
    name_part(path, N_PART).unlink()
    assert (load_log(path).is_complete, load_log(path).damage) == (True, None)


def test_a_part_of_another_log_is_refused(write_parts: Build) -> None:
    path, _ = write_parts()
    other, _ = write_parts("b.mcap", seed=7)
    name_part(path, 3).write_bytes(name_part(other, 3).read_bytes())
    with pytest.raises(DriveError, match=r"a-0003\.mcap'?: it belongs to another log"):
        load_log(path)


def test_a_log_is_refused_beside_a_part_of_an_old_one(tmp_path: Path, build_metadata: Build) -> None:
    (tmp_path / "a-0002.mcap").write_bytes(b"mine")
    with pytest.raises(OutputError, match=r"a-0002\.mcap' exists; allowed: a new file"):
        LogWriter(tmp_path / "a.mcap", 0.0, build_metadata())
    assert [one.name for one in tmp_path.iterdir()] == ["a-0002.mcap"]


def test_a_disc_without_room_for_the_next_part_is_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, build_metadata: Build
) -> None:
    monkeypatch.setattr(part, "MOST_CHUNKS", 1)
    monkeypatch.setattr(writer, "CHUNK_PERIOD", 0.005)
    tried: list[Path] = []
    make = part.create_log

    def refuse(path: Path, head: bytes) -> int:
        tried.append(path)
        if 1 < len(tried) < 4:
            raise OutputError("no room")
        return make(path, head)

    monkeypatch.setattr(part, "create_log", refuse)
    path = tmp_path / "a.mcap"
    with caplog.at_level(logging.WARNING), LogWriter(path, 0.0, build_metadata()) as log:
        end = time.monotonic() + 60.0
        for k in range(10_000):
            log.write("/warning", float(k), {"text": str(k)})
            if name_part(path, 2).exists():
                break
            assert time.monotonic() < end
            time.sleep(0.005)
    assert log.n_lost == 0
    assert [one.name for one in tried[:4]] == ["a.mcap", *["a-0002.mcap"] * 3]
    assert [record.message for record in caplog.records] == [
        "the log is not written as it should be (no room); control goes on"
    ]
    assert load_log(path)[WarningLog].text == tuple(str(i) for i in range(k + 1))
