"""Strategy 7, tip grip and distal flip: what the fingers have gripped is carried inside the curled tip of the trunk.

Source: "Grasping by Spiraling", figure 5, strategy 7, and Results: "a distal flip is frequently used to secure the
object after lifting". What the flip is in detail, the paper does not say. Our reading: once the object is lifted, the
ventral cables curl the trunk from its tip until the tip points up, so that the object lies on the fingers, inside the
curl, and cannot fall out of them; the cables uncurl it before it is set down.

The curl begins at the tip and spreads towards the base: tension and cable length for it come from the equilibrium of
the trunk with the object's weight. Its length paces the curl, there and back, and bounds it, so that stiffer or softer
joints change the tension and not the shape. Paced by tension, the trunk would snap back, as simulated at up to 0.8 m/s.

Limits: as the tip grip's. Cones are left out: the flip turns them in the fingers, and set down askew they topple and
rolled away in 2 of 6 trials. A trunk that curls by a few newtons is soft: what it carries sways.
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
"""How far the flip turns the tip (ours) [rad]: past straight up, towards the trunk."""

RESERVE = 1.5
"""Largest tension over the one that the design needs for the flip [-]: for stiffer joints and heavier objects."""


@final
class FlipGrip(TipStrategy):
    """Three fingers round a small solid, then the trunk's tip curled round both."""

    name = "flip-grip"
    number = 7
    stance = "upright"
    objects = ("ball-30", "cube-28", "cylinder-32")

    def curl(self, observation: Observation) -> Curl | None:
        """Ventral cables pulled in as far as turns the tip up."""
        task = observation.task
        flip = find_flip(task.design, task.target.mass, TURN)
        tension = np.minimum(RESERVE * flip.tension, task.design.cable.tension_max)
        return Curl(tension=tension, pull=np.where(flip.tension > 0, flip.pull, task.design.cable_stroke))
