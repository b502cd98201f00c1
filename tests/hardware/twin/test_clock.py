"""Simulated time, and real time in a thread."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable

import pytest

from spiraltrunk.errors import DesignError, DriveError
from spiraltrunk.hardware.clock import Clock
from spiraltrunk.hardware.twin.clock import RealTimeTwin, TwinClock
from spiraltrunk.hardware.twin.device import TwinDevice

from .conftest import Setup


class Recorder(TwinDevice):
    """Remembers when it was advanced."""

    def __init__(self, clock: Clock | None = None) -> None:
        self.clock, self.moments, self.total = clock, [], 0.0  # type: ignore[var-annotated]

    def advance(self, dt: float) -> None:
        self.total += dt
        if self.clock is not None:
            self.moments.append(self.clock.now())


def test_time_passes_in_whole_steps_and_only_when_waited_for() -> None:
    clock = TwinClock()
    device = Recorder(clock)
    clock.attach(device)
    assert clock.now() == 0.0
    clock.sleep_until(3e-3)
    assert device.moments == pytest.approx([1e-3, 2e-3, 3e-3])
    clock.sleep_until(2e-3)
    assert len(device.moments) == 3
    clock.sleep_until(3.2e-3)
    assert len(device.moments) == 4
    assert clock.now() == pytest.approx(4e-3)


def test_no_step_is_lost_or_gained_in_a_long_run_of_sums() -> None:
    """A driver adds its period up, with rounding."""
    clock = TwinClock()
    device = Recorder()
    clock.attach(device)
    moment = 0.0
    for _ in range(200_000):
        moment += 2e-3
        clock.sleep_until(moment)
        assert clock.now() >= moment
    assert device.total == pytest.approx(400.0, abs=1e-6)
    assert clock.now() == pytest.approx(400.0, abs=1e-6)


@pytest.mark.parametrize("moment", [math.nan, math.inf])
def test_a_moment_that_never_comes_is_refused(moment: float) -> None:
    with pytest.raises(DriveError, match="finite"):
        TwinClock().sleep_until(moment)


def test_a_step_that_is_no_time_is_refused() -> None:
    with pytest.raises(DesignError, match="step"):
        TwinClock(step=0.0)


def test_devices_are_advanced_in_order() -> None:
    order: list[str] = []

    class Named(TwinDevice):
        def __init__(self, name: str) -> None:
            self.name = name

        def advance(self, dt: float) -> None:
            order.append(self.name)

    clock = TwinClock(Named("a"), Named("b"))
    clock.sleep_until(2e-3)
    assert order == ["a", "b", "a", "b"]


class SetClock(Clock):
    """Shows what a test sets."""

    def __init__(self) -> None:
        self.moment = 0.0

    def now(self) -> float:
        return self.moment

    def sleep_until(self, moment: float) -> None:
        raise AssertionError


def wait_for(device: Recorder, total: float) -> None:
    """Wait until a device was advanced by this long [s], at most a minute."""
    deadline = time.monotonic() + 60.0
    while device.total < total - 1e-9:
        assert time.monotonic() < deadline
        time.sleep(1e-3)


def test_in_real_time_the_devices_follow_the_clock_and_do_not_run_ahead() -> None:
    device, clock = Recorder(), SetClock()
    with RealTimeTwin(device, clock=clock):
        for moment in (0.0, 0.03, 0.05, 0.08):
            clock.moment = moment
            wait_for(device, moment)
            time.sleep(2e-3)
            assert device.total <= moment + 1e-3 + 1e-9
    total = device.total
    assert all(thread.name != "twin" for thread in threading.enumerate())
    clock.moment = 1.0
    time.sleep(5e-3)
    assert device.total == total


def test_in_real_time_the_computers_clock_is_the_default() -> None:
    device = Recorder()
    with RealTimeTwin(device):
        wait_for(device, 0.01)
    assert device.total >= 0.01


def test_what_fails_in_the_thread_is_raised_at_its_end() -> None:
    class Broken(TwinDevice):
        def advance(self, dt: float) -> None:
            raise ZeroDivisionError("broken device")

    twin = RealTimeTwin(Broken())
    twin.start()
    with pytest.raises(ZeroDivisionError, match="broken device"):
        twin.stop()
    twin.stop()
    with pytest.raises(DriveError, match="one start"):
        twin.start()


def test_after_a_long_pause_only_the_last_of_it_is_made_up_for() -> None:
    """A computer that slept for an hour does not run through it."""

    device, clock = Recorder(), SetClock()
    with RealTimeTwin(device, clock=clock):
        wait_for(device, 1e-3)
        clock.moment = 3600.0
        wait_for(device, 0.1)
        time.sleep(5e-3)
    assert device.total <= 0.1 + 3e-3


def test_the_same_calls_give_the_same_run(build: Callable[..., Setup]) -> None:
    runs = []
    for _ in range(2):
        setup = build()
        setup.command(0.3, 0.5, -0.1)
        frames = setup.run(0.2)
        setup.command(0.0, 0.5, 0.9)
        runs.append(frames + setup.run(0.2))
    assert runs[0] == runs[1]
    assert len(runs[0]) == 1200
