"""Objects that a strategy cannot grasp are refused before anything is simulated."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.output import UsageError, quote

if TYPE_CHECKING:
    from spiraltrunk.control.strategy import Strategy
    from spiraltrunk.design import TrunkDesign
    from spiraltrunk.sim.objects.catalogue import ObjectSpec


def check_object(strategy: Strategy[Any], design: TrunkDesign, shape: ObjectSpec, name: str) -> None:
    """Refuse an object called ``name`` that is too thin, too wide or too heavy for the strategy with this trunk.

    Raises:
        UsageError: with the object's width or mass, and the range.
    """
    from spiraltrunk.sim.objects.presentation import present

    if strategy.support == "ground":
        shape = present(shape, strategy.orientation)
    smallest, largest = strategy.widths(design)
    if not smallest <= shape.width <= largest:
        low, high = math.ceil(1e4 * smallest) / 10, math.floor(1e4 * largest) / 10
        allowed = f"{low:g} to {high:g} mm, what {strategy.name} can take with the trunk {quote(design.name)}"
        raise UsageError(f"--object: {quote(name)} is {1e3 * shape.width:.4g} mm wide; allowed: {allowed}")
    if strategy.job != "grasp":
        return  # What is pushed along the ground is not carried.
    from spiraltrunk.design import payload

    most = payload(design, shape.width)
    if shape.mass > most:
        allowed = f"at most {math.floor(1e3 * most):g} g, what the trunk {quote(design.name)} holds at that width"
        raise UsageError(f"--object: {quote(name)} has {1e3 * shape.mass:g} g; allowed: {allowed}")
