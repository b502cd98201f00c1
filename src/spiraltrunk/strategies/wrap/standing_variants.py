"""Strategies 4 to 6, wraps of a standing object: oblique near the ground, oblique, and near-horizontal.

Source: "Grasping by Spiraling", figure 5 and Results. Phases and limits are those of `StandingWrap`. The angles and
heights are ours, tuned in simulated trials. The oblique wraps take slender objects above their middle, where the head
can turn away the whole lean that such a wrap leaves; lower, the housing would meet the ground first.
"""

from __future__ import annotations

import math
from typing import final

from spiraltrunk.strategies.wrap.standing import StandingWrap
from spiraltrunk.strategies.wrap.standing_plan import WrapPlane


@final
class WrapObliqueLow(StandingWrap):
    """Wrap in a plane that falls ahead, as near the ground as the housing allows; ventral cables unequal."""

    name = "wrap-oblique-low"
    number = 4
    plane = WrapPlane(
        slope=math.radians(7.0), reach_slope=math.radians(-8.0), differential=-0.12, height=0.3, slender_height=0.62,
        ground_gap=0.022,
    )  # fmt: skip


@final
class WrapOblique(StandingWrap):
    """Wrap in a plane that falls ahead, at half the height; ventral cables unequal."""

    name = "wrap-oblique"
    number = 5
    plane = WrapPlane(
        slope=math.radians(8.0), reach_slope=math.radians(-8.0), differential=-0.14, height=0.5, slender_height=0.62,
        ground_gap=0.022,
    )  # fmt: skip


@final
class WrapHorizontal(StandingWrap):
    """Wrap in a plane that rises ahead and that the load makes level, at half the height; ventral cables equal."""

    name = "wrap-horizontal"
    number = 6
    plane = WrapPlane(slope=math.radians(-12.0), differential=0.0, height=0.55)
