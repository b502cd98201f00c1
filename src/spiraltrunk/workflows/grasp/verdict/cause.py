"""Causes for which trials fail: a small set of physical events."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import final

from spiraltrunk.errors import DesignError, ModelError


@final
class Cause(Enum):
    """What went wrong first in a failed trial; the value is its name in reports.

    The thresholds are constants of `grasp_loss`, `push_loss` and `faults` beside this module, each with its reason.
    """

    MISSED = "missed"
    """The trunk lifted, struck or pushed without the object: it bore no weight of it, and left it where it was."""
    PUSHED_AWAY = "pushed away"
    """The trunk moved the object off its place, or off the way of a push, and never bore it."""
    TOPPLED = "toppled"
    """A standing object fell over on the ground, before it was lifted or after it was set down."""
    SLIPPED = "slipped"
    """The object slid along the trunk's surface under load and came out of the grip."""
    UNROLLED = "unrolled"
    """The trunk opened under the load: its joints lost bend while it bore the object, before the release."""
    DROPPED = "dropped"
    """The object left the trunk in the air at once and fell, or came down fast."""
    MISPLACED = "misplaced"
    """The object went with the trunk, but not as far as asked, or was not set down at rest within the zone."""
    ARM_LIMIT = "arm's limit"
    """The arm passed a limit of position, speed, acceleration, jerk or torque."""
    COLLIDED = "collided"
    """The object touched housing or arm, or these touched the ground."""
    OVERLOADED = "overloaded"
    """A joint was bent past its stop, or two bodies were pressed into one another: contact is not true to a robot."""
    REFUSED = "refused"
    """The strategy had no plan for the object; nothing moved."""
    FAULT = "simulation fault"
    """The solver warned, the simulation diverged, or the trial's process ended."""
    UNKNOWN = "unknown"
    """Nothing is recorded: the trial is of an earlier version."""


def find_error_cause(error: Exception) -> Cause:
    """Cause of a trial that an error ended: REFUSED where robot, object and strategy do not fit, else FAULT."""
    return Cause.REFUSED if isinstance(error, (DesignError, ModelError)) else Cause.FAULT


@final
@dataclass(frozen=True, kw_only=True)
class Failure:
    """Why a trial failed, and when."""

    cause: Cause
    """What went wrong first."""
    time: float
    """When it did [s]."""
