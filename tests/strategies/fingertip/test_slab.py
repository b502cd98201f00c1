"""Grips of objects that stand on unequal sides, too wide for fingers in any direction but one."""

import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk import strategies
from spiraltrunk.design import presets
from spiraltrunk.design.presets import PAPER
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.strategies.assessment import assess
from spiraltrunk.strategies.fingertip.assess import SLAB
from spiraltrunk.strategies.fingertip.gripped_object import as_gripped, is_slab, opposed_axis
from spiraltrunk.strategies.fingertip.plan import set_aside, turned_across
from spiraltrunk.workflows.grasp.trial import run_trial

UP = np.array([0.0, 0.0, 1.0])
HANGING = np.array([[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]])


def announce(spec="box:x_mm=25,y_mm=50,z_mm=140,mass_g=60", yaw=0.0, design=PAPER):
    shape = parse_object(spec)
    return build_task(design, SceneOptions(shape=shape, support="ground", orientation="upright", ground=0.45, yaw=yaw))


@pytest.mark.parametrize("yaw", [0.0, 0.4, -1.2])
def test_fingers_oppose_each_other_across_the_shorter_side(yaw):
    task = announce(yaw=yaw)
    assert is_slab(task)
    along = opposed_axis(task, UP)
    longer = [math.cos(yaw + math.pi / 2), math.sin(yaw + math.pi / 2), 0.0]
    assert abs(along @ longer) == pytest.approx(1.0, abs=1e-6)
    rotation = turned_across(HANGING, along, task)
    finger = max(
        abs(float(along @ (math.cos(angle) * rotation[:, 1] + math.sin(angle) * rotation[:, 2])))
        for angle in (2 * math.pi * np.arange(3) / 3)
    )
    assert finger == pytest.approx(math.sin(math.pi / 3))  # The third is normal to the longer side.
    aside = set_aside(task, rotation, along)
    assert abs(aside @ along) < 1e-9
    assert 0.003 < float(np.linalg.norm(aside)) < 0.008  # A third of half the shorter side and a fingertip.


def test_it_is_as_high_as_it_stands():
    gripped = as_gripped(announce())
    assert gripped.target.width == pytest.approx(0.025)
    assert gripped.target.length == pytest.approx(0.050)
    assert gripped.target.profile.total_height == pytest.approx(0.140)
    assert as_gripped(gripped) is gripped


@pytest.mark.parametrize("spec", ["cube-28", "cylinder-32", "cylinder:diameter_mm=60,height_mm=100,mass_g=60"])
def test_other_objects_are_gripped_as_they_were(spec):
    task = announce(spec)
    assert not is_slab(task)
    assert as_gripped(task) is task
    assert opposed_axis(task, UP) is UP


def test_one_whose_direction_nobody_knows_is_refused():
    task = announce()
    task = replace(task, target=replace(task.target, side_yaw=None))
    assert not is_slab(task)
    told = assess(strategies.get("tip-grip"), task)
    assert not told.feasible
    assert "the fingers do not open round 50 mm" in told.reason


@pytest.mark.parametrize("design", [PAPER, presets.get("paper-large-grip")])
def test_a_shorter_side_beyond_what_held_is_refused_with_the_difference(design):
    widest = SLAB * design.gripper.grasp_width
    longer = f"y_mm={2.2e3 * widest:.1f},z_mm=180,mass_g=60"
    fits, too_wide = (
        assess(strategies.get("tip-grip"), announce(f"box:x_mm={1e3 * (widest + by):.1f},{longer}", design=design))
        for by in (-0.001, 0.002)
    )
    assert fits.feasible
    assert not too_wide.feasible
    assert "too wide for the fingers by 2 mm: its shorter side is" in too_wide.reason


def test_one_that_topples_easily_scores_less():
    scores = [
        assess(strategies.get("tip-grip"), announce(f"box:x_mm=25,y_mm=50,z_mm=140,mass_g={mass}")).score
        for mass in (20, 40, 60)
    ]
    assert scores == sorted(scores)
    assert scores[0] < 0.4 < 0.85 < scores[-1]


def test_a_standing_slab_is_lifted_and_set_down():
    trial = run_trial(PAPER, parse_object("box:x_mm=27,y_mm=55,z_mm=120,mass_g=60"), strategy="tip-grip", seed=3)
    assert trial.verdict.success, trial.verdict.reason
