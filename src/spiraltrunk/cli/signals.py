"""A command that is told to end, or whose terminal closes, ends as it does with Ctrl-C: nothing half done stays."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

_WORDS = {signal.SIGTERM: "terminated", signal.SIGHUP: "hung up"}
"""Signals that end a command, and what is said then."""

_ECHO = 1.0
"""Time in which a signal that comes again is the same one [s]: ``timeout`` sends it to a process and to its group."""


class Terminated(KeyboardInterrupt):
    """A signal has come that ends the command."""

    def __init__(self, number: int) -> None:
        self.code = 128 + number
        """Exit code, as shells have it."""
        super().__init__(_WORDS[signal.Signals(number)])


@contextmanager
def raise_signals() -> Iterator[None]:
    """Within the block the signals raise `Terminated`; one that is ignored, as by ``nohup``, stays so."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came = -_ECHO

    def terminate(number: int, frame: FrameType | None) -> None:
        nonlocal came
        before, came = came, time.monotonic()
        if came - before >= _ECHO:
            raise Terminated(number)

    old = {number: signal.getsignal(number) for number in _WORDS}
    caught = [number for number, handler in old.items() if handler == signal.SIG_DFL]
    try:
        for number in caught:
            signal.signal(number, terminate)
        yield
    finally:
        for number in caught:
            signal.signal(number, old[number])
