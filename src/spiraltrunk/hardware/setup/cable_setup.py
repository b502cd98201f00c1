"""What a robot file says of the cables."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from spiraltrunk.checks import check_number, check_numbers
from spiraltrunk.field_docs import explain_fields

STIFFNESS_LEAST, STIFFNESS_MOST = 5e3, 2e5
"""Range of a cable's stiffness [N/m] (ours): 0.6 m of 1 mm braid have 2e4, of steel rope some 1e5."""

LEAST_FLOOR = 0.1
"""Least pretension of a robot file [N] (ours): less holds no cable on its drum."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class CableSetup:
    """The cables; each limit can only be lower than that of the design, its drum and the motor."""

    tension_floor: float | None = None
    """Pretension [N]; None for the winder's own."""
    tension_max: float | None = None
    """Largest tension that is set [N]; commands may ask for more, as for a motor that is weaker."""
    speed_max: float | None = None
    """Largest speed of a cable [m/s]."""
    stiffness: float | None = None
    """Tension per elongation of cable, drum and gears with the motor at rest, measured [N/m]; None for 2e4."""
    slack: tuple[float, ...] = ()
    """Residual slack of each cable at its full stroke, from -0.1 to 0.1 [m]; none by default. See `winder.slack`."""

    def __post_init__(self) -> None:
        if self.tension_floor is not None:
            check_number("cables.tension_floor", self.tension_floor, least=LEAST_FLOOR, below=100.0)
        if self.tension_max is not None:
            check_number("cables.tension_max", self.tension_max, above=0.0, most=1e4)
        if self.speed_max is not None:
            check_number("cables.speed_max", self.speed_max, above=0.0, most=100.0)
        if self.stiffness is not None:
            check_number("cables.stiffness", self.stiffness, least=STIFFNESS_LEAST, most=STIFFNESS_MOST)
        check_numbers("cables.slack", self.slack, above=-0.1, most=0.0999)
