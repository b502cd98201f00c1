"""Serial port of a relay in the motors' supply, see `safety.watchdog.RelayWatchdog`. Never tried on a real relay."""

from __future__ import annotations

from typing import Any

from spiraltrunk.errors import DriveError, MissingPackage, describe_reason

_BAUD = 115_200
"""Baud rate [bit/s] (ours): a byte takes 0.09 ms, far less than a period of control."""

_WRITE_TIME = 0.005
"""Longest wait for room in the adapter's buffer [s] (ours)."""


def open_relay(port: str) -> Any:
    """The open port of a relay, for this program alone.

    Raises:
        DriveError: where it cannot be opened.
        MissingPackage: without pyserial.
    """
    try:
        import serial
    except ImportError:
        raise MissingPackage("a relay needs pyserial: pip install 'spiraltrunk[hardware]'") from None
    try:
        return serial.Serial(port, _BAUD, timeout=0, write_timeout=_WRITE_TIME, exclusive=True)
    except (OSError, ValueError) as error:
        raise DriveError(
            f"relay {port!r} cannot be opened: {describe_reason(error)}; check name, cable and permissions"
        ) from error
