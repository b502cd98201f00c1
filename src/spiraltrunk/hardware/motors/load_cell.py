"""Tension sensors: load cells at the cables whose amplifier board sends telemetry on a serial line.

A frame is ``AA 55``, then little endian the board's time (u32) [us], one tension per cell (f32) [N] and one length per
cell (f32) [mm], without checksum. Nothing in it is trusted: a frame counts where its values are plausible, its time is
new, and the next frame begins right behind it. Never tried on a real board.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from typing import NamedTuple, Self, final

from spiraltrunk.checks import check_count, check_number, check_numbers, check_text, check_type
from spiraltrunk.errors import DesignError, DriveError, describe_reason
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.clock import Clock
from spiraltrunk.hardware.motors.serial_port import SerialStream, open_serial

_MARK = b"\xaa\x55"
STANDARD_GRAVITY = 9.80665
"""Standard gravity [m/s^2]."""
_LENGTH_MAX = 1e4
"""Largest plausible length [mm] (ours)."""
_RECEIVED_MAX = 8192
"""Most bytes that are kept [bytes] (ours): older ones are dropped."""


@final
class TensionSample(NamedTuple):
    """Measured tension of one cable."""

    time: float
    """Arrival on the driver's clock [s]."""
    tension: float
    """Tension [N]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class LoadCellSettings:
    """Load cells on one serial port."""

    port: str
    """Serial port; there is no default."""
    cables: tuple[int, ...]
    """Cable that each cell measures, in the order of the frame, counted from 0."""
    n_cable: int = 3
    """Number of cables of the design."""
    offsets: tuple[float, ...]
    """What each cell reads with a slack cable [N]."""
    scales: tuple[float, ...]
    """Tension per newton of reading, per cell [-]; -1 where a cell is mounted the other way round."""
    tension_max: float = 200.0
    """Largest plausible magnitude of a reading [N] (ours)."""
    age_max: float = 0.05
    """Age from which a reading no longer counts [s] (ours)."""
    baud: int = 115_200
    """Baud rate [bit/s]; unconfirmed, a USB port takes any."""

    def __post_init__(self) -> None:
        check_text("port", self.port)
        check_type("cables", self.cables, tuple)
        for i, cable in enumerate(self.cables):
            check_count(f"cables[{i}]", cable, least=0, most=self.n_cable - 1)
        if not self.cables or len(set(self.cables)) < len(self.cables):
            raise DesignError("cables", got=self.cables, allowed="one cable per cell, no cable twice")
        check_numbers("offsets", self.offsets, count=len(self.cables))
        check_numbers("scales", self.scales, count=len(self.cables), least=-1e3, most=1e3)
        if 0 in self.scales:
            raise DesignError("scales", got=self.scales, allowed="numbers other than 0")
        check_number("tension_max", self.tension_max, above=0.0, most=1e4)
        check_number("age_max", self.age_max, above=0.0, most=1.0)
        check_count("baud", self.baud, least=1200, most=4_000_000)


@final
class LoadCells:
    """Load cells that send on their own."""

    def __init__(self, settings: LoadCellSettings, stream: SerialStream, clock: Clock) -> None:
        """Read a stream that is open."""
        self.settings = settings
        self.n_refused = 0
        """Frames whose values or time were not believed [-]."""
        n = len(settings.cables)
        self._frame = struct.Struct(f"<2xI{n}f{n}f")
        self._stream = stream
        self._clock = clock
        self._received = bytearray()
        self._is_locked = False
        self._board_time: int | None = None
        self._samples: dict[int, TensionSample] = {}

    @classmethod
    def from_settings(cls, settings: LoadCellSettings, clock: Clock) -> Self:
        """Open the port.

        Raises:
            DriveError: where it cannot be opened.
            MissingPackage: without pyserial.
        """
        return cls(settings, open_serial(settings.port, settings.baud), clock)

    def read(self) -> tuple[TensionSample | None, ...]:
        """Latest tension of each cable; None where no cell measures it or its reading is too old. Never waits.

        Raises:
            DriveError: where the port is gone.
        """
        try:
            self._received += self._stream.read(_RECEIVED_MAX)
        except (OSError, TypeError) as error:
            raise DriveError(
                f"load cells on {self.settings.port}: {describe_reason(error)}; is the board plugged in?"
            ) from error
        del self._received[: max(0, len(self._received) - _RECEIVED_MAX)]
        self._take_frames()
        now = self._clock.now()
        return tuple(self._find_fresh(cable, now) for cable in range(self.settings.n_cable))

    def close(self) -> None:
        """Release the port; harmless when called again."""
        self._stream.close()

    def _find_fresh(self, cable: int, now: float) -> TensionSample | None:
        sample = self._samples.get(cable)
        return sample if sample is not None and now - sample.time <= self.settings.age_max else None

    def _take_frames(self) -> None:
        size = self._frame.size
        while (start := self._received.find(_MARK)) >= 0:
            self._is_locked = self._is_locked and start == 0
            del self._received[:start]
            behind = self._received[size : size + 2]
            if len(self._received) < size or (not self._is_locked and len(behind) < 2):
                return
            if behind == _MARK[: len(behind)] and self._is_taken(bytes(self._received[:size])):
                self._is_locked = True
                del self._received[:size]
            else:
                self._is_locked = False
                del self._received[0]
        del self._received[: max(0, len(self._received) - 1)]

    def _is_taken(self, frame: bytes) -> bool:
        """Take in a frame, unless its time is old; whether its values are plausible."""
        board_time, *values = self._frame.unpack(frame)
        n = len(self.settings.cables)
        readings, lengths = values[:n], values[n:]
        if not all(abs(reading) <= self.settings.tension_max for reading in readings) or not all(
            abs(length) <= _LENGTH_MAX for length in lengths
        ):  # Not true of NaN either.
            self.n_refused += 1
            return False
        last, self._board_time = self._board_time, board_time
        if last is not None and not 0 < (board_time - last) % 2**32 < 2**31:  # Frozen, or restarted.
            self.n_refused += 1
            return True
        now = self._clock.now()
        for cell, cable in enumerate(self.settings.cables):
            tension = self.settings.scales[cell] * (readings[cell] - self.settings.offsets[cell])
            self._samples[cable] = TensionSample(now, tension)
        return True


def check_known_mass(tension: float, mass: float) -> None:
    """Refuse a cell that does not read the weight of a known mass: ``T = m g``, within 10 % (ours).

    Args:
        tension: measured tension of a cable on which the mass hangs [N].
        mass: the mass [kg].

    Raises:
        DriveError: with the unit that the reading looks like, where it is one.
        DesignError: where the mass is not positive.
    """
    check_number("mass", mass, above=0.0, most=100.0)
    for unit, expected in (("N", mass * STANDARD_GRAVITY), ("kg", mass), ("g", 1e3 * mass), ("lbf", 2.20462 * mass)):
        if math.isclose(tension, expected, rel_tol=0.1):
            if unit == "N":
                return
            raise DriveError(
                f"{mass:g} kg read {tension:g}: the cell sends {unit}; "
                f"allowed: newtons, {mass * STANDARD_GRAVITY:.3g} N"
            )
    raise DriveError(
        f"{mass:g} kg read {tension:g} N; allowed: {mass * STANDARD_GRAVITY:.3g} N within 10 %: set scale and offset"
    )
