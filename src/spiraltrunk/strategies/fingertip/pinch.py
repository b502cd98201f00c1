"""Strategy 2, pinch: the fingers at the trunk's tip pinch a slender object across its axis.

Source: "Grasping by Spiraling", figure 5, strategy 2; the gripper's three fingers after its Methods. The trunk hangs
straight over the object's middle. It turns until one finger opposes the other two across the axis that a camera
observed. The rest goes as in the tip grip.

Limits: slender objects that lie on level ground, no wider than the fingers reach round, and gripped near their middle,
since friction alone keeps them level; a camera with errors of 3 mm and 3 deg at most. The trunk stays straight: only
the fingers curl, and no curvature travels along it.
"""

from __future__ import annotations

from typing import final

from spiraltrunk.strategies.fingertip.cycle import TipStrategy


@final
class Pinch(TipStrategy):
    """One finger against the others across a slender object."""

    name = "pinch"
    number = 2
    objects = ("rod-10", "rod-20", "bar-12x20", "bar-20x20")
