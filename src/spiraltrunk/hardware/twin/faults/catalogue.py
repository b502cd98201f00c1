"""Faults by name."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from spiraltrunk.errors import DesignError, UnknownName, Unquoted
from spiraltrunk.hardware.twin.faults.cell_faults import CellSilent, CellStuck, CellUnplugged, CellWireOff
from spiraltrunk.hardware.twin.faults.device_fault import DeviceFault
from spiraltrunk.hardware.twin.faults.device_faults import (
    CableBreak,
    CableSlip,
    EncoderWrap,
    IdSwap,
    OverTemperature,
    PowerCycle,
    Stall,
    TangledDrum,
)
from spiraltrunk.hardware.twin.faults.frame_fault import FrameFault
from spiraltrunk.hardware.twin.faults.frame_faults import (
    BusOff,
    Corrupt,
    Delay,
    Duplicate,
    FrameLoss,
    FrozenFeedback,
    Reorder,
)

FAULTS: Mapping[str, type[FrameFault] | type[DeviceFault]] = {
    kind.name: kind
    for kind in (
        FrameLoss, Delay, Reorder, Duplicate, BusOff, FrozenFeedback, Corrupt,
        IdSwap, EncoderWrap, PowerCycle, OverTemperature, Stall, CableBreak, CableSlip, TangledDrum,
        CellSilent, CellUnplugged, CellStuck, CellWireOff,
    )
}  # fmt: skip
"""Every fault that a twin can have; the docstring of each describes the fault, those of its fields its settings."""


def build_fault(name: str, settings: Mapping[str, Any] | None = None) -> FrameFault | DeviceFault:
    """A fault from its name, with settings where they differ from its defaults.

    Raises:
        UnknownName: where there is no such fault.
        DesignError: where it has no such setting, or a value is not allowed.
    """
    if name not in FAULTS:
        raise UnknownName("fault", name, FAULTS)
    kind, given = FAULTS[name], dict(settings or {})
    known = [field.name for field in dataclasses.fields(kind)]  # type: ignore[arg-type]
    unknown = [setting for setting in given if setting not in known]
    if unknown:
        raise DesignError(f"{name}: setting", got=Unquoted(unknown[0]), allowed=", ".join(known))
    return kind(**given)


def describe_fault(name: str) -> str:
    """What a fault does, in one line."""
    if name not in FAULTS:
        raise UnknownName("fault", name, FAULTS)
    return (FAULTS[name].__doc__ or name).strip().splitlines()[0]
