"""Strategy 7, tip grip and distal flip: the object in the fingers is carried inside the curled tip of the trunk.

Source: "Grasping by Spiraling", figure 5, strategy 7, and Results: "a distal flip is frequently used to secure the
object after lifting". The paper does not describe the flip. Our reading: the ventral cables curl the trunk from its tip
until the tip points up. The object then lies on the fingers, inside the curl, and cannot fall out. The cables uncurl
the trunk before the object is set down.

Tension and cable length follow from the equilibrium of the trunk with the object's weight. The length paces and bounds
the curl: stiffer or softer joints change the tension and not the shape. Paced by tension, the trunk would snap back, at
up to 0.8 m/s as simulated.

Limits: as the tip grip's. Cones are left out: turned in the fingers by the flip and set down askew, they toppled and
rolled away in 2 of 6 trials. A trunk that curls by a few newtons is soft: its load sways.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import final

import numpy as np

from spiraltrunk.control.messages import Observation
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.model import statics
from spiraltrunk.model.kinematics.shape import Shape
from spiraltrunk.model.statics.loads import Loads
from spiraltrunk.model.statics.pull_sequences import carry_gripper
from spiraltrunk.strategies.fingertip.cycle import TipState, TipStrategy
from spiraltrunk.strategies.fingertip.moves import Curl
from spiraltrunk.strategies.sensing import find_ventral

TURN = math.radians(200.0)
"""Turn of the tip by the flip (ours) [rad]: past straight up, towards the trunk."""

RESERVE = 1.5
"""Tension ceiling over the tension that the design needs [-] (ours): for stiffer joints and heavier objects."""

_CLOSE = 0.01
"""Tolerance of the tension [N]."""


@final
class FlipGrip(TipStrategy):
    """Three fingers round a small solid, then the trunk's tip curled round both."""

    name = "flip-grip"
    number = 7
    orientation = "upright"
    objects = ("ball-30", "cube-28", "cylinder-32")

    def init(self, observation: Observation) -> TipState:
        """Plan the way above the object, as every grip with the fingers.

        Raises:
            ModelError: where the cables do not turn the tip up with the announced object: before anything moves.
        """
        find_flip(observation.task.design, observation.task.target.mass, TURN)
        return super().init(observation)

    def curl(self, observation: Observation) -> Curl | None:
        """Ventral cables pulled in as far as turns the tip up."""
        design = observation.task.design
        tension, shape = find_flip(design, observation.task.target.mass, TURN)
        pull = np.where(tension > 0, shape.cable_change, design.cable_stroke)
        return Curl(tension=np.minimum(RESERVE * tension, design.cable.tension_max), pull=pull)


@lru_cache(maxsize=64)
def find_flip(design: TrunkDesign, mass: float, turn: float) -> tuple[np.ndarray, Shape]:
    """Ventral tensions at which the hanging trunk's tip, ``mass`` [kg] in its gripper, has turned by ``turn`` [rad].

    Cached; nothing is written into the arrays.

    Returns:
        Tension of the cables, 0 for those that do not pull ventral, shape (n_cable,) [N]; the shape of the trunk.

    Raises:
        ModelError: where no cable pulls ventral, or none pulls hard enough.
    """
    from scipy.optimize import brentq  # Takes 0.3 s: not at the start.

    ventral, trunk = find_ventral(design).astype(float), carry_gripper(design)

    def curl(tension: float) -> Shape:
        return statics.solve(trunk, tension=tension * ventral, loads=Loads(mass=mass), friction=0.0)

    def lack(tension: float) -> float:
        return turn - float(curl(tension).joint_angle.sum())

    most = design.cable.tension_max
    if lack(most) > 0:
        widest = float(np.degrees(turn - lack(most)))
        raise ModelError(
            f"the tip turns by {widest:.0f} deg at {most:g} N, not by {np.degrees(turn):.0f}; try a lighter object"
        )
    tension = float(brentq(lack, 0.0, most, xtol=_CLOSE))
    return tension * ventral, curl(tension)
