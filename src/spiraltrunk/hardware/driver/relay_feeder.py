"""Feeds a relay in the motors' supply while their driver is being built, before its loop feeds it."""

from __future__ import annotations

import sys
import threading
import time
from typing import Final, Self, final

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.driver.threaded_driver import SWITCH_INTERVAL
from spiraltrunk.hardware.safety.watchdog import RelayWatchdog

FEED_PERIOD: Final = 0.002
"""Time between two pulses [s]: a period of control with GM6020, a tenth of what their timer waits."""

LONGEST_FEED: Final = 15.0
"""Time after which the pulses end, whatever the program does [s] (ours: servos that do not answer take seconds)."""


@final
class RelayFeeder:
    """Keeps a relay closed within its block, from a thread of its own; a program that hangs there loses it.

    The last pulse is at the end of the block. Where the relay could not be fed to there, that is a `DriveError`.
    """

    def __init__(self, relay: RelayWatchdog, longest: float = LONGEST_FEED) -> None:
        self._relay, self._longest = relay, longest
        self._ending = threading.Event()
        self._error: DriveError | None = None
        self._thread = threading.Thread(target=self._feed, name="relay", daemon=True)

    def __enter__(self) -> Self:
        self._interval = sys.getswitchinterval()
        sys.setswitchinterval(min(SWITCH_INTERVAL, self._interval))
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self._ending.set()
        self._thread.join()
        sys.setswitchinterval(self._interval)
        if kind is not None:
            return
        if self._error is not None:
            raise self._error
        self._relay.feed()

    def _feed(self) -> None:
        """Main function of the thread."""
        end = time.monotonic() + self._longest
        try:
            while not self._ending.is_set():
                if time.monotonic() >= end:
                    allowed = "allowed: motors that answer sooner"
                    raise DriveError(f"the motors were not ready within {self._longest:g} s; {allowed}")
                self._relay.feed()
                self._ending.wait(FEED_PERIOD)
        except DriveError as error:
            self._error = error
