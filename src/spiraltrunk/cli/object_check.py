"""Objects that a strategy cannot grasp are refused before anything is simulated."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.output import DONE, UsageError, complain
from spiraltrunk.cli.progress import print_if_slow
from spiraltrunk.errors import ModelError

if TYPE_CHECKING:
    from spiraltrunk.control.strategy import Strategy
    from spiraltrunk.design import TrunkDesign
    from spiraltrunk.sim.objects.catalogue import ObjectSpec


def read_object(text: str) -> ObjectSpec:
    """`parse_object`, which says what takes so long where it does."""
    from spiraltrunk.sim.objects.catalogue import parse_object

    with print_if_slow("reading the object; convex parts (collide=parts) may take two minutes", sys.stderr):
        return parse_object(text)


def check_object(strategy: Strategy[Any], design: TrunkDesign, shape: ObjectSpec, name: str) -> None:
    """Refuse an object called ``name`` that is too thin, too wide or too heavy for the strategy with this trunk.

    Raises:
        UsageError: with the object's width or mass, the range, and the strategies that can take it.
    """
    from spiraltrunk.sim.objects.presentation import take_pose
    from spiraltrunk.workflows.grasp.choice.refusal import find_refusal

    refusal = find_refusal(strategy, design, shape, name)
    if refusal is not None:
        laid = ""
        if _is_laid(strategy, shape) and find_refusal(strategy, design, take_pose(shape, "upright"), name) is None:
            laid = f"; {strategy.name} lays it down, pose=upright keeps it standing"
        raise UsageError(f"--object: {refusal}{laid}{_list_able(design, shape, strategy)}")


def warn_infeasible(strategy: Strategy[Any], design: TrunkDesign, shape: ObjectSpec) -> None:
    """Warn where the models rank the strategy as infeasible for the object as it rests, or as the strategy lays it.

    Raises:
        UsageError: where the strategy cannot even plan for it.
    """
    from spiraltrunk.strategies.assessment import assess
    from spiraltrunk.workflows.grasp.choice.auto import Auto
    from spiraltrunk.workflows.grasp.choice.orientation import find_orientation
    from spiraltrunk.workflows.grasp.choice.ranking import announce_task
    from spiraltrunk.workflows.grasp.trial import check_plan

    if strategy.job != "grasp" or strategy.number == 0:
        return  # A choice and a learned policy have no model of their own.
    resting = Auto(design, strategy.support, find_orientation(shape), ranking=lambda observation, tried: ())
    found = assess(strategy, announce_task(design, shape, strategy if _is_laid(strategy, shape) else resting))
    if not found.feasible:
        with name_able(design, shape, strategy):
            check_plan(design, shape, strategy)
        complain(f"{strategy.name} is expected to fail: {found.reason}; it is tried all the same", DONE)


def _is_laid(strategy: Strategy[Any], shape: ObjectSpec) -> bool:
    """Whether a strategy of lying objects lays down what stands by its measures, and is bound to no pose."""
    from spiraltrunk.sim.objects.presentation import natural_orientation

    is_for_lying = strategy.support == "ground" and strategy.orientation == "lying" and strategy.number > 0
    return is_for_lying and natural_orientation(shape) == "upright" and not shape.pose


def warn_laid(strategy: Strategy[Any], shape: ObjectSpec) -> None:
    """Tell that a choice of strategies lays an object down that would hardly stand as it is described."""
    from spiraltrunk.sim.objects.presentation import natural_orientation
    from spiraltrunk.sim.objects.profile import compute_profile
    from spiraltrunk.workflows.grasp.choice.auto import AUTO
    from spiraltrunk.workflows.grasp.choice.orientation import STANDS, find_orientation

    is_chosen_on_ground = strategy.name == AUTO and strategy.support == "ground"
    if is_chosen_on_ground and natural_orientation(shape) == "upright" and find_orientation(shape) == "lying":
        angle = math.floor(10 * math.degrees(compute_profile(shape).topple_angle)) / 10
        least = f"{math.degrees(STANDS):g} deg needed"
        complain(f"standing it would topple at {angle:g} deg, {least}: laid down; pose=upright keeps it standing", DONE)


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
    from spiraltrunk.workflows.grasp.choice.ranking import find_able

    able: list[str] = []
    with print_if_slow("looking for strategies that can take the object", sys.stderr), suppress(ModelError):
        able = [name for name in find_able(design, shape) if name != strategy.name]
    return f"; what can take it: {', '.join(able)}" if able else "; no other strategy can take it"
