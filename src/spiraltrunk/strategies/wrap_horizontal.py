"""Strategy 6, wrap of a standing object in a near-horizontal plane.

Source: "Grasping by Spiraling", figure 5, strategy 6, and Results. Phases and limits are those of all wraps of standing
objects, `wrap_standing`; here the trunk curls in a plane that rises a little ahead, which the load makes level.
"""

from __future__ import annotations

import math
from typing import final

from spiraltrunk.strategies.standing_plan import StandingOptions
from spiraltrunk.strategies.wrap_standing import StandingWrap


@final
class WrapHorizontal(StandingWrap):
    """Wrap of a standing object in a near-horizontal plane."""

    name = "wrap-horizontal"
    number = 6

    @staticmethod
    def default_options() -> StandingOptions:
        """A level plane at half the height, ventral cables equal."""
        return StandingOptions(plane=math.radians(-12.0), differential=0.0, height=0.55)
