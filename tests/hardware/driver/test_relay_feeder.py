"""A relay is fed within a block, and not for ever."""

from __future__ import annotations

import threading
import time

import pytest

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.driver.relay_feeder import RelayFeeder
from spiraltrunk.hardware.safety.watchdog import RelayWatchdog


class Port:
    def __init__(self) -> None:
        self.n_pulse = 0

    def write(self, data: bytes) -> None:
        self.n_pulse += 1


def test_pulses_end_with_the_block():
    port = Port()
    with RelayFeeder(RelayWatchdog(port)):
        time.sleep(0.1)
    count = port.n_pulse
    assert count > 3
    time.sleep(0.05)
    assert port.n_pulse == count
    assert not [thread for thread in threading.enumerate() if thread.name == "relay"]


def test_pulses_end_with_the_block_that_raises():
    port = Port()
    with pytest.raises(ZeroDivisionError), RelayFeeder(RelayWatchdog(port)):
        raise ZeroDivisionError
    count = port.n_pulse
    time.sleep(0.05)
    assert port.n_pulse == count


def test_a_program_that_hangs_loses_the_relay():
    port = Port()
    with pytest.raises(DriveError, match=r"the motors were not ready within 0\.05 s"):
        stay(port)
    count = port.n_pulse
    time.sleep(0.05)
    assert port.n_pulse == count


def stay(port: Port) -> None:
    """Longer in the block than the relay is fed."""
    with RelayFeeder(RelayWatchdog(port), longest=0.05):
        time.sleep(0.2)
