"""Limits of a winder: from the design, its drum and the motor's data sheet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from spiraltrunk.checks import check_number
from spiraltrunk.control.plant import TENSION_SLEW
from spiraltrunk.design.drum import SPARE
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, Unquoted
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.motors.motor_port import MotorDataSheet
from spiraltrunk.hardware.winder.drum import DrumGeometry

TENSION_FLOOR = 1.0
"""Least pretension that keeps a cable on its drum [N] (ours: a sixtieth of the paper trunk's largest tension)."""

FRICTION_SHARE = 0.8
"""Share of the dry friction that is compensated [-] (ours: less than all, so that the rotor does not creep)."""

FLOOR_MARGIN = 1.5
"""Pretension over the friction that is left at least, so that a slack cable is wound in [-] (ours)."""

FULL_SPEED_DRAG = 15.0
"""Tension that winding at full speed costs, and paying out adds: the damping on a soft trunk [N] (ours)."""

SPEED_SHARE = 0.8
"""Largest speed of winding over the motor's speed without load [-] (ours: torque is left to slow down)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class WinderLimits:
    """What a winder never exceeds, whatever it is commanded."""

    tension_floor: float
    """Pretension [N]."""
    tension_max: float
    """Largest tension that a command may ask for, the design's [N]."""
    tension_ceiling: float
    """Largest tension that is set: the design's, or the motor's torque without its friction over the radius [N]."""
    tension_slew: float
    """Largest rate of change of the set tension [N/s]."""
    speed_max: float
    """Largest speed of the cable [m/s]."""
    drag: float
    """Tension over speed of a moving cable [N s/m]."""
    pull_min: float
    """Least pull since the straight trunk, negative [m]."""
    pull_max: float
    """Largest pull since the straight trunk [m]."""
    torque_max: float
    """Largest torque, the data sheet's [N m]."""


def build_limits(
    design: TrunkDesign, drum: DrumGeometry, motor: MotorDataSheet, tension_floor: float | None = None
) -> WinderLimits:
    """Limits of one winder; those of pull are the drum's travel, extended by the share `SPARE` on both sides.

    The floor is `TENSION_FLOOR` by default, or what a slack cable needs to be wound in: `FLOOR_MARGIN` times the
    friction over the radius that is not compensated. A cable that the trunk pulls off a drum which stands still carries
    up to twice the friction more.

    Raises:
        DesignError: where the floor is out of its range, or the motor is too weak for twice the floor.
    """
    innermost = drum.design.winding_radius
    is_given = tension_floor is not None
    if tension_floor is None:
        tension_floor = max(TENSION_FLOOR, FLOOR_MARGIN * (1 - FRICTION_SHARE) * motor.rotor_friction / innermost)
    check_number("winder.tension_floor", tension_floor, above=0.0, below=100.0)
    strongest = (motor.torque_max - motor.rotor_friction) / drum.radius_max
    ceiling = min(design.cable.tension_max, strongest)
    if not ceiling >= 2 * tension_floor:
        most = f"{ceiling:.3g} N at most with {motor.name} on {1e3 * drum.radius_max:.1f} mm"
        if is_given:
            allowed = f"up to {ceiling / 2:.3g} N, half of the tension of {most}"
            raise DesignError("winder.tension_floor", got=Unquoted(f"{tension_floor:g} N"), allowed=allowed)
        allowed = f"at least twice the floor of {tension_floor:g} N"
        raise DesignError("winder.tension", got=Unquoted(most), allowed=allowed)
    speed_max = SPEED_SHARE * motor.speed_max * innermost
    return WinderLimits(
        tension_floor=tension_floor, tension_max=design.cable.tension_max, tension_ceiling=ceiling,
        tension_slew=TENSION_SLEW, speed_max=speed_max, drag=FULL_SPEED_DRAG / speed_max,
        pull_min=-(1 + SPARE) * drum.design.travel_out, pull_max=(1 + SPARE) * drum.design.travel_in,
        torque_max=motor.torque_max,
    )  # fmt: skip
