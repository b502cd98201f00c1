"""Clock of a driver: one for motors, arm and motion capture; the computer's own, or that of a twin."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from typing import final


class Clock(ABC):
    """Monotonic time, and waiting for it."""

    @abstractmethod
    def now(self) -> float:
        """Time since an arbitrary origin [s]; never runs backwards."""

    @abstractmethod
    def sleep_until(self, moment: float) -> None:
        """Return when `now` is at least ``moment`` [s]; at once if it already is."""


@final
class SystemClock(Clock):
    """The computer's monotonic clock."""

    def now(self) -> float:
        """Time since the computer started [s]."""
        return time.monotonic()

    def sleep_until(self, moment: float) -> None:
        """Sleep; the operating system wakes it up to about a millisecond late."""
        while (left := moment - time.monotonic()) > 0.0:
            time.sleep(left)
