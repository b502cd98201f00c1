"""Strategy 5, wrap of a standing object in an oblique plane.

Source: "Grasping by Spiraling", figure 5, strategy 5, and Results. Phases and limits are those of all wraps of standing
objects, `wrap_standing`; here the head then turns down and the lower ventral cable pulls harder, so that
the plane falls ahead and aside. What topples at less than 15 deg is taken above its middle, where the head can turn
away all of the lean that such a wrap leaves.
"""

from __future__ import annotations

import math
from typing import final

from spiraltrunk.strategies.standing_plan import StandingOptions
from spiraltrunk.strategies.wrap_standing import StandingWrap


@final
class WrapOblique(StandingWrap):
    """Wrap of a standing object in an oblique plane."""

    name = "wrap-oblique"
    number = 5

    @staticmethod
    def default_options() -> StandingOptions:
        """A falling plane at half the height, above it what topples early; ventral cables unequal."""
        return StandingOptions(
            plane=math.radians(8.0), differential=-0.14, height=0.5, slender_height=0.62,
            reach_plane=math.radians(-8.0), ground_gap=0.022,
        )  # fmt: skip
