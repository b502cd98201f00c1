"""Load cells of a robot file: their port, their cables, and their calibration. Never tried on real cells."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from spiraltrunk.checks import check_numbers, check_text, check_type
from spiraltrunk.errors import DesignError, DriveError, Unquoted
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.bus.bus_address import check_port
from spiraltrunk.hardware.motors.load_cell import LoadCellSettings

_OFFSET_MOST, _SCALE_MOST = 200.0, 1e3
_PORT = "/dev/ttyACM1, the load cells' board on a serial port"


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class LoadCellSetup:
    """Load cells at the cables, whose amplifiers are read by one board on a serial port."""

    port: str
    """Serial port."""
    cables: tuple[int, ...]
    """Cable of each cell, counted from 1, in the order of the board's frame."""
    offsets: tuple[float, ...] = ()
    """What each cell reads with a slack cable, -200 to 200 [N]; 0 by default."""
    scales: tuple[float, ...] = ()
    """Tension per newton of reading, -1000 to 1000 [-]; 1 by default, -1 where a cell is upside down."""

    def __post_init__(self) -> None:
        check_text("load_cells.port", self.port)
        try:
            check_port(self.port, self.port, _PORT)
        except DriveError:
            raise DesignError("load_cells.port", got=self.port, allowed=_PORT) from None
        check_type("load_cells.cables", self.cables, tuple)
        counts = [cable for cable in self.cables if isinstance(cable, int) and cable >= 1]
        if not counts or len(set(counts)) < len(self.cables):
            got = Unquoted(str(list(self.cables))[:80])
            raise DesignError("load_cells.cables", got=got, allowed="one cable for each cell, from 1, no cable twice")
        for name, most in (("offsets", _OFFSET_MOST), ("scales", _SCALE_MOST)):
            values = getattr(self, name)
            if values != ():
                check_numbers(f"load_cells.{name}", values, count=len(self.cables), least=-most, most=most)
        if 0 in self.scales:
            got = Unquoted(str(list(self.scales))[:80])
            raise DesignError("load_cells.scales", got=got, allowed="numbers other than 0")

    def build_settings(self, n_cable: int) -> LoadCellSettings:
        """Settings of the reader for a design of so many cables."""
        n = len(self.cables)
        return LoadCellSettings(
            port=self.port, cables=tuple(cable - 1 for cable in self.cables), n_cable=n_cable,
            offsets=self.offsets or (0.0,) * n, scales=self.scales or (1.0,) * n,
        )  # fmt: skip
