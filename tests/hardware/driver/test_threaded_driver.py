"""A driver whose loop runs in a thread: what is asked of it must not hold the loop up."""

from __future__ import annotations

import time

import pytest

from spiraltrunk.errors import RunError
from spiraltrunk.hardware.clock import SystemClock
from spiraltrunk.hardware.driver.threaded_driver import ThreadedDriver


class SlowToSummarise:
    """A driver whose lateness takes 0.3 s to summarise."""

    def __init__(self) -> None:
        self.clock, self.n_tick, self.summarised = SystemClock(), 0, (0, 0)

    def wait(self) -> None:
        time.sleep(0.001)

    def tick(self) -> None:
        self.n_tick += 1

    def summarise_lateness(self) -> str:
        before = self.n_tick
        time.sleep(0.3)
        self.summarised = (before, self.n_tick)
        return "late"

    def snapshot(self, lateness: str | None = None) -> str:
        return lateness or self.summarise_lateness()

    def close(self) -> None: ...


@pytest.fixture
def slow():
    driver = SlowToSummarise()
    threaded = ThreadedDriver(driver)
    yield driver, threaded
    threaded.close()


def test_the_loop_goes_on_while_its_lateness_is_summarised(slow):
    driver, threaded = slow
    assert threaded.snapshot() == "late"
    before, after = driver.summarised
    assert after - before > 10


def test_an_error_in_the_loop_is_a_run_that_failed_and_no_bad_input():
    class Ending(SlowToSummarise):
        def tick(self) -> None:
            raise ZeroDivisionError("in the loop")

    threaded = ThreadedDriver(Ending())
    threaded._thread.join(5.0)
    with pytest.raises(RunError, match="driver's loop ended: in the loop"):
        threaded.tick()
    threaded.close()
