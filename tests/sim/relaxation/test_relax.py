"""The trunk alone comes to rest where, and how, the equilibrium models put it."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import ModelError
from spiraltrunk.model.kinematics.cables import lengths_from_rotations
from spiraltrunk.model.kinematics.shape import Status
from spiraltrunk.sim.relaxation.relax import LoadStep, RelaxationOptions, RelaxationRig
from spiraltrunk.sim.robot.trunk import TrunkOptions

STIFF = RelaxationOptions(trunk=TrunkOptions(stiffness_factor=99.0))
FAST = RelaxationOptions(pull_speed=0.05, tension_speed=10.0)
SLACK = math.nan


def relax(design, steps=(), **given):
    return RelaxationRig(design, **given).relax(steps)


@pytest.mark.parametrize("theta_0", [-1.0, 0.0, 0.7, math.pi / 2, 2.5])
@pytest.mark.parametrize("roll", [0.0, 2.0])
def test_the_base_axis_points_theta_0_below_the_horizontal(theta_0, roll):
    points = relax(PAPER, theta_0=theta_0, roll=roll, options=STIFF).shape.points
    axis = np.array([math.cos(theta_0), -math.sin(theta_0), 0.0])
    np.testing.assert_allclose(points[0], PAPER.section_length[0] * axis, rtol=0, atol=1e-9)
    sag = 0.03 * PAPER.length * math.cos(theta_0)
    assert abs(points[-1] @ axis - PAPER.length) <= 0.01 * PAPER.length
    assert (points[-1] - PAPER.length * axis)[1] <= 1e-6 + abs(sag)


@pytest.mark.parametrize(
    ("roll", "towards"), [(0.0, (1, 0, 0)), (math.pi / 2, (0, 0, 1)), (math.pi, (-1, 0, 0)), (-math.pi / 2, (0, 0, -1))]
)
def test_hanging_the_dorsal_cable_pulls_to_x_turned_by_the_roll(roll, towards):
    points = relax(PAPER, [LoadStep(tension=(5.0, SLACK, SLACK))], roll=roll, options=FAST).shape.points
    aside = points[-1] * [1, 0, 1]
    assert np.linalg.norm(aside) > 0.05
    assert aside @ towards > 0.999 * np.linalg.norm(aside)


@pytest.mark.parametrize("has_gripper", [True, False])
def test_small_sags_are_the_moments_of_the_masses_it_names(has_gripper):
    """Stiff and horizontal, each joint bends by the moment of what lies beyond it over its stiffness."""
    loads = np.zeros(PAPER.n_section)
    loads[[6, 17]] = 0.05, 0.01
    options = replace(STIFF, has_gripper=has_gripper)
    rig = RelaxationRig(PAPER, theta_0=0.0, loads=loads, options=options)
    start = np.cumsum(PAPER.section_length) - PAPER.section_length
    lever = np.maximum(start + rig.section_center - start[1:, None], 0.0)
    beyond = np.arange(PAPER.n_section) > np.arange(PAPER.n_joint)[:, None]
    moment = 9.81 * (lever * beyond) @ rig.section_mass
    expected = moment / (99.0 * PAPER.joint_stiffness)
    np.testing.assert_allclose(rig.relax().shape.joint_angle, expected, rtol=2e-3, atol=1e-6)


@pytest.mark.parametrize("has_gripper", [True, False])
def test_the_masses_it_names_are_all_that_hangs_on_the_base(has_gripper):
    loads = np.linspace(0.0, 0.02, PAPER.n_section)
    rig = RelaxationRig(PAPER, theta_0=0.0, loads=loads, options=RelaxationOptions(has_gripper=has_gripper))
    first = rig.model.body("section_01")
    assert first.subtreemass[0] == pytest.approx(rig.section_mass.sum(), rel=1e-12)
    own = PAPER.section_mass.sum() + loads.sum() + (PAPER.gripper.mass if has_gripper else 0.0)
    assert rig.section_mass.sum() == pytest.approx(own, rel=1e-12)
    data = mujoco.MjData(rig.model)
    mujoco.mj_forward(rig.model, data)
    start = np.cumsum(PAPER.section_length) - PAPER.section_length
    center = rig.section_mass @ (start + rig.section_center) / rig.section_mass.sum()
    base = data.site("trunk_base").xpos
    np.testing.assert_allclose(data.subtree_com[first.id] - base, [center, 0, 0], rtol=0, atol=1e-12)


def test_shape_and_cables_are_one_configuration():
    found = relax(PAPER, [LoadStep(pull=(0.05, SLACK, SLACK))], theta_0=1.0, options=FAST)
    cables = lengths_from_rotations(PAPER, found.shape.joint_rotation)
    turn = np.array([[math.cos(1), math.sin(1), 0], [-math.sin(1), math.cos(1), 0], [0, 0, 1]])
    np.testing.assert_allclose(found.shape.points, cables.points @ turn.T, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.shape.cable_change, cables.change)
    # The holes as simulated are set back: their cable runs a little differently.
    np.testing.assert_allclose(found.cable_pull, cables.change, rtol=0, atol=2e-3)
    true = relax(PAPER, [LoadStep(pull=0.02)], options=RelaxationOptions(trunk=TrunkOptions(hole_set_back=0.0)))
    np.testing.assert_allclose(true.cable_pull, true.shape.cable_change, rtol=0, atol=1e-9)


def test_a_commanded_length_is_reached_but_for_the_winders_stiffness():
    found = relax(PAPER, [LoadStep(pull=(0.06, SLACK, SLACK))], options=FAST)
    gain = TrunkOptions().cable_gain
    assert found.shape.status == Status.CONVERGED
    assert found.cable_pull[0] == pytest.approx(0.06 - found.cable_tension[0] / gain, abs=1e-9)
    assert found.cable_tension[1:] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_a_commanded_tension_is_held_and_let_go():
    held = relax(PAPER, [LoadStep(tension=(4.0, 2.0, SLACK))], options=FAST)
    assert held.cable_tension == pytest.approx([4.0, 2.0, 0.0], abs=1e-9)
    free = relax(PAPER, [LoadStep(tension=(4.0, 2.0, SLACK)), LoadStep()], options=FAST)
    np.testing.assert_allclose(free.shape.points, relax(PAPER).shape.points, rtol=0, atol=3e-4)


@pytest.mark.slow
def test_how_fast_and_how_damped_does_not_matter_without_friction():
    stages = [LoadStep(pull=(0.05, SLACK, SLACK)), LoadStep(pull=(0.05, 0.0, SLACK))]
    slow = relax(PAPER, stages, theta_0=0.5, options=RelaxationOptions(pull_speed=0.02))
    fast = RelaxationOptions(pull_speed=math.inf, damping_factor=6.0, armature_factor=3.0)
    other = relax(PAPER, stages, theta_0=0.5, options=fast)
    np.testing.assert_allclose(other.shape.points, slow.shape.points, rtol=0, atol=5e-5)
    assert other.time < slow.time


@pytest.mark.slow
def test_it_is_deterministic():
    rig = RelaxationRig(PAPER, theta_0=0.3, options=FAST)
    stages = [LoadStep(pull=(0.03, SLACK, SLACK))]
    first, second = rig.relax(stages), rig.relax(stages)
    np.testing.assert_array_equal(first.shape.points, second.shape.points)
    np.testing.assert_array_equal(first.shape.points, relax(PAPER, stages, theta_0=0.3, options=FAST).shape.points)


def test_the_status_says_how_it_ended():
    assert relax(PAPER).shape.status == Status.CONVERGED
    short = RelaxationOptions(time_most=0.05)
    assert relax(PAPER, theta_0=0.0, options=short).shape.status == Status.NOT_CONVERGED
    assert relax(PAPER, [LoadStep(pull=(0.06, SLACK, SLACK), tension=2.0)], options=FAST).shape.status == Status.STALLED
    full = relax(PAPER, [LoadStep(tension=(60.0, SLACK, SLACK))], options=FAST)
    assert full.shape.status == Status.ALL_SHUT
    assert full.shape.is_shut.all()


@pytest.mark.parametrize("stage", [LoadStep(pull=(-0.5, 0, 0)), LoadStep(pull=(0.1, 0.1)), LoadStep(tension=math.inf)])
def test_impossible_commands_are_refused(stage):
    with pytest.raises(ModelError, match=r"(pull|tension) is .*; allowed: 3 numbers, at least (-0.2597|0) or nan"):
        relax(PAPER, [stage])


@pytest.mark.parametrize("across", [(0, 1, 0), (0, 0, 1), (0, 0.6, -0.8)])
def test_a_push_on_the_tip_bends_stiff_joints_by_its_moments(across):
    """Straight along its weight, each joint bends by the force times its distance to the tip, over its stiffness."""
    force = 0.02 * np.roll(across, 1)
    rig = RelaxationRig(PAPER, options=replace(STIFF, still=1e-7))
    rest = rig.relax()
    pushed = rig.push(force)
    lever = PAPER.length - np.cumsum(PAPER.section_length)[:-1]
    expected = 0.02 * lever / (99.0 * PAPER.joint_stiffness)
    np.testing.assert_allclose(pushed.shape.joint_angle, expected, rtol=0.02)
    moved = pushed.shape.points[-1] - rest.shape.points[-1]
    assert moved @ force > 0.999 * np.linalg.norm(moved) * np.linalg.norm(force)
    np.testing.assert_allclose(rig.push(np.zeros(3)).shape.points, rest.shape.points, rtol=0, atol=1e-6)


def test_locking_the_winders_moves_nothing_and_holds_the_lengths():
    rig = RelaxationRig(PAPER, options=FAST)
    rest = rig.relax([LoadStep(tension=(3.0, 6.0, 6.0))])
    held = rig.push(np.zeros(3), hold="length")
    np.testing.assert_allclose(held.shape.points, rest.shape.points, rtol=0, atol=1e-5)
    np.testing.assert_allclose(held.cable_tension, rest.cable_tension, rtol=0, atol=1e-2)
    pushed = rig.push((0.1, 0.0, 0.0))
    np.testing.assert_allclose(pushed.cable_pull, rest.cable_pull, rtol=0, atol=3.0 / rig.options.trunk.cable_gain)
    assert np.abs(pushed.cable_tension - rest.cable_tension).max() > 0.05
    freed = rig.push((0.1, 0.0, 0.0), hold="tension")
    np.testing.assert_allclose(rig.push(np.zeros(3)).cable_tension, freed.cable_tension, rtol=0, atol=1e-6)


@pytest.mark.parametrize("force", [(1.0, 0.0), math.nan, (math.inf, 0.0, 0.0)])
def test_a_force_that_is_none_is_refused(force):
    with pytest.raises(ModelError, match=r"force (has shape|is) .*; allowed: (\(3,\)|a finite number)"):
        RelaxationRig(PAPER).push(force)


def test_a_stiffer_limit_is_passed_by_less():
    past = []
    for factor in (1.0, 10.0, 100.0):
        options = replace(FAST, armature_factor=100.0, damping_factor=8.0, limit_factor=factor)
        shape = relax(PAPER, [LoadStep(pull=(0.1, SLACK, SLACK))], options=options).shape
        past.append(float(shape.joint_angle.max()) - PAPER.joint_limit)
    assert 0 < past[0] < math.radians(1.0)
    assert past[1] == pytest.approx(past[0] / 10, rel=0.3)
    assert past[2] == pytest.approx(past[1] / 10, rel=0.3)


def test_each_stage_is_visited_and_the_last_is_where_it_settles():
    stages = [LoadStep(pull=(0.01, SLACK, SLACK)), LoadStep(pull=(0.02, SLACK, SLACK))]
    rig = RelaxationRig(PAPER, options=FAST)
    visited = list(rig.iterate(stages))
    assert len(visited) == 3
    assert [round(float(s.cable_pull[0]), 4) for s in visited[1:]] == pytest.approx([0.01, 0.02], abs=2e-4)
    np.testing.assert_array_equal(visited[-1].shape.points, rig.relax(stages).shape.points)
