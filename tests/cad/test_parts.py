"""Every part is sound, printable and of the volume of its definition; the trunk is the design's."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spiraltrunk.cad.checks.self_collision import check_curl, compute_allowed_overlap, find_overlap
from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.housing.winder import find_arm, find_drum
from spiraltrunk.cad.output.catalogue import GROUPS, build_parts, check_groups
from spiraltrunk.cad.trunk.body import build_body, build_joint
from spiraltrunk.cad.trunk.gripper import build_finger, strand_travel
from spiraltrunk.cad.trunk.pieces import build_trunk
from spiraltrunk.cad.trunk.skin import build_moulds, build_shells
from spiraltrunk.design import design_from_rules, presets
from spiraltrunk.errors import DesignError, UnknownName


@pytest.mark.parametrize("i", [0, 5, 12, 13, 16])
def test_a_joint_is_as_stiff_as_the_design(i, options):
    """A ring of second moment pi (R^4 - c^4) / 4 over its own length against E I / L of the design."""
    joint = build_joint(presets.PAPER, i, options)
    moment = math.pi * (joint.radius**4 - (joint.bore / 2) ** 4) / 4
    stiffness = presets.PAPER.joint.youngs_modulus * 1e-9 * moment / joint.length
    assert stiffness == pytest.approx(presets.PAPER.joint_stiffness[i], rel=1e-9)


def test_thin_joints_are_solid_and_the_cables_go_beside_them(options):
    body = build_body(presets.PAPER, options)
    hollow = [joint.bore > 0 for joint in body.joints]
    assert hollow == sorted(hollow, reverse=True)
    assert True in hollow
    assert False in hollow
    walls = [joint.radius - joint.bore / 2 if joint.bore else 2 * joint.radius for joint in body.joints]
    assert min(walls) >= options.least_wall


def test_a_trunk_without_gripper_has_no_channel(options):
    body = build_body(replace(presets.PAPER, gripper=None), options)
    assert all(joint.bore == 0 for joint in body.joints)
    assert body.end == pytest.approx(1e3 * presets.PAPER.length)


@pytest.mark.parametrize("tall", [100.0, 150.0, 256.0, 600.0])
def test_pieces_fit_the_bed_and_leave_nothing_out(tall, options):
    from spiraltrunk.cad.geometry.csg import compute_bounds

    options = replace(options, bed=(256.0, 256.0, tall))
    parts = build_trunk(presets.PAPER, options)
    heights = [np.ptp(compute_bounds(part.form)[:, 2]) for part in parts]
    assert max(heights) <= tall + 1e-9
    assert len(parts) >= math.ceil(500 / tall)
    spans = [
        sorted((part.at[2], part.at[2] + height * math.cos(part.turn)))
        for part, height in zip(parts, heights, strict=True)
    ]
    assert [low for low, _ in spans[1:]] == pytest.approx([high for _, high in spans[:-1]])
    assert spans[-1][1] == pytest.approx(build_body(presets.PAPER, options).end)


@pytest.mark.parametrize("tall", [100.0, 180.0, 256.0])
def test_pieces_together_are_the_body(tall, options):
    """Their outlines, without holes, have the volume of the whole outline; the first stands on its cut end."""
    from spiraltrunk.cad.geometry.csg import Revolved, compute_volume

    whole = build_body(presets.PAPER, options)
    parts = build_trunk(presets.PAPER, replace(options, bed=(256.0, 256.0, tall)))
    outlines = [part.form.form.form if part.turn else part.form.form for part in parts]
    volume = sum(compute_volume(outline.form) for outline in outlines)
    ends = ((0.0, 0.0), *whole.profile[1:], (0.0, whole.end))
    assert volume == pytest.approx(compute_volume(Revolved(profile=ends)), rel=1e-9)
    assert [part.turn for part in parts] == [math.pi] + [0.0] * (len(parts) - 1)


def test_a_bed_too_small_is_refused(options):
    with pytest.raises(DesignError, match="wide at section 1"):
        build_trunk(presets.PAPER, replace(options, bed=(80.0, 80.0, 256.0)))
    with pytest.raises(DesignError, match="at least as high as two sections"):
        build_trunk(presets.PAPER, replace(options, bed=(256.0, 256.0, 40.0)))


def test_shells_are_drawn_from_the_seed(options):
    one, same, other = (build_shells(presets.PAPER, replace(options, seed=seed)) for seed in (3, 3, 4))
    assert one == same
    assert one != other
    assert len({part.form for part in one}) == len(one)  # No two sections have the same wrinkles.


def test_a_mould_is_the_negative_of_its_shell(options):
    """Ring and core enclose what is left of the cavity: the shell."""
    from spiraltrunk.cad.geometry.csg import contains

    shell = build_shells(presets.PAPER, options)[4]
    core, ring = (part for part in build_moulds(presets.PAPER, options) if part.name.endswith("05"))
    random = np.random.default_rng(0)
    height = shell.form.form.profile[2][1]
    inner, outer = shell.form.form.profile[0][0], shell.form.form.profile[1][0]
    rho = np.sqrt(random.uniform(inner**2, outer**2, 20000))
    angle = random.uniform(-np.pi, np.pi, 20000)
    points = np.stack([rho * np.cos(angle), rho * np.sin(angle), random.uniform(0, height, 20000)], axis=-1)
    floor = core.form.T[2][3], ring.form.T[2][3]
    is_mould = contains(core.form, points + np.array([0, 0, floor[0]])) | contains(
        ring.form, points + np.array([0, 0, floor[1]])
    )
    assert (contains(shell.form, points) == ~is_mould).all()
    assert is_mould.any()


def test_a_drum_takes_the_stroke(options):
    for name in presets.NAMES:
        design = presets.get(name)
        drum = find_drum(design, options)
        wound = 2 * math.pi * drum.radius * (drum.turns - 2)
        assert wound >= 1e3 * design.cable_stroke + drum.travel_out
        assert drum.width >= drum.turns * options.cable
        assert drum.rim >= drum.radius + 2 * options.cable
        assert options.motor.torque / (1e-3 * drum.radius) >= design.cable.tension_max


def test_what_a_drum_pays_out_is_what_the_gaps_open():
    """From 30 to 60 deg: chord(60) - chord(30) of each joint."""
    design = presets.PAPER
    opened = sum(2 * r * (math.sin(math.pi / 6) - math.sin(math.pi / 12)) for r in design.hole_to_joint)
    assert find_drum(design, MakeOptions()).travel_out == pytest.approx(1e3 * opened)


def test_the_double_arm_moves_the_strands_all_the_way(options):
    gripper = presets.PAPER.gripper
    assert strand_travel(gripper) == pytest.approx(0.4 * math.pi / 3 * (0.010 + 0.010 * gripper.k_p))
    assert 1e-3 * find_arm(presets.PAPER, options) >= strand_travel(gripper)


def test_finger_joints_are_as_stiff_as_the_design(options):
    design = presets.PAPER
    finger = build_finger(design.gripper, design.joint.youngs_modulus, options)
    for radius, wanted in zip(finger.joints, design.gripper.joint_stiffness, strict=True):
        moment, length = math.pi * radius**4 / 4, radius * sum(finger.slopes)
        assert design.joint.youngs_modulus * 1e-9 * moment / length == pytest.approx(wanted)
    assert math.atan(finger.slopes[0]) + math.atan(finger.slopes[1]) == pytest.approx(math.pi / 3)


@pytest.mark.parametrize("name", presets.NAMES)
def test_a_curled_preset_has_room(name):
    """Turns touch where sections fill a turn; else corners stand into sides by what their chords leave out."""
    design = presets.get(name)
    worst = check_curl(design)
    play = compute_allowed_overlap(design, worst.sections[1])
    assert worst.depth <= play + 1e-6
    assert (play == 0) == (abs(2 * math.pi / design.delta_theta % 1 - 0) < 1e-9)


def test_a_trunk_less_compact_runs_into_itself():
    fat = replace(presets.PAPER, k=presets.PAPER.k + 0.02)
    with pytest.raises(DesignError, match=r"overlap of sections \d+ and \d+"):
        check_curl(fat)


@given(st.floats(0.0, math.pi / 6))
@settings(max_examples=20)
def test_curling_less_is_never_deeper(bend):
    assert find_overlap(presets.PAPER, bend).depth <= find_overlap(presets.PAPER).depth + 1e-9


def test_groups_are_asked_for_by_name():
    assert check_groups(["all"]) == tuple(GROUPS)
    assert check_groups(["horn", "trunk"]) == ("trunk", "horn")
    with pytest.raises(UnknownName, match="known: all, trunk"):
        check_groups(["elephant"])


def test_a_design_that_has_no_room_says_where(options):
    with pytest.raises(DesignError, match=r"housing\.radius_mm is 60\.0 mm; allowed: at least \d+"):
        build_parts(replace(presets.PAPER, housing=replace(presets.PAPER.housing, radius=0.06)), ["housing"], options)
    with pytest.raises(DesignError, match=r"gripper\.mount_radius_mm"):
        build_parts(
            replace(presets.PAPER, gripper=replace(presets.PAPER.gripper, mount_radius=0.004)), ["gripper"], options
        )
    tiny = design_from_rules(b=0.16, arm_radius=0.012, turns=1.5, name="tiny")
    with pytest.raises(DesignError, match="tenon"):
        build_parts(tiny, ["trunk"], options)
