"""Strategies 4 to 6, wraps of a standing object: in an oblique plane near the ground, oblique, and near-horizontal.

Source: "Grasping by Spiraling", figure 5 and Results. Phases and limits are those of `StandingWrap`; the three differ
in their options alone. What topples at less than 15 deg is taken above its middle by the oblique wraps, where the head
can turn away all of the lean that such a wrap leaves: low down, the housing would meet the ground first.
"""

from __future__ import annotations

import math
from typing import final

from spiraltrunk.strategies.wrap.standing import StandingWrap
from spiraltrunk.strategies.wrap.standing_plan import StandingOptions


@final
class WrapObliqueLow(StandingWrap):
    """Wrap in an oblique plane, as near the ground as the housing allows."""

    name = "wrap-oblique-low"
    number = 4

    @staticmethod
    def default_options() -> StandingOptions:
        """A falling plane near the ground, ventral cables unequal."""
        return StandingOptions(
            plane=math.radians(7.0), differential=-0.12, height=0.3, slender_height=0.62,
            reach_plane=math.radians(-8.0), ground_gap=0.022,
        )  # fmt: skip


@final
class WrapOblique(StandingWrap):
    """Wrap in an oblique plane that falls ahead and aside: the head turns down, the lower cable pulls harder."""

    name = "wrap-oblique"
    number = 5

    @staticmethod
    def default_options() -> StandingOptions:
        """A falling plane at half the height, above it what topples early; ventral cables unequal."""
        return StandingOptions(
            plane=math.radians(8.0), differential=-0.14, height=0.5, slender_height=0.62,
            reach_plane=math.radians(-8.0), ground_gap=0.022,
        )  # fmt: skip


@final
class WrapHorizontal(StandingWrap):
    """Wrap in a plane that rises a little ahead, which the load makes level."""

    name = "wrap-horizontal"
    number = 6

    @staticmethod
    def default_options() -> StandingOptions:
        """A level plane at half the height, ventral cables equal."""
        return StandingOptions(plane=math.radians(-12.0), differential=0.0, height=0.55)
