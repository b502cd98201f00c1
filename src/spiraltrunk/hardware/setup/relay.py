"""Serial port of a relay in the motors' supply, see `safety.watchdog.RelayWatchdog`. Never tried on a real relay."""

from __future__ import annotations

from typing import Any

from spiraltrunk.hardware.motors.serial_port import open_port

_BAUD = 115_200
"""Baud rate [bit/s] (ours): a byte takes 0.09 ms, far less than a period of control."""


def open_relay(port: str) -> Any:
    """The open port of a relay, for this program alone.

    Raises:
        DriveError: where it cannot be opened.
        MissingPackage: without pyserial.
    """
    return open_port(port, _BAUD, "relay")
