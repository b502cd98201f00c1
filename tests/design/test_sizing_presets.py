"""Designs from wished sizes meet them; presets are known by name and are what they say."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spiraltrunk.design import CableDesign, design_from_sizes, presets
from spiraltrunk.errors import DesignError, UnknownName

TIPS = st.floats(2e-3, 3e-2)


@settings(max_examples=30)
@given(TIPS, st.floats(12.0, 40.0), st.floats(8.0, 20.0))
def test_tip_length_and_taper_are_met(tip_width, slenderness, taper_deg):
    taper = math.radians(taper_deg)
    design = design_from_sizes(tip_width=tip_width, length=slenderness * tip_width, taper=taper)
    assert design.tip_width == pytest.approx(tip_width, rel=1e-9)
    assert design.length == pytest.approx(slenderness * tip_width, rel=1e-9)
    assert design.taper == pytest.approx(taper, rel=1e-9)
    assert 10.0 < math.degrees(design.delta_theta) < 60.0


@settings(max_examples=30)
@given(TIPS, st.floats(30.0, 100.0), st.floats(6.0, 20.0))
def test_tip_length_and_base_are_met(tip_width, slenderness, flare):
    design = design_from_sizes(tip_width=tip_width, length=slenderness * tip_width, base_width=flare * tip_width)
    assert design.tip_width == pytest.approx(tip_width, rel=1e-9)
    assert design.length == pytest.approx(slenderness * tip_width, rel=1e-9)
    assert design.base_width == pytest.approx(flare * tip_width, rel=1e-9)


def test_the_papers_trunk_comes_back_from_its_sizes():
    paper = presets.PAPER
    design = design_from_sizes(tip_width=paper.tip_width, length=paper.length, base_width=paper.base_width)
    assert design.n_section == paper.n_section
    assert design.spiral.b == pytest.approx(paper.spiral.b, rel=1e-9)
    assert design.spiral.a == pytest.approx(paper.spiral.a, rel=1e-9)
    assert design.delta_theta == pytest.approx(paper.delta_theta, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "wish"),
    [
        ("base_width", {"tip_width": 5e-3, "length": 0.25}),
        ("base_width", {"tip_width": 5e-3, "length": 0.25, "base_width": 0.1, "taper": 0.2}),
        ("base_width", {"tip_width": 5e-3, "length": 0.25, "base_width": 4e-3}),
        ("taper", {"tip_width": 5e-3, "length": 0.25, "taper": 0.0}),
        ("taper", {"tip_width": 5e-3, "length": 0.25, "taper": math.nan}),
        ("tip_width", {"tip_width": 0.0, "length": 0.25, "taper": 0.2}),
        ("length", {"tip_width": 5e-3, "length": math.inf, "taper": 0.2}),
        ("sizes", {"tip_width": 5e-3, "length": 0.25, "taper": 1.5}),
    ],
)
def test_impossible_sizes_are_refused_by_name(name, wish):
    with pytest.raises(DesignError) as caught:
        design_from_sizes(**wish)
    assert caught.value.name == name


@pytest.mark.parametrize("name", presets.NAMES)
def test_presets_carry_their_names(name):
    assert presets.get(name).name == name
    assert presets.get(name) is presets.get(name)


def test_the_first_preset_is_the_paper():
    assert presets.NAMES[0] == "paper"
    assert presets.get("paper") is presets.PAPER


@pytest.mark.parametrize("name", ["papr", "", "PAPER"])
def test_an_unknown_preset_lists_those_that_exist(name):
    with pytest.raises(UnknownName, match="paper, paper-large-grip, spirob-15, spirob-1m"):
        presets.get(name)


def test_spirob_15_has_its_published_sizes():
    """Wang et al.: planar, taper 15 deg, 25 cm, tip 5.5 mm, holds from 5.6 mm up."""
    design = presets.get("spirob-15")
    assert math.degrees(design.taper) == pytest.approx(15.0)
    assert design.length == pytest.approx(0.25)
    assert design.tip_width == pytest.approx(5.5e-3)
    assert design.cable == CableDesign(angles=(0.0, math.pi))
    assert design.gripper is None


def test_spirob_1m_has_its_published_sizes():
    """Wang et al.: three cables, 1 m, tip 5 mm, base 120 mm."""
    design = presets.get("spirob-1m")
    assert design.length == pytest.approx(1.0)
    assert (design.tip_width, design.base_width) == pytest.approx((5e-3, 0.12))
    assert design.n_cable == 3
