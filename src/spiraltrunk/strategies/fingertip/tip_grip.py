"""Strategies 2 and 3: pinch of a slender object across its axis, and tip grip of a small solid from above.

Source: "Grasping by Spiraling", figure 5, strategies 2 and 3; the gripper's three fingers after its Methods. The trunk
hangs straight, with open fingers round the object as a camera observed it: only the fingers curl, and no curvature
travels along the trunk. For a pinch the trunk first turns until one finger opposes the other two across the axis. The
fingers close, a tip grip's below the widest part of the solid. The arm lifts, checks, carries, holds and sets down.

Limits: objects on level ground, no wider than the fingers reach round; a camera with errors of 3 mm and 3 deg at most.
A pinch takes slender objects that lie, near their middle, since friction alone keeps them level. A tip grip takes
solids about as wide as high, and what has a handle round its body; cones slip where friction is barely more than
their slope.
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


@final
class TipGrip(TipStrategy):
    """Three fingers round a small solid."""

    name = "tip-grip"
    number = 3
    orientation = "upright"
    objects = ("ball-30", "cube-28", "cylinder-32", "cone-35")
