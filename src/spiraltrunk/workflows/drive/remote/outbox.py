"""Messages of the robot's process, sent by a thread, so that a receiver that hangs does not stop the robot's loop."""

from __future__ import annotations

import threading
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any, final

_MOST = 100
"""Messages that wait; further ones replace the oldest [-] (ours)."""

_PATIENCE = 1.0
"""Time that the last messages have [s] (ours)."""


@final
class Outbox:
    """Messages in their order; of states that wait the last alone."""

    def __init__(self, pipe: Connection) -> None:
        self._pipe = pipe
        self._waiting: list[tuple[Any, ...]] = []
        self._changed = threading.Condition()
        self._is_closed = False
        self._thread = threading.Thread(target=self._send, name="outbox", daemon=True)
        self._thread.start()

    def put(self, *message: Any) -> None:
        """Send a message, soon; never waits."""
        with self._changed:
            if message[0] == "state":
                self._waiting = [one for one in self._waiting if one[0] != "state"]
            self._waiting = [*self._waiting[-_MOST:], message]
            self._changed.notify()

    def close(self) -> None:
        """Send what waits, within a second, and end the thread."""
        with self._changed:
            self._is_closed = True
            self._changed.notify()
        self._thread.join(_PATIENCE)

    def _send(self) -> None:
        with suppress(OSError, ValueError):  # The receiver is gone.
            while (message := self._take()) is not None:
                self._pipe.send(message)

    def _take(self) -> tuple[Any, ...] | None:
        with self._changed:
            while not self._waiting and not self._is_closed:
                self._changed.wait()
            return self._waiting.pop(0) if self._waiting else None
