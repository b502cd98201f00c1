"""Serial line to Feetech servos: the port that their SDK works on, and one exchange with one servo."""

from __future__ import annotations

import time
from typing import Any, final

from spiraltrunk.errors import DriveError, MissingPackage, describe_reason
from spiraltrunk.hardware.motors.serial_port import SerialStream, open_serial

BAUD = 1_000_000
"""Baud rate of a servo as delivered [bit/s]."""
ANSWER_TIME = 0.03
"""Longest wait for an answer in an exchange [s] (ours): USB adapters deliver up to 16 ms late."""


def load_sdk() -> Any:
    """Feetech's SDK.

    Raises:
        MissingPackage: where it is not installed.
    """
    try:
        import scservo_sdk
    except ImportError:
        raise MissingPackage("STS servos need feetech-servo-sdk: pip install 'spiraltrunk[hardware]'") from None
    return scservo_sdk


@final
class StsLine:
    """An open serial line.

    It has the methods that the SDK's packet handler calls, under the SDK's names, instead of the SDK's own port, which
    waits until all is written, waits without limit where an adapter is stuck, and lets two programs open one port.
    """

    def __init__(self, port: str, baud: int = BAUD, *, stream: SerialStream | None = None) -> None:
        """Open a port, or use a stream that is open, such as a twin's.

        Raises:
            DriveError: where it cannot be opened, with the ports that exist.
            MissingPackage: without pyserial or the SDK.
        """
        self.sdk = load_sdk()
        self.port = port
        self.is_using = False
        self._deadline = 0.0
        self._stream: SerialStream = open_serial(port, baud) if stream is None else stream
        self.handler = self.sdk.PacketHandler(0)

    def clearPort(self) -> None:  # noqa: N802
        """Nothing: what was written leaves by itself."""

    def writePort(self, packet: list[int]) -> int:  # noqa: N802
        """Queue bytes in the adapter; their number."""
        try:
            return self._stream.write(bytes(packet)) or 0
        except OSError as error:  # pyserial's errors are.
            raise self._gone(error) from error

    def readPort(self, length: int) -> bytes:  # noqa: N802
        """Up to ``length`` bytes of an answer; none after its time, so that the SDK ends on a line that chatters."""
        return self.receive(length) if length > 0 and time.monotonic() <= self._deadline else b""

    def receive(self, most: int = 4096) -> bytes:
        """Up to ``most`` bytes that have arrived; never waits.

        Raises:
            DriveError: where the port is gone.
        """
        try:
            return bytes(self._stream.read(most))
        except (OSError, TypeError) as error:  # pyserial raises TypeError where the port was closed meanwhile.
            raise self._gone(error) from error

    def setPacketTimeout(self, packet_length: int) -> None:  # noqa: N802
        """Start the wait for an answer."""
        self._deadline = time.monotonic() + ANSWER_TIME

    def isPacketTimeout(self) -> bool:  # noqa: N802
        """Whether the wait for an answer is over."""
        time.sleep(1e-4)
        return time.monotonic() > self._deadline

    def ping(self, servo_id: int) -> int | None:
        """Model number of the servo with this id, None where none answers; waits at most twice `ANSWER_TIME`."""
        self.receive()  # What an earlier exchange left.
        model, result, _ = self.handler.ping(self, servo_id)
        return int(model) if result == self.sdk.COMM_SUCCESS else None

    def read_register(self, servo_id: int, register: int, size: int) -> bytes:
        """Read ``size`` bytes; waits at most twice `ANSWER_TIME`.

        Raises:
            DriveError: where the servo does not answer.
        """
        for _ in range(2):
            self.receive()
            data, result, _ = self.handler.readTxRx(self, servo_id, register, size)
            if result == self.sdk.COMM_SUCCESS and len(data) == size:
                return bytes(data)
        raise self._no_answer(servo_id)

    def write_register(self, servo_id: int, register: int, value: int) -> None:
        """Write one byte and have it confirmed by reading it.

        Raises:
            DriveError: where the servo does not answer, or keeps another value.
        """
        for _ in range(2):
            self.is_using = False
            self.receive()
            self.handler.write1ByteTxRx(self, servo_id, register, value)
            found = self.read_register(servo_id, register, 1)[0]
            if found == value:
                return
        raise DriveError(f"servo id {servo_id} keeps {found} in register {register}; wanted: {value}")

    def close(self) -> None:
        """Release the port; harmless when called again."""
        self._stream.close()

    def _no_answer(self, servo_id: int) -> DriveError:
        return DriveError(f"servo id {servo_id} on {self.port} does not answer; check its power, wiring and id")

    def _gone(self, error: Exception) -> DriveError:
        return DriveError(f"serial port {self.port}: {describe_reason(error)}; is the adapter still plugged in?")
