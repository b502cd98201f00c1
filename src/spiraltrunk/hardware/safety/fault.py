"""Faults: what can go wrong, and one that has."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import final

from spiraltrunk.field_docs import explain_fields


@final
class FaultKind(Enum):
    """Every cause for which a driver leaves the armed state; its value is what logs and messages call it."""

    BAD_COMMAND = "bad command"
    STALE_COMMAND = "stale command"
    STALE_FEEDBACK = "stale feedback"
    FROZEN_FEEDBACK = "frozen feedback"
    IMPLAUSIBLE_FEEDBACK = "implausible feedback"
    BUS = "bus"
    COUNT_LOST = "turn count lost"
    OVER_TEMPERATURE = "over-temperature"
    VOLTAGE = "supply voltage"
    MOTOR = "reported by the motor"
    STALL = "stall"
    SLACK = "slack, broken or tangled cable"
    CABLE_SLIP = "slipped, broken or tangled cable"
    CABLE_LENGTHS = "cable does not follow its drum"
    TANGLED_DRUM = "tangled drum"
    OVER_TENSION = "tension over its ceiling"
    LENGTH_LIMIT = "length limit"
    LOAD_CELL = "load cell"
    HOMING = "homing failed"
    ARM = "arm"
    SERVO = "servo"
    WATCHDOG = "watchdog"
    STOPPED = "stopped by a person"

    @property
    def needs_homing(self) -> bool:
        """Whether the zeros of the drums are in doubt afterwards, so that the robot is armed only after homing."""
        return self in _UNHOMED


_UNHOMED = frozenset(
    {
        FaultKind.FROZEN_FEEDBACK,
        FaultKind.IMPLAUSIBLE_FEEDBACK,
        FaultKind.COUNT_LOST,
        FaultKind.MOTOR,
        FaultKind.SLACK,
        FaultKind.CABLE_SLIP,
        FaultKind.CABLE_LENGTHS,
        FaultKind.TANGLED_DRUM,
        FaultKind.LENGTH_LIMIT,
        FaultKind.HOMING,
    }
)
"""Faults after which the angle of a motor no longer tells the length of its cable, or may not have done so before."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Fault:
    """A fault that was noticed."""

    kind: FaultKind
    """What it is."""
    time: float
    """When it was noticed, on the driver's clock [s]."""
    cable: int | None
    """Cable that it concerns, counted from 0; None where it concerns all."""
    text: str
    """What was measured and what is allowed, one line."""
