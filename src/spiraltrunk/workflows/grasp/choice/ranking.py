"""Ranking of the strategies for an object without a trial, in a scene that is as announced.

`candidates.rank` ranks them for an observed task, in a trial.
"""

from __future__ import annotations

from typing import Any

from spiraltrunk.control.messages import Task
from spiraltrunk.control.strategy import Strategy
from spiraltrunk.design import presets
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.objects.catalogue import ObjectSpec
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.workflows.grasp.choice.auto import Auto
from spiraltrunk.workflows.grasp.choice.candidates import STAGES, Candidate
from spiraltrunk.workflows.grasp.choice.ground import compare_grounds, list_scenes, rank_scene
from spiraltrunk.workflows.grasp.choice.orientation import find_orientation
from spiraltrunk.workflows.grasp.choice.other_grounds import join_grounds
from spiraltrunk.workflows.grasp.world import AS_ANNOUNCED, draw_scene


def rank_object(design: TrunkDesign, shape: ObjectSpec, stage: str = "ground") -> tuple[Candidate, ...]:
    """Candidates for an object on a stage: the feasible ones by score, then the others.

    Object and trunk are as announced. A strategy that reaches the object over another ground only comes after those
    that reach it over the ground of the best (`join_grounds`).

    Raises:
        UnknownName: for a stage that does not exist.
    """
    auto = Auto(design, stage, find_orientation(shape))
    scenes = list_scenes(design, draw_scene(shape, 0, strategy=auto, spread=AS_ANNOUNCED), auto)
    ranked = {scene.ground: rank_scene(design, scene, auto) for scene in scenes}
    best = max(ranked, key=lambda ground: compare_grounds(ranked[ground]))
    return join_grounds(ranked.pop(best), ranked)


def announce_task(design: TrunkDesign, shape: ObjectSpec, strategy: Strategy[Any]) -> Task:
    """The task of a strategy whose object is as announced."""
    return build_task(design, draw_scene(shape, 0, strategy=strategy, spread=AS_ANNOUNCED))


def find_able(design: TrunkDesign, shape: ObjectSpec) -> tuple[str, ...]:
    """Names of the strategies that can take an object on one of the stages, by their models."""
    found = [each for stage in STAGES for each in rank_object(design, shape, stage) if each.feasible]
    return tuple(each.strategy for each in sorted(found, key=lambda each: -each.score))


def find_alternatives(design: TrunkDesign, shape: ObjectSpec, stage: str) -> dict[str, str]:
    """The best strategy on another stage, the best with larger fingers, and where there is none the best with both.

    Returns:
        Name of the strategy by the options of the command line that select that stage and design.
    """
    large, option = presets.get("paper-large-grip"), "--design paper-large-grip"
    others = [other for other in STAGES if other != stage]
    tried = {f"--stage {other}": (design, other) for other in others}
    both = {f"--stage {other} {option}": (large, other) for other in others}
    rounds = [tried | {option: (large, stage)}, both] if design == presets.PAPER else [tried]
    for asked in rounds:
        best = {given: rank_object(robot, shape, where)[0] for given, (robot, where) in asked.items()}
        found = {given: each.strategy for given, each in best.items() if each.feasible}
        if found:
            return found
    return {}
