"""One file of a log. A long log is split into parts, because MCAP's writer keeps an index of its whole file in memory.

The parts of ``drive.mcap`` are ``drive.mcap``, ``drive-0002.mcap``, ``drive-0003.mcap`` and so on, each a whole MCAP
file with the metadata of the run. Before its index each says whether it ends the log, so that a missing last part is
noticed.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import IO, TYPE_CHECKING, cast, final

from spiraltrunk.errors import MissingPackage
from spiraltrunk.hardware.log.channels import CHANNELS, format_schema
from spiraltrunk.hardware.log.log_file import PendingStream, create_log
from spiraltrunk.hardware.log.metadata import END_RECORD, RECORD, LogMetadata, format_end, format_metadata

if TYPE_CHECKING:
    from mcap.writer import Writer

MOST_CHUNKS = 12_000
"""Chunks after which the next part begins (ours): an hour of one every 0.3 s, 10 MB of index."""

MOST_BYTES = 1_000_000_000
"""Size from which the next part begins [bytes] (ours), a quarter of the largest log that is read."""


def name_part(path: Path, number: int) -> Path:
    """File of a part, counted from 1."""
    return path if number == 1 else path.with_name(f"{path.stem}-{number:04d}{path.suffix}")


@final
class LogPart:
    """A file that is being written, its index, and what the disc has not taken yet."""

    def __init__(self, path: Path, metadata: LogMetadata) -> None:
        """Make the file.

        Raises:
            OutputError: where it exists or cannot be made.
            MissingPackage: where mcap is not installed.
        """
        self._stream = PendingStream()
        self._writer = _start_writer(self._stream, metadata)
        self._channels: dict[str, int] = {}
        self._n_chunk = 0
        self._descriptor = create_log(path, self._stream.take())

    @property
    def pending(self) -> int:
        """Bytes that the disc has not taken."""
        return self._stream.pending

    @property
    def is_full(self) -> bool:
        """Whether the next part is due."""
        return self._n_chunk >= MOST_CHUNKS or self._stream.tell() >= MOST_BYTES

    def add(self, channel: str, moment: int, data: bytes, sequence: int) -> None:
        """Add a message at this wall-clock time [ns]."""
        self._writer.add_message(self._find_channel(channel), moment, data, moment, sequence)

    def _find_channel(self, channel: str) -> int:
        """Number of a channel, registered where it is new."""
        if channel not in self._channels:
            schema = self._writer.register_schema(CHANNELS[channel].__name__, "jsonschema", format_schema(channel))
            self._channels[channel] = self._writer.register_channel(channel, "json", schema)
        return self._channels[channel]

    def flush(self) -> None:
        """End the chunk."""
        self._writer.flush()  # type: ignore[no-untyped-call]
        self._n_chunk += 1

    def finish(self, *, is_last: bool) -> None:
        """End the file with a record of whether it ends the log, index and footer."""
        self._writer.add_metadata(END_RECORD, format_end(is_last=is_last))
        self._writer.finish()  # type: ignore[no-untyped-call]

    def commit(self) -> None:
        """Write and fsync what is pending.

        Raises:
            OSError: where the disc does not take all; the rest stays pending.
        """
        self._stream.commit(lambda data: os.write(self._descriptor, data))
        os.fsync(self._descriptor)

    def close(self) -> None:
        """Close the file as it is."""
        os.close(self._descriptor)


def _start_writer(stream: PendingStream, metadata: LogMetadata) -> Writer:
    try:
        from mcap.writer import CompressionType, Writer
    except ImportError:
        raise MissingPackage("mcap is not installed: pip install 'spiraltrunk[hardware]'") from None
    writer = Writer(cast("IO[bytes]", stream), compression=CompressionType.ZSTD)  # It writes, tells and flushes only.
    writer.start(profile="", library="spiraltrunk")
    writer.add_metadata(RECORD, format_metadata(metadata))
    return writer
