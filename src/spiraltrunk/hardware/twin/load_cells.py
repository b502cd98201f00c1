"""Twin of the load cells at the cables, with the board that sends their telemetry, and faults on request."""

from __future__ import annotations

import random
import struct
from collections.abc import Callable, Sequence
from typing import final

from spiraltrunk.checks import check_number
from spiraltrunk.hardware.motors.load_cell import LoadCellSettings
from spiraltrunk.hardware.twin.device import TwinDevice

NOISE = 0.02
"""Standard deviation of a cell's reading [N] (ours: measured on no cell)."""

PERIOD = 2e-3
"""Time between two frames [s] (ours; a maker's board sends at 600 Hz)."""

_ROUNDING = 1e-9
_BUFFERED = 4096
"""Bytes that the adapter keeps for a driver that does not read [bytes] (ours)."""


@final
class LoadCellTwin(TwinDevice):
    """Cells, amplifiers and board; also the driver's end of its serial line.

    A cell reads ``offset + T / scale`` and noise, so that a driver with the same settings measures the true tension.
    Attach it behind the motors whose cables it measures.
    """

    def __init__(
        self,
        settings: LoadCellSettings,
        read_tensions: Callable[[], Sequence[float]],
        *,
        noise: float = NOISE,
        period: float = PERIOD,
        seed: int = 0,
    ) -> None:
        """Cells that work.

        Args:
            settings: cables, offsets and scales.
            read_tensions: true tension of each cable [N].
            noise: standard deviation of a reading [N].
            period: time between two frames [s].
            seed: seed of the noise.
        """
        check_number("load_cells.noise", noise, least=0.0, most=100.0)
        check_number("load_cells.period", period, least=1e-4, most=1.0)
        self.stuck: set[int] = set()
        """Cables whose cells repeat their last reading."""
        self.wire_off: dict[int, float] = {}
        """Cables whose cells have a broken wire, with what is read then [N]."""
        self.is_silent = False
        """Whether the board sends nothing."""
        self.is_gone = False
        """Whether its plug was pulled."""
        self.is_closed = False
        """Whether the driver has released the port."""
        self._settings, self._read_tensions = settings, read_tensions
        self._noise, self._period, self._random = noise, period, random.Random(seed)
        self._frame = struct.Struct(f"<2sI{2 * len(settings.cables)}f")
        self._readings = [0.0] * len(settings.cables)
        self._time, self._wait = 0.0, period
        self._sent = bytearray()

    @property
    def cables(self) -> tuple[int, ...]:
        """Cables with a cell, counted from 0."""
        return self._settings.cables

    def advance(self, dt: float) -> None:
        """See `TwinDevice.advance`: a frame, where one is due."""
        self._time += dt
        self._wait -= dt
        if self._wait > _ROUNDING:
            return
        self._wait += self._period
        tensions, settings = self._read_tensions(), self._settings
        for i, cable in enumerate(settings.cables):
            if cable not in self.stuck:
                true = settings.offsets[i] + tensions[cable] / settings.scales[i]
                self._readings[i] = self.wire_off.get(cable, true) + self._random.gauss(0.0, self._noise)
        if not (self.is_silent or self.is_gone):
            micros = round(1e6 * self._time) % 2**32
            self._sent += self._frame.pack(b"\xaa\x55", micros, *self._readings, *[0.0] * len(self._readings))
            del self._sent[: max(0, len(self._sent) - _BUFFERED)]

    def read(self, size: int, /) -> bytes:
        """Bytes that arrived; OSError where the plug was pulled."""
        if self.is_gone:
            raise OSError("the adapter was unplugged")
        taken = bytes(self._sent[:size])
        del self._sent[:size]
        return taken

    def write(self, data: bytes, /) -> int:
        """Take bytes and ignore them: the board listens to nothing."""
        return len(data)

    def close(self) -> None:
        """Release the port."""
        self.is_closed = True
