"""Objects that a strategy cannot grasp are refused before anything is simulated."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.output import UsageError, quote
from spiraltrunk.errors import ModelError

if TYPE_CHECKING:
    from spiraltrunk.control.strategy import Strategy
    from spiraltrunk.design import TrunkDesign
    from spiraltrunk.sim.objects.catalogue import ObjectSpec


def check_object(strategy: Strategy[Any], design: TrunkDesign, shape: ObjectSpec, name: str) -> None:
    """Refuse an object called ``name`` that is too thin, too wide or too heavy for the strategy with this trunk.

    Raises:
        UsageError: with the object's width or mass, the range, and the strategies that can take it.
    """
    refusal = _find_refusal(strategy, design, shape, name)
    if refusal is not None:
        raise UsageError(f"--object: {refusal}{_list_able(design, shape, strategy)}")


@contextmanager
def name_able(design: TrunkDesign, shape: ObjectSpec, strategy: Strategy[Any]) -> Iterator[None]:
    """Name the strategies that can take the object where this one cannot plan for it.

    Raises:
        UsageError: with the reason of the plan.
    """
    try:
        yield
    except ModelError as error:
        raise UsageError(f"{strategy.name}: {error}{_list_able(design, shape, strategy)}") from None


def _list_able(design: TrunkDesign, shape: ObjectSpec, strategy: Strategy[Any]) -> str:
    """The end of a refusal: which strategies can take the object, by their models."""
    from spiraltrunk.workflows.grasp.ranking import find_able

    able = [name for name in find_able(design, shape) if name != strategy.name]
    return f"; what can take it: {', '.join(able)}" if able else "; no other strategy can take it"


def _find_refusal(strategy: Strategy[Any], design: TrunkDesign, shape: ObjectSpec, name: str) -> str | None:
    """Why the object is too thin, too wide or too heavy; None where it is not."""
    from spiraltrunk.sim.objects.presentation import present
    from spiraltrunk.workflows.grasp.auto import AUTO

    if strategy.support == "ground":
        shape = present(shape, strategy.orientation)
    smallest, largest = strategy.widths(design)
    if not smallest <= shape.width <= largest:
        low, high = math.ceil(1e4 * smallest) / 10, math.floor(1e4 * largest) / 10
        allowed = f"{low:g} to {high:g} mm, what {strategy.name} can take with the trunk {quote(design.name)}"
        return f"{quote(name)} is {1e3 * shape.width:.4g} mm wide; allowed: {allowed}"
    if strategy.job != "grasp" or strategy.name == AUTO:
        return None  # What is pushed along the ground is not carried, and a choice has its own reasons.
    from spiraltrunk.design import payload

    most = payload(design, shape.width)
    if shape.mass > most:
        allowed = f"at most {math.floor(1e3 * most):g} g, what the trunk {quote(design.name)} holds at that width"
        return f"{quote(name)} has {1e3 * shape.mass:g} g; allowed: {allowed}"
    return None
