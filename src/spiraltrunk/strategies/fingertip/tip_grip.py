"""Strategy 3, tip grip: the fingers at the trunk's tip take a small solid from above.

Source: "Grasping by Spiraling", figure 5, strategy 3; the gripper's three fingers after its Methods. The trunk hangs
straight, with open fingers round the object as a camera observed it. The fingers close below its widest part. The arm
lifts, checks, carries, holds and sets down.

Limits: solids about as wide as high, up to what the fingers reach round, standing or resting on level ground; a camera
with an error of 3 mm at most. Cones slip where friction is barely more than their slope. The trunk stays straight: only
the fingers curl, and no curvature travels along it.
"""

from __future__ import annotations

from typing import final

from spiraltrunk.strategies.fingertip.cycle import TipStrategy


@final
class TipGrip(TipStrategy):
    """Three fingers round a small solid."""

    name = "tip-grip"
    number = 3
    orientation = "upright"
    objects = ("ball-30", "cube-28", "cylinder-32", "cone-35")
