"""Thread that waits for an adapter whose driver cannot be asked without waiting."""

from __future__ import annotations

import contextlib
import threading
from collections import deque
from typing import TYPE_CHECKING, final

from spiraltrunk.hardware.clock import Clock

if TYPE_CHECKING:
    import can

CAPACITY = 1024
"""Messages that are kept until they are taken (ours); the oldest are dropped [-]."""

WAIT = 0.05
"""Longest wait for a message, and so for the thread's end (ours) [s]."""

PAUSE = 0.001
"""Pause after something unreadable, so that a driver that is broken takes no whole core (ours) [s]."""

UNREADABLE = (ValueError, LookupError, TypeError, AttributeError, ArithmeticError, AssertionError)
"""Errors of parsing."""


@final
class CanReader:
    """Receives from a bus of python-can in a thread, with the time at which each message arrived."""

    def __init__(self, bus: can.BusABC, clock: Clock) -> None:
        self.error: BaseException | None = None
        """Why the thread ended: the adapter is gone; None while it runs."""
        self.unreadable = 0
        """Times that something arrived which is no message [-]."""
        self._bus = bus
        self._clock = clock
        self._messages: deque[tuple[can.Message, float]] = deque(maxlen=CAPACITY)
        self._is_stopped = threading.Event()
        self._thread = threading.Thread(target=self._run, name="can reader", daemon=True)
        self._thread.start()

    def take(self, most: int) -> list[tuple[can.Message, float]]:
        """Up to so many messages, oldest first, each with its arrival on the clock [s]; never waits."""
        return [self._messages.popleft() for _ in range(min(most, len(self._messages)))]

    def stop(self) -> None:
        """End the thread."""
        self._is_stopped.set()
        self._thread.join(10 * WAIT)

    def _run(self) -> None:
        while not self._is_stopped.is_set():
            try:
                message = self._bus.recv(WAIT)
            except Exception as error:
                if is_gone(error):
                    self.error = error
                    return
                self.unreadable += 1
                skip_unreadable(self._bus, error)
                self._is_stopped.wait(PAUSE)
                continue
            if message is not None:
                self._messages.append((message, self._clock.now()))


def is_gone(error: BaseException) -> bool:
    """Whether an error of `can.BusABC.recv` means that the adapter is gone, and not that something unreadable arrived.

    What arrives is never trusted: python-can raises errors of parsing as they are, or as the cause of its own.
    """
    return not isinstance(error.__cause__ or error, UNREADABLE)


def skip_unreadable(bus: can.BusABC, error: BaseException) -> None:
    """Drop what a serial adapter sent that is no text: python-can keeps it, and would fail on it again and again."""
    skip = getattr(bus, "flush", None)
    if skip is not None and isinstance(error.__cause__ or error, UnicodeDecodeError):
        with contextlib.suppress(Exception):  # Where the adapter is gone, the next attempt to receive says so.
            skip()
