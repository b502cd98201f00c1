"""Any bytes give a log, as far as it is intact, or one line."""

from __future__ import annotations

import io
import json
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zstandard
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.data_stream import RecordBuilder
from mcap.records import Chunk
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.log import load_log, reader
from spiraltrunk.hardware.log.channels import MotorLog, WarningLog
from spiraltrunk.hardware.log.metadata import RECORD, format_metadata

Write = Callable[..., Path]
Build = Callable[..., Any]


def measure_head(data: bytes) -> int:
    """Length of a file's head: magic, header and metadata."""
    file = io.BytesIO(data)
    records = StreamReader(file).records
    next(records), next(records)
    return file.tell()


def load_or_refuse(path: Path) -> np.ndarray:
    """Angles of the log, none where it is refused in one line."""
    message = ""
    try:
        return load_log(path)[MotorLog].angle
    except DriveError as error:
        message = str(error)
    assert message
    assert "\n" not in message
    return np.empty((0, 3))


def test_a_file_cut_anywhere_opens_and_holds_the_begin(write: Write, tmp_path: Path) -> None:
    data, cut = write(20).read_bytes(), tmp_path / "cut.mcap"
    head = measure_head(data)
    found = set()
    for n in range(head, len(data), 23):
        cut.write_bytes(data[:n])
        log = load_log(cut)
        ticks = log[MotorLog].angle[:, 0].tolist() if log[MotorLog].time.size else []
        assert ticks == list(range(len(ticks)))
        assert log.damage is None
        found.add(len(ticks))
    assert found == {0, 20}
    for n in range(0, head, 29):
        cut.write_bytes(data[:n])
        with pytest.raises(DriveError, match="does not begin as a log"):
            load_log(cut)


def test_a_chunk_whose_content_changed_is_damage(forge: Callable[..., Path]) -> None:
    path = forge(b'{"time": 1, "text": "right"}')
    path.write_bytes(path.read_bytes().replace(b"right", b"wrong"))
    log = load_log(path)
    assert (log[WarningLog].text, log.is_complete) == ((), False)
    assert "crc" in str(log.damage)


def test_zeros_after_a_power_failure_end_the_log(write: Write) -> None:
    path = write(20)
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2 + 300] + bytes(5000))
    assert not load_log(path).is_complete


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), min_size=1, max_size=20))
def test_changed_bytes_give_a_log_or_one_line(write: Write, tmp_path: Path, changes: list[tuple[int, int]]) -> None:
    path = tmp_path / "a.mcap"
    if not path.exists():
        write(30)
    data = bytearray(path.read_bytes())
    for place, value in changes:
        data[place % len(data)] = value
    other = tmp_path / "b.mcap"
    other.write_bytes(data)
    ticks = load_or_refuse(other)
    if ticks.size:  # Whole chunks only: their CRC fits.
        assert ticks[:, 0].tolist() == list(range(30))


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.binary(max_size=300))
def test_random_bytes_behind_the_head_give_a_log_or_one_line(write: Write, tmp_path: Path, tail: bytes) -> None:
    path = tmp_path / "a.mcap"
    if not path.exists():
        write(1)
    data = path.read_bytes()
    other = tmp_path / "b.mcap"
    other.write_bytes(data[: measure_head(data)] + tail)
    assert load_or_refuse(other).size == 0
    other.write_bytes(tail)
    with pytest.raises(DriveError, match="does not begin"):
        load_log(other)


@pytest.fixture
def forge(tmp_path: Path, build_metadata: Build) -> Callable[..., Path]:
    """Writes a whole log of warnings with these contents of the messages, whatever they are."""

    def forge(*contents: bytes, topic: str = "/warning", extra: Callable[[Writer], None] | None = None) -> Path:
        path = tmp_path / "forged.mcap"
        with path.open("wb") as file:
            out = Writer(file, compression=CompressionType.NONE)
            out.start()
            out.add_metadata(RECORD, format_metadata(build_metadata()))
            channel = out.register_channel(topic, "json", 0)
            for content in contents:
                out.add_message(channel, 0, content, 0)
            if extra is not None:
                out.flush()
                extra(out)
            out.finish()
        return path

    return forge


def test_an_uncompressed_log_of_a_plain_writer_is_read(forge: Callable[..., Path]) -> None:
    log = load_log(forge(b'{"time": 1, "text": "a", "more": 2}', b'{"time": null, "text": null}'))
    assert log.is_complete
    assert log[WarningLog].text == ("a", None)
    np.testing.assert_array_equal(log[WarningLog].time, [1.0, np.nan])


@pytest.mark.parametrize(
    "content",
    [
        b"", b"\xff", b"[]", b"[" * 100_000, b'{"a":' * 100_000, b'{"time": 1}', b'{"time": 1, "text": 3}',
        b'{"time": "1", "text": "a"}', b'{"time": true, "text": "a"}', b'{"time": [1], "text": "a"}',
        b'{"time": 1e999, "text": "a"}', b'{"time": Infinity, "text": "a"}', b'{"time": ' + b"9" * 5000 + b"}",
        b'{"time": ' + b"9" * 400 + b', "text": "a"}', b'{"time": {}, "text": "a"}', b'{"time": 1, "text": ["a"]}',
    ],
)  # fmt: skip
def test_messages_that_are_none_are_one_line(forge: Callable[..., Path], content: bytes) -> None:
    with pytest.raises(DriveError, match=r"/warning") as caught:
        load_log(forge(b'{"time": 0, "text": ""}', content))
    assert len(str(caught.value)) < 600


@pytest.mark.parametrize(
    "angle", [[[1, 2], [3]], [[1, 2], [1, 2, 3]], [[1, 2], 3], [[[1]], [1]], [["1"], [1]], [[True]]]
)
def test_lists_of_other_shapes_are_one_line(forge: Callable[..., Path], motor_values: Build, angle: list[Any]) -> None:
    contents = [json.dumps({"time": 0.0, **motor_values(0), "angle": one}).encode() for one in angle]
    with pytest.raises(DriveError, match="angle of /motors"):
        load_log(forge(*contents, topic="/motors"))


def test_a_shape_that_changes_late_is_one_line(forge: Callable[..., Path], motor_values: Build) -> None:
    first, other = (json.dumps({"time": 0.0, **motor_values(0), "angle": one}).encode() for one in ([1, 2], [3]))
    with pytest.raises(DriveError, match="angle of /motors"):
        load_log(forge(*[first] * 4096, other, topic="/motors"))


def test_a_log_of_before_lacks_the_torque_that_was_sent(forge: Callable[..., Path], motor_values: Build) -> None:
    """Its other fields are read; a field that it must have is asked for."""
    contents = [{"time": float(k), **motor_values(k)} for k in range(3)]
    for content in contents:
        del content["torque_sent"]
    motors = load_log(forge(*[json.dumps(one).encode() for one in contents], topic="/motors"))[MotorLog]
    assert motors.torque_sent.shape == (3, 0)
    assert motors.torque[:, 0].tolist() == [0.0, 1.0, 2.0]
    del contents[0]["torque"]
    with pytest.raises(DriveError, match="has no torque; allowed:"):
        load_log(forge(json.dumps(contents[0]).encode(), topic="/motors"))


def test_missing_values_are_nan_across_blocks(forge: Callable[..., Path], motor_values: Build) -> None:
    first, other = (json.dumps({"time": 0.0, **motor_values(0), "angle": one}).encode() for one in (None, [3, None]))
    angle = load_log(forge(*[first] * 4096, other, topic="/motors"))[MotorLog].angle
    assert angle.shape == (4097, 2)
    assert np.isnan(angle[:-1]).all()
    np.testing.assert_array_equal(angle[-1], [3, np.nan])


def append_chunk(path: Path, data: bytes, size: int, compression: str) -> None:
    """Replace everything behind the head by one chunk."""
    content = path.read_bytes()
    builder = RecordBuilder()
    Chunk(
        compression=compression, data=data, message_end_time=0, message_start_time=0, uncompressed_crc=zlib.crc32(b""),
        uncompressed_size=size,
    ).write(builder)  # fmt: skip
    path.write_bytes(content[: measure_head(content)] + builder.end())


@pytest.mark.parametrize("says", [100, 10**9, 2**62])
def test_a_chunk_that_unpacks_to_gigabytes_ends_the_log(write: Write, says: int) -> None:
    path = write(1)
    packer = zstandard.ZstdCompressor().compressobj()
    bomb = b"".join(packer.compress(bytes(1 << 24)) for _ in range(8)) + packer.flush()
    append_chunk(path, bomb, says, "zstd")
    log = load_log(path)
    assert not log.is_complete
    assert "a chunk of" in str(log.damage)


@pytest.mark.parametrize("length", [0, 10**6, 2**40, 2**64 - 1])
@pytest.mark.parametrize("opcode", [0, 1, 3, 4, 5, 6, 9, 12, 15, 200])
def test_records_that_say_huge_lengths_end_the_log(write: Write, opcode: int, length: int) -> None:
    path = write(1)
    data = path.read_bytes()
    head = data[: measure_head(data)]
    path.write_bytes(head + bytes([opcode]) + length.to_bytes(8, "little") + b"\xff" * 100)
    assert load_log(path)[MotorLog].time.size == 0


def test_too_large_and_odd_files_are_one_line(write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(DriveError, match="No such file"):
        load_log(tmp_path / "none.mcap")
    with pytest.raises(DriveError, match="folder"):
        load_log(tmp_path)
    with pytest.raises(DriveError, match="null"):
        load_log("a\0b")
    monkeypatch.setattr(reader, "MOST_BYTES", 100)
    with pytest.raises(DriveError, match=r"0\.00 GB; allowed"):
        load_log(write(1))


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("schema", "2"),
        ("is_twin", "1"),
        ("task", "[" * 10_000),
        ("seed", '"a"'),
        ("clock_origin", "null"),
        ("new", "1"),
    ],
)  # fmt: skip
def test_damaged_metadata_are_one_line(tmp_path: Path, build_metadata: Build, name: str, text: str) -> None:
    with (tmp_path / "a.mcap").open("wb") as file:
        out = Writer(file)
        out.start()
        out.add_metadata(RECORD, format_metadata(build_metadata()) | {name: text})
        out.finish()
    with pytest.raises(DriveError, match="of the log"):
        load_log(tmp_path / "a.mcap")


def test_channels_can_be_left_out(write: Write) -> None:
    log = load_log(write(3), ["/warning"])
    assert log.channels.keys() == {"/warning"}
    with pytest.raises(DriveError, match="MotorLog was not read"):
        log[MotorLog]
