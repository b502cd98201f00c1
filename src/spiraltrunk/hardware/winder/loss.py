"""Loss of a winder with a load cell: the commanded force that does not reach its cable."""

from __future__ import annotations

from typing import NamedTuple, final

LOSS_RATE = 0.5
"""Rate at which a load cell's tension corrects the estimated loss, over the observer's [-] (ours)."""

LOSS_SHARE = 0.2
"""Largest loss over the tension's ceiling, beside the dry friction [-] (ours)."""


@final
class LossBounds(NamedTuple):
    """What the loss of a winder is kept in."""

    friction: float
    """Dry friction of the rotor at the drum [N]."""
    floor: float
    """Floor of the tension [N]."""
    ceiling: float
    """Ceiling of the tension [N]."""

    @property
    def most(self) -> float:
        """Largest magnitude of the loss [N]."""
        return self.friction + LOSS_SHARE * self.ceiling


def follow_loss(before: float, loss: float, measured: float, share: float, bounds: LossBounds) -> float:
    """Estimate of the loss after a step [N]: dry friction, and what the motor's torque falls short of its command.

    The loss ``f - m dv/dt - T`` passes a first-order low-pass, with f the force after all limits, so that the estimate
    does not wind up. A drum at rest is turned by it until the cable has the set tension, as by an integral part.

    Args:
        before: estimate before [N].
        loss: commanded force less that of inertia and the measured tension [N].
        measured: tension by the load cell [N].
        share: share of the way that the low-pass goes [-].
        bounds: what it is kept in; a cable at the floor of tension gets no negative loss, which would pay it out.
    """
    least = -bounds.most if measured > bounds.floor else 0.0
    return min(max(before + share * (loss - before), least), bounds.most)


def is_most(loss: float, bounds: LossBounds) -> bool:
    """Whether a loss [N] stands at its bound, within a hundredth."""
    return abs(loss) > 0.99 * bounds.most
