"""Reasons in words for every strategy, without a trial."""

from __future__ import annotations

import pytest

from spiraltrunk import strategies
from spiraltrunk.design import presets
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import UnknownName
from spiraltrunk.sim.objects.catalogue import ObjectSpec, parse_object
from spiraltrunk.workflows.grasp.choice import ranking
from spiraltrunk.workflows.grasp.choice.candidates import Candidate
from spiraltrunk.workflows.grasp.choice.ranking import rank_object
from spiraltrunk.workflows.grasp.choice.refusal import PUSHES, explain_choice, find_refusal


def test_width_and_mass_are_refused_in_words() -> None:
    design = presets.PAPER
    thin = parse_object("rod-10")
    refusal = find_refusal(strategies.get("wrap-vertical"), design, thin, "rod-10")
    assert refusal is not None
    assert refusal.startswith("'rod-10' is 10 mm wide; allowed: 32.7 to 267.9 mm")
    heavy = parse_object("cylinder:diameter_mm=60,height_mm=240,mass_g=19000")
    refusal = find_refusal(strategies.get("wrap-vertical"), design, heavy, "lead")
    assert refusal is not None
    assert refusal.startswith("'lead' has 19000 g; allowed: at most")
    assert find_refusal(strategies.get("wrap-vertical"), design, parse_object("cylinder-60"), "cylinder-60") is None


def test_every_strategy_of_a_stage_is_explained() -> None:
    shape = parse_object("ball-30")
    found = explain_choice(presets.PAPER, shape, "ground", "ball-30")
    lifting, pushing = found[:-2], found[-2:]
    assert lifting == rank_object(presets.PAPER, shape, "ground")
    assert {each.strategy for each in pushing} == {"kick", "sweep"}
    assert all(each.reason for each in found)
    assert all(each.score == 0.0 and (each.feasible == (each.reason == PUSHES)) for each in pushing)
    with pytest.raises(UnknownName, match="unknown stage"):
        explain_choice(presets.PAPER, shape, "floor")


PAPER, LARGE = presets.PAPER, presets.get("paper-large-grip")


@pytest.mark.parametrize(
    ("able", "told"),
    [
        ({("paper", "ground"), ("large", "ground")}, {"--stage ground": "pinch"}),
        ({("large", "ground")}, {"--stage ground --design paper-large-grip": "pinch"}),
        ({("large", "hung")}, {"--design paper-large-grip": "pinch"}),
        ({("paper", "ground"), ("large", "hung")}, {"--stage ground": "pinch", "--design paper-large-grip": "pinch"}),
        (set(), {}),
    ],
)
def test_an_option_is_told_only_where_it_holds_with_the_others_that_were_given(
    monkeypatch: pytest.MonkeyPatch, able: set[tuple[str, str]], told: dict[str, str]
) -> None:
    def rank_fake(design: TrunkDesign, shape: ObjectSpec, stage: str) -> list[Candidate]:
        is_able = ("paper" if design == PAPER else "large", stage) in able
        return [Candidate(strategy="pinch", feasible=is_able, score=0.9 * is_able, reason="")]

    monkeypatch.setattr(ranking, "rank_object", rank_fake)
    assert ranking.find_alternatives(PAPER, parse_object("cube-28"), "hung") == told


def test_another_design_is_not_exchanged_for_the_large_grip(monkeypatch: pytest.MonkeyPatch) -> None:
    def rank_fake(design: TrunkDesign, shape: ObjectSpec, stage: str) -> list[Candidate]:
        assert design == LARGE
        return [Candidate(strategy="pinch", feasible=True, score=0.9, reason="")]

    monkeypatch.setattr(ranking, "rank_object", rank_fake)
    assert ranking.find_alternatives(LARGE, parse_object("cube-28"), "ground") == {"--stage hung": "pinch"}
