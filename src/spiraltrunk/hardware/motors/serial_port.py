"""Serial ports of the operating system: their names, and opening one."""

from __future__ import annotations

from typing import Any, Protocol, final

from spiraltrunk.errors import DriveError, MissingPackage, describe_reason

_WRITE_TIME = 0.005
"""Longest wait for room in the adapter's buffer [s] (ours)."""


class SerialStream(Protocol):
    """What is used of an open port: pyserial's, or a twin's."""

    def read(self, size: int, /) -> bytes:
        """Up to ``size`` bytes that have arrived; never waits. OSError where the port is gone."""

    def write(self, data: bytes, /) -> int | None:
        """Queue bytes, and return their number. OSError where the port is gone."""

    def close(self) -> None:
        """Release the port."""


def list_ports() -> list[str]:
    """Names of the serial ports that exist now, such as /dev/ttyACM0, /dev/cu.usbmodem1 or COM3, sorted.

    Raises:
        MissingPackage: without pyserial.
    """
    try:
        from serial.tools.list_ports import comports
    except ImportError:
        raise _no_serial() from None
    return sorted(str(port.device) for port in comports())


def open_serial(port: str, baud: int) -> SerialStream:
    """Open a port for this program alone; reading never waits.

    Writing waits for 5 ms at most. Bytes for which a stuck adapter has no room by then are lost as on a broken wire,
    which the age of the feedback shows; pyserial reports the same where the program was merely interrupted.

    Raises:
        DriveError: where it cannot be opened, with the ports that exist.
        MissingPackage: without pyserial.
    """
    opened = open_port(port, baud)
    from serial import SerialTimeoutException

    return _PatientStream(opened, SerialTimeoutException)


def open_port(port: str, baud: int, name: str = "serial port") -> Any:
    """pyserial's own port, for this program alone; a write that waits for more than 5 ms is an OSError.

    Raises:
        DriveError: where it cannot be opened, with the ``name`` of what it is and the ports that exist.
        MissingPackage: without pyserial.
    """
    try:
        import serial
    except ImportError:
        raise _no_serial() from None
    try:
        return serial.Serial(port, baud, timeout=0, write_timeout=_WRITE_TIME, exclusive=True)
    except (OSError, ValueError) as error:
        known = ", ".join(list_ports()) or "none"
        raise DriveError(f"{name} {port!r} cannot be opened: {describe_reason(error)}; ports found: {known}") from error


@final
class _PatientStream:
    """pyserial's port, on which a late write is no error."""

    def __init__(self, port: Any, late: type[OSError]) -> None:
        self._port, self._late = port, late
        self.read = port.read
        self.close = port.close

    def write(self, data: bytes, /) -> int:
        try:
            return int(self._port.write(data) or 0)
        except self._late:
            return len(data)


def _no_serial() -> MissingPackage:
    return MissingPackage("serial ports need pyserial: pip install 'spiraltrunk[hardware]'")
