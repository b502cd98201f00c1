"""Reader of logs, whole ones and those that a crash cut off."""

from __future__ import annotations

import json
import os
import struct
import zlib
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple, TypeVar, cast, final

from spiraltrunk.errors import DriveError, MissingPackage, describe
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.files.text_lines import check_regular
from spiraltrunk.hardware.log.channels import CHANNELS
from spiraltrunk.hardware.log.columns import Columns
from spiraltrunk.hardware.log.metadata import END_RECORD, RECORD, LogMetadata, parse_end, parse_metadata
from spiraltrunk.hardware.log.part import name_part

if TYPE_CHECKING:
    from mcap.records import Chunk, McapRecord

MOST_BYTES = 4_000_000_000
"""Largest log that is read [bytes] (ours)."""

_MOST_RECORD = 64_000_000
"""Largest record, and largest chunk once decompressed [bytes] (ours): chunks that are written have about 1 MB."""

_Channel = TypeVar("_Channel")


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Log:
    """What a log holds."""

    metadata: LogMetadata
    """What ran, on what, from which versions."""
    is_complete: bool
    """Whether the log was closed; else it ends where its process was killed, or at the damage."""
    damage: str | None
    """What is wrong behind the last message that was read; None where the file ends there."""
    channels: dict[str, Any]
    """Messages of each channel that was read, in order of arrival, as its dataclass in `CHANNELS`."""

    def __getitem__(self, kind: type[_Channel]) -> _Channel:
        """Messages of the channel with this dataclass.

        Raises:
            DriveError: where it was not read.
        """
        for messages in self.channels.values():
            if type(messages) is kind:
                return messages
        raise DriveError(f"{kind.__name__} was not read; allowed: a channel of {', '.join(self.channels)}")


def load_log(path: str | Path, channels: Collection[str] = tuple(CHANNELS)) -> Log:
    """Read a log as far as it is intact, with the parts that follow its file, see `part`.

    Args:
        path: the file; a later part alone is read alone.
        channels: topics to read, of `CHANNELS`; others are left out.

    Raises:
        DriveError: where it is no log of this package, too large, or cannot be read.
        MissingPackage: where mcap is not installed.
    """
    columns = {topic: Columns(topic) for topic in CHANNELS if topic in channels}
    whole, size = _read_file(Path(path), columns, MOST_BYTES)
    number = 2
    while whole.damage is None and (file := name_part(Path(path), number)).exists():
        part, part_size = _read_file(file, columns, MOST_BYTES - size)
        if part.metadata != whole.metadata:
            raise DriveError(f"log {describe(str(file))}: it belongs to another log; allowed: parts of one log")
        damage = part.damage if whole.is_complete else f"part {number - 1} has no end"
        whole, size, number = part._replace(damage=damage), size + part_size, number + 1
    if whole.damage is None and whole.is_complete and whole.is_last is False:
        whole = whole._replace(damage="the log ends without its last part")
    try:
        read = {topic: column.build() for topic, column in columns.items()}
    except DriveError as error:
        raise DriveError(f"log {describe(str(path))}: {error}") from None
    is_complete = whole.is_complete and whole.damage is None
    return Log(metadata=whole.metadata, is_complete=is_complete, damage=whole.damage, channels=read)


@final
class _Read(NamedTuple):
    """What one file holds beside its messages."""

    metadata: LogMetadata
    is_complete: bool
    damage: str | None
    is_last: bool | None
    """Whether it says that it ends the log; None where it does not say so."""


def _read_file(path: Path, columns: dict[str, Columns], most: int) -> tuple[_Read, int]:
    """Add the messages of one file to the columns; also its size [bytes], of at most ``most``.

    Raises:
        DriveError: where it is no log of this package, too large, or cannot be read.
    """
    try:
        check_regular(path)
        with path.open("rb") as file:
            size = os.fstat(file.fileno()).st_size
            if size > most:
                raise DriveError(f"it has {size / 1e9:.2f} GB; allowed: at most {MOST_BYTES / 1e9:g} GB")
            return _read(_WholeReads(file, size), columns), size
    except DriveError as error:
        raise DriveError(f"log {describe(str(path))}: {error}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise DriveError(f"log {describe(str(path))}: {reason}; allowed: a log of `spiraltrunk drive`") from None


@final
class _EndOfFile(Exception):
    """The file ends within a record."""


@final
class _WholeReads:
    """A stream whose reads give all bytes asked for, and make no room for more than the file has."""

    def __init__(self, file: BinaryIO, size: int) -> None:
        self._file, self._left = file, size

    def read(self, n: int) -> bytes:
        if n > self._left:
            raise _EndOfFile
        self._left -= n
        return self._file.read(n)


def _read(stream: _WholeReads, columns: dict[str, Columns]) -> _Read:
    records = _iterate_records(stream)
    metadata, is_complete, damage, is_last = _read_head(records), False, None, None
    topics: dict[int, str | None] = {}
    from mcap.records import Channel, Footer, Message, Metadata

    while True:
        try:
            record = next(records)
        except (_EndOfFile, StopIteration):
            break
        except _DAMAGE as error:
            damage = f"bytes that are no log: {describe(str(error))}"
            break
        if isinstance(record, Channel):
            topics[record.id] = record.topic if record.topic in columns else None
        elif isinstance(record, Message):
            if (topic := topics.get(record.channel_id)) is not None:
                columns[topic].add(_parse(record.data, topic))
        elif isinstance(record, Metadata) and record.name == END_RECORD:
            is_last = parse_end(record.metadata)
        elif isinstance(record, Footer):
            is_complete = True
    return _Read(metadata, is_complete, damage, is_last)


_DAMAGE = (ValueError, struct.error, MemoryError, OverflowError, RecursionError, TypeError, zlib.error)
"""What mcap raises for bytes that are no MCAP; its own errors become a ValueError."""


def _read_head(records: Iterator[McapRecord]) -> LogMetadata:
    """Metadata, which follow the header.

    Raises:
        DriveError: where the file does not begin as a log of this package.
    """
    from mcap.records import Header, Metadata

    try:
        header, record = next(records), next(records)
        if isinstance(header, Header) and isinstance(record, Metadata) and record.name == RECORD:
            return parse_metadata(record.metadata)
    except (_EndOfFile, StopIteration, *_DAMAGE):
        pass
    raise DriveError("it does not begin as a log; allowed: an MCAP file as `spiraltrunk drive` writes it") from None


def _iterate_records(stream: _WholeReads) -> Iterator[McapRecord]:
    """Records in order, those in chunks too.

    Raises:
        _EndOfFile: where the file ends within a record.
        ValueError: and others of `_DAMAGE`, where the bytes are no MCAP.
    """
    try:
        from mcap.exceptions import McapError
        from mcap.records import Chunk, Footer
        from mcap.stream_reader import StreamReader, breakup_chunk
    except ImportError:
        raise MissingPackage("mcap is not installed: pip install 'spiraltrunk[hardware]'") from None
    reader = StreamReader(cast("BinaryIO", stream), emit_chunks=True, record_size_limit=_MOST_RECORD)
    try:
        for record in reader.records:
            if isinstance(record, Chunk):
                yield from breakup_chunk(_decompress(record), validate_crc=True)
            elif record is not None:
                yield record
            if isinstance(record, Footer):
                return
    except McapError as error:
        raise ValueError(str(error)) from None


def _decompress(chunk: Chunk) -> Chunk:
    """The chunk uncompressed, with no more room than it is allowed.

    Raises:
        ValueError: where it is too large, damaged, or compressed otherwise.
    """
    import zstandard
    from mcap.records import Chunk

    if chunk.uncompressed_size > _MOST_RECORD or chunk.compression not in ("", "zstd"):
        raise ValueError(f"a chunk of {chunk.uncompressed_size} bytes, compression {chunk.compression!r:.20}")
    data = chunk.data
    if chunk.compression == "zstd":
        try:
            with zstandard.ZstdDecompressor(max_window_size=1 << 27).stream_reader(data) as opened:
                data = opened.read(chunk.uncompressed_size + 1)
        except zstandard.ZstdError as error:
            raise ValueError(str(error)) from None
    if len(data) != chunk.uncompressed_size:
        raise ValueError("a chunk of another size than it says")
    return Chunk(
        compression="", data=data, message_start_time=chunk.message_start_time, message_end_time=chunk.message_end_time,
        uncompressed_crc=chunk.uncompressed_crc, uncompressed_size=chunk.uncompressed_size,
    )  # fmt: skip


def _parse(data: bytes, topic: str) -> dict[str, Any]:
    """A message.

    Raises:
        DriveError: where it is no JSON object.
    """
    try:
        message = json.loads(data)
    except (ValueError, RecursionError):
        message = None
    if not isinstance(message, dict):
        raise DriveError(f"a message of {topic} is {describe(data)}; allowed: a JSON object")
    return message
