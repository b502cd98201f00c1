"""The ranking: what fits a stage, the arm's reach, and one order for all."""

from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk import strategies
from spiraltrunk.design import presets
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import UnknownName
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.robot.arm_ik import ArmReach
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.strategies.assessment import assess
from spiraltrunk.workflows.grasp.choice.candidates import follow_frames, list_strategies, rank
from spiraltrunk.workflows.grasp.choice.other_grounds import rank_over_grounds
from spiraltrunk.workflows.grasp.choice.ranking import announce_task, find_able, rank_object

ON_GROUND = {"pinch", "tip-grip", "flip-grip", "wrap-oblique-low", "wrap-oblique", "wrap-horizontal"}


@pytest.fixture(scope="module")
def reach():
    return ArmReach(PAPER)


@pytest.fixture(scope="module")
def cube(reach):
    """What is seen of a small cube, and its ranking."""
    seen = _observe("cube-28")
    return seen, tuple(rank(seen, reach))


def _observe(name, **options):
    given = {"support": "ground", "orientation": "upright", "position": (0.46, 0.12, 0.0)} | options
    return SimPlant(PAPER, SceneOptions(shape=parse_object(name), **given)).reset()


def test_a_stage_has_the_strategies_that_lift_from_it():
    assert set(list_strategies("ground")) == ON_GROUND
    assert list_strategies("hung") == ("wrap-vertical",)
    with pytest.raises(UnknownName, match="stage 'air'; known: hung, ground"):
        list_strategies("air")


def test_a_small_cube_is_for_the_fingers_first_the_plain_grip(cube):
    _, found = cube
    assert {each.strategy for each in found} == ON_GROUND
    assert [each.strategy for each in found if each.feasible] == ["tip-grip", "pinch", "flip-grip"]
    scores = [each.score for each in found]
    assert scores == sorted(scores, reverse=True)
    assert all(each.score == 0.0 and each.reason for each in found if not each.feasible)


def test_a_standing_cylinder_is_for_the_wraps(reach):
    found = rank(_observe("cylinder-90"), reach)
    assert {each.strategy for each in found if each.feasible} == {"wrap-oblique-low", "wrap-oblique", "wrap-horizontal"}
    assert "too wide for the fingers by 50 mm" in next(each.reason for each in found if each.strategy == "pinch")


@pytest.mark.parametrize("length", [*(pytest.param(one, marks=pytest.mark.slow) for one in (75, 85)), 95])
def test_a_standing_thing_with_a_handle_is_for_the_wraps(length):
    """A mug is not round across its handle, and stands all the same."""
    found = rank_object(PAPER, parse_object(f"box:x_mm={length},y_mm=56,z_mm=140,mass_g=300"))
    assert {each.strategy for each in found if each.feasible} == {"wrap-oblique-low", "wrap-oblique", "wrap-horizontal"}


def test_a_thing_that_is_longer_than_the_loop_is_wide_is_refused_by_its_corners():
    """150 x 80 mm are 170 mm across the corners; of four such things none was lifted."""
    found = rank_object(PAPER, parse_object("box:x_mm=150,y_mm=80,z_mm=95,mass_g=300"))
    assert not any(each.feasible for each in found)
    told = "too long for the trunk's loop by 17 mm: 170 mm across, with handle and corners; it goes round 153 mm"
    assert {each.reason for each in found if each.strategy.startswith("wrap")} == {told}


@pytest.mark.parametrize(
    ("measures", "told"),
    [
        ("x_mm=90,y_mm=60,z_mm=150,mass_g=800", "too heavy by 67 g: the trunk holds 733 g for an object with unequal"),
        pytest.param(
            "x_mm=110,y_mm=70,z_mm=180,mass_g=200", "too wide for an object with unequal sides by 12 mm: 115 mm",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "x_mm=70,y_mm=70,z_mm=120,mass_g=600", "too heavy by 144 g: the trunk holds 456 g where an object is lower",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "x_mm=135,y_mm=50,z_mm=150,mass_g=200", "too long for the trunk's loop by 5 mm: its longer side is 135 mm",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "x_mm=90,y_mm=85,z_mm=100,mass_g=200",
            "too short for its width: 100 mm tall; what is 124 mm across needs 143 mm",
            marks=pytest.mark.slow,
        ),
    ],
)  # fmt: skip
def test_what_wraps_lost_in_trials_is_refused(measures, told):
    found = rank_object(PAPER, parse_object(f"box:{measures}"))
    reasons = {each.reason for each in found if each.strategy.startswith("wrap")}
    assert len(reasons) == 1
    assert next(iter(reasons)).startswith(told)


@pytest.mark.slow
def test_square_ones_of_the_same_mass_or_height_are_taken():
    for measures in ("x_mm=84,y_mm=84,z_mm=150,mass_g=800", "x_mm=70,y_mm=70,z_mm=85,mass_g=200"):
        found = rank_object(PAPER, parse_object(f"box:{measures}"))
        assert {each.strategy for each in found if each.feasible} >= {"wrap-oblique-low"}, measures


def test_what_was_tried_is_left_out(reach, cube):
    found = rank(cube[0], reach, but=("tip-grip",))
    assert found[0].strategy == "pinch"
    assert "tip-grip" not in {each.strategy for each in found}


def test_an_object_too_far_away_is_beyond_the_arm(reach):
    found = rank(_observe("cube-28", position=(0.95, 0.12, 0.0)), reach)
    assert not any(each.feasible for each in found)
    grip = next(each for each in found if each.strategy == "tip-grip")
    assert grip.reason.startswith("base beyond the arm's reach by ")
    assert grip.reason.endswith(" cm")


def test_the_reach_is_that_of_the_arms_inverse_kinematics(reach):
    home = reach.T_base(reach.home)
    near, far = home.copy(), home.copy()
    near[:3, 3] = 0.46, 0.12, 1.2
    far[:3, 3] = 0.46, 0.12, 2.2
    assert follow_frames(reach, reach.home, [near]) == pytest.approx((0.0, 0.0), abs=1e-3)
    short, _ = follow_frames(reach, reach.home, [near, far])
    assert 0.5 < short < 1.0  # The arm with the hanging trunk's base ends at about 1.4 m.


def test_the_ranking_is_the_same_every_time(reach, cube):
    seen, found = cube
    assert tuple(rank(seen, reach)) == found


def test_a_heavier_cube_scores_less(reach):
    light, heavy = (rank(_observe(f"box:x_mm=28,y_mm=28,z_mm=28,mass_g={mass}"), reach)[0].score for mass in (20, 200))
    assert heavy < light


def test_a_low_object_is_refused_by_its_height():
    low = next(
        each for each in rank_object(PAPER, parse_object("cylinder:diameter_mm=80,height_mm=40,mass_g=300"))
        if each.strategy == "wrap-horizontal"
    )  # fmt: skip
    assert not low.feasible
    assert low.reason == "too short by 29 mm: 40 mm, it wraps 69 mm of height or more"


def test_what_can_take_an_object_is_named_best_first():
    assert find_able(PAPER, parse_object("cylinder-90"))[0] == "wrap-oblique-low"
    assert find_able(PAPER, parse_object("cube-28")) == ("tip-grip", "pinch", "flip-grip")
    assert find_able(PAPER, parse_object("sphere:diameter_mm=300,mass_g=900")) == ()


def test_a_far_place_counts_too(reach, cube):
    seen, _ = cube
    goal = replace(seen.task.goal, place=seen.task.goal.place + np.array([0.0, 0.6, 0.0]))
    found = rank(replace(seen, task=replace(seen.task, goal=goal)), reach)
    assert "beyond the arm's reach" in next(each.reason for each in found if each.strategy == "tip-grip")


@pytest.mark.slow
@pytest.mark.parametrize("mass", [200, 400])
def test_the_mass_does_not_decide_over_which_ground_a_bottle_is_ranked(mass):
    """Fingers could hold the neck of the lighter one over a ground so low that no wrap reaches it."""
    found = rank_object(PAPER, parse_object(f"bottle:diameter_mm=65,height_mm=210,neck_mm=28,mass_g={mass}"))
    here = [each.strategy for each in found if each.feasible and "over a ground of" not in each.reason]
    assert here == ["wrap-oblique-low", "wrap-horizontal", "wrap-oblique"]
    assert found[0].score > 0.9


def test_where_fingers_alone_fit_the_ground_is_low_enough_for_them():
    design = presets.get("paper-large-grip")
    found = rank_object(design, parse_object("cylinder:diameter_mm=30,height_mm=150,mass_g=60"))
    assert found[0].feasible
    assert found[0].strategy in {"tip-grip", "pinch"}


def test_what_is_reached_over_another_ground_only_is_told_and_comes_later():
    """A slender barrel is for the fingers over a low ground; the wraps reach it over the usual one."""
    found = rank_object(PAPER, parse_object("everyday:seed=12070"))
    assert [each.feasible for each in found] == 6 * [True]
    assert {each.strategy for each in found[:3]} == {"tip-grip", "pinch", "flip-grip"}
    assert all(each.reason.endswith("; over a ground of 0.6 m") for each in found[3:])
    assert not any("over a ground" in each.reason for each in found[:3])


def test_what_a_low_ground_puts_out_of_reach_is_assessed_over_the_usual_one(reach):
    shape = parse_object("everyday:seed=12070")
    options = SceneOptions(
        shape=shape, support="ground", orientation="upright", position=(0.46, 0.12, 0.0), ground=0.3
    )  # fmt: skip
    found = rank(SimPlant(PAPER, options).reset(), reach)
    beyond = {each.strategy for each in found if "beyond the arm's reach" in each.reason}
    assert beyond == {"wrap-oblique-low", "wrap-oblique", "wrap-horizontal"}
    joined = rank_over_grounds(PAPER, options, found)
    assert joined[:3] == found[:3]
    assert {each.strategy for each in joined[3:] if each.feasible} == beyond
    assert all("; over a ground of " in each.reason for each in joined[3:])


def test_a_scene_with_a_ground_of_its_own_keeps_its_candidates(reach):
    seen = _observe("cylinder:diameter_mm=34,height_mm=140,mass_g=150", ground=0.4)
    refused = tuple(rank(seen, reach))
    options = SceneOptions(
        shape=parse_object("cylinder:diameter_mm=34,height_mm=140,mass_g=150"), support="ground",
        orientation="upright", position=(0.46, 0.12, 0.0), ground=0.4,
    )  # fmt: skip
    assert any("beyond the arm's reach" in each.reason for each in refused)
    assert rank_over_grounds(PAPER, options, refused) == refused


@pytest.mark.parametrize(("height", "fits"), [(100, True), (80, False)])
def test_what_is_thinner_than_the_loop_is_wrapped_where_it_is_tall(height, fits):
    task = announce_task(
        PAPER, parse_object(f"cylinder:diameter_mm=30,height_mm={height},mass_g=90"), strategies.get("wrap-oblique")
    )
    found = assess(strategies.get("wrap-oblique"), task)
    assert found.feasible == fits
    assert fits or "too thin for the trunk by 3 mm: 30 mm, it wraps 33 mm or more" in found.reason


@pytest.mark.parametrize(
    ("side", "able"), [(31, {"tip-grip", "pinch", "flip-grip"}), (34, {"tip-grip", "pinch"}), (37, set())]
)
def test_fingers_take_slabs_up_to_a_side_and_flip_thinner_ones(side, able):
    shape = parse_object(f"box:x_mm=70,y_mm={side},z_mm=90,mass_g=120")
    task = announce_task(PAPER, shape, strategies.get("tip-grip"))
    fingers = ("tip-grip", "pinch", "flip-grip")
    assert {each for each in fingers if assess(strategies.get(each), task).feasible} == able
