"""Candidates that the arm does not reach over the ground of a scene, over other grounds.

A strategy by its name gets a ground over which the arm reaches its moves (`ground.choose_ground`); a choice among
strategies gets the ground of its best candidate. What is beyond reach there may be within reach over another.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from spiraltrunk import strategies
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.robot.arm_ik import ArmReach
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.strategies.assessment import assess
from spiraltrunk.workflows.grasp.choice.candidates import Candidate, assess_candidate
from spiraltrunk.workflows.grasp.choice.ground import list_grounds


def rank_over_grounds(
    design: TrunkDesign, options: SceneOptions, candidates: Sequence[Candidate]
) -> tuple[Candidate, ...]:
    """Candidates of a scene; those that only plan or arm refuse in it are assessed over the other grounds too.

    A scene with another ground than `list_grounds` has, or with none, keeps its candidates.
    """
    if options.support != "ground" or all(each.feasible for each in candidates):
        return tuple(candidates)
    arm, task = ArmReach(design), build_task(design, options)
    grounds = list_grounds(design, arm)
    refused = (strategies.get(each.strategy) for each in candidates if not each.feasible)
    beyond = [each for each in refused if assess(each, task).feasible]
    if options.ground not in grounds or not beyond:
        return tuple(candidates)
    others = {}
    for ground in grounds:
        if ground != options.ground:
            seen = SimPlant(design, replace(options, ground=ground)).reset()
            others[ground] = [assess_candidate(each, seen, arm) for each in beyond]
    return join_grounds(candidates, others)


def join_grounds(candidates: Sequence[Candidate], others: Mapping[float, Sequence[Candidate]]) -> tuple[Candidate, ...]:
    """Candidates of a scene, each that is refused replaced by what it is over the first of the other grounds it fits.

    It tells that ground in its reason, and comes after those that are feasible in the scene.

    Args:
        candidates: those of the scene, the feasible ones first.
        others: those of the same scene over other grounds, by the height of the ground [m].
    """
    refused = {each.strategy: each for each in candidates if not each.feasible}
    found: dict[str, Candidate] = {}
    for ground, ranked in others.items():
        for each in ranked:
            if each.feasible and each.strategy in refused and each.strategy not in found:
                found[each.strategy] = replace(each, reason=f"{each.reason}; over a ground of {ground:g} m")
    able = [each for each in candidates if each.feasible]
    left = [each for name, each in refused.items() if name not in found]
    return (*able, *sorted(found.values(), key=lambda each: -each.score), *left)
