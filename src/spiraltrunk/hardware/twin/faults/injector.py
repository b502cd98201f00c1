"""Faults in time: when each begins and ends."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import final

from spiraltrunk.checks import check_number
from spiraltrunk.errors import DesignError, UnknownName
from spiraltrunk.hardware.twin.device import TwinDevice
from spiraltrunk.hardware.twin.faults.device_fault import DeviceFault
from spiraltrunk.hardware.twin.faults.faulty_bus import FaultyBus, check_wrapped
from spiraltrunk.hardware.twin.faults.frame_fault import FrameFault
from spiraltrunk.hardware.twin.motors import MotorTwins

_ROUNDING = 1e-9


@final
@dataclass(kw_only=True)
class _Entry:
    """A fault that was injected."""

    fault: FrameFault | DeviceFault
    at: float
    until: float
    is_begun: bool = False


@final
class FaultInjector(TwinDevice):
    """Lets faults begin and end, beforehand or while the twin runs; attach it to the clock before the motors."""

    def __init__(
        self,
        motors: MotorTwins,
        bus: FaultyBus | None = None,
        *,
        on_change: Callable[[float, str, bool], None] | None = None,
    ) -> None:
        """No faults yet.

        Args:
            motors: what faults of devices happen to.
            bus: what faults of frames happen to, at either end; None where there will be none.
            on_change: called with the time [s], the fault's name, and whether it has begun (or ended).
        """
        self._motors, self._bus = motors, bus
        self._on_change = on_change
        self._entries: list[_Entry] = []
        self._time = 0.0

    @property
    def active(self) -> tuple[FrameFault | DeviceFault, ...]:
        """Faults that have begun and not ended, the earliest first."""
        return tuple(entry.fault for entry in self._entries if entry.is_begun)

    def inject(self, fault: FrameFault | DeviceFault, *, at: float = 0.0, until: float = math.inf) -> None:
        """Let a fault begin at ``at`` and end at ``until`` [s]; at once where that has passed.

        Raises:
            DesignError: where the times are no numbers, or the end is not after the beginning.
            DriveError: where the fault begins at once and cannot.
        """
        check_number("at", at, least=0.0)
        if not until > at:
            raise DesignError("until", got=until, allowed=f"after {at:g} s, when the fault begins")
        if isinstance(fault, FrameFault):
            check_wrapped(self._bus)
        entry = _Entry(fault=fault, at=at, until=until)
        if at <= self._time + _ROUNDING:
            self._begin(entry)
        self._entries.append(entry)

    def clear(self, name: str | None = None) -> None:
        """End the faults of this name, begun or not; all of them by default.

        Raises:
            UnknownName: where there is none of this name.
        """
        chosen = [entry for entry in self._entries if name in (None, entry.fault.name)]
        if name is not None and not chosen:
            raise UnknownName("injected fault", name, sorted({entry.fault.name for entry in self._entries}))
        for entry in chosen:
            self._end(entry)

    def advance(self, dt: float) -> None:
        """See `TwinDevice.advance`."""
        self._time += dt
        now = self._time + _ROUNDING
        for entry in tuple(self._entries):
            if not entry.is_begun and entry.at <= now:
                self._begin(entry)
            if entry.is_begun and (entry.until <= now or self._is_over(entry)):
                self._end(entry)

    def _is_over(self, entry: _Entry) -> bool:
        """Whether a fault of a device is over by itself."""
        fault = entry.fault
        return isinstance(fault, DeviceFault) and fault.step(self._motors, self._time - entry.at + _ROUNDING)

    def _begin(self, entry: _Entry) -> None:
        if isinstance(entry.fault, FrameFault):
            check_wrapped(self._bus).begin(entry.fault)
        else:
            entry.fault.begin(self._motors)
        entry.is_begun, entry.at = True, self._time
        self._report(entry)

    def _end(self, entry: _Entry) -> None:
        self._entries = [other for other in self._entries if other is not entry]
        if not entry.is_begun:
            return
        if isinstance(entry.fault, FrameFault):
            check_wrapped(self._bus).end(entry.fault)
        else:
            entry.fault.end(self._motors)
        entry.is_begun = False
        self._report(entry)

    def _report(self, entry: _Entry) -> None:
        if self._on_change is not None:
            self._on_change(self._time, entry.fault.name, entry.is_begun)
