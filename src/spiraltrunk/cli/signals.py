"""Signals that end a command raise an exception, as Ctrl-C does, so that no partial output stays."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

_MESSAGES = {signal.SIGTERM: "terminated", signal.SIGHUP: "hung up"}
"""Signals that end a command, with their messages."""

_REPEAT_TIME = 1.0
"""Time within which a repeated signal counts as the same [s]: ``timeout`` signals a process and then its group."""


class Terminated(KeyboardInterrupt):
    """The command was ended by a signal."""

    def __init__(self, number: int) -> None:
        self.code = 128 + number
        """Exit code, by the convention of shells."""
        super().__init__(_MESSAGES[signal.Signals(number)])


@contextmanager
def raise_signals() -> Iterator[None]:
    """Raise `Terminated` on signals within the block; signals that are ignored, as by ``nohup``, stay ignored."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    last = -_REPEAT_TIME

    def terminate(number: int, frame: FrameType | None) -> None:
        nonlocal last
        before, last = last, time.monotonic()
        if last - before >= _REPEAT_TIME:
            raise Terminated(number)

    caught = [number for number in _MESSAGES if signal.getsignal(number) == signal.SIG_DFL]
    try:
        for number in caught:
            signal.signal(number, terminate)
        yield
    finally:
        for number in caught:
            signal.signal(number, signal.SIG_DFL)
