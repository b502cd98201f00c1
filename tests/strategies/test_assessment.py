"""Assessments: every refusal names its physical reason with numbers, and more margin never scores less."""

import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk import strategies
from spiraltrunk.control.messages import Goal, Target, Task
from spiraltrunk.control.object_profile import ObjectProfile
from spiraltrunk.design.presets import PAPER
from spiraltrunk.strategies.assessment import assess
from spiraltrunk.strategies.fingertip.assess import grip_force
from spiraltrunk.strategies.object_measures import height_of, topple_force, widths_between
from spiraltrunk.strategies.scores import margin_factor
from spiraltrunk.strategies.wrap.assess import RATES

GROUND = 0.60
LONG = ObjectProfile(
    height=np.array([0.0, 0.1]), width_least=np.full(2, 0.09), width_most=np.full(2, 0.16), girth=np.full(2, 0.39),
    center_height=0.05, topple_angle=0.7, support_radius=0.045,
)  # fmt: skip
"""A thing with a handle: 90 mm wide, 160 mm long seen from above."""
UP, LEVEL = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)


def _flat(ratio):
    """A prism of 240 mm whose one side is ``ratio`` times the other."""
    side = np.full(2, 0.05)
    return ObjectProfile(
        height=np.array([0.0, 0.24]), width_least=side, width_most=ratio * side, girth=2 * (1 + ratio) * side,
        center_height=0.12, topple_angle=0.2, support_radius=0.025,
    )  # fmt: skip


def _task(width, length, mass, *, kind="cylinder", axis=UP, ground=GROUND, design=PAPER, profile=None):
    height = length if axis == UP else width
    target = Target(
        kind=kind, width=width, length=length, mass=mass, position=np.array([0.46, 0.12, GROUND + height / 2]),
        axis=np.array(axis), profile=profile,
    )  # fmt: skip
    aside = np.array([0.0, 0.2, 0.0])
    return Task(design=design, target=target, goal=Goal(aside=aside, place=target.position + aside, ground=ground))


def _assess(name, *args, **kwargs):
    return assess(strategies.get(name), _task(*args, **kwargs))


@pytest.mark.parametrize(
    ("name", "task", "reason"),
    [
        ("tip-grip", _task(0.0484, 0.06, 0.1), "too wide for the fingers by 8 mm: 48 mm, they open 40 mm"),
        (
            "tip-grip",
            _task(0.0391, 0.06, 0.1),
            "by 0.2 mm: 39.1 mm, they open 40 mm and hold what is up to 38.9 mm wide",
        ),
        ("pinch", _task(0.03, 0.2, 0.5, axis=LEVEL), "would slip: it weighs 4.9 N, the fingers hold"),
        ("tip-grip", _task(0.034, 0.02, 0.02, kind="cone"), "narrows upwards by 40 deg, friction holds up to 39 deg"),
        ("flip-grip", _task(0.03, 0.03, 0.02, ground=None), "the object hangs; the fingers take what rests on"),
        ("tip-grip", _task(0.03, 0.03, 0.02, design=replace(PAPER, gripper=None)), "the trunk has no gripper"),
        ("wrap-horizontal", _task(0.165, 0.24, 0.5), "too wide for the trunk by 12 mm: 165 mm, it wraps 153 mm"),
        ("wrap-horizontal", _task(0.1529, 0.24, 0.5), "too wide for the trunk by 0.2 mm: 152.9 mm, it wraps 152.7 mm"),
        ("wrap-oblique", _task(0.02, 0.24, 0.1), "too thin for the trunk by 8 mm: 20 mm, it wraps 28 mm or more"),
        ("wrap-oblique", _task(0.06, 0.24, 1.6), "too heavy by 86 g: the trunk holds 1514 g at that width"),
        ("wrap-oblique-low", _task(0.04, 0.24, 0.02), "would topple at 0.027 N; the closing trunk pushes with"),
        ("wrap-oblique", _task(0.05, 0.05, 0.15), "too short: the trunk would press"),
        ("wrap-oblique", _task(0.04, 0.064, 0.08), "too short by 5 mm: 64 mm, it wraps 69 mm of height or more"),
        ("wrap-oblique", _task(0.04, 0.069, 0.08), "too short by 0.2 mm: 69.0 mm, it wraps 69.2 mm of height or more"),
        ("wrap-horizontal", _task(0.09, 0.1, 0.5, kind="box", profile=LONG), "loop by 7 mm: 160 mm across"),
        ("wrap-horizontal", _task(0.08, 0.08, 0.2, kind="sphere"), "would roll away"),
        ("wrap-horizontal", _task(0.06, 0.24, 0.2, axis=LEVEL), "the object lies; this wrap takes one that stands"),
        ("wrap-vertical", _task(0.06, 0.24, 0.2), "the object rests on the ground; this wrap takes one that hangs"),
        ("wrap-vertical", _task(0.08, 0.08, 0.2, axis=LEVEL, ground=None), "too short to stay in the loop: 1 times"),
        ("wrap-vertical", _task(0.15, 0.2245, 0.5, axis=LEVEL, ground=None), "loop: 1.49 times as long as wide, 1.5 "),
        ("kick", _task(0.06, 0.24, 0.2), "kick has no model that could tell"),
    ],
)
def test_a_refusal_names_its_reason_with_numbers(name, task, reason):
    found = assess(strategies.get(name), task)
    assert not found.feasible
    assert found.score == 0.0
    assert reason in found.reason


def test_what_the_strategies_are_meant_for_is_feasible():
    for name, task in {
        "tip-grip": _task(0.028, 0.028, 0.02, kind="box"),
        "pinch": _task(0.02, 0.15, 0.06, axis=LEVEL),
        "flip-grip": _task(0.032, 0.04, 0.03),
        "wrap-oblique-low": _task(0.06, 0.24, 0.25),
        "wrap-oblique": _task(0.09, 0.24, 0.3),
        "wrap-horizontal": _task(0.12, 0.24, 0.4),
        "wrap-vertical": _task(0.06, 0.24, 0.25, axis=LEVEL, ground=None),
    }.items():
        found = assess(strategies.get(name), task)
        assert found.feasible, (name, found.reason)
        assert 0.5 < found.score <= 1.0


def test_names_tell_what_grips_are_meant_for():
    rod, cube = _task(0.02, 0.15, 0.06, axis=LEVEL), _task(0.028, 0.028, 0.02, kind="box")
    scores = {
        (name, each.target.kind): assess(strategies.get(name), each).score
        for name in ("pinch", "tip-grip", "flip-grip")
        for each in (rod, cube)
    }
    assert max(scores, key=lambda key: scores[key] * (key[1] == "cylinder"))[0] == "pinch"
    assert max(scores, key=lambda key: scores[key] * (key[1] == "box"))[0] == "tip-grip"


@pytest.mark.parametrize(
    ("name", "tasks"),
    [
        ("tip-grip", [_task(0.03, 0.03, mass) for mass in (0.02, 0.1, 0.2, 0.24)]),
        ("pinch", [_task(width, 0.15, 0.05, kind="box", axis=LEVEL) for width in (0.02, 0.0375, 0.038, 0.0387)]),
        ("wrap-oblique", [_task(0.06, 0.24, mass) for mass in (0.3, 0.055, 0.04, 0.03, 0.02)]),
        ("wrap-oblique-low", [_task(0.06, height, 0.2) for height in (0.24, 0.19, 0.14, 0.1)]),
        ("wrap-horizontal", [_task(0.06, 0.24, 0.3, profile=_flat(ratio)) for ratio in (1.0, 1.1, 1.5, 2.2)]),
        ("wrap-horizontal", [_task(0.06, 0.24, mass) for mass in (0.4, 1.1, 1.4)]),
    ],
)
def test_less_margin_scores_less(name, tasks):
    found = [assess(strategies.get(name), task) for task in tasks]
    assert all(each.feasible for each in found)
    scores = [each.score for each in found]
    assert scores == sorted(scores, reverse=True)
    assert scores[-1] < 0.9 * scores[0]


def test_a_prism_topples_where_its_weight_passes_its_edge():
    target = _task(0.06, 0.24, 0.25).target
    assert topple_force(target, 0.24) == pytest.approx(0.25 * 9.81 * 0.03 / 0.24)
    assert topple_force(target, 0.12) == pytest.approx(2 * topple_force(target, 0.24))


def test_a_profile_counts_before_the_extents():
    """A bottle of 70 mm with a neck of 30 mm, 200 mm tall, its centre of mass low and off the middle."""
    height = np.array([0.0, 0.14, 0.141, 0.20])
    width = np.array([0.07, 0.07, 0.03, 0.03])
    profile = ObjectProfile(
        height=height, width_least=width, width_most=width, girth=math.pi * width, center_height=0.08,
        topple_angle=0.4, support_radius=0.03,
    )  # fmt: skip
    target = _task(0.07, 0.20, 0.3, profile=profile).target
    assert height_of(target) == 0.20
    assert widths_between(target, 0.16, 0.20) == pytest.approx((0.03, 0.03))
    assert widths_between(target, 0.10, 0.20) == pytest.approx((0.07, 0.07))
    assert topple_force(target, 0.10) == pytest.approx(0.3 * 9.81 * 0.03 / 0.10)


def test_fingers_press_with_what_their_cables_give():
    """Three fingers of 1.0 N each, as simulated at the tip of the paper's gripper; 3.4 N at twice its size."""
    assert PAPER.gripper is not None
    assert grip_force(PAPER.gripper) == pytest.approx(3.0, rel=0.1)
    assert grip_force(PAPER.gripper.scaled(2.0)) == pytest.approx(3 * 3.4, rel=0.02)


def test_a_margin_counts_from_half_to_whole():
    assert [margin_factor(margin, 0.2) for margin in (-1.0, 0.0, 0.1, 0.2, 9.0)] == [0.5, 0.5, 0.75, 1.0, 1.0]
    assert [margin_factor(margin, 0.2, 0.2) for margin in (-1.0, 0.1, 9.0)] == pytest.approx([0.2, 0.6, 1.0])


def test_a_reason_tells_what_the_score_is_made_of():
    reasons = {name: _assess(name, 0.09, 0.24, 0.3).reason for name in RATES if name != "wrap-vertical"}
    assert len(set(reasons.values())) == 3
    assert all(f"; rate {RATES[name]:g}" in reason for name, reason in reasons.items())
    assert _assess("flip-grip", 0.03, 0.03, 0.02).reason.endswith("; rate 0.94, times 0.95 for flip")
    assert ", times 0.88 for opening" in _assess("tip-grip", 0.0388, 0.03, 0.02).reason


@pytest.mark.parametrize("angles", [(90.0, 270.0), (0.0, 5.0)])
@pytest.mark.parametrize("name", ["wrap-oblique", "wrap-vertical"])
def test_a_wrap_without_a_ventral_cable_is_refused(angles, name):
    cable = replace(PAPER.cable, angles=tuple(math.radians(angle) for angle in angles))
    task = _task(0.06, 0.24, 0.25, design=replace(PAPER, cable=cable), ground=None if "vertical" in name else GROUND)
    found = assess(strategies.get(name), task)
    assert not found.feasible
    assert found.reason == "no cable pulls ventral; allowed: a design with a cable more than 90 deg from dorsal"
