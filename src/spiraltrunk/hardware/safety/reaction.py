"""Reaction to a fault: the torque ramps to that of the floor of tension within a fixed time, and then it is off.

A sudden release whips, and a slow one is a risk of its own: `RAMP_TIME` = 40 ms takes a cable from 60 N to 2 N at
1450 N/s, and leaves 60 ms of the 100 ms in which the safe state has to be reached for noticing the fault. The torque
depends on the time since the fault alone, neither on feedback, which may be what is at fault, nor on how many commands
arrived: when a bus returns, what is sent is the torque of that moment. There is no position in it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

from spiraltrunk.field_docs import explain_fields

RAMP_TIME: Final = 0.040
"""Time from the fault to the torque of the floor, after which the torque is off [s] (ours)."""

LET_GO_TIME: Final = 0.500
"""The same where nothing is wrong and a person disarms [s] (ours): 60 N at 116 N/s."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class Ramp:
    """A ramp from the last torques to zero."""

    start: float
    """When it began [s]."""
    duration: float = RAMP_TIME
    """Time to the floor [s]."""
    torques: tuple[float, ...]
    """Last torques commanded before it [N m]."""
    floors: tuple[float, ...]
    """Torques of the floor of tension [N m]."""


def is_over(ramp: Ramp, now: float) -> bool:
    """Whether the torques are off."""
    return now - ramp.start >= ramp.duration


def ramp_torques(ramp: Ramp, now: float) -> tuple[float, ...]:
    """Torques at ``now`` [N m]: never larger than before, never of the other sign, zero after the ramp.

    tau(t) = tau_floor + (tau_0 - tau_floor) (1 - t / T), with tau_floor at most tau_0 and zero for a motor that was
    paying out.
    """
    if is_over(ramp, now):
        return (0.0,) * len(ramp.torques)
    left = min(1.0, 1.0 - (now - ramp.start) / ramp.duration)
    torques = []
    for torque, floor in zip(ramp.torques, ramp.floors, strict=True):
        end = min(torque, floor) if torque > 0.0 else 0.0
        torques.append(end + (torque - end) * left)
    return tuple(torques)
