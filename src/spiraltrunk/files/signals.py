"""Signals that wait until files are where they belong."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Signals that end a command."""


@contextmanager
def hold_signals() -> Iterator[None]:
    """Within the block signals that end a command are held; the first of them is raised again at its end.

    Their handlers are replaced, because a blocked signal is delivered to another thread, and Python then handles it in
    the main one. Outside of the main thread, which alone handles signals, nothing is held.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    held: list[int] = []
    before = {number: signal.getsignal(number) for number in _ENDING}
    heard = {number: handler for number, handler in before.items() if handler not in (signal.SIG_IGN, None)}
    try:
        for number in heard:
            signal.signal(number, lambda number, frame: held.append(number))
        yield
    finally:
        for number, handler in heard.items():
            signal.signal(number, handler)
        if held:
            signal.raise_signal(held[0])
