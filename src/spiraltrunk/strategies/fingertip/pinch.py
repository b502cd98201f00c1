"""Strategy 2, pinch: the fingers at the trunk's tip pinch something slender across its axis.

Source: "Grasping by Spiraling", figure 5, strategy 2; the gripper's three fingers after its Methods. The trunk hangs
straight over the object's middle and turns until one finger stands against the other two across the axis that a camera
saw; they close, and the rest goes as in the tip grip.

Limits: slender things that lie on level ground, no wider than the fingers reach round; gripped near their middle, since
only friction keeps them level; a camera right to 3 mm and 3 deg. The trunk stays straight throughout: only the fingers
curl, so that no curvature travels along it.
"""

from __future__ import annotations

from typing import final

from spiraltrunk.control.messages import Observation
from spiraltrunk.strategies.fingertip.cycle import TipStrategy
from spiraltrunk.strategies.fingertip.moves import Curl


@final
class Pinch(TipStrategy):
    """One finger against the others across a slender object."""

    name = "pinch"
    number = 2
    objects = ("rod-10", "rod-20", "bar-12x20", "bar-20x20")

    def curl(self, observation: Observation) -> Curl | None:
        """None: the trunk hangs straight."""
        return None
