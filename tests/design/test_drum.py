"""The winders' drum: what limits it, and that CAD makes the drum that the winders compute with."""

import math
from dataclasses import asdict, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.cad.checks.assembly import check_hardware
from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.housing.winder import find_drum, motor_angles, motor_ring
from spiraltrunk.cad.output.cable_lengths import cable_length
from spiraltrunk.cad.output.catalogue import build_parts
from spiraltrunk.design import presets
from spiraltrunk.design.drum import DEAD_TURNS, DrumDesign, DrumOptions, full_turns, size_drum
from spiraltrunk.errors import DesignError


@pytest.mark.parametrize("name", presets.NAMES)
def test_cad_makes_the_drum_of_the_design(name):
    design = presets.get(name)
    sized, made = size_drum(design), find_drum(design, MakeOptions())
    assert made.radius == pytest.approx(1e3 * sized.winding_radius, rel=1e-14)
    assert made.width == pytest.approx(1e3 * sized.width, rel=1e-14)
    assert made.travel_in == pytest.approx(1e3 * sized.travel_in, rel=1e-14)
    assert made.travel_out == pytest.approx(1e3 * sized.travel_out, rel=1e-14)
    assert made.dead_turns == sized.dead_turns


def test_the_options_of_cad_are_those_of_the_design():
    assert asdict(MakeOptions().drum) == pytest.approx(asdict(DrumOptions()), rel=1e-14)


def test_the_papers_drum():
    """Radius of the rim beside the screws' heads, 28 mm / 2 - 2.9 mm, less two and a half cables; one layer."""
    drum = size_drum(presets.PAPER)
    assert drum.winding_radius == pytest.approx(9.85e-3)
    assert drum.travel_in == presets.PAPER.cable_stroke
    turns = full_turns(drum.travel_in + drum.travel_out, drum.winding_radius, drum.dead_turns)
    assert turns > DEAD_TURNS + (drum.travel_in + drum.travel_out) / (2 * math.pi * drum.winding_radius)
    assert drum.width >= (turns + 1) * drum.cable_diameter


@given(st.floats(0.06, 0.09), st.floats(0.03e-3, 1e-3))
def test_a_thicker_cable_makes_a_smaller_drum(motor_diameter, more):
    options = DrumOptions(motor_diameter=motor_diameter)
    thick = replace(options, cable_diameter=options.cable_diameter + more)
    assert size_drum(presets.PAPER, thick).winding_radius <= size_drum(presets.PAPER, options).winding_radius


def test_a_weak_motor_and_a_small_rotor_are_refused():
    with pytest.raises(DesignError, match=r"part drum: tension is 51 N at most on 9.9 mm; allowed: at least cable"):
        size_drum(presets.PAPER, DrumOptions(torque_max=0.5))
    with pytest.raises(DesignError, match=r"part drum: radius is 3.85 mm; allowed: at least 5.00 mm"):
        size_drum(presets.PAPER, DrumOptions(rotor_circle=16e-3))


@pytest.mark.parametrize("name", ["winding_radius", "cable_diameter", "width", "travel_in", "travel_out"])
@pytest.mark.parametrize("value", [math.nan, math.inf, -1.0])
def test_a_drum_without_finite_sizes_is_refused(name, value):
    with pytest.raises(DesignError, match=f"drum.{name}"):
        replace(size_drum(presets.PAPER), **{name: value})


def test_motors_stand_side_by_side_half_a_step_past_their_cables():
    ring, angles = motor_ring(presets.PAPER, MakeOptions()), motor_angles(presets.PAPER)
    assert 2 * ring * math.sin(math.pi / 3) == pytest.approx(66.7 + 2 * 0.2)
    assert angles == pytest.approx((math.pi / 3, math.pi, 5 * math.pi / 3))


@given(st.floats(-360.0, 360.0), st.permutations((0.0, 120.0, 240.0)))
def test_turned_and_reordered_cables_keep_their_way_to_the_drum(turn, angles):
    angles = tuple(math.radians(angle + turn) for angle in angles)
    design = replace(presets.PAPER, cable=replace(presets.PAPER.cable, angles=angles))
    for angle, axis in zip(angles, motor_angles(design), strict=True):
        assert 0.0 <= axis < 2 * math.pi
        assert math.remainder(axis - angle - math.pi / 3, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert cable_length(design, MakeOptions()) == pytest.approx(cable_length(presets.PAPER, MakeOptions()), rel=1e-9)


def test_a_turned_housing_holds_its_screws():
    angles = tuple(angle + math.radians(59.0) for angle in presets.PAPER.cable.angles)
    design = replace(presets.PAPER, cable=replace(presets.PAPER.cable, angles=angles))
    parts = build_parts(design, ["housing"], MakeOptions())
    straight = build_parts(presets.PAPER, ["housing"], MakeOptions())
    assert check_hardware(design, MakeOptions(), parts) == check_hardware(presets.PAPER, MakeOptions(), straight)


def test_a_makers_spool_can_be_described():
    spool = DrumDesign(
        winding_radius=5.5e-3, cable_diameter=1e-3, width=3e-3, travel_in=0.2, travel_out=0.1, dead_turns=1.0
    )
    assert spool.width == 3e-3
