"""Writer of logs: MCAP with JSON messages, from a thread of its own, so that the control loop never waits for the disc.

The file grows by a whole chunk every `CHUNK_PERIOD`, which the kernel has from then on: a process that is killed loses
what came since. Each is followed by fsync(2), so that a power failure loses little more. After an hour the next file
begins, see `part`, so that the memory of the index stays bounded. That Foxglove opens such a log
follows from its documentation ("jsonschema" and "json"), and was never tried.
"""

from __future__ import annotations

import json
import logging
import threading
import time as wall
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import Any, final

import numpy as np

from spiraltrunk.checks import read_numbers
from spiraltrunk.errors import DriveError, OutputError, SpiralTrunkError, describe
from spiraltrunk.files.results import to_json
from spiraltrunk.hardware.log.channels import CHANNELS, list_columns
from spiraltrunk.hardware.log.metadata import LogMetadata
from spiraltrunk.hardware.log.part import LogPart, name_part

CHUNK_PERIOD = 0.3
"""Time after which a chunk is closed and written [s] (ours): a third of the 1 s that may be lost."""

_POLL = 0.05
"""Longest time between two looks at the queue [s] (ours). A message wakes the thread sooner: it then works while the
control loop, which shares the interpreter, sleeps until its next tick."""

_BATCH = 50
"""Messages encoded at once (ours): about half a millisecond."""

_CHUNK_CHECK = 1000
"""Messages after which the thread sees whether a chunk is due (ours): some 50 ms."""

_PAUSE = 0.0002
"""Pause between two of these [s] (ours)."""

_SLOW = 0.5
"""Time of one write from which the disc is called slow [s] (ours): together with `CHUNK_PERIOD` still below 1 s."""

MOST_QUEUED = 50_000
"""Messages that wait at most (ours): 20 s at 500 Hz with five messages each."""

_MOST_PENDING = 32_000_000
"""Bytes that wait at most for a disc that takes none (ours)."""

_LONGEST_CLOSE = 10.0
"""Time that closing waits at most for the disc [s] (ours)."""

_Message = tuple[str, float, Mapping[str, Any]]


@final
class LogWriter:
    """A log that is being written; a context manager. `write` never waits and never raises for the disc's sake.

    Where the disc is slow or full, one warning is logged, control goes on, and messages that found no room are counted
    in `n_lost`; the count is written to the log as soon as there is room.
    """

    def __init__(self, path: str | Path, clock_origin: float, metadata: LogMetadata, *, waits: bool = False) -> None:
        """Make the file and start its thread.

        Args:
            path: file to make, by convention named ``.mcap``.
            clock_origin: time on the driver's clock now [s], which is `LogMetadata.wall_start` by the wall clock.
            metadata: what is known at the start.
            waits: whether `write` waits for room instead of losing messages: for a twin faster than real time.

        Raises:
            DriveError: where the clock's origin is not finite.
            OutputError: where the file exists or cannot be made.
            MissingPackage: where mcap is not installed.
        """
        origin = float(read_numbers("clock_origin of the log", clock_origin, shape=(), unit="s", error=DriveError))
        self._waits = waits
        self._metadata = replace(metadata, clock_origin=origin)
        self._path, self._n_part = Path(path), 1
        self._refuse_part(2)
        self._part = LogPart(self._path, self._metadata)
        self._fields = {channel: list_columns(channel).keys() - {"time"} for channel in CHANNELS}
        self._queue: SimpleQueue[_Message] = SimpleQueue()
        self._refused = 0  # Counted by the caller's thread,
        self._failed, self._n_loss_logged, self._unwritten, self._sequence = 0, 0, 0, 0  # these by the log's.
        self._time = origin
        self._has_warned = self._is_closing = self._is_dead = False
        self._thread = threading.Thread(target=self._run, name="spiraltrunk log", daemon=True)
        self._thread.start()

    @property
    def n_lost(self) -> int:
        """Messages lost so far."""
        return self._refused + self._failed

    def write(self, channel: str, time: float, values: Mapping[str, Any]) -> None:
        """Queue one message; the caller changes neither the mapping nor its arrays any more.

        Args:
            channel: topic, of `CHANNELS`.
            time: time on the driver's clock [s].
            values: fields of the channel's dataclass but for its time; arrays, numbers or texts.

        Raises:
            DriveError: for an unknown channel, and after `close`.
        """
        if channel not in CHANNELS or self._is_closing:
            allowed = "a log that is open" if channel in CHANNELS else ", ".join(CHANNELS)
            raise DriveError(f"channel of the log is {describe(channel)}; allowed: {allowed}")
        while self._waits and not self._is_dead and self._queue.qsize() >= MOST_QUEUED:
            wall.sleep(_POLL)
        if self._is_dead or self._queue.qsize() >= MOST_QUEUED:
            self._refused += 1
            self._warn("the disc is too slow, and messages are lost")
        else:
            self._queue.put((channel, time, values))

    def close(self) -> None:
        """Write what is queued, index and footer; harmless when called again.

        A disc that takes nothing holds it up by at most 10 s; the file is then without a footer, and readable.
        """
        self._is_closing = True
        self._thread.join(_LONGEST_CLOSE)
        if self._thread.is_alive():
            self._warn(f"the disc took nothing for {_LONGEST_CLOSE:g} s")

    def __enter__(self) -> LogWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _run(self) -> None:
        """Main function of the thread."""
        try:
            self._write_chunks()
            self._drain(self._queue.qsize())
            self._log_loss()
            self._part.finish(is_last=True)
            self._commit()
        except Exception as error:  # Control goes on, whatever it is.
            self._warn(f"{type(error).__name__}: {error}")
        finally:
            self._is_dead = True
            self._failed += self._queue.qsize() + self._unwritten
            self._part.close()

    def _write_chunks(self) -> None:
        due = wall.monotonic() + CHUNK_PERIOD
        while not self._is_closing:
            if self._part.pending < _MOST_PENDING:
                self._await_message()
                self._drain(_CHUNK_CHECK)
            else:
                wall.sleep(_POLL)
            if wall.monotonic() >= due:
                self._log_loss()
                self._part.flush()
                self._commit()
                if self._part.is_full and not self._part.pending:
                    self._turn_part()
                due = wall.monotonic() + CHUNK_PERIOD

    def _turn_part(self) -> None:
        """End the file and begin the next; while the disc takes neither, messages wait in the queue."""
        self._part.finish(is_last=False)
        self._commit()
        while not self._is_closing:
            try:
                if not self._part.pending:
                    self._refuse_part(self._n_part + 1)
                    after = LogPart(name_part(self._path, self._n_part + 1), self._metadata)
                    break
            except OutputError as error:
                self._warn(str(error))
            wall.sleep(_POLL)
            self._commit()
        else:
            raise OutputError("the disc takes no further file")
        self._part.close()
        self._part, self._n_part = after, self._n_part + 1

    def _refuse_part(self, number: int) -> None:
        """Refuse to continue where the file of a part exists: a reader would take it for a part of this log."""
        if (path := name_part(self._path, number)).exists():
            raise OutputError(f"the log {str(path)!r} exists; allowed: a new file, as no log is replaced")

    def _await_message(self) -> None:
        """Wait for a message, at most `_POLL`, and encode it."""
        with suppress(Empty):
            self._encode(*self._queue.get(timeout=_POLL))

    def _drain(self, most: int) -> None:
        """Encode at most so many messages, in slices between which the control loop has the interpreter."""
        for i in range(1, min(self._queue.qsize(), most) + 1):
            self._encode(*self._queue.get_nowait())
            if i % _BATCH == 0:
                wall.sleep(_PAUSE)

    def _encode(self, channel: str, time: float, values: Mapping[str, Any]) -> None:
        try:
            self._time = float(time)
            moment = self._metadata.wall_start + round(1e9 * (self._time - self._metadata.clock_origin))
            if values.keys() != self._fields[channel]:
                raise ValueError(f"fields are {', '.join(values)}; allowed: {', '.join(sorted(self._fields[channel]))}")
            data = _format_message(self._time, values)
            if not 0 <= moment < 1 << 64:
                raise ValueError("the time is out of range")
        except (TypeError, ValueError, OverflowError, RecursionError) as error:
            self._failed += 1
            self._warn(f"a message of {channel} cannot be written: {error}")
            return
        self._unwritten += 1
        self._sequence = (self._sequence + 1) % (1 << 32)
        self._part.add(channel, moment, data, self._sequence)

    def _log_loss(self) -> None:
        """Log that messages were lost."""
        if (lost := self.n_lost) > self._n_loss_logged:
            self._n_loss_logged = lost
            self._encode("/warning", self._time, {"text": f"{lost} messages of the log are lost so far"})

    def _commit(self) -> None:
        """Write and fsync; a disc that is slow or refuses is warned of once."""
        began = wall.monotonic()
        try:
            self._part.commit()
            self._unwritten = 0
        except OSError as error:
            self._warn(error.strerror or str(error))
        if (took := wall.monotonic() - began) > _SLOW:
            self._warn(f"writing took {took:.1f} s; allowed: {_SLOW:g} s, so that a crash loses at most 1 s")

    def _warn(self, reason: str) -> None:
        if not self._has_warned:
            self._has_warned = True
            text = str(SpiralTrunkError(f"the log is not written as it should be ({reason}); control goes on"))
            logging.getLogger("spiraltrunk").warning(text)


def _format_message(time: float, values: Mapping[str, Any]) -> bytes:
    """JSON of a message; numbers that are not finite become null.

    Raises:
        TypeError, ValueError, RecursionError: where a value has no JSON.
    """
    message = {"time": time, **values}
    try:
        return json.dumps(message, default=_to_list, allow_nan=False, separators=(",", ":")).encode()
    except ValueError:
        return json.dumps(to_json(message), allow_nan=False, separators=(",", ":")).encode()


def _to_list(value: object) -> object:
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} has no JSON")
