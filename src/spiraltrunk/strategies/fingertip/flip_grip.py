"""Strategy 7, tip grip and distal flip: the object in the fingers is carried inside the curled tip of the trunk.

Source: "Grasping by Spiraling", figure 5, strategy 7, and Results: "a distal flip is frequently used to secure the
object after lifting". The paper does not describe the flip. Our reading: once the object is lifted, the ventral cables
curl the trunk from its tip until the tip points up. The object then lies on the fingers, inside the curl, and cannot
fall out. The cables uncurl the trunk before the object is set down.

The curl begins at the tip and spreads towards the base. Tension and cable length follow from the equilibrium of the
trunk with the object's weight. The length paces and bounds the curl, so that stiffer or softer joints change the
tension and not the shape. Paced by tension, the trunk would snap back, at up to 0.8 m/s as simulated.

Limits: as the tip grip's. Cones are left out: the flip turns them in the fingers, and set down askew they toppled and
rolled away in 2 of 6 trials. A trunk that curls by a few newtons is soft: its load sways.
"""

from __future__ import annotations

import math
from typing import final

import numpy as np

from spiraltrunk.control.messages import Observation
from spiraltrunk.strategies.fingertip.cycle import TipStrategy
from spiraltrunk.strategies.fingertip.flip_model import find_flip
from spiraltrunk.strategies.fingertip.moves import Curl

TURN = math.radians(200.0)
"""Turn of the tip by the flip (ours) [rad]: past straight up, towards the trunk."""

RESERVE = 1.5
"""Tension ceiling over the tension that the design needs [-] (ours): for stiffer joints and heavier objects."""


@final
class FlipGrip(TipStrategy):
    """Three fingers round a small solid, then the trunk's tip curled round both."""

    name = "flip-grip"
    number = 7
    orientation = "upright"
    objects = ("ball-30", "cube-28", "cylinder-32")

    def curl(self, observation: Observation) -> Curl | None:
        """Ventral cables pulled in as far as turns the tip up.

        Raises:
            ModelError: where no cable pulls ventral, or none pulls hard enough.
        """
        task = observation.task
        flip = find_flip(task.design, task.target.mass, TURN)
        tension = np.minimum(RESERVE * flip.tension, task.design.cable.tension_max)
        return Curl(tension=tension, pull=np.where(flip.tension > 0, flip.pull, task.design.cable_stroke))
