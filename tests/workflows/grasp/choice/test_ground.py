"""The ground is as high as the arm allows for what is lifted from it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk import strategies
from spiraltrunk.design import presets
from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.rules import design_from_rules
from spiraltrunk.errors import ModelError
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.robot.arm_ik import ArmReach
from spiraltrunk.workflows.grasp.choice import place
from spiraltrunk.workflows.grasp.choice.auto import Auto
from spiraltrunk.workflows.grasp.choice.ground import GROUNDS, choose_ground, set_ground
from spiraltrunk.workflows.grasp.choice.ranking import announce_task
from spiraltrunk.workflows.grasp.world import EXACT, draw_scene

LARGE = presets.get("paper-large-grip")


def _ground(design, shape, name="tip-grip", seed=0):
    strategy = strategies.get(name)
    return choose_ground(design, draw_scene(parse_object(shape), seed, strategy=strategy), strategy).ground


@pytest.mark.parametrize("name", ["tip-grip", "pinch", "flip-grip"])
def test_the_papers_objects_stay_on_the_usual_ground(name):
    for shape in strategies.get(name).objects:
        assert _ground(PAPER, shape, name) == GROUNDS[0]


def test_long_fingers_and_tall_things_stand_lower():
    can, tall = "cylinder:diameter_mm=50,height_mm=80,mass_g=150", "cylinder:diameter_mm=40,height_mm=230,mass_g=150"
    assert _ground(LARGE, can) == GROUNDS[1]
    assert _ground(LARGE, tall) == GROUNDS[2]


def test_what_is_too_tall_over_every_ground_is_refused_in_words():
    with pytest.raises(ModelError, match=r"base is \d+ cm beyond the arm's reach .*; allowed: lower objects"):
        _ground(LARGE, "cylinder:diameter_mm=40,height_mm=400,mass_g=150")


@pytest.mark.slow
def test_a_choice_has_the_ground_over_which_the_arm_is_not_straight_at_the_end_of_the_carry():
    """Lifted over its place this box is within reach at 0.60 m, carried aside it is at the arm's very end."""
    for shape, ground in (("box:x_mm=34,y_mm=25,z_mm=58,mass_g=23", GROUNDS[1]), ("cube-28", GROUNDS[0])):
        auto = Auto(PAPER)
        assert set_ground(PAPER, draw_scene(parse_object(shape), 0, strategy=auto), auto).ground == ground


def test_other_scenes_are_left_alone():
    wrap = strategies.get("wrap-vertical")
    hung = draw_scene(parse_object("cylinder-60"), 0, strategy=wrap)
    assert choose_ground(LARGE, hung, wrap) is hung
    grip = strategies.get("tip-grip")
    own = replace(draw_scene(parse_object("ball-30"), 0, strategy=grip), ground=0.5)
    assert choose_ground(LARGE, own, grip) is own


def test_a_choice_among_strategies_that_tell_no_height_keeps_the_usual_ground():
    can = parse_object("cylinder:diameter_mm=66,height_mm=115,mass_g=350")  # Too wide for the paper's fingers.
    auto = Auto(PAPER)
    assert auto.highest_base(announce_task(PAPER, can, auto)) is None
    scene = draw_scene(can, 0, strategy=auto)
    assert choose_ground(PAPER, scene, auto) is scene
    assert set_ground(PAPER, scene, auto) is scene
    narrow = parse_object("cylinder:diameter_mm=32,height_mm=40,mass_g=30")
    task = announce_task(PAPER, narrow, auto)
    fingers = [strategies.get(name).highest_base(task) for name in ("tip-grip", "pinch", "flip-grip")]
    assert auto.highest_base(task) == max(fingers)


def test_a_long_object_that_lies_is_presented_lying_to_fingers(tmp_path):
    lemon = tmp_path / "lemon.xml"
    lemon.write_text(
        "<mujoco><worldbody><body><freejoint/>"
        '<geom type="ellipsoid" size="0.034 0.02 0.02" mass="0.06"/></body></worldbody></mujoco>'
    )
    strategy = strategies.get("tip-grip")
    lying = [f"mjcf:path={lemon}", "box:x_mm=144,y_mm=40,z_mm=40,mass_g=200"]
    standing = ["ball-30", "cone-35", "cube-28", "cylinder-32", "box:x_mm=40,y_mm=40,z_mm=144,mass_g=200"]
    for shapes, orientation in ((lying, "lying"), (standing, "upright")):
        drawn = [draw_scene(parse_object(shape), 0, strategy=strategy) for shape in shapes]
        assert [scene.orientation for scene in drawn] == [orientation] * len(shapes)
    assert draw_scene(parse_object(lying[0]), 0, strategy=strategy).announced.width == pytest.approx(0.040, abs=2e-4)
    sweep = strategies.get("sweep")
    assert draw_scene(parse_object(lying[1]), 0, strategy=sweep).orientation == sweep.orientation


STANDING = ("wrap-oblique-low", "wrap-oblique", "wrap-horizontal")
LARGE_TRUNK = design_from_rules(arm_radius=0.055)


@pytest.mark.parametrize("name", [STANDING[0], *(pytest.param(name, marks=pytest.mark.slow) for name in STANDING[1:])])
def test_the_papers_standing_objects_stay_where_they_are(name):
    strategy = strategies.get(name)
    for shape in strategy.objects:
        scene = replace(draw_scene(parse_object(shape), 0, strategy=strategy), yaw=math.radians(30.0))
        assert choose_ground(PAPER, scene, strategy) is scene


@pytest.mark.parametrize("name", [STANDING[0], *(pytest.param(name, marks=pytest.mark.slow) for name in STANDING[1:])])
def test_what_is_approached_turned_stands_where_the_arm_has_room(name):
    """At the usual place the base would come beside the arm's foot, and the wrist to its pedestal."""
    strategy, arm = strategies.get(name), ArmReach(PAPER)
    scene = replace(draw_scene(parse_object("box-80"), 0, strategy=strategy), yaw=math.radians(80.0))
    chosen = choose_ground(PAPER, scene, strategy)
    assert chosen.position[0] >= scene.position[0] + 0.06
    assert chosen.offset == scene.offset
    before, after = (place._find_ease(PAPER, each, strategy, arm) for each in (scene, chosen))
    assert before < 0.6
    assert after >= 1.0


@pytest.mark.slow
def test_a_choice_among_strategies_has_that_place_too():
    box = parse_object("box:x_mm=80,y_mm=80,z_mm=240,mass_g=300")
    auto = Auto(PAPER)
    scene = replace(draw_scene(box, 0, strategy=auto), yaw=math.radians(80.0))
    chosen = set_ground(PAPER, scene, auto)
    assert chosen.position[0] >= scene.position[0] + 0.06
    straight = replace(scene, yaw=math.radians(30.0))
    assert set_ground(PAPER, straight, auto).position == scene.position


def test_the_wrist_keeps_from_the_pedestal():
    frame = np.eye(4)
    frame[:3, 3] = 0.28 + 0.09 + 0.05, 0.0, 0.8  # The wrist is 0.28 m behind the base, the pedestal's side at 0.09 m.
    assert place._find_pedestal_gap(frame) == pytest.approx(0.05)
    frame[0, 3] = 0.3
    assert place._find_pedestal_gap(frame) == 0.0


@pytest.mark.parametrize("name", ["wrap-horizontal", pytest.param("sweep", marks=pytest.mark.slow), "kick"])
def test_a_long_trunk_hangs_clear_of_the_ground_at_its_start(name):
    """At the usual height its end would start 58 mm below the ground."""
    strategy = strategies.get(name)
    scene = draw_scene(parse_object("cylinder-60"), 0, strategy=strategy)
    overlaps = []
    for each in (scene, choose_ground(LARGE_TRUNK, scene, strategy)):
        plant = SimPlant(LARGE_TRUNK, each)
        plant.reset()
        overlaps.append(-min(plant.data.contact.dist, default=0.0))
    assert overlaps[0] > 0.02
    assert overlaps[1] < 0.001


def test_a_long_trunk_gets_its_object_further_ahead_where_no_joint_comes_near_its_limit():
    strategy, arm = strategies.get("wrap-horizontal"), ArmReach(LARGE_TRUNK)
    scene = draw_scene(parse_object("cylinder-60"), 0, strategy=strategy)
    chosen = choose_ground(LARGE_TRUNK, scene, strategy)
    near = replace(chosen, position=scene.position)
    assert chosen.position[1] > scene.position[1]
    assert chosen.offset == scene.offset
    before, after = (place._find_ease(LARGE_TRUNK, each, strategy, arm) for each in (near, chosen))
    assert before < 0.16  # 2 degrees of the 13
    assert after > 0.62


def test_an_object_is_moved_where_the_arm_would_be_near_the_end_of_its_reach():
    """At the usual place joint 4 needs 4 times its speed for 1 m/s of the base, with every joint within its margin."""
    strategy, design = strategies.get("wrap-horizontal"), design_from_rules(m=1.7)
    arm, scene = ArmReach(design), draw_scene(parse_object("box-60"), 0, strategy=strategy)
    chosen = choose_ground(design, scene, strategy)
    assert chosen.position[1] > scene.position[1]
    before, after = (place._find_ease(design, each, strategy, arm) for each in (scene, chosen))
    assert before < 0.9
    assert after >= 1.0


@pytest.mark.parametrize("shape", ["ball-30", "cylinder-60"])
def test_a_swept_object_stands_where_the_arm_can_lift_it(shape):
    """Its grasp begins where it was swept to. With the paper's trunk that is reached as it stands."""
    strategy = strategies.get("sweep")
    scene = draw_scene(parse_object(shape), 0, strategy=strategy)
    assert choose_ground(PAPER, scene, strategy) is scene
    chosen = choose_ground(LARGE_TRUNK, scene, strategy)
    fingers = shape == "ball-30"
    assert (chosen.ground < 0.5) == fingers
    assert (chosen.position[1] > scene.position[1]) != fingers


def test_the_grasp_of_a_sweep_begins_at_its_goal():
    strategy = strategies.get("sweep")
    task = announce_task(PAPER, parse_object("ball-30"), strategy)
    grasp = strategy.grasp_task(task)
    assert grasp.target.position == pytest.approx(task.goal.place)
    assert grasp.goal.place == pytest.approx(task.goal.place + task.goal.aside)
    assert strategy.highest_base(grasp) == strategies.get("tip-grip").highest_base(grasp)


@pytest.mark.parametrize("radius", [0.055, 0.060, 0.065])
def test_no_wide_hung_object_touches_a_thick_trunk_at_the_start(radius):
    """The object is 20 mm off its announced place, towards the trunk; in its usual place it would touch these."""
    design, wrap = design_from_rules(arm_radius=radius), strategies.get("wrap-vertical")
    scene = draw_scene(parse_object("cylinder-120"), 0, strategy=wrap, spread=EXACT)
    plant = SimPlant(design, set_ground(design, replace(scene, offset=(0.0, -0.02, 0.0)), wrap))
    plant.reset()
    bodies = [plant.model.geom_bodyid[contact.geom] for contact in plant.data.contact]
    assert plant.model.body("object").id not in np.concatenate([*bodies, [0]])


def test_beside_the_papers_trunk_objects_hang_where_they_did():
    wrap = strategies.get("wrap-vertical")
    hung = draw_scene(parse_object("cylinder-120"), 0, strategy=wrap)
    assert set_ground(PAPER, hung, wrap) is hung


@pytest.mark.parametrize("position", [(0.45, -0.15, 0.85), (0.9, -0.05, 0.85), (0.45, 0.1, 1.32)])
def test_a_place_of_ones_own_for_a_hung_object_is_kept(position):
    wrap, thick = strategies.get("wrap-vertical"), design_from_rules(arm_radius=0.055)
    hung = replace(draw_scene(parse_object("cylinder-60"), 0, strategy=wrap), position=position)
    assert set_ground(thick, hung, wrap) is hung


@pytest.mark.parametrize("width_mm", [132, 150])
def test_a_wide_hung_object_begins_clear_of_the_trunk(width_mm):
    """It hangs 28 mm off its announced place; in the usual place it would begin 3 mm in the trunk or deeper."""
    wrap = strategies.get("wrap-vertical")
    shape = parse_object(f"cylinder:diameter_mm={width_mm},height_mm=240,mass_g=300")
    hung = replace(draw_scene(shape, 0, strategy=wrap, spread=EXACT), offset=(-0.02, -0.02, 0.0))
    moved = set_ground(PAPER, hung, wrap)
    assert moved.position != hung.position
    assert measure_overlap(moved) < 0.5e-3
    assert measure_overlap(hung) > 2.5e-3


def measure_overlap(options):
    """How deep the object is in the trunk at the start [m]."""
    plant = SimPlant(PAPER, options)
    plant.reset()
    target = plant.model.body("object").id
    touching = [each for each in plant.data.contact if target in plant.model.geom_bodyid[each.geom]]
    return max((-float(each.dist) for each in touching), default=0.0)
