"""Load cells as the driver reads them: fresh tensions, or a fault."""

from __future__ import annotations

import math
from typing import final

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.motors.load_cell import LoadCells, TensionSample
from spiraltrunk.hardware.safety.fault import Fault, FaultKind
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.reading import Finding
from spiraltrunk.hardware.safety.watches.cell_watch import StillState, find_silent_cell, watch_still


@final
class TensionSide:
    """Load cells at some cables or all; one that is silent, stuck or gone is a fault and not used."""

    def __init__(self, cells: LoadCells | None, n_cable: int, limits: SafetyLimits) -> None:
        self._cells, self._limits, self._n_cable = cells, limits, n_cable
        self._still = [StillState()] * n_cable
        self._faults: tuple[Fault, ...] = ()
        self._samples: tuple[TensionSample | None, ...] = (None,) * n_cable

    @property
    def has_cell(self) -> tuple[bool, ...]:
        """Which cables have a load cell."""
        cables = () if self._cells is None else self._cells.settings.cables
        return tuple(cable in cables for cable in range(self._n_cable))

    @property
    def tensions(self) -> tuple[float | None, ...]:
        """Tension of each cable by its load cell [N]; None where there is no cell, or no reading that may be used."""
        return tuple(None if sample is None else sample.tension for sample in self._samples)

    def compute_age(self, cable: int, now: float) -> float | None:
        """Age of a cable's reading [s], infinite where it may not be used; None where there is no cell."""
        if not self.has_cell[cable]:
            return None
        sample = self._samples[cable]
        return math.inf if sample is None else now - sample.time

    def read(self, now: float) -> tuple[Fault, ...]:
        """Read the cells, and return the faults that were found."""
        if self._cells is None:
            return ()
        try:
            samples = self._cells.read()
        except DriveError as error:
            self._samples = (None,) * self._n_cable
            self._faults = (Fault(kind=FaultKind.LOAD_CELL, time=now, cable=None, text=str(error)),)
            return self._faults
        kept, faults = list(samples), []
        for cable in self._cells.settings.cables:
            self._still[cable], finding = self._watch(cable, samples[cable], now)
            if finding is not None:
                kept[cable] = None
                faults.append(Fault(kind=finding.kind, time=now, cable=cable, text=finding.text))
        self._samples, self._faults = tuple(kept), tuple(faults)
        return self._faults

    def _watch(self, cable: int, sample: TensionSample | None, now: float) -> tuple[StillState, Finding | None]:
        if sample is None:
            assert self._cells is not None
            return StillState(), find_silent_cell(self._cells.settings.age_max)
        return watch_still(self._still[cable], sample.tension, sample.time, self._limits)

    def find_obstacles(self) -> tuple[str, ...]:
        """Why torque must not be switched on, one line for each cell that cannot be used."""
        return tuple(
            fault.text if fault.cable is None else f"cable {fault.cable + 1}: {fault.text}" for fault in self._faults
        )

    def close(self) -> None:
        """Release the port."""
        if self._cells is not None:
            self._cells.close()
