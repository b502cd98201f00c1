"""Time of a twin: simulated, and as fast as the computer allows, or real, in a thread."""

from __future__ import annotations

import math
import threading
import time
from types import TracebackType
from typing import final

from spiraltrunk.checks import check_number
from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.clock import Clock, SystemClock
from spiraltrunk.hardware.twin.device import TwinDevice

STEP = 1e-3
"""Step of the twins [s] (ours): the period of a GM6020's feedback."""

_ROUNDING = 0.1
"""Part of a step by which a driver's sum of periods may miss a multiple of it: 8 h at 500 Hz miss 26 us at most [-]."""

_CATCH_UP = 0.1
"""Longest time that a late thread makes up for [s] (ours)."""


@final
class TwinClock(Clock):
    """Simulated time, which passes only in `sleep_until`; the same calls give the same run, however long they take."""

    def __init__(self, *devices: TwinDevice, step: float = STEP) -> None:
        """A clock at 0 s.

        Args:
            devices: advanced in this order.
            step: step [s].
        """
        check_number("step", step, least=1e-6, most=0.1)
        self._devices, self._step = list(devices), step
        self._count, self._now = 0, 0.0

    def attach(self, device: TwinDevice) -> None:
        """Advance this device too, after those that are attached already."""
        self._devices.append(device)

    def now(self) -> float:
        """Simulated time since the clock was made [s]."""
        return self._now

    def sleep_until(self, moment: float) -> None:
        """Advance the devices in whole steps until it is ``moment`` [s].

        Raises:
            DriveError: where the moment is not finite.
        """
        if not math.isfinite(moment):
            raise DriveError(f"sleep until {moment} s; allowed: a finite moment")
        step, devices = self._step, self._devices
        last = moment - _ROUNDING * step
        while self._count * step < last:
            self._count += 1
            self._now = max(self._now, self._count * step)
            for device in devices:
                device.advance(step)
        self._now = max(self._now, moment)


@final
class RealTimeTwin:
    """A thread that advances devices by the computer's clock: for people at a terminal, and for measured lateness.

    What it does is not repeatable. Devices are advanced in whole steps; a thread that was late takes the missed ones
    at once, up to 100 ms, so that a suspended computer does not wake up to hours of them.
    """

    def __init__(self, *devices: TwinDevice, clock: Clock | None = None, step: float = STEP) -> None:
        """Devices at rest; `start` sets them going.

        Args:
            devices: advanced in this order, by one thread.
            clock: time that they follow; the computer's by default.
            step: step [s].
        """
        check_number("step", step, least=1e-6, most=0.1)
        self._devices, self._step = devices, step
        self._clock = SystemClock() if clock is None else clock
        self._stopping = threading.Event()
        self._thread: threading.Thread | None = None
        self._error: BaseException | None = None

    def start(self) -> None:
        """Start the thread.

        Raises:
            DriveError: where it was started before.
        """
        if self._thread is not None:
            raise DriveError("the twin runs or has run already; allowed: one start")
        self._thread = threading.Thread(target=self._run, name="twin", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the thread; harmless when called again.

        Raises:
            Exception: the one that ended the thread before, where there was one.
        """
        self._stopping.set()
        if self._thread is not None:
            self._thread.join()
        error, self._error = self._error, None
        if error is not None:
            raise error

    def __enter__(self) -> RealTimeTwin:
        self.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.stop()

    def _run(self) -> None:
        try:
            self._follow()
        except BaseException as error:  # Raised by `stop`.
            self._error = error

    def _follow(self) -> None:
        step, due = self._step, self._clock.now()
        while not self._stopping.is_set():
            now = self._clock.now()
            due = max(due, now - _CATCH_UP)
            while due <= now:
                for device in self._devices:
                    device.advance(step)
                due += step
            time.sleep(max(0.0, due - self._clock.now()))
