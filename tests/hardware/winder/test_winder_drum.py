"""Geometry of a wound drum: both maps are inverse to each other, continuous, and layer upon layer."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.design import presets
from spiraltrunk.design.drum import DrumDesign, size_drum
from spiraltrunk.errors import DesignError
from spiraltrunk.hardware.winder.drum import DrumGeometry

PAPER = DrumGeometry(design=size_drum(presets.PAPER))


@st.composite
def drums(draw):
    """Drums of one layer and of many."""
    cable = draw(st.floats(0.2e-3, 2e-3))
    design = DrumDesign(
        winding_radius=cable / 2 + draw(st.floats(2e-3, 40e-3)), cable_diameter=cable,
        width=cable * draw(st.floats(1.5, 30.0)), travel_in=draw(st.floats(0.02, 0.4)),
        travel_out=draw(st.floats(0.0, 0.4)), dead_turns=draw(st.floats(0.0, 5.0)),
    )  # fmt: skip
    return DrumGeometry(design=design)


@given(drums(), st.floats(-1.0, 1.0))
def test_angle_is_the_inverse_of_pull(drum, pull):
    assert drum.pull(drum.angle(pull)) == pytest.approx(pull, abs=1e-12)


@given(drums(), st.floats(-200.0, 200.0))
def test_pull_is_the_inverse_of_angle(drum, angle):
    assert drum.angle(drum.pull(angle)) == pytest.approx(angle, abs=1e-9)


@given(drums(), st.floats(-100.0, 100.0), st.floats(1e-6, 10.0))
def test_winding_in_always_pulls_by_between_least_and_largest_radius(drum, angle, more):
    """Continuity too: no jump at a change of layers."""
    pulled = drum.pull(angle + more) - drum.pull(angle)
    least, most = drum.design.winding_radius, drum.radius_max
    assert least * more - 1e-12 <= pulled <= most * more + 1e-12


@given(drums(), st.floats(-100.0, 100.0))
def test_the_radius_is_the_slope_of_the_pull(drum, angle):
    step = 1e-6
    before, after = drum.radius(angle - step), drum.radius(angle + step)
    slope = (drum.pull(angle + step) - drum.pull(angle - step)) / (2 * step)
    assert before - 1e-8 <= slope <= after + 1e-8


@given(drums())
def test_the_straight_trunk_is_zero(drum):
    assert drum.pull(0.0) == pytest.approx(0.0, abs=1e-12)


@given(drums())
def test_the_last_layer_holds_the_travel_and_no_layer_is_too_many(drum):
    """Independent sum over whole layers: turns of radius r_0 + j d."""
    design = drum.design
    turns, lengths = drum.turns_per_layer, []
    for j in range(drum.n_layer):
        lengths.append(2 * math.pi * turns * (design.winding_radius + j * design.cable_diameter))
    dead, left, radius = 0.0, design.dead_turns, design.winding_radius
    while left > 0:
        dead += 2 * math.pi * radius * min(left, turns)
        left, radius = left - turns, radius + design.cable_diameter
    needed = dead + 1.1 * (design.travel_in + design.travel_out)
    assert sum(lengths) >= needed - 1e-9
    assert sum(lengths[:-1]) < needed + 1e-9


def test_cads_drum_winds_one_layer():
    for name in presets.NAMES:
        drum = DrumGeometry(design=size_drum(presets.get(name)))
        assert drum.n_layer == 1
        assert drum.radius_max == drum.design.winding_radius
    assert PAPER.pull(2 * math.pi) == pytest.approx(2 * math.pi * 9.85e-3)


def test_a_spool_of_one_turn_a_layer():
    """5 mm of core and 1 mm of cable: turns of 5.5, 6.5 and 7.5 mm, the first one dead."""
    spool = DrumGeometry(
        design=DrumDesign(
            winding_radius=5.5e-3, cable_diameter=1e-3, width=1.2e-3, travel_in=0.08, travel_out=0.0, dead_turns=1.0
        )
    )
    assert spool.turns_per_layer == 1
    assert spool.pull(2 * math.pi) == pytest.approx(2 * math.pi * 6.5e-3)
    assert spool.pull(4 * math.pi) == pytest.approx(2 * math.pi * (6.5e-3 + 7.5e-3))
    assert spool.radius(0.1) == pytest.approx(6.5e-3)
    assert spool.radius(2 * math.pi + 0.1) == pytest.approx(7.5e-3)


def test_a_drum_of_too_many_layers_is_refused():
    design = replace(size_drum(presets.PAPER), width=0.6e-3, travel_in=50.0)
    with pytest.raises(DesignError, match=r"drum.width is 0.6 mm, .* allowed: a drum that needs at most 100 layers"):
        DrumGeometry(design=design)
