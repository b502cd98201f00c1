"""Reasons, in words, for which a strategy cannot take an object, found without a trial."""

from __future__ import annotations

import math
from typing import Any

from spiraltrunk import strategies
from spiraltrunk.control.messages import Task
from spiraltrunk.control.strategy import Strategy
from spiraltrunk.design import payload
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import describe
from spiraltrunk.sim.objects.catalogue import ObjectSpec
from spiraltrunk.strategies.assessment import measure_width
from spiraltrunk.workflows.grasp.choice.auto import AUTO
from spiraltrunk.workflows.grasp.choice.candidates import Candidate
from spiraltrunk.workflows.grasp.choice.ranking import announce_task, rank_object

PUSHES = "pushes the object along the ground; it is not ranked"
"""Reason of a strategy that pushes."""


def find_refusal(strategy: Strategy[Any], design: TrunkDesign, shape: ObjectSpec, name: str) -> str | None:
    """Why the object called ``name`` is too thin, too wide or too heavy for a strategy; None where it is not."""
    if strategy.name == AUTO:
        return None  # A choice has its own reasons.
    task = announce_task(design, shape, strategy)
    width, (smallest, largest) = measure_width(strategy, task), strategy.widths(design)
    if not smallest <= width <= largest:
        if largest == 0.0 and strategy.holds == "fingers":
            trunk = f"the trunk {describe(design.name)} has no gripper"
            return f"{describe(name)} cannot be taken by {strategy.name}: {trunk}; allowed: a design with a gripper"
        if largest == 0.0:
            trunk = f"the trunk {describe(design.name)} is too short to wrap anything"
            return f"{describe(name)} cannot be taken by {strategy.name}: {trunk}; allowed: a trunk of more sections"
        low, high = math.ceil(1e4 * smallest) / 10, math.floor(1e4 * largest) / 10
        allowed = f"{low:g} to {high:g} mm, what {strategy.name} can take with the trunk {describe(design.name)}"
        return (
            f"{describe(name)} is {1e3 * width:.4g} mm wide{_format_where(strategy, width, task)}; allowed: {allowed}"
        )
    if strategy.job != "grasp":
        return None  # What is pushed along the ground is not carried.
    most = payload(design, width)
    if shape.mass > most:
        allowed = f"at most {_floor_g(most)} g, what the trunk {describe(design.name)} holds at that width"
        return f"{describe(name)} has {1e3 * shape.mass:g} g; allowed: {allowed}"
    return None


def explain_choice(design: TrunkDesign, shape: ObjectSpec, stage: str, name: str = "object") -> tuple[Candidate, ...]:
    """What the models predict for every strategy of a stage, those that push among them, without a trial.

    Those that lift come first, ranked as by `rank_object`; those that push are feasible where the width of the object
    allows it, with a score of 0.

    Raises:
        UnknownName: for a stage that does not exist.
    """
    ranked = rank_object(design, shape, stage)
    known = (strategies.get(each) for each in strategies.NAMES)
    return (*ranked, *(_assess_push(each, design, shape, name) for each in known if _pushes_on(each, stage)))


def _pushes_on(strategy: Strategy[Any], stage: str) -> bool:
    return strategy.job != "grasp" and strategy.support == stage


def _assess_push(strategy: Strategy[Any], design: TrunkDesign, shape: ObjectSpec, name: str) -> Candidate:
    refusal = find_refusal(strategy, design, shape, name)
    return Candidate(
        strategy=strategy.name, feasible=refusal is None, score=0.0, reason=PUSHES if refusal is None else refusal
    )


def _format_where(strategy: Strategy[Any], width: float, task: Task) -> str:
    """Where the width is measured; empty where it is the announced one, to a tenth of a millimetre."""
    if abs(width - task.target.width) < 1e-4:
        return ""
    return " where the fingers grip" if strategy.holds == "fingers" else " by its girth"


def _floor_g(mass: float) -> str:
    """A mass [kg] in grams, rounded down, of less than 10 g to a thousandth."""
    digits = 0 if mass >= 0.01 else 3
    return f"{math.floor(1e3 * mass * 10**digits) / 10**digits:g}"
