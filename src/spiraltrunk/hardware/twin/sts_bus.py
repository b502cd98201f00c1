"""Twin of a serial line with STS servos, in memory or on a pseudo-terminal, with faults on request."""

from __future__ import annotations

import os
import random
import select
import threading
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import final

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.motors.sts import codec
from spiraltrunk.hardware.twin.cable_load import CableLoad
from spiraltrunk.hardware.twin.device import TwinDevice
from spiraltrunk.hardware.twin.load_cells import LoadCellTwin
from spiraltrunk.hardware.twin.sts_servo import ServoTwin

_SYNC_READ, _SYNC_WRITE = 0x82, 0x83


@final
@dataclass(kw_only=True)
class LineFaults:
    """What goes wrong on the line; may be changed at any time. Faults of one servo are set on its `ServoTwin`."""

    loss: float = 0.0
    """Probability that a request, or an answer, is lost [-]."""
    corruption: float = 0.0
    """Probability that one byte of a request, or of an answer, is changed [-]."""
    duplication: float = 0.0
    """Probability that an answer comes twice [-]."""
    delay: float = 0.0
    """Time by which answers come late [s]."""
    is_silent: bool = False
    """Whether no byte passes in either direction."""
    is_gone: bool = False
    """Whether the adapter was unplugged."""


@final
class StsTwin(TwinDevice):
    """Servos, their motors and cables, and the bytes between them and a driver."""

    def __init__(self, load: CableLoad, servos: Sequence[ServoTwin], *, seed: int = 0) -> None:
        """Servos in the order of the cables.

        Args:
            load: other end of the cables.
            servos: the servos; faults of one are set on it.
            seed: of the line's random faults.
        """
        self.servos = tuple(servos)
        self.motors = tuple(servo.motor for servo in servos)
        """Motor of each servo, to which faults of devices happen."""
        self.cells: LoadCellTwin | None = None
        """Load cells at the cables, to which faults of cells happen; None without any."""
        self.faults = LineFaults()
        self.n_command = 0
        """Commands of duty cycles that arrived whole, to all servos at once [-]."""
        self.n_answered = 0
        """Answers that were given [-]."""
        self.tensions = [0.0] * len(self.servos)
        """Tension of each cable [N]."""
        self._load = load
        self._random = random.Random(seed)
        self._lock = threading.RLock()
        self._received = bytearray()
        self._answers: deque[tuple[float, bytes]] = deque()
        self._due = bytearray()
        self._now = 0.0

    def advance(self, dt: float) -> None:
        """Advance motors and cables by ``dt`` [s]."""
        with self._lock:
            wound, stiffness = [m.wound for m in self.motors], [m.stiffness for m in self.motors]
            self.tensions = list(self._load.advance(wound, stiffness, dt))
            for servo, tension in zip(self.servos, self.tensions, strict=True):
                servo.advance(tension, dt)
            self._now += dt

    def swap_ids(self, first: int, second: int) -> None:
        """Exchange the ids of two servos."""
        one, other = self.servos[first], self.servos[second]
        one.id, other.id = other.id, one.id

    def forget(self, cable: int) -> None:
        """Nothing: a servo without supply forgets its command by itself."""

    def receive(self, data: bytes) -> None:
        """Take in bytes from the driver, carry out what they say, and make the answers ready."""
        with self._lock:
            if self.faults.is_silent:
                return
            self._received += data
            for packet in codec.take_packets(self._received):
                if (damaged := self._damage(codec.encode_packet(packet))) is not None:
                    for whole in codec.take_packets(bytearray(damaged)):
                        self._carry_out(whole)

    def take_answers(self, most: int = 4096) -> bytes:
        """Up to ``most`` bytes of the answers that are due."""
        with self._lock:
            while self._answers and self._answers[0][0] <= self._now:
                self._due += self._answers.popleft()[1]
            taken = bytes(self._due[:most])
            del self._due[:most]
            return b"" if self.faults.is_silent else taken

    def _carry_out(self, packet: codec.Packet) -> None:
        if packet.code == _SYNC_WRITE and len(packet.data) >= 2:
            self._write_all(packet.data[0], packet.data[1], packet.data[2:])
        elif packet.code == _SYNC_READ and len(packet.data) >= 2:
            for servo_id in packet.data[2:]:
                self._answer(codec.Packet(servo_id, 2, packet.data[:2]))
        else:
            self._answer(packet)

    def _write_all(self, register: int, size: int, data: bytes) -> None:
        self.n_command += register == codec.GOAL_DUTY
        for start in range(0, len(data) - size, size + 1):
            for servo in self.servos:
                if servo.motor.is_on and servo.id == data[start]:
                    servo.write(register, data[start + 1 : start + 1 + size])

    def _answer(self, packet: codec.Packet) -> None:
        """Answers of all servos with this id: two with one id answer one after the other."""
        for servo in self.servos:
            if servo.motor.is_on and servo.id == packet.servo_id and (answer := servo.answer(packet)):
                copies = 2 if self._random.random() < self.faults.duplication else 1
                self.n_answered += 1
                damaged = self._damage(answer)
                if damaged is not None:
                    self._answers.extend([(self._now + self.faults.delay, damaged)] * copies)

    def _damage(self, data: bytes) -> bytes | None:
        """The bytes as they arrive; None where they are lost."""
        if self.faults.loss and self._random.random() < self.faults.loss:
            return None
        if self.faults.corruption and self._random.random() < self.faults.corruption:
            wrong = bytearray(data)
            wrong[self._random.randrange(len(wrong))] ^= self._random.randrange(1, 256)
            return bytes(wrong)
        return data


@final
class MemoryStream:
    """The line's end at the driver, without an operating system between: repeatable, in simulated time."""

    def __init__(self, twin: StsTwin) -> None:
        """The driver's end of a twin's line."""
        self._twin = twin

    def read(self, size: int, /) -> bytes:
        """Answers that are due."""
        self._check()
        return self._twin.take_answers(size)

    def write(self, data: bytes, /) -> int:
        """Bytes for the servos."""
        self._check()
        self._twin.receive(data)
        return len(data)

    def close(self) -> None:
        """Nothing is to be released."""

    def _check(self) -> None:
        if self._twin.faults.is_gone:
            raise OSError("the adapter was unplugged")


@final
class PseudoTerminal:
    """A pseudo-terminal at whose other end a twin answers: a serial port for any program. Not on Windows."""

    def __init__(self, twin: StsTwin) -> None:
        """Open a pseudo-terminal.

        Raises:
            DriveError: where the operating system has none.
        """
        try:
            import tty

            self._master, self._slave = os.openpty()
        except (ImportError, AttributeError, OSError) as error:
            raise DriveError(f"no pseudo-terminal: {error}; use the line in memory") from error
        tty.setraw(self._slave)
        self.port = os.ttyname(self._slave)
        """Name of the serial port."""
        self._twin = twin
        self._turn = threading.Lock()  # Of two that see the same bytes, the second would wait for more for ever.
        self.n_received = 0
        """Bytes received, all of whose answers that were due are sent [-]."""
        self.n_sent = 0
        """Bytes sent to the driver [-]."""

    def serve(self, longest: float = 0.0) -> None:
        """Pass on what has arrived, and the answers that are due; waits at most ``longest`` [s] for the first byte."""
        self._has_bytes(longest)
        with self._turn:
            data = os.read(self._master, 4096) if self._has_bytes(0.0) else b""
            self._twin.receive(data)
            while answers := self._twin.take_answers():
                self.n_sent += os.write(self._master, answers)
            self.n_received += len(data)

    def _has_bytes(self, longest: float) -> bool:
        return bool(select.select([self._master], [], [], longest)[0])

    @contextmanager
    def serving(self) -> Iterator[str]:
        """Serve in a thread; the port's name."""
        stopping = threading.Event()

        def run() -> None:
            while not stopping.is_set():
                self.serve(0.002)

        thread = threading.Thread(target=run, name="sts line", daemon=True)
        thread.start()
        try:
            yield self.port
        finally:
            stopping.set()
            thread.join()

    def close(self) -> None:
        """Close both ends, as an adapter that is unplugged; harmless when called again."""
        for end in {self._master, self._slave} - {-1}:
            os.close(end)
        self._master = self._slave = -1
