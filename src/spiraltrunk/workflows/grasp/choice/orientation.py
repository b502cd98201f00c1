"""How the choice has an object stand or lie before it ranks the strategies."""

from __future__ import annotations

import math

from spiraltrunk.sim.objects.catalogue import ObjectSpec
from spiraltrunk.sim.objects.presentation import natural_orientation
from spiraltrunk.sim.objects.profile import compute_profile

STANDS = math.radians(5.0)
"""Least angle of toppling of an object that is left standing on end [rad] (ours)."""

TALL, COMPACT = 0.06, 1.5
"""Least height [m], and largest ratio of the widths seen from above [-], of an object on its side that counts as
standing (ours): a wrap may take it, and fingers need not turn across it."""
BEYOND_FINGERS, COMPACT_WIDE = 0.065, 2.0
"""Least width of an object that fingers do not go round [m], as of a mug, and that ratio for it [-] (ours): with its
handle it is longer than wide."""


def find_orientation(shape: ObjectSpec) -> str:
    """How an object on the ground is described: "upright" by its vertical axis, or "lying" by its level one.

    The object itself rests as its measures or its file state. An object that would hardly stand is laid down, unless a
    pose was given.
    """
    if natural_orientation(shape) == "upright":
        would_fall = shape.kind != "sphere" and compute_profile(shape).topple_angle < STANDS
        return "lying" if would_fall and not shape.pose else "upright"
    length, across, height = shape.size
    most = COMPACT if across < BEYOND_FINGERS else COMPACT_WIDE
    return "upright" if height >= TALL and length <= most * across else "lying"
