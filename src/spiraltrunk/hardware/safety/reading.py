"""Inputs of the watches for one cable in one period of control."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.motors.motor_port import MotorState
from spiraltrunk.hardware.safety.fault import FaultKind


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class CableReading:
    """One cable and its motor: measured, estimated and commanded."""

    motor: MotorState
    """Latest feedback."""
    torque: float
    """Torque that was commanded in the period before [N m]."""
    pull: float = 0.0
    """Cable wound in since the straight, just taut trunk [m]."""
    speed: float = 0.0
    """Speed of winding in [m/s]."""
    tension: float = 0.0
    """Tension by a load cell, or as the winder estimates it [N]."""
    felt: float | None = None
    """Tension by a load cell [N], as it came; None where there is none."""
    estimated: float | None = None
    """Tension as the winder estimates it [N], where a load cell measures it: it follows fast changes more slowly, to
    which some limits are fit; None where that is ``tension``."""
    pull_at_tension: float | None = None
    """Pull at the time that this tension tells of [m]; None where that is now."""
    resistance: float = 0.0
    """Force against winding in as the winder estimates it, tension and dry friction; negative where the cable drives
    the drum in [N]."""
    tension_wanted: float = 0.0
    """Tension that the winder aims at in this period, after its limits [N]."""
    is_stirred: bool = False
    """Whether an alternating torque makes the estimate of the tension swing, see `winder.dither`."""

    is_loss_most: bool = False
    """Whether a load cell asks for more force than any friction explains, see `winder.loss`."""

    @property
    def by_motor(self) -> float:
        """Tension as the motor tells it [N]."""
        return self.tension if self.estimated is None else self.estimated


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class CableRange:
    """What a cable may do; the winder keeps inside, the watches raise a fault outside."""

    tension_least: float
    """Least load of a cable that is wound in at the floor of tension, which is the floor less the rotor's friction that
    is not compensated [N]."""
    tension_ceiling: float
    """Largest tension [N]."""
    pull_least: float
    """Least cable wound in [m]."""
    pull_most: float
    """Most cable wound in [m]."""
    drag: float = 0.0
    """Tension over speed with which the winder brakes a cable that it pays out [N s/m]."""
    friction: float = 0.0
    """Dry friction of the rotor at the drum, by which the tension of a drum at rest is uncertain [N]."""


@final
@dataclass(frozen=True, slots=True)
class Finding:
    """What a watch found in one period, before it has a time and a cable."""

    kind: FaultKind
    """What it is."""
    text: str
    """What was measured and what is allowed, one line."""
