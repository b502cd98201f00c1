"""Strategy 4, wrap of a standing object in an oblique plane near the ground.

Source: "Grasping by Spiraling", figure 5, strategy 4, and Results. Phases and limits are those of all wraps of standing
objects, `wrap_standing`; here as in `wrap_oblique`, as near the ground as the housing allows.
What topples at less than 15 deg is taken above its middle instead: low down, the housing meets the ground before the
head has turned away all of the lean that such a wrap leaves.
"""

from __future__ import annotations

import math
from typing import final

from spiraltrunk.strategies.standing_plan import StandingOptions
from spiraltrunk.strategies.wrap_standing import StandingWrap


@final
class WrapObliqueLow(StandingWrap):
    """Wrap of a standing object in an oblique plane near the ground."""

    name = "wrap-oblique-low"
    number = 4

    @staticmethod
    def default_options() -> StandingOptions:
        """A falling plane near the ground, ventral cables unequal."""
        return StandingOptions(
            plane=math.radians(7.0), differential=-0.12, height=0.3, slender_height=0.62,
            reach_plane=math.radians(-8.0), ground_gap=0.022,
        )  # fmt: skip
