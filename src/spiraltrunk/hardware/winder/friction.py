"""Direction in which a rotor's dry friction acts, from its encoder: what is compensated, and what tension it hides.

Two elements in series. A play (backlash) of half width h follows the angle as r(t) = min(max(r, angle - h), angle + h),
so that a last digit that flickers at rest moves nothing; a Prandtl element follows r and is full after some steps of
motion (Brokate and Sprekels, "Hysteresis and Phase Transitions", 1996, section 2.2: play and stop operators). Nothing
here was tried on a real motor.
"""

from __future__ import annotations

from typing import Final, NamedTuple, final

PLAY_STEPS: Final = 1.0
"""Half width of the play in encoder steps [-] (ours: a count that flickers over three neighbouring values is rest)."""

FRICTION_STEPS: Final = 2.0
"""Encoder steps of motion that turn the direction of friction from none to full [-] (ours)."""

FRICTION_TIME: Final = 0.05
"""Time in which a changing tension, or standstill, turns that direction [s] (ours)."""


@final
class FrictionDirection(NamedTuple):
    """Direction of winding that dry friction opposes."""

    share: float = 0.0
    """-1 while paying out, 1 while winding in [-]."""
    angle: float = 0.0
    """The motor's angle behind the play [rad]."""


def follow_motion(before: FrictionDirection, angle: float, angle_step: float) -> FrictionDirection:
    """Direction after the motor was seen at ``angle`` [rad] by an encoder of this resolution [rad]."""
    play = PLAY_STEPS * angle_step
    reached = min(max(before.angle, angle - play), angle + play)
    share = before.share + (reached - before.angle) / (FRICTION_STEPS * angle_step)
    return FrictionDirection(min(max(share, -1.0), 1.0), reached)


def lead_at_rest(before: FrictionDirection, dt: float, *, is_let_down: bool) -> FrictionDirection:
    """Direction compensated at standstill, turned for ``dt`` [s]: out while the tension is let down, else in."""
    sense, most = -1.0 if is_let_down else 1.0, dt / FRICTION_TIME
    return before._replace(share=min(max(sense, before.share - most), before.share + most))
